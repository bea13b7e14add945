// The events: a ribbon of spans from onset to end, and their list.

import { h } from "./base.js";
import { fitted } from "./fingers.js";

/** @typedef {import("./base.js").Content} Content */

const LANE = 14, NAMES = 52;

/** Whether black is read better than white on a colour. @param {string} hex */
const light = (hex) => [1, 3, 5].reduce((sum, at, k) => sum + [0.299, 0.587, 0.114][k] * parseInt(hex.slice(at, at + 2), 16), 0) > 140;

export class Ribbon {
  /** @param {HTMLCanvasElement} canvas @param {HTMLElement} list @param {Content} known @param {(t: number) => void} seek */
  constructor(canvas, list, known, seek) {
    this.canvas = canvas;
    this.list = list;
    this.known = known;
    /** @type {Content[]} */
    this.events = [];
    /** @type {Content | null} */
    this.again = null;
    /** @type {Map<string, number>} */
    this.lanes = new Map();
    /** Left, top, right and bottom of each bar, and its onset. @type {number[][]} */
    this.bars = [];
    const jump = (/** @type {Event} */ event) => {
      const item = /** @type {HTMLElement} */ (event.target).closest("li");
      if (item) seek(Number(item.dataset.t));
    };
    list.addEventListener("click", jump);
    list.addEventListener("keydown", (event) => event.key === "Enter" && jump(event));
    const over = (/** @type {MouseEvent} */ { offsetX: x, offsetY: y }) => this.bars.find(([left, top, right, bottom]) => x >= left && x <= right && y >= top && y <= bottom);
    canvas.addEventListener("click", (event) => {
      const bar = over(event);
      if (bar) seek(bar[4]);
    });
    canvas.addEventListener("pointermove", (event) => (canvas.style.cursor = over(event) ? "pointer" : ""));
  }

  /** @param {string} kind */
  colour(kind) {
    return this.known.kinds[kind] || this.known.own;
  }

  /** @param {Content[] | undefined} events @param {number} t @param {number} begin of the time axis */
  show(events, t, begin) {
    if (events) {
      this.events = events;
      this.list.replaceChildren(...events.slice(-60).reverse().map((one) => {
        const item = h("li", { title: `${one.words}: go to its onset`, "data-t": one.t, tabindex: 0 }, h("time", {}, one.t.toFixed(2)), ` ${one.finger} `, h("b", {}, one.words));
        item.style.setProperty("--kind", this.colour(one.kind));
        return item;
      }));
    }
    /** @type {[string, Content[]][]} */
    const parts = this.again ? [["", this.events], ["↻ ", t >= this.again.begin ? this.again.events : []]] : [["", this.events]];
    const names = [...this.known.arrays.map((/** @type {Content} */ a) => a.name), "hand"];
    /** @type {Content[]} */
    const rows = names.flatMap((finger) => parts.map(([word, list]) => ({ name: word + finger, again: word !== "", events: list.filter((e) => e.finger === finger) })))
      .filter((row) => !row.name.endsWith("hand") || row.events.length);
    for (const row of rows) row.height = LANE * (1 + Math.max(0, ...row.events.map((/** @type {Content} */ e) => this.lane(row, e)))) + 3;
    this.draw(rows, t, begin);
    this.canvas.setAttribute("aria-label", `events of the last ${this.known.span} s: ${this.events.map((e) => e.words).join(", ") || "none"}`);
  }

  /** The lane of an event: the first that is free at its onset; it keeps it. @param {Content} row @param {Content} event */
  lane(row, event) {
    const name = (/** @type {Content} */ e) => `${row.name} ${e.kind} ${e.t}`, kept = this.lanes.get(name(event));
    if (kept !== undefined) return kept;
    const taken = new Set(row.events.filter((/** @type {Content} */ e) => e !== event && e.t <= event.t && (e.end ?? Infinity) >= event.t).map((/** @type {Content} */ e) => this.lanes.get(name(e))));
    let lane = 0;
    while (taken.has(lane)) lane++;
    if (this.lanes.size > 5000) this.lanes.clear();
    this.lanes.set(name(event), lane);
    return lane;
  }

  /** @param {Content[]} rows @param {number} t @param {number} begin */
  draw(rows, t, begin) {
    const width = /** @type {HTMLElement} */ (this.canvas.parentElement).clientWidth, height = rows.reduce((sum, row) => sum + row.height, 0) + 14;
    const c = fitted(this.canvas, width, height), style = getComputedStyle(document.documentElement), { span } = this.known;
    const x = (/** @type {number} */ s) => NAMES + ((s - begin) / span) * (width - NAMES - 4);
    c.font = "11px system-ui";
    c.textBaseline = "middle";
    c.strokeStyle = style.getPropertyValue("--line");
    for (let s = Math.ceil(begin); s <= begin + span; s++) {
      c.beginPath();
      c.moveTo(x(s), 0);
      c.lineTo(x(s), height);
      c.stroke();
      c.fillStyle = style.getPropertyValue("--soft");
      if (s % 2 === 0) c.fillText(`${s} s`, Math.min(x(s) + 2, width - 24), height - 7);
    }
    let top = 0;
    this.bars = [];
    for (const row of rows) {
      c.fillStyle = style.getPropertyValue("--ink");
      c.fillText(row.name, 3, top + 9, NAMES - 6);
      for (const event of row.events) {
        const from = Math.max(NAMES, x(event.t)), to = Math.max(from + 3, x(Math.min(t, event.end ?? t))), y = top + 2 + LANE * this.lane(row, event);
        c.globalAlpha = row.again ? 0.6 : 1;
        c.fillStyle = this.colour(event.kind);
        c.fillRect(from, y, to - from, LANE - 3);
        this.bars.push([from, y, to, y + LANE - 3, event.t]);
        c.globalAlpha = 1;
        if (to - from < 24) continue;
        c.save();
        c.beginPath();
        c.rect(from, y, to - from - 2, LANE);
        c.clip();
        c.fillStyle = light(this.colour(event.kind)) ? "#000" : "#fff";
        c.fillText(event.words, from + 3, y + LANE / 2 - 1);
        c.restore();
      }
      top += row.height;
    }
    c.strokeStyle = style.getPropertyValue("--accent");
    c.beginPath();
    c.moveTo(x(t), 0);
    c.lineTo(x(t), height - 14);
    c.stroke();
  }
}
