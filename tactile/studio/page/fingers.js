// The taxels of each finger: squares, shear arrows, the load, the code, and the planes of programs.

import { h, paint } from "./base.js";

/** @typedef {import("./base.js").Content} Content */

/** Digits for people. @param {number} value @param {number} [digits] */
export const short = (value, digits = 3) => String(Number(value.toPrecision(digits)));

/** What the validity of a load means. @type {{[validity: string]: string}} */
const MEANING = { inside: "the load is within sqrt(2) depths of the taxels, where its place is reliable", outside: "the load is sqrt(2) depths or farther away", "no single point load": "the signals fit no point load, nor a few that are well apart" };

/** Newtons for people. @param {number} value */
const newtons = (value) => `${Math.abs(value) < 5e-4 ? 0 : short(value, 2)} N`;

/** An arrow from its middle. @param {CanvasRenderingContext2D} c @param {number} x @param {number} y @param {number} dx @param {number} dy */
function arrow(c, x, y, dx, dy) {
  const length = Math.hypot(dx, dy), head = Math.min(length, Math.max(5, length * 0.3));
  if (length < 1.5) return;
  const [ux, uy] = [dx / length, dy / length], [tx, ty] = [x + dx / 2, y + dy / 2];
  c.beginPath();
  c.moveTo(x - dx / 2, y - dy / 2);
  c.lineTo(tx - ux * head * 0.7, ty - uy * head * 0.7);
  c.stroke();
  c.beginPath();
  c.moveTo(tx, ty);
  c.lineTo(tx - ux * head - uy * head * 0.45, ty - uy * head + ux * head * 0.45);
  c.lineTo(tx - ux * head + uy * head * 0.45, ty - uy * head - ux * head * 0.45);
  c.fill();
}

/** Fits a canvas to a size in CSS pixels, and returns its context in them. @param {HTMLCanvasElement} canvas @param {number} width @param {number} height */
export function fitted(canvas, width, height) {
  const ratio = devicePixelRatio, context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
  [canvas.style.width, canvas.style.height] = [`${width}px`, `${height}px`];
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return context;
}

/** A load in words. @param {Content} now */
function words({ load, validity }) {
  const others = load.others.map((/** @type {Content} */ one) => ` and ${newtons(one.F)}`).join("");
  const place = load.x === null ? "" : ` at (${(load.x * 1e3).toFixed(2)}, ${(load.y * 1e3).toFixed(2)}) mm`;
  return `${newtons(load.F)}${others}${place}; shear ${newtons(Math.hypot(load.Q ?? 0, load.R ?? 0))}; ${validity}`;
}

export class Fingers {
  /** @param {HTMLElement} host @param {HTMLCanvasElement} legend @param {Content} known @param {Uint8Array[]} maps colour maps of a press, and of press and pull */
  constructor(host, legend, known, maps) {
    this.known = known;
    this.legend = legend;
    if (known.arrays[0].unit === "‰") legend.title = "‰: strain in thousandths";
    this.maps = maps.map((bytes) => new Uint32Array(bytes.slice().buffer));
    this.pulls = this.smooth = false;
    this.cards = known.arrays.map((/** @type {Content} */ array) => {
      const canvas = h("canvas", { role: "img", "aria-label": `taxels of ${array.name}` });
      const card = { array, canvas, box: h("div", { class: "box" }, canvas), load: h("output", { class: "load", "data-finger": array.name }),
        arrows: h("pre", { class: "arrows", "aria-label": "code", title: "directions of the shear that is above the dead band" }), bits: h("pre", { class: "bits", "aria-label": "sign code", title: "sign code: two bits per taxel, x then y; 1 is a positive shear" }), planes: h("div") };
      host.append(h("article", { class: "finger" }, h("h2", {}, `${array.name}, ${array.rows} x ${array.cols}`), card.box,
        h("div", { class: array.rows > 4 ? "side dense" : "side" }, card.arrows, card.bits, card.planes), card.load));
      return card;
    });
  }

  /** Pixels of a pitch: the same for all fingers, so that arrows of one length are one shear. */
  pitch() {
    return Math.max(8, Math.min(...this.cards.map((/** @type {Content} */ { array, box }) =>
      Math.min(box.clientWidth / (array.cols + 1), box.clientHeight / (array.rows + 1)))));
  }

  /** @param {Content} frame @param {Uint8Array[]} buffers */
  show(frame, buffers) {
    let next = 0;
    const pitch = this.pitch();
    this.cards.forEach((/** @type {Content} */ card, /** @type {number} */ k) => {
      const now = frame.fingers[k], context = fitted(card.canvas, card.box.clientWidth, card.box.clientHeight);
      if (!now) return;
      const bytes = buffers[next++], values = new Float32Array(bytes.slice().buffer);
      this.draw(context, card, values, frame.scales[card.array.quantity], pitch, now);
      card.arrows.textContent = now.arrows.replaceAll(" ", "\n");
      card.bits.textContent = now.bits.match(new RegExp(`.{${2 * card.array.cols}}`, "g")).map((/** @type {string} */ row) => row.match(/../g)?.join(" ")).join("\n");
      card.load.textContent = now.load ? words(now) : now.validity;
      card.load.title = `${card.load.textContent}${MEANING[now.validity] ? `\n${now.validity}: ${MEANING[now.validity]}` : ""}`;
      next = this.programs(card, now.outputs, buffers, next);
    });
    this.key(frame.scales[this.cards[0].array.quantity], this.cards[0].array, pitch);
  }

  /** @param {CanvasRenderingContext2D} c @param {Content} card @param {Float32Array} values @param {Content} scale @param {number} pitch @param {Content} now */
  draw(c, { array, box }, values, scale, pitch, now) {
    const { rows, cols } = array, left = (box.clientWidth - cols * pitch) / 2, top = (box.clientHeight - rows * pitch) / 2;
    const press = (/** @type {number} */ i) => array.inward * values[3 * i + 2];
    for (let i = 0; i < rows * cols; i++) this.pulls ||= press(i) < -Math.max(this.known.thresholds.contact_level, scale.normal * 0.1);
    const map = this.maps[this.pulls ? 1 : 0];
    const shade = (/** @type {number} */ v) => map[Math.max(0, Math.min(255, Math.round(255 * (this.pulls ? 0.5 + v / scale.normal / 2 : v / scale.normal / 1.6))))];
    const css = (/** @type {number} */ colour) => `rgb(${colour & 255} ${(colour >> 8) & 255} ${(colour >> 16) & 255})`;
    if (this.smooth) {
      const small = new OffscreenCanvas(cols, rows), data = new ImageData(cols, rows);
      new Uint32Array(data.data.buffer).forEach((_, i, all) => (all[i] = shade(press(i) || 0)));
      /** @type {OffscreenCanvasRenderingContext2D} */ (small.getContext("2d")).putImageData(data, 0, 0);
      c.imageSmoothingEnabled = true;
      c.drawImage(small, left, top, cols * pitch, rows * pitch);
    }
    c.strokeStyle = "#888";
    const gap = pitch > 14 ? 1.5 : 0.5;
    for (let i = 0; i < rows * cols; i++) {
      const x = left + (i % cols) * pitch, y = top + Math.floor(i / cols) * pitch;
      if (Number.isNaN(press(i))) {
        const m = pitch * 0.3;
        c.strokeRect(x + gap, y + gap, pitch - 2 * gap, pitch - 2 * gap);
        c.beginPath();
        for (const [a, b] of [[m, m], [m, pitch - m]]) {
          c.moveTo(x + a, y + b);
          c.lineTo(x + pitch - a, y + pitch - b);
        }
        c.stroke();
      } else if (!this.smooth) {
        c.fillStyle = css(shade(press(i)));
        c.fillRect(x + gap, y + gap, pitch - 2 * gap, pitch - 2 * gap);
        c.strokeRect(x + gap, y + gap, pitch - 2 * gap, pitch - 2 * gap);
      }
    }
    this.arrows(c, array, values, (this.known.reach * pitch) / scale.shear, pitch, left, top);
    const place = (/** @type {Content} */ load) => [left + (cols / 2 + (load.x - array.origin[0]) / array.pitch) * pitch, top + (rows / 2 + (load.y - array.origin[1]) / array.pitch) * pitch];
    for (const load of now.load ? [now.load, ...now.load.others] : []) this.load(c, load, now.load.sure, place(load));
  }

  /** Draws the shear of taxels, or the means of blocks of a large array.
   * @param {CanvasRenderingContext2D} c @param {Content} array @param {Float32Array} values @param {number} scale @param {number} pitch @param {number} left @param {number} top */
  arrows(c, { rows, cols }, values, scale, pitch, left, top) {
    const block = Math.ceil(Math.max(rows, cols) / this.known.arrows);
    c.strokeStyle = c.fillStyle = this.known.arrow;
    c.lineWidth = Math.max(1.5, Math.min(4, pitch * block * 0.06));
    for (let i = 0; i < rows; i += block)
      for (let j = 0; j < cols; j += block) {
        let n = 0, x = 0, y = 0;
        for (let k = i; k < Math.min(rows, i + block); k++)
          for (let l = j; l < Math.min(cols, j + block); l++) {
            const at = 3 * (k * cols + l);
            if (Number.isNaN(values[at])) continue;
            [n, x, y] = [n + 1, x + values[at], y + values[at + 1]];
          }
        if (n) arrow(c, left + (Math.min(j + block, cols) + j) * pitch / 2, top + (Math.min(i + block, rows) + i) * pitch / 2, (x / n) * scale * block, (y / n) * scale * block);
      }
    c.lineWidth = 1;
  }

  /** A located load is a disc with its force, an uncertain one a cross. @param {CanvasRenderingContext2D} c @param {Content} load @param {boolean} sure @param {number[]} place */
  load(c, load, sure, [x, y]) {
    if (!Number.isFinite(x + y) || load.x === null) return;
    c.save();
    c.fillStyle = "#d55e00";
    c.beginPath();
    if (sure) {
      c.arc(x, y, 6, 0, 7);
      c.fill();
    } else for (const s of [1, -1]) {
      c.moveTo(x - 6, y - 6 * s);
      c.lineTo(x + 6, y + 6 * s);
    }
    for (const [colour, width] of /** @type {[string, number][]} */ (sure ? [["#fff", 2.5]] : [["#fff", 5], ["#777", 2.5]])) {
      [c.strokeStyle, c.lineWidth] = [colour, width];
      c.stroke();
    }
    c.font = "600 12px system-ui";
    c.strokeStyle = "#fff";
    c.fillStyle = "#1b1f24";
    c.lineWidth = 3;
    c.strokeText(newtons(load.F), x + 10, y + 4);
    c.fillText(newtons(load.F), x + 10, y + 4);
    c.restore();
  }

  /** @param {Content} card @param {Content[]} outputs @param {Uint8Array[]} buffers @param {number} next */
  programs({ planes }, outputs, buffers, next) {
    const names = outputs.map((one) => `${one.program}: ${one.name}`).join("\n");
    if (planes.dataset.names !== names) {
      planes.dataset.names = names;
      planes.replaceChildren(...outputs.map((one) => h("figure", { "data-output": one.name }, one.shape ? h("canvas", { role: "img", "aria-label": one.name }) : h("b"), h("figcaption", { title: one.program }, one.name))));
    }
    outputs.forEach((one, k) => {
      const inside = planes.children[k].firstChild;
      if (one.shape) paint(inside, buffers[next++], one.shape);
      else inside.textContent = one.value.map((/** @type {number} */ v) => short(Number(v))).join(" ");
    });
    return next;
  }

  /** Draws the scales. @param {Content} scale @param {Content} array @param {number} pitch */
  key(scale, array, pitch) {
    const c = fitted(this.legend, 420, 26), map = this.maps[this.pulls ? 1 : 0], ink = getComputedStyle(document.documentElement).getPropertyValue("--ink");
    const bytes = new Uint8ClampedArray(map.slice().buffer), strip = new OffscreenCanvas(256, 1), text = (/** @type {number} */ v) => `${short(v * array.factor, 2)} ${array.unit}`;
    /** @type {OffscreenCanvasRenderingContext2D} */ (strip.getContext("2d")).putImageData(new ImageData(bytes, 256, 1), 0, 0);
    c.font = "12px system-ui";
    c.fillStyle = ink;
    c.fillText("normal", 0, 17);
    c.drawImage(strip, 0, 0, this.pulls ? 256 : 160, 1, 48, 7, 90, 12);
    c.strokeStyle = "#888";
    c.strokeRect(48, 7, 90, 12);
    c.fillText(`${this.pulls ? "±" : ""}${text(scale.normal)}`, 144, 17);
    const length = (scale.key / scale.shear) * this.known.reach * pitch;
    c.fillText(`shear ${text(scale.key)}`, 225, 17);
    c.strokeStyle = c.fillStyle = this.known.arrow;
    c.lineWidth = 2;
    arrow(c, 320 + length / 2, 13, length, 0);
    this.legend.setAttribute("aria-label", `normal up to ${text(scale.normal)}; an arrow of ${Math.round(length)} pixels is a shear of ${text(scale.key)}`);
  }
}
