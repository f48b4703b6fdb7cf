/** What presses the snow in one update. Lengths in metres, angles in radians. */

/** A place that a stamp came from since the last update, so that a fast wheel leaves no gaps. */
export interface Place {
  readonly x: number;
  readonly y: number;
  readonly z: number;
}

/** A wheel: a cylinder with rounded shoulders; x, y, z is the centre of its axle. */
export interface WheelStamp extends Place {
  readonly shape: "wheel";
  /** Direction of rolling: (cos, sin) in (x, z). */
  readonly heading: number;
  readonly radius: number;
  readonly width: number;
  /** Circumference minus ground speed [m/s]: a spinning wheel throws more snow behind it. */
  readonly slip: number;
  /** Where the axle was at the last update: what lies between is pressed too. */
  readonly from?: Place;
}

/** The underside of the car where it touches down: a tilted rectangle; x, y, z is its middle. */
export interface BoxStamp extends Place {
  readonly shape: "box";
  readonly heading: number;
  /** Along the heading. */
  readonly length: number;
  /** Across it. */
  readonly width: number;
  /** Rise of the underside per metre along and across the heading. */
  readonly slopeAlong: number;
  readonly slopeAcross: number;
  readonly from?: Place;
}

export type Stamp = WheelStamp | BoxStamp;
