// Reads a message of a view from the console: a header in JSON after its length, then the picture.
/** @import { PictureHeader } from "../model/messages.d.ts" */

/** @typedef {{ header: PictureHeader, bytes: ArrayBuffer, offset: number, isPicture: boolean }} ViewMessage */

const decoder = new TextDecoder();

/** A binary message with its header, where its picture begins, and whether there is one or only the camera's status.
 * @type {(bytes: ArrayBuffer) => ViewMessage} */
export function parsePicture(bytes) {
  const length = new DataView(bytes).getUint16(0, true);
  const header = JSON.parse(decoder.decode(new Uint8Array(bytes, 2, length)));
  const offset = 2 + length;
  return { header, bytes, offset, isPicture: offset < bytes.byteLength };
}
