// The panels Run and Cell: how the network is computed, and what one cell does.

import { h } from "./base.js";

/** @typedef {import("./base.js").Content} Content */
const uPlot = /** @type {any} */ (globalThis).uPlot;
const COLOURS = { light: ["#0072b2", "#d55e00", "#009e73", "#cc79a7"], dark: ["#56b4e9", "#e69f00", "#2fbf98", "#e29cc3"] };

/** A line plot that follows the theme. @param {HTMLElement} host @param {string[]} names @param {any[]} data @param {Content} more */
export function plot(host, names, data, more = {}) {
  const style = getComputedStyle(document.documentElement), ink = style.getPropertyValue("--ink"), line = style.getPropertyValue("--line");
  const axis = (/** @type {Content} */ own) => ({ stroke: ink, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1 }, font: "11px system-ui", ...own });
  const { axes = [{}, {}], series = [], height = 150, ...rest } = more;
  const colours = COLOURS[matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light"];
  host.replaceChildren();
  return new uPlot({
    width: Math.max(200, host.clientWidth), height, cursor: { show: false }, legend: { show: names.length > 2, live: false },
    scales: { x: { time: false } }, axes: [axis({ size: 34, ...axes[0] }), axis({ size: 42, ...axes[1] })],
    series: names.map((label, i) => (i ? { label, stroke: colours[(i - 1) % 4], width: 2, points: { show: false }, ...series[i - 1] } : { label })), ...rest,
  }, data, host);
}

/** How the network is computed. */
export class Rules {
  /** @param {HTMLElement} host @param {(changes: Content) => void} change */
  constructor(host, change) {
    const choice = (/** @type {string} */ name, /** @type {any} */ empty = undefined) => h("select", { name, onchange: (/** @type {any} */ e) => change({ [name]: e.target.value || empty }) });
    const number = (/** @type {string} */ name, /** @type {string} */ hint, /** @type {any} */ empty) => h("input", { name, placeholder: hint, inputmode: "decimal", oninput: (/** @type {any} */ e) => (e.target.dataset.typing = "1"), onchange: (/** @type {any} */ e) => {
      delete e.target.dataset.typing;
      const text = e.target.value.trim();
      change({ [name]: text === "" ? empty : Number.isFinite(Number(text)) ? Number(text) : text });
    } });
    this.fields = { boundary: choice("boundary"), cell: choice("cell"), scheme: choice("scheme", null), step: number("step", "the plan's", null),
      accuracy: number("accuracy", "none; 1e-3, binary, exact", null), backend: choice("backend"), duration: number("duration", "until settled", "settled"),
      initial_state: choice("initial_state") };
    const words = { boundary: "boundary", cell: "cell model", scheme: "scheme", step: "step h", accuracy: "accuracy", backend: "backend", duration: "running time", initial_state: "x(0) is" };
    this.fields.initial_state.onchange = (/** @type {any} */ e) => {
      const value = e.target.value;
      change({ initial_state: value.startsWith("=") ? Number(value.slice(1)) : value });
    };
    this.plan = h("dl", { class: "plan" });
    this.about = h("p", { class: "about" });
    host.append(...Object.entries(this.fields).map(([name, field]) => h("label", { class: "setting" }, h("span", {}, /** @type {any} */ (words)[name]), field)),
      h("h3", {}, "The plan, and why"), this.plan, h("h3", {}, "About the template"), this.about);
  }

  /** @param {Content} known */
  offer(known) {
    const fill = (/** @type {any} */ select, /** @type {string[]} */ names, /** @type {string} */ first = "") =>
      select.replaceChildren(...(first ? [h("option", { value: "" }, first)] : []), ...names.map((name) => h("option", { value: name }, name)));
    fill(this.fields.boundary, known.boundaries);
    fill(this.fields.cell, known.cells);
    fill(this.fields.scheme, known.schemes, "the plan's choice");
    fill(this.fields.backend, known.backends);
    this.fields.initial_state.replaceChildren(...[["picture", "the input"], ["given", "a picture of its own"], ["=0", "0 everywhere"], ["=-1", "-1 everywhere"], ["=1", "+1 everywhere"]]
      .map(([value, text]) => h("option", { value }, text)));
  }

  /** @param {Content} now */
  show(now) {
    const set = (/** @type {any} */ field, /** @type {any} */ value) => {
      if (field.options && ![...field.options].some((one) => one.value === String(value))) field.append(h("option", { value }, value));
      if (!field.dataset.typing) field.value = value ?? "";
    };
    const fixed = /^fixed:(.*),\1$/.exec(now.boundary);
    set(this.fields.boundary, fixed ? `fixed:${fixed[1]}` : now.boundary);
    set(this.fields.cell, now.cell);
    set(this.fields.scheme, now.scheme ?? "");
    set(this.fields.step, now.step);
    set(this.fields.accuracy, now.accuracy);
    set(this.fields.backend, now.backend);
    set(this.fields.duration, now.duration === "settled" ? "" : now.duration);
    const start = Array.isArray(now.initial_state) ? now.initial_state.join(", ") : typeof now.initial_state === "number" ? `=${now.initial_state}` : now.initial_state;
    set(this.fields.initial_state, start === "any" ? "=0" : start);
    this.plan.replaceChildren(...now.plan.flatMap((/** @type {string[]} */ [what, why]) => [h("dt", {}, what), h("dd", {}, why)]));
    this.about.textContent = [now.summary, now.note, `Source: ${now.reference}`].filter(Boolean).join(" ");
  }
}

/** What one cell does: state over time, contributions of its neighbours, dynamic route. */
export class CellPanel {
  /** @param {HTMLElement} host @param {import("./view.js").View} view */
  constructor(host, view) {
    this.view = view;
    this.place = /** @type {number[] | null} */ (null);
    this.title = h("p", { name: "cell-title" }, "Click a cell of the state, or choose one with the arrow keys and Enter.");
    this.time = h("div");
    this.route = h("div");
    this.parts = h("div", { class: "parts" });
    this.heads = [h("h3", { hidden: true }, "State and output over time"), h("h3", { hidden: true }, "What drives it now"), h("h3", { hidden: true }, "Dynamic route: dx/dt against x")];
    this.foot = h("p", { class: "about" });
    host.append(this.title, this.heads[0], this.time, this.heads[1], this.parts, this.heads[2], this.route, this.foot);
  }

  /** @param {number} row @param {number} col */
  inspect(row, col) {
    this.place = [row, col];
    return this.refresh();
  }

  /** Asks for the cell again, at the present time. */
  refresh() {
    if (!this.place) return undefined;
    const [row, col] = this.place, [rows, cols] = this.view.session.shape;
    if (row >= rows || col >= cols) return undefined;
    return this.view.link.latest("cell", async () => this.show((await this.view.link.ask({ do: "cell", row, col, layer: this.view.layer })).content));
  }

  /** @param {Content} cell */
  show(cell) {
    for (const head of this.heads) head.hidden = false;
    const last = cell.x.length - 1, number = (/** @type {number} */ v) => String(Number(v.toFixed(3)));
    this.title.replaceChildren(h("b", {}, `row ${cell.row}, column ${cell.col}`), ` x = ${number(cell.x[last])}, y = ${number(cell.y[last])}. `,
      cell.final ? `Its output stays from t = ${number(cell.final)}.` : "Its output has not changed.");
    plot(this.time, ["t", "x", "y", "A∗y", "B∗u"], [cell.t, cell.x, cell.y, cell.feedback, cell.control], { height: 165, series: [{ width: 3 }, { dash: [5, 3] }, { width: 1 }, { width: 1 }] });
    const grid = (/** @type {string} */ name, /** @type {number[][]} */ values) => {
      const box = h("div", { class: "grid" }, values.flat().map((v) => h("span", { class: `weight ${v > 0 ? "plus" : v < 0 ? "minus" : ""}` }, number(v))));
      box.style.gridTemplateColumns = `repeat(${values.length}, 1fr)`;
      return h("div", { class: "grid-box" }, h("b", {}, name), box);
    };
    this.parts.replaceChildren(grid("A∗y", cell.A), grid("B∗u", cell.B),
      h("p", {}, `z ${number(cell.z)}${Math.abs(cell.terms) > 1e-9 ? `, terms ${number(cell.terms)}` : ""}: drive ${number(cell.drive)}, dx/dt ${number(cell.drive - cell.x[last])}`));
    const { x, rate, equilibria } = cell.route;
    if (!x.length) {
      this.route.replaceChildren("A discrete-time cell has no dynamic route.");
      this.foot.textContent = "";
      return;
    }
    const dots = { hooks: { draw: [(/** @type {any} */ u) => this.dots(u, equilibria, cell.x[last])] } };
    plot(this.route, ["x", "dx/dt"], [x, rate], { height: 150, plugins: [dots] });
    this.foot.textContent = equilibria.length ? `Equilibria: ${equilibria.map((/** @type {Content} */ e) => `${number(e.x)} ${e.stable ? "(stable)" : "(unstable)"}`).join(", ")}. The neighbours are held as they are now.` : "No equilibrium in this range.";
  }

  /** Draws equilibria (full: stable) and the present state. @param {any} u @param {Content[]} equilibria @param {number} now */
  dots(u, equilibria, now) {
    const c = u.ctx, style = getComputedStyle(document.documentElement), y0 = u.valToPos(0, "y", true);
    c.save();
    c.lineWidth = 2;
    c.strokeStyle = c.fillStyle = style.getPropertyValue("--ink");
    c.beginPath();
    c.moveTo(u.bbox.left, y0);
    c.lineTo(u.bbox.left + u.bbox.width, y0);
    c.globalAlpha = 0.4;
    c.stroke();
    c.globalAlpha = 1;
    for (const { x, stable } of equilibria) {
      c.beginPath();
      c.arc(u.valToPos(x, "x", true), y0, 5, 0, 7);
      c.fillStyle = stable ? "#d55e00" : style.getPropertyValue("--paper");
      c.strokeStyle = "#d55e00";
      c.fill();
      c.stroke();
    }
    const at = u.valToPos(now, "x", true);
    c.strokeStyle = "#009e73";
    c.setLineDash([4, 3]);
    c.beginPath();
    c.moveTo(at, u.bbox.top);
    c.lineTo(at, u.bbox.top + u.bbox.height);
    c.stroke();
    c.restore();
  }
}
