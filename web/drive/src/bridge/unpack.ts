/** Numbers of 16 bits as src/neve/drive/packing.py packs them: the lesser byte first, deflated, in base64. */
export async function inflated(text: string): Promise<Uint16Array> {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const view = new DataView(await new Response(stream).arrayBuffer());
  return Uint16Array.from({ length: view.byteLength / 2 }, (_, k) => view.getUint16(2 * k, true));
}
