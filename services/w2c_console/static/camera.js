// @ts-check
/** The picture and what is drawn on it. Both change in the same instant: a marker on another picture would lie. */

import { Area } from "./area.js";
import { Connection } from "./connection.js";
import { byId, makeSvg, shortId } from "./dom.js";

const DOT_RADIUS = 5;
const RING_RADIUS = 18;
const HINT = "Click on the picture to point at a place.";

/**
 * @typedef {{frame_stamp: string, robot_boot: string}} Picture which one it is, for what is said about it
 * @typedef {{target_id: string, u: number, v: number, state: string, corrected: boolean}} Marker
 * @typedef {{left: number, top: number, right: number, bottom: number, phrase: string}} Box
 * @typedef {{
 *   sequence: number, stamp: string, robot_boot: string, width: number, height: number, age_s: number, silent_s: number,
 *   limit_s: number, frozen: boolean, notice: string, marker: Marker | null, destination: Marker | null,
 *   moving_to: string, boxes: Box[], area: string,
 * }} Header
 */

export class Camera {
  /**
   * @param {{
   *   point: (u: number, v: number, picture: Picture) => void,
   *   shown: () => void,
   *   connected: (open: boolean) => void,
   * }} handlers
   */
  constructor(handlers) {
    this.handlers = handlers;
    this.canvas = byId("canvas", HTMLCanvasElement);
    this.overlay = byId("overlay", SVGSVGElement);
    this.area = new Area();
    this.live = false;
    /** @type {Header | null} what is on the screen */
    this.header = null;
    this.heardAt = 0;
    this.brokenSequence = 0;
    this.overlay.addEventListener("click", (event) => this.click(event));
    byId("live", HTMLButtonElement).addEventListener("click", () => this.toggleLive());
    setInterval(() => this.showAge(), 250);
    this.connection = new Connection("/ws/camera", {
      greet: (send) => send(this.wish()),
      receive: async (data, send) => {
        await this.receive(data);
        send(this.wish());
      },
      change: (open) => handlers.connected(open),
    });
  }

  /** @returns {Picture} the one on the screen; "-1": none. */
  get picture() {
    return { frame_stamp: this.header?.stamp ?? "-1", robot_boot: this.header?.robot_boot ?? "" };
  }

  /** The target as drawn on the screen. */
  get marker() {
    return this.header?.marker ?? null;
  }

  /** Id of the target that the robot moves to while another one is drawn; "": there is none. */
  get movingTo() {
    return this.header?.moving_to ?? "";
  }

  wish() {
    return JSON.stringify({ shown: this.header?.sequence ?? 0, live: this.live });
  }

  /** @param {ArrayBuffer} data */
  async receive(data) {
    const length = new DataView(data).getUint32(0);
    /** @type {Header} */
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
    const jpeg = new Uint8Array(data, 4 + length);
    const heardAt = performance.now();
    if (jpeg.length > 0) {
      const bitmap = await createImageBitmap(new Blob([jpeg], { type: "image/jpeg" })).catch(() => null);
      this.brokenSequence = bitmap === null ? header.sequence : 0;
      this.draw(bitmap, header);
    }
    this.heardAt = heardAt;
    this.header = header;
    this.drawOverlay(header);
    this.showAge();
    this.handlers.shown();
  }

  /**
   * @param {ImageBitmap | null} bitmap
   * @param {Header} header
   */
  draw(bitmap, header) {
    this.canvas.width = header.width;
    this.canvas.height = header.height;
    this.overlay.setAttribute("viewBox", `0 0 ${header.width} ${header.height}`);
    if (bitmap !== null) this.canvas.getContext("2d")?.drawImage(bitmap, 0, 0);
    bitmap?.close();
  }

  /** @param {Header} header */
  drawOverlay(header) {
    byId("boxes", SVGGElement).replaceChildren(...header.boxes.map(boxShape));
    this.area.show(header.area);
    const marker = header.marker;
    const markers = marker === null ? [] : [markerShape(marker, header)];
    if (header.destination !== null) markers.unshift(destinationShape(header.destination, header));
    byId("marker", SVGGElement).replaceChildren(...markers);
    byId("picture", HTMLElement).classList.toggle("frozen", header.frozen);
    const button = byId("live", HTMLButtonElement);
    if (header.notice === "") this.live = false;
    button.hidden = !header.frozen && !this.live;
    button.textContent = this.live ? "Back to the target" : "Show live picture";
    byId("notice", HTMLElement).classList.toggle("raised", header.notice !== "");
    const text = header.notice || HINT;
    const notice = byId("notice-text", HTMLElement);
    if (notice.textContent !== text) notice.textContent = text;
  }

  showAge() {
    const since = (performance.now() - this.heardAt) / 1000;
    const header = this.header;
    const alarm = byId("alarm", HTMLElement);
    const age = byId("age", HTMLElement);
    if (header === null || header.sequence === 0) {
      age.textContent = "no picture yet";
      alarm.hidden = true;
      return;
    }
    const silent = header.silent_s + since;
    const broken = this.brokenSequence === header.sequence;
    age.textContent = `${header.frozen ? "frozen, " : ""}${(header.age_s + since).toFixed(1)} s old`;
    alarm.hidden = silent <= header.limit_s && !broken;
    const text = broken ? "the picture cannot be decoded" : `no picture for ${Math.floor(silent)} s`;
    if (alarm.textContent !== text) alarm.textContent = text;
    byId("picture", HTMLElement).classList.toggle("stale", !alarm.hidden);
  }

  toggleLive() {
    this.live = !this.live;
  }

  /** @param {MouseEvent} event */
  click(event) {
    const matrix = this.overlay.getScreenCTM();
    const header = this.header;
    if (matrix === null || header === null || header.sequence === 0) return;
    const pixel = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
    if (pixel.x < 0 || pixel.y < 0 || pixel.x >= header.width || pixel.y >= header.height) return;
    this.handlers.point(pixel.x, pixel.y, this.picture);
  }
}

/**
 * @param {Marker} marker
 * @param {Header} header
 */
function markerShape(marker, header) {
  const { u, v } = marker;
  const leftwards = u > header.width - 140;
  return makeSvg(
    "g",
    {
      role: "img",
      "aria-label": `target ${marker.target_id}`,
      class: `marker ${marker.corrected ? "corrected" : "predicted"} ${marker.state}`,
    },
    makeSvg("circle", { class: "halo", cx: u, cy: v, r: RING_RADIUS }),
    makeSvg("circle", { class: "ring", cx: u, cy: v, r: RING_RADIUS }),
    makeSvg("circle", { class: "dot", cx: u, cy: v, r: DOT_RADIUS }),
    makeSvg(
      "text",
      { x: leftwards ? u - 28 : u + 28, y: v + 7, "text-anchor": leftwards ? "end" : "start" },
      shortId(marker.target_id),
    ),
  );
}

/**
 * Where the robot moves to while another target waits for a yes: another shape, so that no colour is needed to tell.
 * @param {Marker} marker
 * @param {Header} header
 */
function destinationShape(marker, header) {
  const { u, v } = marker;
  const r = RING_RADIUS;
  const path = `M ${u} ${v - r} L ${u + r} ${v} L ${u} ${v + r} L ${u - r} ${v} Z`;
  const leftwards = u > header.width - 240;
  const label = `moving to ${shortId(marker.target_id)}`;
  return makeSvg(
    "g",
    { role: "img", "aria-label": label, class: "marker destination" },
    makeSvg("path", { class: "halo", d: path }),
    makeSvg("path", { class: "ring", d: path }),
    makeSvg("text", { x: leftwards ? u - 28 : u + 28, y: v + 7, "text-anchor": leftwards ? "end" : "start" }, label),
  );
}

/** @param {Box} box */
function boxShape(box) {
  const width = Math.max(0, box.right - box.left);
  const height = Math.max(0, box.bottom - box.top);
  const y = box.top > 30 ? box.top - 9 : box.top + 24;
  return makeSvg(
    "g",
    { role: "img", "aria-label": `object ${box.phrase}`, class: "box" },
    makeSvg("rect", { x: box.left, y: box.top, width, height, rx: 4 }),
    makeSvg("text", { x: box.left + 4, y }, box.phrase),
  );
}
