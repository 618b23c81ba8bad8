// @ts-check
/** Where a hand may go, shaded over the picture it was found in. */

import { byId } from "./dom.js";

/** Green, thin enough for the picture to be seen through it. */
const SHADE = [65, 205, 140, 76];

/** @typedef {{type: "area", stamp: string, rows: number, columns: number, bits: string}} AreaNews */

export class Area {
  constructor() {
    this.canvas = byId("area", HTMLCanvasElement);
    this.legend = byId("area-legend", HTMLLabelElement);
    this.switch = byId("area-switch", HTMLInputElement);
    /** Stamp of the picture whose area is known. */
    this.known = "";
    /** Stamp of the picture whose area fits the one on the screen. */
    this.wanted = "-1";
    this.switch.addEventListener("change", () => this.show(this.wanted));
  }

  /** @param {AreaNews} news */
  take(news) {
    this.known = news.stamp;
    this.canvas.width = news.columns;
    this.canvas.height = news.rows;
    const context = this.canvas.getContext("2d");
    if (context === null) return;
    const bytes = Uint8Array.from(atob(news.bits), (character) => character.charCodeAt(0));
    const image = context.createImageData(news.columns, news.rows);
    for (let cell = 0; cell < news.rows * news.columns; cell++) {
      if (((bytes[cell >> 3] ?? 0) >> (7 - (cell & 7))) & 1) image.data.set(SHADE, 4 * cell);
    }
    context.putImageData(image, 0, 0);
    this.show(this.wanted);
  }

  /** @param {string} stamp of the picture whose area fits the one on the screen; "-1": none */
  show(stamp) {
    this.wanted = stamp;
    const fits = stamp !== "-1" && stamp === this.known;
    this.legend.hidden = !fits;
    this.canvas.hidden = !fits || !this.switch.checked;
  }
}
