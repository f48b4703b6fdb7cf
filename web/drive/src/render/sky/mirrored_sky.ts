/** The sky as paint and glass mirror it, made anew when the hour or the clouds have changed. */
import { PMREMGenerator, Scene } from "three";
import type { Texture, WebGLRenderer, WebGLRenderTarget } from "three";
import type { Atmosphere } from "./atmosphere";
import { Sky } from "./sky";

/** Pixels along a face of the mirrored sky, and bytes of its levels of blur (half floats, 3 x 4 faces). */
const SIZE = 64;
export const MIRROR_BYTES = 8 * 3 * SIZE * 4 * SIZE;

export class MirroredSky {
  private readonly scene = new Scene();
  private readonly sky: Sky;
  private readonly renderer: WebGLRenderer;
  private target: WebGLRenderTarget | null = null;
  private made = "";

  constructor(renderer: WebGLRenderer, air: Atmosphere, noise: Texture) {
    this.renderer = renderer;
    this.sky = new Sky(air, noise, 1);
    this.scene.add(this.sky.mesh);
  }

  /** The texture for `envMap` at this hour [h] below `clouds` 0..1, or null if the last one still holds. */
  update(hour: number, clouds: number): Texture | null {
    const wanted = `${Math.round(hour * 8)} ${Math.round(clouds * 8)}`;
    if (wanted === this.made) return null;
    this.made = wanted;
    this.sky.update(0, 0, clouds);
    const generator = new PMREMGenerator(this.renderer);
    const old = this.target;
    this.target = generator.fromScene(this.scene, 0, 0.1, 100, { size: SIZE });
    old?.dispose();
    generator.dispose();
    return this.target.texture;
  }

  /** After a lost context: make it again at the next update. */
  restore(): void {
    this.target = null;
    this.made = "";
  }

  dispose(): void {
    this.sky.dispose();
    this.target?.dispose();
  }
}
