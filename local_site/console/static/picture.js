// Decodes a picture from the console: a header in JSON after its length, then the JPEG.
const decoder = new TextDecoder();

/** Header and JPEG bytes of a binary message; the JPEG is empty when there is only the camera's status. */
export function parsePicture(bytes) {
  const length = new DataView(bytes).getUint16(0, true);
  const header = JSON.parse(decoder.decode(new Uint8Array(bytes, 2, length)));
  return { header, jpeg: new Uint8Array(bytes, 2 + length) };
}
