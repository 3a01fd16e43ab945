// Reads a message of a view from the console: a header in JSON after its length, then the picture.
/** @import { PictureHeader } from "../model/messages.d.ts" */

const decoder = new TextDecoder();

/** Header of a binary message, where its picture begins, and whether there is one or only the camera's status.
 * @type {(bytes: ArrayBuffer) => { header: PictureHeader, offset: number, isPicture: boolean }} */
export function parsePicture(bytes) {
  const length = new DataView(bytes).getUint16(0, true);
  const header = JSON.parse(decoder.decode(new Uint8Array(bytes, 2, length)));
  const offset = 2 + length;
  return { header, offset, isPicture: offset < bytes.byteLength };
}
