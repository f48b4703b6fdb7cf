import { densityRatio } from "../law";

/** The snow as files that engines read: a PNG of 16 bits, and an OpenEXR of 32-bit floats. */

/** (h, W) pairs in rows of z, as `SnowField.read` gives them. */
export interface Pixels16 {
  readonly width: number;
  readonly height: number;
  readonly data: Float32Array;
}

/**
 * Return a PNG of grey and alpha, 16 bits each: depth h and mass W [m] over `full` [m], the value of white.
 * What is greater is white. Source: PNG, ISO/IEC 15948:2004.
 */
export async function depthPng({ width, height, data }: Pixels16, full: number): Promise<Uint8Array> {
  require(width, height, data);
  if (!(full > 0)) throw new Error(`White must be a depth greater than 0 m, not ${full}.`);
  const rows = new DataView(new ArrayBuffer(height * (1 + 4 * width)));
  for (let j = 0; j < height; j++)
    for (let k = 0; k < 2 * width; k++) {
      const share = Math.max(0, Math.min(1, data[2 * width * j + k]! / full));
      rows.setUint16(j * (1 + 4 * width) + 1 + 2 * k, Math.round(65535 * share));
    }
  const head = new DataView(new ArrayBuffer(13));
  head.setUint32(0, width);
  head.setUint32(4, height);
  head.setUint8(8, 16); // bits
  head.setUint8(9, 4); // grey and alpha
  const signature = new Uint8Array([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);
  const packed = await deflated(new Uint8Array(rows.buffer));
  return joined([
    signature,
    chunk("IHDR", new Uint8Array(head.buffer)),
    chunk("IDAT", packed),
    chunk("IEND"),
  ]);
}

/**
 * Return an OpenEXR of 32-bit floats, not compressed: R = h and G = W [m], B = W / h, how densely the snow is packed
 * (1: fresh, or none). Many readers take three channels only. Source: OpenEXR file layout, openexr.com.
 */
export function snowExr({ width, height, data }: Pixels16): Uint8Array {
  require(width, height, data);
  const box = ints(0, 0, width - 1, height - 1);
  const channel = (name: string) => joined([text(name), ints(2, 0, 1, 1)]); // float, not linear, every pixel
  const head = joined([
    ints(20000630, 2),
    attribute("channels", "chlist", joined([channel("B"), channel("G"), channel("R"), new Uint8Array(1)])),
    attribute("compression", "compression", new Uint8Array(1)),
    attribute("dataWindow", "box2i", box),
    attribute("displayWindow", "box2i", box),
    attribute("lineOrder", "lineOrder", new Uint8Array(1)),
    attribute("pixelAspectRatio", "float", floats(1)),
    attribute("screenWindowCenter", "v2f", floats(0, 0)),
    attribute("screenWindowWidth", "float", floats(1)),
    new Uint8Array(1),
  ]);
  const line = 8 + 12 * width;
  const file = new DataView(new ArrayBuffer(head.length + height * (8 + line)));
  new Uint8Array(file.buffer).set(head);
  for (let j = 0; j < height; j++) {
    const at = head.length + 8 * height + j * line;
    file.setBigUint64(head.length + 8 * j, BigInt(at), true);
    file.setInt32(at, j, true);
    file.setInt32(at + 4, 12 * width, true);
    for (let i = 0; i < width; i++) {
      const [h, W] = [data[2 * (i + j * width)]!, data[2 * (i + j * width) + 1]!];
      const at8 = at + 8 + 4 * i; // channels in the order of their names: B, G, R
      file.setFloat32(at8, densityRatio({ h, W }), true);
      file.setFloat32(at8 + 4 * width, W, true);
      file.setFloat32(at8 + 8 * width, h, true);
    }
  }
  return new Uint8Array(file.buffer);
}

function require(width: number, height: number, data: Float32Array): void {
  if (width < 1 || height < 1 || data.length !== 2 * width * height)
    throw new Error(`A picture of ${width} x ${height} needs as many (h, W) pairs, not ${data.length / 2}.`);
}

async function deflated(bytes: Uint8Array<ArrayBuffer>): Promise<Uint8Array> {
  const stream = new Blob([bytes]).stream().pipeThrough(new CompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function chunk(name: string, data: Uint8Array = new Uint8Array()): Uint8Array {
  const body = joined([new TextEncoder().encode(name), data]);
  const [length, sum] = [new DataView(new ArrayBuffer(4)), new DataView(new ArrayBuffer(4))];
  length.setUint32(0, data.length);
  sum.setUint32(0, crc(body));
  return joined([new Uint8Array(length.buffer), body, new Uint8Array(sum.buffer)]);
}

/** The cyclic redundancy check of PNG, bit by bit. */
function crc(bytes: Uint8Array): number {
  let sum = 0xffffffff;
  for (const byte of bytes) {
    sum ^= byte;
    for (let k = 0; k < 8; k++) sum = sum & 1 ? (sum >>> 1) ^ 0xedb88320 : sum >>> 1;
  }
  return (sum ^ 0xffffffff) >>> 0;
}

function attribute(name: string, type: string, value: Uint8Array): Uint8Array {
  return joined([text(name), text(type), ints(value.length), value]);
}

function text(word: string): Uint8Array {
  return new TextEncoder().encode(`${word}\0`);
}

function ints(...values: number[]): Uint8Array {
  return new Uint8Array(new Int32Array(values).buffer);
}

function floats(...values: number[]): Uint8Array {
  return new Uint8Array(new Float32Array(values).buffer);
}

function joined(parts: readonly Uint8Array[]): Uint8Array {
  const all = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}
