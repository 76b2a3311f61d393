// Decodes the images of one canvas. The browser may decode a later one sooner; the older one is then left out.

export class ImageDecoder {
  #begun = 0;
  #newest = 0;

  // Returns the image, null if the browser cannot read it, and nothing if it is not the newest any more.
  async decode(jpeg) {
    const number = ++this.#begun;
    const image = await createImageBitmap(jpeg, { imageOrientation: "none" }).catch(() => null);
    if (number < this.#newest) {
      image?.close();
      return undefined;
    }
    this.#newest = number;
    return image;
  }

  // Leaves out what is decoded now.
  skip() {
    this.#newest = ++this.#begun;
  }
}
