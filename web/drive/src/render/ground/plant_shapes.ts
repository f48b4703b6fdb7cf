/** Shapes of pines, rocks and poles, one metre high or wide; the attribute `leaf` says what a vertex is part of. */
import { BufferAttribute, BufferGeometry, CylinderGeometry, IcosahedronGeometry } from "three";
import { mergeGeometries, mergeVertices } from "three/addons/utils/BufferGeometryUtils.js";
import { random } from "../../world/noise";

/** How finely a pine is made: whorls of branches, branches in a whorl, steps along a branch. */
export interface PineSize {
  readonly whorls: number;
  readonly branches: number;
  readonly steps: number;
}

/**
 * A pine 1 m high: whorls of drooping skirts, whose rims are drawn out to branches. `leaf` is (place along a branch 0
 * at the stem .. 1 at the tip, angle, 1 for needles and 0 for the stem).
 */
export function pine({ whorls, branches, steps }: PineSize, seed: number): BufferGeometry {
  const position: number[] = [];
  const normal: number[] = [];
  const leaf: number[] = [];
  const index: number[] = [];
  for (let w = 0; w < whorls; w++) {
    const up = w / whorls;
    const top = 0.2 + 0.8 * up + 0.8 / whorls;
    const reach = (0.205 * (1 - up) ** 0.86 + 0.022) * (0.9 + 0.2 * random(w, 1, seed));
    const fall = (1.12 / whorls) * (1 + 0.5 * (1 - up));
    const around = 2 * branches;
    const first = position.length / 3;
    for (let s = 0; s <= steps; s++) {
      const along = s / steps;
      for (let b = 0; b < around; b++) {
        const angle =
          (2 * Math.PI * (b + 0.5 * (w % 2))) / around + 0.35 * (random(w, b, seed + 2) - 0.5) + w;
        const tip = b % 2 === 0 ? 1 + 0.28 * (random(w, b, seed) - 0.4) : 0.62;
        const r = reach * (0.08 + 0.92 * along * (along > 0.99 ? tip : 0.9 * tip + 0.1));
        const droop = fall * (0.35 * along + 0.65 * along ** 2) * (b % 2 === 0 ? 1.0 : 0.78);
        position.push(r * Math.cos(angle), Math.min(top, 1) - droop, r * Math.sin(angle));
        const out = 0.75 + 0.3 * along;
        const length = Math.hypot(out, 0.8);
        normal.push((out * Math.cos(angle)) / length, 0.8 / length, (out * Math.sin(angle)) / length);
        leaf.push(along, b / 2, 1);
      }
    }
    for (let s = 0; s < steps; s++) {
      for (let b = 0; b < around; b++) {
        const next = (b + 1) % around;
        const [a, c] = [first + s * around + b, first + s * around + next];
        index.push(a, c, a + around, c, c + around, a + around);
      }
    }
  }
  const skirts = new BufferGeometry();
  skirts.setAttribute("position", new BufferAttribute(new Float32Array(position), 3));
  skirts.setAttribute("normal", new BufferAttribute(new Float32Array(normal), 3));
  skirts.setAttribute("leaf", new BufferAttribute(new Float32Array(leaf), 3));
  skirts.setIndex(index);
  const stem = new CylinderGeometry(0.008, 0.021, 0.4, steps > 1 ? 6 : 3, 1, true).translate(0, 0.2, 0);
  stem.deleteAttribute("uv");
  stem.setAttribute(
    "leaf",
    new BufferAttribute(new Float32Array(3 * stem.getAttribute("position").count), 3),
  );
  return mergeGeometries([skirts, stem]);
}

/** A boulder about 1 m wide, split along some planes so that it has faces; of 20 (detail + 1)^2 triangles. */
export function rock(detail: number): BufferGeometry {
  const ball = new IcosahedronGeometry(0.5, detail);
  ball.deleteAttribute("uv");
  ball.deleteAttribute("normal");
  const whole = mergeVertices(ball);
  const p = whole.getAttribute("position");
  const planes = Array.from({ length: 11 }, (_, k) => {
    const z = 2 * random(k, 1, 5) - 1;
    const angle = 6.283 * random(k, 2, 5);
    const r = Math.sqrt(1 - z * z);
    return [r * Math.cos(angle), z, r * Math.sin(angle), 0.27 + 0.16 * random(k, 3, 5)] as const;
  });
  for (let k = 0; k < p.count; k++) {
    let [x, y, z] = [p.getX(k), p.getY(k), p.getZ(k)];
    for (const [a, b, c, d] of planes) {
      const over = Math.max(0, a * x + b * y + c * z - d) * 0.93;
      [x, y, z] = [x - over * a, y - over * b, z - over * c];
    }
    p.setXYZ(k, 1.25 * x, 0.95 * y, z);
  }
  whole.computeVertexNormals();
  whole.setAttribute("leaf", new BufferAttribute(new Float32Array(3 * p.count), 3));
  return whole;
}

/** A marking pole of a mountain road, 2.2 m high. `leaf` holds its height, for the bands of paint. */
export function pole(): BufferGeometry {
  const rod = new CylinderGeometry(0.032, 0.036, 2.4, 6).translate(0, 1, 0);
  rod.deleteAttribute("uv");
  const p = rod.getAttribute("position");
  const leaf = new Float32Array(3 * p.count);
  for (let k = 0; k < p.count; k++) leaf[3 * k] = p.getY(k);
  rod.setAttribute("leaf", new BufferAttribute(leaf, 3));
  return rod;
}
