// The numbers of a template: A, B, z and its terms in grids that are typed, dragged or turned with the wheel.

import { h } from "./base.js";

/** @typedef {import("./base.js").Content} Content */

/** Rounds away what the addition of 0.1 leaves behind. @param {number} value */
const tidy = (value) => Number(value.toPrecision(12));

/** Copies of the offset (i, j) of a grid of a side under a symmetry. @param {string} lock @param {number} i @param {number} j @param {number} n */
export function twins(lock, i, j, n) {
  const far = n - 1, all = [[i, j]];
  if (lock === "centre") all.push([far - i, far - j]);
  if (lock === "full") for (const [a, b] of [[i, j], [j, i]]) all.push([a, b], [far - a, b], [a, far - b], [far - a, far - b]);
  return all;
}

export class Weights {
  /** @param {HTMLElement} host @param {(network: Content) => void} changed */
  constructor(host, changed) {
    this.host = host;
    this.changed = changed;
    this.lock = "full";
    this.layer = 0;
    /** @type {string} */
    this.drawn = "";
  }

  /** Shows the network of a session; a number that is being typed stays. @param {Content} session */
  show(session) {
    this.network = structuredClone(session.network);
    for (const part of this.network.layer || [this.network]) part.B ??= [[0]];
    for (const layer of this.network.layer || []) layer.time_constant ??= 1;
    this.own = session.changed;
    const layers = this.network.layer;
    this.layer = layers ? Math.min(this.layer, layers.length - 1) : 0;
    const shape = JSON.stringify([session.name, this.layer, this.shapes()]);
    if (shape !== this.drawn) {
      this.drawn = shape;
      this.build(session);
    }
    for (const field of this.host.querySelectorAll("input[data-path]")) {
      const input = /** @type {any} */ (field);
      if (document.activeElement === input && input.dataset.typing) continue;
      const value = this.at(JSON.parse(input.dataset.path));
      input.value = String(tidy(value));
      if (input.type === "range") continue;
      const cell = input.parentElement;
      cell.className = `weight ${value > 0 ? "plus" : value < 0 ? "minus" : ""}`;
      cell.style.setProperty("--size", `${Math.min(100, 18 + Math.abs(value) * 14)}%`);
    }
    const reset = /** @type {any} */ (this.host.querySelector("[name=reset]"));
    if (reset) reset.disabled = !session.changed;
  }

  /** The part of the network that is shown: a layer, or all. @returns {Content} */
  part() {
    return this.network.layer ? this.network.layer[this.layer] : this.network;
  }

  shapes() {
    const part = this.part(), side = (/** @type {any} */ m) => (Array.isArray(m) ? m.length : 0);
    const terms = (part.term || []).map((/** @type {Content} */ t) => [side(t.weights), JSON.stringify({ ...t, weights: 0, table: 0 }).length]);
    return [side(part.A), side(part.B), terms];
  }

  /** @param {(string | number)[]} path */
  at(path) {
    return path.reduce((/** @type {any} */ value, key) => value[key], this.part());
  }

  /** The entries that change with one, itself among them. @param {(string | number)[]} path */
  places(path) {
    return this.lock !== "none" && path.length > 2 && (path[0] === "A" || path[0] === "B")
      ? twins(this.lock, Number(path[1]), Number(path[2]), this.at([path[0]]).length).map(([i, j]) => [path[0], i, j]) : [path];
  }

  /** Marks the entries that change with one; none for an empty path. @param {(string | number)[]} path */
  link(path) {
    const linked = this.places(path).map((place) => JSON.stringify(place));
    for (const input of this.host.querySelectorAll("input[data-path]")) input.toggleAttribute("data-linked", linked.includes(/** @type {any} */ (input).dataset.path));
  }

  /** @param {(string | number)[]} path @param {number} value */
  put(path, value) {
    if (!Number.isFinite(value)) return;
    for (const place of this.places(path)) this.at(place.slice(0, -1))[place[place.length - 1]] = tidy(value);
    this.changed(this.network);
    this.show({ ...this.session, network: this.network, changed: true });
  }

  /** Nothing is being typed any more. */
  typed() {
    for (const input of this.host.querySelectorAll("[data-typing]")) input.removeAttribute("data-typing");
  }

  /** @param {(string | number)[]} path @param {string} label */
  field(path, label) {
    const input = h("input", { type: "text", inputmode: "decimal", "data-path": JSON.stringify(path), "aria-label": label, title: `${label}: type, drag up or down, turn the wheel`,
      oninput: () => {
        input.dataset.typing = "1";
        const typed = input.value.trim() === "" ? NaN : Number(input.value.replace(",", "."));
        input.toggleAttribute("aria-invalid", !Number.isFinite(typed));
        this.put(path, typed);
      },
      onblur: () => {
        delete input.dataset.typing;
        this.link([]);
      },
      onfocus: () => {
        input.select();
        this.link(path);
      },
      onkeydown: (/** @type {KeyboardEvent} */ event) => {
        const by = { ArrowUp: 0.1, ArrowDown: -0.1 }[event.key];
        if (!by) return;
        event.preventDefault();
        turn(event.shiftKey ? by * 10 : by);
      } });
    const turn = (/** @type {number} */ by) => {
      this.typed();
      this.put(path, this.at(path) + by);
    };
    input.addEventListener("wheel", (/** @type {WheelEvent} */ event) => {
      event.preventDefault();
      turn((event.deltaY < 0 ? 0.1 : -0.1) * (event.shiftKey ? 10 : 1));
    }, { passive: false });
    let from = 0, value = 0, held = false;
    input.addEventListener("pointerdown", (/** @type {PointerEvent} */ event) => {
      [from, value, held] = [event.clientY, this.at(path), true];
      input.setPointerCapture(event.pointerId);
    });
    input.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => {
      if (!held || Math.abs(event.clientY - from) < 4) return;
      this.typed();
      this.put(path, tidy(Math.round((value + (from - event.clientY) / 40) * 20) / 20));
    });
    for (const name of ["pointerup", "pointercancel"]) input.addEventListener(name, () => (held = false));
    return h("span", { class: "weight" }, input);
  }

  /** @param {string} name @param {(string | number)[]} path @param {string} title */
  grid(name, path, title) {
    const matrix = this.at(path);
    if (!Array.isArray(matrix)) return h("div", { class: "grid-box" }, h("b", {}, name), this.field(path, name));
    const n = matrix.length, middle = (n - 1) / 2;
    if (Array.isArray(matrix[0][0])) return h("p", {}, `${name}: one weight for each cell`);
    const cells = matrix.flatMap((/** @type {any[]} */ row, /** @type {number} */ i) => row.map((_, j) =>
      this.field([...path, i, j], `${name}, neighbour (${i - middle}, ${j - middle})`)));
    const box = h("div", { class: "grid-box" }, h("b", { title }, name), h("div", { class: `grid side-${n}`, role: "group", "aria-label": title }, cells));
    box.querySelector(".grid").style.gridTemplateColumns = `repeat(${n}, 1fr)`;
    return box;
  }

  /** @param {Content} session */
  build(session) {
    this.session = session;
    const part = this.part(), layers = this.network.layer || [], side = Math.max(1, ...this.shapes().slice(0, 2).map(Number));
    const resize = (/** @type {number} */ by) => {
      for (const name of ["A", "B"]) {
        const matrix = this.at([name]), n = Array.isArray(matrix) ? matrix.length : 1, to = Math.max(1, Math.min(11, n + 2 * by));
        const get = (/** @type {number} */ i, /** @type {number} */ j) => (Array.isArray(matrix) ? matrix[i]?.[j] ?? 0 : i || j ? 0 : matrix);
        this.part()[name] = Array.from({ length: to }, (_, i) => Array.from({ length: to }, (_, j) => get(i - (to - n) / 2, j - (to - n) / 2)));
      }
      this.changed(this.network);
      this.show({ ...session, network: this.network, changed: true });
    };
    const lock = h("select", { name: "lock", title: "entries that change together", onchange: () => (this.lock = lock.value) },
      h("option", { value: "full" }, "all four sides"), h("option", { value: "centre" }, "opposite entries"), h("option", { value: "none" }, "each alone"));
    lock.value = this.lock;
    const slider = h("input", { type: "range", min: -8, max: 8, step: 0.05, "data-path": '["z"]', "aria-label": "z, slider",
      oninput: () => this.put(["z"], Number(slider.value)) });
    const pick = h("select", { name: "weights-layer", onchange: () => {
      this.layer = Number(pick.value);
      this.show({ ...session, network: this.network });
    } }, layers.map((/** @type {Content} */ _, /** @type {number} */ i) => h("option", { value: i }, `layer ${i}`)));
    pick.value = String(this.layer);
    this.host.replaceChildren(
      h("p", { class: "equation" }, "dx/dt = −x + A∗y + B∗u + z"),
      layers.length ? h("div", { class: "line points" }, pick, "time constant", this.field(["time_constant"], "time constant of the layer")) : "",
      h("div", { class: "grids" }, this.grid("A", ["A"], "feedback: weights of the neighbours' outputs y"), this.grid("B", ["B"], "control: weights of the neighbours' inputs u")),
      h("div", { class: "z-row" }, h("b", {}, "z"), this.field(["z"], "z, bias"), slider),
      h("div", { class: "line" }, h("label", { class: "field" }, "change together ", lock)),
      h("div", { class: "line field" }, `size ${side} x ${side}`,
        h("button", { name: "smaller", title: "smaller neighbourhood", onclick: () => resize(-1) }, "−"),
        h("button", { name: "larger", title: "larger neighbourhood", onclick: () => resize(1) }, "+")),
      h("button", { name: "reset", onclick: () => this.reset() }, "back to the library's numbers"),
      ...(part.term || []).map((/** @type {Content} */ term, /** @type {number} */ k) => this.term(term, k)),
    );
  }

  /** @param {Content} term @param {number} k */
  term(term, k) {
    const inner = term.table ? `f(${term.of || "y_kl"})` : term.of || "y_kl";
    const said = `+ w · ${inner}${term.times ? ` · (${term.times})` : ""}${term.layer === undefined ? "" : `, of layer ${term.layer}`}`;
    const rows = [];
    const table = term.table || {};
    if (table.linear) rows.push(h("div", { class: "points" }, h("span", {}, "f: lines through (v, f)"), table.linear.map((/** @type {any} */ _, /** @type {number} */ i) =>
      h("span", { class: "pair" }, this.field(["term", k, "table", "linear", i, 0], `v of point ${i}`), this.field(["term", k, "table", "linear", i, 1], `f of point ${i}`)))));
    if (table.step) {
      rows.push(h("div", { class: "points" }, h("span", {}, "f: steps at v ="), table.step.at.map((/** @type {any} */ _, /** @type {number} */ i) => this.field(["term", k, "table", "step", "at", i], `step ${i} at`)),
        h("span", {}, "values"), table.step.values.map((/** @type {any} */ _, /** @type {number} */ i) => this.field(["term", k, "table", "step", "values", i], `value ${i}`))));
    }
    if (term.delay) rows.push(h("div", { class: "points" }, h("span", {}, "delay [time constants]"), this.field(["term", k, "delay"], "delay")));
    return h("div", { class: "term" }, h("p", {}, said), this.grid("w", ["term", k, "weights"], "weights of the term"), rows);
  }

  reset() {}
}
