import { describe, expect, it } from "vitest";
import { HANDS_OFF } from "../../src/car/driver/controls";
import { driven, drivenSpeed, share } from "../../src/car/wheels/driveline";
import { Gearbox, steeringLimit } from "../../src/car/wheels/gearbox";

const CAR = { mass: 1500, power: 160e3 };
const DT = 1 / 120;

describe("gearbox", () => {
  it("gives no more than the power at any speed, and no more than the launch force at rest", () => {
    const box = new Gearbox();
    for (let speed = 0; speed < 70; speed += 0.1) {
      const { drive } = box.demand({ ...HANDS_OFF, throttle: 1 }, speed, speed, CAR, DT);
      expect(drive * speed).toBeLessThanOrEqual(CAR.power * (1 + 1e-12));
      expect(drive).toBeLessThanOrEqual(0.8 * 9.81 * CAR.mass);
    }
  });

  it("shifts up one by one and down again, with a pause without power each time", () => {
    const box = new Gearbox();
    const seen: number[] = [];
    const go = (speed: number) => {
      const { drive } = box.demand({ ...HANDS_OFF, throttle: 1 }, speed, speed, CAR, DT);
      if (seen.at(-1) === box.gear) return;
      seen.push(box.gear);
      if (seen.length > 1) expect(drive).toBeLessThanOrEqual(0);
    };
    for (let speed = 0; speed < 50; speed += 0.02) go(speed);
    for (let speed = 50; speed > 0; speed -= 0.02) go(speed);
    expect(seen).toEqual([1, 2, 3, 4, 5, 6, 5, 4, 3, 2, 1]);
  });

  it("does not hunt: no speed makes it shift to and fro", () => {
    for (let speed = 0; speed < 60; speed += 0.25) {
      const box = new Gearbox();
      let shifts = 0;
      let gear = 1;
      for (let i = 0; i < 600; i++) {
        box.demand({ ...HANDS_OFF, throttle: 1 }, speed, speed, CAR, DT);
        if (box.gear !== gear) shifts++;
        gear = box.gear;
      }
      expect(shifts).toBeLessThanOrEqual(5); // from first to sixth at most
    }
  });

  it("brakes while the car rolls and backs only after a while at rest", () => {
    const box = new Gearbox();
    const pedal = { ...HANDS_OFF, brake: 1 };
    expect(box.demand(pedal, 5, 5, CAR, DT).brake).toBe(9 * CAR.mass);
    box.demand(pedal, 0, 0, CAR, DT);
    expect(box.gear).toBe(1);
    for (let t = 0; t < 0.6; t += DT) box.demand(pedal, 0, 0, CAR, DT);
    expect(box.name).toBe("R");
    expect(box.demand(pedal, 0, 0, CAR, DT).brake).toBe(0);
    for (let t = 0; t < 0.2; t += DT) box.demand(pedal, 0, 0, CAR, DT);
    expect(box.demand(pedal, 0, 0, CAR, DT).drive).toBeLessThan(0);
  });
});

describe("driveline", () => {
  const wheel = { omega: 0, slip: 0, load: 4000, friction: 0.5 };
  const four = [wheel, wheel, wheel, wheel];

  it("drives the wheels that are chosen, with all of the force", () => {
    for (const drive of ["all", "front", "rear"] as const) {
      const torques = share({ drive: 1000, brake: 0 }, 0, 0, four, { mass: 1500, radius: 0.4, drive });
      const sum = torques.reduce((total, torque) => total + torque.drive, 0);
      expect(sum).toBeCloseTo(1000 * 0.4, 9);
      for (const [i, torque] of torques.entries()) expect(torque.drive > 0).toBe(driven(i, drive));
    }
    expect(drivenSpeed([1, 3, 10, 20], "front")).toBe(2);
    expect(drivenSpeed([1, 3, 10, 20], "rear")).toBe(15);
  });

  it("moves torque from the wheel that runs away to the others, and makes none", () => {
    const wheels = [{ ...wheel, omega: 5 }, wheel, wheel, wheel];
    const torques = share({ drive: 0, brake: 0 }, 0, 0, wheels, { mass: 1500, radius: 0.4, drive: "all" });
    expect(torques[0]!.drive).toBeLessThan(0);
    expect(torques[1]!.drive).toBeGreaterThan(0);
    expect(torques.reduce((total, torque) => total + torque.drive, 0)).toBeCloseTo(0, 9);
  });

  it("keeps the brake below the grip at speed, but lets the handbrake lock the rear", () => {
    const grip = 0.5 * 4000 * 0.4;
    const torques = share({ drive: 0, brake: 1e5 }, 0, 10, four, { mass: 1500, radius: 0.4, drive: "all" });
    for (const { brake } of torques) expect(brake).toBeLessThan(grip);
    const pulled = share({ drive: 0, brake: 0 }, 1, 10, four, { mass: 1500, radius: 0.4, drive: "all" });
    expect(pulled[0]!.brake).toBe(0);
    expect(pulled[2]!.brake).toBeGreaterThan(grip);
  });
});

describe("steering", () => {
  it("is full at walking pace and smaller the faster the car", () => {
    expect(steeringLimit(0, 2.6)).toBe(0.6);
    let before = 0.6;
    for (let speed = 8; speed < 60; speed += 4) {
      expect(steeringLimit(speed, 2.6)).toBeLessThan(before);
      before = steeringLimit(speed, 2.6);
    }
    expect(before).toBeGreaterThan(0.05);
  });
});
