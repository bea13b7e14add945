// Elements, colours, and requests over a model, which is that of a notebook or a websocket.

/** @typedef {{[key: string]: any}} Content */
/** @typedef {{content: Content, buffers: Uint8Array[]}} Reply */
/** @typedef {{send(content: Content, callbacks?: any, buffers?: any[]): void, on(event: string, call: any): void}} Model */

export const WHITE = 16, GREY = 128, BLACK = 240;

/** Makes an element: h("button", {class: "x", onclick: f}, "text").
 * @param {string} tag @param {Content} [props] @param {...any} inside @returns {any} */
export function h(tag, props = {}, ...inside) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(props)) {
    if (value === undefined || value === null || value === false) continue;
    if (typeof value === "function") element.addEventListener(key.slice(2), value);
    else if (key === "value") /** @type {any} */ (element).value = value;
    else element.setAttribute(key, value === true ? "" : String(value));
  }
  element.append(...inside.flat().filter((one) => one !== null && one !== undefined));
  return element;
}

/** Colours of the 256 palette indices as little-endian RGBA: grey inside [-1, 1], orange above, blue below. */
export const PALETTE = (() => {
  const mix = (/** @type {number[]} */ a, /** @type {number[]} */ b, /** @type {number} */ s) =>
    a.map((v, i) => Math.round(v + (b[i] - v) * s));
  const colours = new Uint32Array(256);
  for (let i = 0; i < 256; i++) {
    const level = Math.round(255 - ((i - WHITE) * 255) / (BLACK - WHITE));
    const [r, g, b] = i > BLACK ? mix([64, 26, 8], [205, 98, 20], (i - BLACK - 1) / 14)
      : i < WHITE ? mix([224, 240, 252], [112, 176, 224], (WHITE - 1 - i) / 15) : [level, level, level];
    colours[i] = (255 << 24) | (b << 16) | (g << 8) | r;
  }
  return colours;
})();

/** The pixels of each canvas, used again for every picture. @type {WeakMap<HTMLCanvasElement, ImageData>} */
const IMAGES = new WeakMap();

/** Draws palette indices (rows, cols) into a canvas of as many pixels.
 * @param {HTMLCanvasElement} canvas @param {Uint8Array} bytes @param {number[]} shape @param {Uint32Array} [colours] */
export function paint(canvas, bytes, shape, colours = PALETTE) {
  const [rows, cols] = shape, context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  if (canvas.width !== cols || canvas.height !== rows) [canvas.width, canvas.height] = [cols, rows];
  let image = IMAGES.get(canvas);
  if (image?.width !== cols || image.height !== rows) IMAGES.set(canvas, (image = context.createImageData(cols, rows)));
  const pixels = new Uint32Array(image.data.buffer);
  for (let i = 0; i < pixels.length; i++) pixels[i] = colours[bytes[i]];
  context.putImageData(image, 0, 0);
}

/** Requests and their replies over a model; of requests in one slot only the last one waits. */
export class Link {
  /** @param {Model} model */
  constructor(model) {
    this.model = model;
    this.number = 0;
    /** @type {Map<number, {yes: (reply: Reply) => void, no: (error: Error) => void}>} */
    this.asked = new Map();
    /** @type {Map<string, {busy: boolean, next: null | (() => Promise<any>)}>} */
    this.slots = new Map();
    /** @type {Set<(reply: Reply) => void>} */
    this.seen = new Set();
    /** @type {(text: string) => void} */
    this.failed = () => {};
    /** @type {(busy: boolean) => void} */
    this.waits = () => {};
    model.on("msg:custom", (/** @type {Content} */ content, /** @type {any[]} */ buffers) => {
      const views = (buffers || []).map((b) => (b instanceof Uint8Array ? b : new Uint8Array(b.buffer || b)));
      const waits = this.asked.get(content.id);
      this.asked.delete(content.id);
      if (content.is === "error") {
        this.failed(content.text);
        waits?.no(new Error(content.text));
        return;
      }
      const reply = { content, buffers: views };
      for (const call of this.seen) call(reply);
      waits?.yes(reply);
    });
  }

  /** @param {Content} content @param {Uint8Array[]} [buffers] @returns {Promise<Reply>} */
  ask(content, buffers = []) {
    const id = ++this.number;
    let waited = false;
    const late = setTimeout(() => this.waits((waited = true)), 2500);
    return new Promise((yes, no) => {
      const over = (/** @type {any} */ call) => (/** @type {any} */ value) => {
        clearTimeout(late);
        if (waited) this.waits(false);
        call(value);
      };
      this.asked.set(id, { yes: over(yes), no: over(no) });
      this.model.send({ ...content, id }, undefined, buffers);
    });
  }

  /** Asks when the slot's last request is answered; what waited in the slot is dropped.
   * @param {string} slot @param {() => Promise<any>} make */
  async latest(slot, make) {
    const state = this.slots.get(slot) || { busy: false, next: null };
    this.slots.set(slot, state);
    state.next = make;
    if (state.busy) return;
    state.busy = true;
    while (state.next) {
      const go = state.next;
      state.next = null;
      await go().catch(() => {});
    }
    state.busy = false;
  }
}
