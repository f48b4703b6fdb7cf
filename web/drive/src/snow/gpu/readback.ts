/** A rectangle of a framebuffer [pixels]. */
export interface Pixels {
  readonly x: number;
  readonly y: number;
  readonly nx: number;
  readonly ny: number;
}

interface Reading {
  readonly buffer: WebGLBuffer;
  readonly capacity: number;
  readonly floats: number;
  readonly fence: WebGLSync;
  readonly done: (data: Float32Array | null) => void;
}

/**
 * Reads of a floating-point framebuffer that do not wait: the pixels go into a buffer of the GPU and are fetched when
 * its fence has passed, in the order in which they were asked for. RGBA, because that is the only format that every
 * WebGL 2 can read from a floating-point target.
 */
export class Readback {
  private readonly gl: WebGL2RenderingContext;
  private readings: Reading[] = [];
  private spare: { buffer: WebGLBuffer; capacity: number }[] = [];
  private timer: ReturnType<typeof setTimeout> | null = null;

  constructor(gl: WebGL2RenderingContext) {
    this.gl = gl;
  }

  /**
   * Read rectangles of the framebuffer that is bound, one after the other into one array of RGBA. `done` gets null
   * if the context was lost before.
   */
  read(rects: readonly Pixels[], done: (data: Float32Array | null) => void): void {
    const { gl } = this;
    const floats = rects.reduce((sum, { nx, ny }) => sum + 4 * nx * ny, 0);
    const { buffer, capacity } = this.bufferFor(4 * floats);
    let offset = 0;
    for (const { x, y, nx, ny } of rects) {
      gl.readPixels(x, y, nx, ny, gl.RGBA, gl.FLOAT, offset);
      offset += 16 * nx * ny;
    }
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    if (!fence) return done(null);
    gl.flush();
    this.readings.push({ buffer, capacity, floats, fence, done });
    this.wake();
  }

  /** Hand out what has arrived. A timer does it too, for pages that do not update at the moment. */
  poll(): void {
    const { gl } = this;
    while (this.readings[0]) {
      const { buffer, capacity, floats, fence, done } = this.readings[0];
      const state = gl.clientWaitSync(fence, 0, 0);
      if (state === gl.TIMEOUT_EXPIRED) break;
      this.readings.shift();
      gl.deleteSync(fence);
      const data = state === gl.WAIT_FAILED ? null : new Float32Array(floats);
      if (data) {
        gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
        gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, data);
        gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
      }
      this.spare.push({ buffer, capacity });
      done(data);
    }
    this.wake();
  }

  /** Give up all that is under way: the context is gone, or nobody wants it any more. */
  abandon(): void {
    const given = this.readings;
    this.readings = [];
    for (const { fence, buffer } of given) {
      this.gl.deleteSync(fence);
      this.gl.deleteBuffer(buffer);
    }
    for (const { buffer } of this.spare) this.gl.deleteBuffer(buffer);
    this.spare = [];
    for (const { done } of given) done(null);
  }

  private wake(): void {
    if (this.timer !== null || this.readings.length === 0) return;
    this.timer = setTimeout(() => {
      this.timer = null;
      this.poll();
    }, 4);
  }

  /** Bind a buffer of at least so many bytes: a used one that is not far too large, or a new one. */
  private bufferFor(bytes: number): { buffer: WebGLBuffer; capacity: number } {
    const { gl } = this;
    const i = this.spare.findIndex(({ capacity }) => capacity >= bytes && capacity <= 4 * bytes);
    const found = i >= 0 ? this.spare.splice(i, 1)[0]! : null;
    const buffer = found?.buffer ?? gl.createBuffer();
    const capacity = found?.capacity ?? 2 ** Math.ceil(Math.log2(bytes));
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
    // New storage each time, as for a stream: the driver need not wait for the last user.
    gl.bufferData(gl.PIXEL_PACK_BUFFER, capacity, gl.STREAM_READ);
    return { buffer, capacity };
  }
}
