import {
  Camera,
  DataTexture,
  FloatType,
  GLSL3,
  InstancedBufferGeometry,
  BufferAttribute,
  LinearFilter,
  Mesh,
  NearestFilter,
  NoBlending,
  RawShaderMaterial,
  RedFormat,
  RepeatWrapping,
  RGFormat,
  Sphere,
  Vector2,
  Vector4,
  WebGLRenderTarget,
  type IUniform,
  type Texture,
  type WebGLRenderer,
} from "three";
import type { GroundSource } from "../../world/ground_source";
import { STAMPS, StampUniforms } from "../footprint";
import { area, type Rect } from "../window/rects";
import * as shaders from "./shaders";
import { TILE } from "../window/tiles";

/** What a pass is called, its shader, and the bytes of textures it reads for a texel (neighbours come from caches). */
const PASSES = {
  bed: { fragment: "", reads: 0 },
  fresh: { fragment: shaders.FRESH, reads: 8 },
  copy: { fragment: shaders.COPY, reads: 8 },
  scale: { fragment: shaders.SCALE, reads: 8 },
  recover: { fragment: shaders.RECOVER, reads: 16 },
  sum: { fragment: shaders.SUM, reads: 0 },
  lanes: { fragment: shaders.SUM_LANES, reads: 16 * shaders.LANES },
  stamp: { fragment: shaders.STAMP, reads: 16 },
  slide: { fragment: shaders.SLIDE, reads: 16 },
};
type PassName = keyof typeof PASSES;

/** The textures of the snow and the passes over rectangles of them. */
export class Passes {
  /** The snow, and where passes put what they make of it. */
  readonly snow: WebGLRenderTarget;
  readonly other: WebGLRenderTarget;
  /** (height of the ground, cover). */
  readonly bed: WebGLRenderTarget;
  readonly lanes = this.targetOf(shaders.LANES, STAMPS, false);
  readonly sums = this.targetOf(1, STAMPS, false);
  readonly cover: DataTexture;
  readonly stamps = new StampUniforms();
  readonly uniforms: Record<string, IUniform>;
  /** Bytes that passes read and wrote, and their draws, since the last `begin`. */
  bytes = 0;
  draws = 0;
  private readonly renderer: WebGLRenderer;
  private readonly materials: Record<PassName, RawShaderMaterial>;
  private readonly mesh: Mesh<InstancedBufferGeometry, RawShaderMaterial>;
  private readonly camera = new Camera();
  private readonly rects = Array.from({ length: shaders.RECTS }, () => new Vector4());
  private readonly extras = Array.from({ length: shaders.RECTS }, () => new Vector2());
  private before: (() => void) | null = null;

  constructor(renderer: WebGLRenderer, resolution: number, texel: number, ground: GroundSource) {
    this.renderer = renderer;
    this.snow = this.targetOf(resolution, resolution, true);
    this.other = this.targetOf(resolution, resolution, true);
    this.bed = this.targetOf(resolution, resolution, true);
    this.snow.texture.name = "snow";
    if (renderer.extensions.has("OES_texture_float_linear"))
      this.snow.texture.magFilter = this.snow.texture.minFilter = LinearFilter;
    const side = (resolution / TILE) * shaders.COVER_SIDE;
    this.cover = new DataTexture(new Float32Array(side * side), side, side, RedFormat, FloatType);
    this.uniforms = {
      target: { value: new Vector2() },
      rects: { value: this.rects },
      extras: { value: this.extras },
      snow: { value: null },
      bed: { value: this.bed.texture },
      lanes: { value: this.lanes.texture },
      sums: { value: this.sums.texture },
      cover: { value: this.cover },
      corner: { value: new Vector2() },
      origin: { value: new Vector2() },
      mask: { value: resolution - 1 },
      texel: { value: texel },
      depth: { value: 0 },
      compaction: { value: 0 },
      repose: { value: 1 },
      region: { value: new Vector4() },
      last: { value: false },
      stamps: { value: this.stamps.vectors },
      bounds: { value: this.stamps.bounds },
      count: { value: 0 },
    };
    this.materials = this.materialsOver(ground);
    const geometry = new InstancedBufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array([0, 0, 1, 0, 0, 1, 1, 1]), 2));
    geometry.setIndex([0, 1, 2, 2, 1, 3]);
    // It is never culled; three asks for a sphere all the same.
    geometry.boundingSphere = new Sphere();
    this.mesh = new Mesh(geometry, this.materials.copy);
    this.mesh.frustumCulled = false;
  }

  /** Bytes of all textures. */
  get textureBytes(): number {
    const { width, height } = this.snow;
    return 3 * 8 * width * height + 16 * STAMPS * (shaders.LANES + 1) + this.cover.image.data!.byteLength;
  }

  /** Take the renderer over, until `end`. */
  begin(): void {
    const { renderer } = this;
    const [target, autoClear, xr] = [renderer.getRenderTarget(), renderer.autoClear, renderer.xr.enabled];
    this.before = () => {
      renderer.setRenderTarget(target);
      [renderer.autoClear, renderer.xr.enabled] = [autoClear, xr];
    };
    renderer.autoClear = false;
    renderer.xr.enabled = false;
    this.bytes = this.draws = 0;
  }

  /** Give the renderer back as it was. */
  end(): void {
    this.before?.();
    this.before = null;
  }

  /** Draw a pass over rectangles of a target [texels]. Each rectangle may have two numbers for its shader. */
  draw(
    name: PassName,
    target: WebGLRenderTarget,
    rects: readonly Rect[],
    extras: readonly (readonly [number, number])[] = [],
    source: WebGLRenderTarget = this.snow,
  ): void {
    const { uniforms, renderer, mesh } = this;
    mesh.material = this.materials[name];
    (uniforms["target"]!.value as Vector2).set(target.width, target.height);
    uniforms["snow"]!.value = target === source ? null : source.texture;
    renderer.setRenderTarget(target);
    for (let first = 0; first < rects.length; first += shaders.RECTS) {
      const some = rects.slice(first, first + shaders.RECTS);
      some.forEach((rect, i) => {
        const [a, b] = extras[first + i] ?? extras[0] ?? [0, 0];
        this.rects[i]!.set(rect.x0, rect.z0, rect.x1, rect.z1);
        this.extras[i]!.set(a, b);
        this.bytes += area(rect) * (PASSES[name].reads + (target.texture.format === RGFormat ? 8 : 16));
      });
      mesh.geometry.instanceCount = some.length;
      mesh.material.uniformsNeedUpdate = true;
      renderer.render(mesh, this.camera);
      this.draws++;
    }
  }

  /** Bind a target, to be read. */
  bind(target: WebGLRenderTarget): void {
    this.renderer.setRenderTarget(target);
  }

  /** Put texels, (h, W) pairs of one tile or of a piece so wide [texels], into the snow. */
  upload(data: Float32Array, x: number, z: number, width: number = TILE): void {
    const texture = new DataTexture(data, width, data.length / (2 * width), RGFormat, FloatType);
    this.renderer.initRenderTarget(this.snow);
    this.renderer.copyTextureToTexture(texture, this.snow.texture, null, new Vector2(x, z));
    texture.dispose();
    this.bytes += data.byteLength;
  }

  dispose(): void {
    for (const target of [this.snow, this.other, this.bed, this.lanes, this.sums]) target.dispose();
    for (const material of Object.values(this.materials)) material.dispose();
    this.cover.dispose();
    this.mesh.geometry.dispose();
  }

  private targetOf(width: number, height: number, two: boolean): WebGLRenderTarget<Texture> {
    return new WebGLRenderTarget(width, height, {
      type: FloatType,
      format: two ? RGFormat : undefined,
      minFilter: NearestFilter,
      magFilter: NearestFilter,
      wrapS: RepeatWrapping,
      wrapT: RepeatWrapping,
      depthBuffer: false,
    });
  }

  private materialsOver(ground: GroundSource): Record<PassName, RawShaderMaterial> {
    const entries = Object.entries(PASSES).map(([name, { fragment }]) => [
      name,
      new RawShaderMaterial({
        name: `snow: ${name}`,
        glslVersion: GLSL3,
        vertexShader: shaders.VERTEX,
        fragmentShader: fragment || shaders.bedShader(ground.glsl),
        uniforms: fragment ? this.uniforms : { ...ground.uniforms, ...this.uniforms },
        depthTest: false,
        depthWrite: false,
        blending: NoBlending,
      }),
    ]);
    return Object.fromEntries(entries) as Record<PassName, RawShaderMaterial>;
  }
}
