/** The dials of the cockpit, as the driver sees them: who looks along +x has +z to the right and +y up. */
import { Mesh, Texture, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { carAt } from "../../src/course/run";
import { CarView } from "../../src/render/car/car_view";
import { Cockpit } from "../../src/render/car/cockpit";
import { numeral } from "../../src/render/car/numerals";
import { Atmosphere } from "../../src/render/sky/atmosphere";

const cockpit = new Cockpit((material) => material);
const part = (name: string) => cockpit.group.getObjectByName(name) as Mesh;

/** Angle of a needle from straight up, to the right [degrees], from where its tip is. */
function angle(name: "speed" | "engine"): number {
  const needle = part(name);
  needle.updateMatrixWorld();
  const tip = needle.localToWorld(new Vector3(0, 0.05, 0)).sub(needle.position);
  expect(tip.x).toBeCloseTo(0, 12);
  return (Math.atan2(tip.z, tip.y) * 180) / Math.PI;
}

/** Whether some of the marks is drawn as far as `radius` [m] from the middle of a dial, at an angle [degrees]. */
function marked(name: "speed" | "engine", degrees: number, radius: number): boolean {
  const { x, y, z } = part(name).position;
  const a = (degrees * Math.PI) / 180;
  const place = new Vector3(x, y + radius * Math.cos(a), z + radius * Math.sin(a));
  const at = part("marks").geometry.getAttribute("position");
  return Array.from({ length: at.count }, (_, k) => new Vector3().fromBufferAttribute(at, k)).some((p) => {
    p.x = x;
    return p.distanceTo(place) < 0.002;
  });
}

describe("the dials", () => {
  it("show the speed: 0 at the lower left, 60 km/h straight up, 120 at the lower right, in even steps", () => {
    for (const [speed, degrees] of [
      [0, -135],
      [50, -22.5],
      [60, 0],
      [-50, -22.5],
      [120, 135],
      [180, 135],
    ] as const) {
      cockpit.update(speed / 3.6, 0, 0);
      expect(angle("speed")).toBeCloseTo(degrees, 9);
    }
  });

  it("show the engine likewise, 0 to full", () => {
    for (const [revs, degrees] of [
      [0, -135],
      [0.5, 0],
      [1, 135],
    ] as const) {
      cockpit.update(0, revs, 0);
      expect(angle("engine")).toBeCloseTo(degrees, 9);
    }
  });

  it("have a mark where the needle is at every 10 km/h and every 500 turns a minute, and none between", () => {
    for (const name of ["speed", "engine"] as const)
      for (let k = 0; k <= 24; k++) expect(marked(name, -135 + 11.25 * k, 0.056)).toBe(k % 2 === 0);
  });

  it("are seen from inside of the car alone", () => {
    const view = new CarView(new Atmosphere({ glsl: "", uniforms: {} }), new Texture());
    const drive = { time: 1, rows: [0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0] };
    const pose = carAt(drive, 0.5, 0.38, 0.26);
    view.update(pose, 0);
    const shown = () => {
      let seen = false;
      view.group.traverseVisible((object) => (seen ||= object.name === "speed"));
      return seen;
    };
    view.look(view.toWorld(-0.3, 1, -0.36));
    expect(shown()).toBe(true);
    view.look(view.toWorld(-5.6, 1.75, 0));
    expect(shown()).toBe(false);
  });
});

describe("a number on a dial", () => {
  const size = (number: number) => {
    const shape = numeral(number, 1);
    shape.computeBoundingBox();
    return shape.boundingBox!.getSize(new Vector3());
  };

  it("is as high as it is asked to be, and wider with each digit", () => {
    for (const number of [0, 20, 120]) expect(size(number).y).toBeCloseTo(1.11, 6); // with the thickness of its bars
    expect(size(220).z - size(20).z).toBeCloseTo(0.74, 6);
  });

  it("has the bars of its digits: two for a one, seven for an eight", () => {
    const bars = (number: number) => numeral(number, 1).getAttribute("position").count / 36;
    expect([0, 1, 2, 3, 4, 5, 6, 7, 8, 9].map(bars)).toEqual([6, 2, 5, 5, 4, 5, 6, 3, 7, 6]);
    expect(bars(120)).toBe(2 + 5 + 6);
  });
});
