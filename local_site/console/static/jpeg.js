// Decodes a JPEG: from memory where the browser can, else by way of a Blob, which costs it two more copies.

/** The picture in the rest of `bytes` from `offset`: a VideoFrame or an ImageBitmap; both want to be closed.
 * @type {(bytes: ArrayBuffer, offset: number) => Promise<VideoFrame | ImageBitmap>} */
export async function decodedJpeg(bytes, offset) {
  const data = new Uint8Array(bytes, offset);
  if (!("ImageDecoder" in self)) return createImageBitmap(new Blob([data], { type: "image/jpeg" }));
  const decoder = new ImageDecoder({ data, type: "image/jpeg" });
  try {
    return (await decoder.decode()).image;
  } finally {
    decoder.close();
  }
}
