// A canvas of a plane, in which cells are pointed at and drawn.

import { BLACK, WHITE, h, paint } from "./base.js";

/** One canvas with a marked cell and an overlay; it fits its box and knows which cell a pointer is on. */
export class Pane {
  /** @param {string} label */
  constructor(label) {
    this.shape = [1, 1];
    /** @type {Uint8Array} */
    this.bytes = new Uint8Array([WHITE]);
    this.canvas = h("canvas", { tabindex: 0, role: "img", "aria-label": label });
    this.overlay = h("canvas", { class: "cw-overlay" });
    this.mark = h("div", { class: "cw-mark", hidden: true });
    this.stack = h("div", { class: "cw-stack" }, this.canvas, this.overlay, this.mark);
    this.box = h("div", { class: "cw-box" }, this.stack);
    this.cursor = [0, 0];
    new ResizeObserver(() => this.fit()).observe(this.box);
  }

  /** @param {Uint8Array} bytes @param {number[]} shape */
  show(bytes, shape) {
    const grown = shape[0] !== this.shape[0] || shape[1] !== this.shape[1];
    [this.bytes, this.shape] = [bytes, shape];
    paint(this.canvas, bytes, shape);
    if (grown) {
      this.fit();
      this.mark.hidden = true;
      this.overlay.width = this.overlay.height = 1;
    }
  }

  fit() {
    const [rows, cols] = this.shape, { clientWidth: width, clientHeight: height } = this.box;
    const scale = Math.min(width / cols, height / rows), whole = scale > 2 ? Math.floor(scale) : scale;
    this.stack.style.width = `${cols * whole}px`;
    this.stack.style.height = `${rows * whole}px`;
  }

  /** @param {PointerEvent} event @returns {[number, number]} */
  cell(event) {
    const at = this.canvas.getBoundingClientRect(), [rows, cols] = this.shape;
    const row = Math.floor(((event.clientY - at.top) / at.height) * rows);
    const col = Math.floor(((event.clientX - at.left) / at.width) * cols);
    return [Math.max(0, Math.min(rows - 1, row)), Math.max(0, Math.min(cols - 1, col))];
  }

  /** @param {number} row @param {number} col */
  point(row, col) {
    const [rows, cols] = this.shape;
    this.cursor = [row, col];
    this.mark.hidden = false;
    Object.assign(this.mark.style, {
      left: `${(col / cols) * 100}%`, top: `${(row / rows) * 100}%`, width: `${100 / cols}%`, height: `${100 / rows}%`,
    });
  }

  /** Lets the pane be drawn in, and its cells be inspected where it shows the state.
   * @param {import("./view.js").View} view @param {() => string} plane the plane that it shows: input, start or state */
  bind(view, plane) {
    const ink = () => Number(/** @type {any} */ (view.ink.querySelector("input:checked")).value);
    let last = /** @type {any} */ (null), dirty = /** @type {any} */ (null), moved = false, value = BLACK;
    const dab = (/** @type {number} */ row, /** @type {number} */ col) => {
      const size = Number(view.brush.value), r = (size - 1) / 2, [rows, cols] = this.shape;
      for (let i = Math.ceil(row - r); i <= row + r; i++)
        for (let j = Math.ceil(col - r); j <= col + r; j++) {
          const inside = size < 4 || (i - row) ** 2 + (j - col) ** 2 <= r * r + 0.5;
          if (!inside || i < 0 || j < 0 || i >= rows || j >= cols) continue;
          this.bytes[i * cols + j] = value;
          dirty = dirty ? [Math.min(dirty[0], i), Math.min(dirty[1], j), Math.max(dirty[2], i), Math.max(dirty[3], j)] : [i, j, i, j];
        }
    };
    const line = (/** @type {number[]} */ from, /** @type {number[]} */ to) => {
      const steps = Math.max(Math.abs(to[0] - from[0]), Math.abs(to[1] - from[1]), 1);
      for (let k = 0; k <= steps; k++)
        dab(Math.round(from[0] + ((to[0] - from[0]) * k) / steps), Math.round(from[1] + ((to[1] - from[1]) * k) / steps));
      paint(this.canvas, this.bytes, this.shape);
      view.link.latest(`draw ${plane()}`, send);
    };
    const send = async () => {
      if (!dirty) return;
      const [top, left, bottom, right] = dirty, cols = this.shape[1], wide = right - left + 1;
      dirty = null;
      const bytes = new Uint8Array((bottom - top + 1) * wide);
      for (let i = top; i <= bottom; i++) bytes.set(this.bytes.subarray(i * cols + left, i * cols + right + 1), (i - top) * wide);
      await view.link.ask({ do: "draw", plane: plane(), row: top, col: left, rows: bottom - top + 1, cols: wide,
        live: view.playing, layer: view.layer, frame: view.frame }, [bytes]);
    };
    const state = () => plane() === "state";
    const begin = (/** @type {number[]} */ cell) => {
      view.stroke = true;
      if (state()) view.pause();
      this.bytes = this.bytes.slice();
      line(cell, cell);
    };
    const end = () => {
      view.link.latest(`draw ${plane()}`, async () => {
        await send();
        view.stroke = false;
        if (!state()) await view.restart();
        view.ended = false;
        view.play();
      });
    };
    this.canvas.addEventListener("pointerdown", (/** @type {PointerEvent} */ event) => {
      this.canvas.setPointerCapture(event.pointerId);
      value = event.button === 2 ? WHITE : ink();
      [last, moved] = [this.cell(event), false];
      if (!state()) begin(last);
    });
    this.canvas.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => {
      if (!last) return;
      const cell = this.cell(event);
      if (cell[0] === last[0] && cell[1] === last[1]) return;
      if (state() && !moved) begin(last);
      moved = true;
      line(last, cell);
      last = cell;
    });
    const up = () => {
      if (!last) return;
      if (state() && !moved) view.inspect(last[0], last[1]);
      else end();
      last = null;
    };
    this.canvas.addEventListener("pointerup", up);
    this.canvas.addEventListener("pointercancel", up);
    this.canvas.addEventListener("contextmenu", (/** @type {Event} */ event) => event.preventDefault());
    this.canvas.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
      const move = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] }[event.key];
      if (move) this.point(Math.max(0, Math.min(this.shape[0] - 1, this.cursor[0] + move[0])),
        Math.max(0, Math.min(this.shape[1] - 1, this.cursor[1] + move[1])));
      else if (event.key === "Enter" && state()) view.inspect(this.cursor[0], this.cursor[1]);
      else if (event.key === "Enter") {
        value = ink();
        begin(this.cursor);
        end();
      } else return;
      event.preventDefault();
    });
  }
}
