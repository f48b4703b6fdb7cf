/** Sun or moon with two shadow maps about the car, and the light of sky and snow. */
import { DirectionalLight, Group, HemisphereLight, Vector3 } from "three";
import type { Light, Object3D } from "three";
import type { Daylight } from "./daylight";

/** Half widths of what the two shadow maps see [m], and their texels along a side. */
const FINE = { reach: 22, size: 2048 };
const COARSE = { reach: 170, size: 2048 };

/** Bytes of the shadow maps: 32 bits of depth. */
export const SHADOW_BYTES = 4 * (FINE.size ** 2 + COARSE.size ** 2);

/** Who throws shadows into which map: the car into the fine one, which is drawn every time, the rest into the coarse. */
export interface Casters {
  readonly fine: readonly Object3D[];
  readonly coarse: readonly Object3D[];
}

export class Lights {
  readonly group = new Group();
  private readonly sun = new DirectionalLight(0xffffff, 1);
  // Gives no light of its own: it only carries the coarse shadow map.
  private readonly far = new DirectionalLight(0xffffff, 0);
  private readonly sky = new HemisphereLight();
  private readonly middle = new Vector3(Infinity, 0, 0);
  private readonly drawn = new Vector3(0, 1, 0);

  constructor(casters: Casters) {
    for (const [light, { reach, size }] of [
      [this.sun, FINE],
      [this.far, COARSE],
    ] as const) {
      light.castShadow = true;
      light.shadow.mapSize.set(size, size);
      const camera = light.shadow.camera;
      [camera.left, camera.right, camera.top, camera.bottom] = [-reach, reach, reach, -reach];
      camera.near = 1;
      camera.far = 8 * reach;
      light.shadow.normalBias = (1.6 * reach) / size;
      light.shadow.bias = -0.0004;
      this.group.add(light, light.target);
    }
    only(this.sun, casters.fine, casters.coarse);
    only(this.far, casters.coarse, casters.fine);
    this.far.shadow.autoUpdate = false;
    this.group.add(this.sky);
  }

  /** Set the light of the hour and keep the shadows about `focus`, which the fine map has in its middle. */
  update(light: Daylight, focus: Vector3): void {
    const [r, g, b] = light.sun;
    this.sun.color.setRGB(r, g, b);
    this.sky.color.setRGB(...light.sky);
    this.sky.groundColor.setRGB(...light.bounce);
    const direction = new Vector3(...light.direction);
    this.place(this.sun, snapped(focus, direction, (2 * FINE.reach) / FINE.size), direction, FINE.reach);
    // The coarse map is drawn again only when the car or the light has gone some way.
    if (this.middle.distanceTo(focus) < 12 && this.drawn.distanceTo(direction) < 2e-3) return;
    this.middle.copy(focus);
    this.drawn.copy(direction);
    this.place(
      this.far,
      snapped(focus, direction, (2 * COARSE.reach) / COARSE.size),
      direction,
      COARSE.reach,
    );
    this.far.shadow.needsUpdate = true;
  }

  /** Draw the coarse map anew with the next picture. */
  refresh(): void {
    this.middle.set(Infinity, 0, 0);
  }

  dispose(): void {
    this.sun.dispose();
    this.far.dispose();
  }

  private place(light: DirectionalLight, at: Vector3, direction: Vector3, reach: number): void {
    light.target.position.copy(at);
    light.position
      .copy(direction)
      .multiplyScalar(4 * reach)
      .add(at);
    light.target.updateMatrixWorld();
    light.updateMatrixWorld();
  }
}

/** The point of a grid of texels across the light nearest to `focus`: shadows' edges do not crawl while it moves. */
function snapped(focus: Vector3, direction: Vector3, texel: number): Vector3 {
  const side = new Vector3(0, 1, 0).cross(direction).normalize();
  const up = direction.clone().cross(side);
  const at = direction.clone().multiplyScalar(focus.dot(direction));
  for (const axis of [side, up]) at.addScaledVector(axis, Math.round(focus.dot(axis) / texel) * texel);
  return at;
}

/**
 * Let only `these` throw shadows into the map of `light`, not `others`. three asks a shadow for its matrices right
 * before it draws the map, and has no other way to choose what a light sees.
 */
function only(light: DirectionalLight, these: readonly Object3D[], others: readonly Object3D[]): void {
  const { shadow } = light;
  const update = shadow.updateMatrices.bind(shadow);
  shadow.updateMatrices = (of: Light) => {
    for (const object of these) object.castShadow = true;
    for (const object of others) object.castShadow = false;
    update(of as DirectionalLight);
  };
}
