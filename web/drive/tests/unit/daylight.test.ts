import { describe, expect, it } from "vitest";
import { daylight, moonDirection, sunDirection } from "../../src/render/sky/daylight";

const HOURS = Array.from({ length: 241 }, (_, k) => k / 10);

describe("sunDirection", () => {
  it("is a unit vector, east in the morning, south and highest at noon, west in the evening", () => {
    for (const hour of HOURS) expect(Math.hypot(...sunDirection(hour))).toBeCloseTo(1, 12);
    expect(sunDirection(9)[0]).toBeGreaterThan(0.3);
    expect(sunDirection(15)[0]).toBeLessThan(-0.3);
    const noon = sunDirection(12);
    expect(noon[0]).toBeCloseTo(0, 12);
    expect(noon[2]).toBeGreaterThan(0);
    // Height at noon: 90 degrees less the latitude plus the declination, 90 - 46 - 11 = 33.
    expect((Math.asin(noon[1]) * 180) / Math.PI).toBeCloseTo(33, 9);
    for (const hour of HOURS) expect(sunDirection(hour)[1]).toBeLessThanOrEqual(noon[1] + 1e-12);
  });

  it("has the moon opposite", () => {
    for (const hour of HOURS) {
      const [sun, moon] = [sunDirection(hour), moonDirection(hour)];
      expect(sun[0] * moon[0] + sun[1] * moon[1] + sun[2] * moon[2]).toBeCloseTo(-1, 12);
    }
  });
});

describe("daylight", () => {
  it("comes from above whenever it is more than a trace", () => {
    for (const hour of HOURS) {
      const { direction, sun } = daylight(hour);
      if (Math.max(...sun) > 0.6) expect(direction[1]).toBeGreaterThan(-0.02);
    }
  });

  it("changes without jumps: no faster than the steepest way between keys, at most 1.6 degrees of the sun a step", () => {
    const flat = (hour: number) => {
      const { sun, zenith, horizon, sky } = daylight(hour);
      return [...sun, ...zenith, ...horizon, ...sky];
    };
    for (const hour of HOURS) {
      const [a, b] = [flat(hour), flat(hour + 0.1)];
      // The steepest way between two keys: 4.4 of the sun's red over 4 degrees, so 1.1 a degree.
      a.forEach((v, k) => expect(Math.abs(v - b[k]!)).toBeLessThan(1.6 * 1.1 + 1e-9));
    }
  });

  it("needs lamps and shows stars at night only", () => {
    expect(daylight(12).lamps).toBe(0);
    expect(daylight(12).stars).toBe(0);
    expect(daylight(0).lamps).toBe(1);
    expect(daylight(0).stars).toBe(1);
  });
});
