// Controls of the picture view: tabs, ink, brush, time, speed, layers, and the key of the colours.

import { BLACK, GREY, WHITE, h } from "./base.js";

function legend() {
  const part = (/** @type {string} */ name, /** @type {string} */ text) => [h("i", { class: `cw-${name}` }), text];
  return h("span", { class: "cw-legend" }, part("below", "x < -1"), part("inside", "-1 to +1"), part("above", "x > +1"));
}

/** The controls, which call the methods of the view that extends them. */
export class Controls {
  constructor() {
    /** @type {{[key: string]: any}} */
    this.tabs = {};
  }

  /** Builds the controls and puts the two panes between. @param {HTMLElement} host @param {HTMLElement} left @param {HTMLElement} right */
  build(host, left, right) {
    const view = /** @type {any} */ (this);
    const button = (/** @type {string} */ name, /** @type {string} */ title, /** @type {string} */ text, /** @type {any} */ act) =>
      h("button", { name, title, "aria-label": title, onclick: act }, text);
    const tab = (/** @type {string} */ name, /** @type {string} */ text, /** @type {any} */ act) =>
      h("button", { name, class: "cw-tab", onclick: act }, text);
    this.tabs = {
      input: tab("input", "Input u", () => view.turn("input")), start: tab("start", "Start x(0)", () => view.turn("start")),
      x: tab("x", "State x", () => view.see("x")), y: tab("y", "Output y", () => view.see("y")),
    };
    this.layers = h("select", { name: "layer", title: "layer", "aria-label": "layer", hidden: true, onchange: () => view.pick() });
    this.frames = h("select", { name: "frame", title: "picture of the sequence", "aria-label": "picture of the sequence", hidden: true,
      onchange: () => view.pick() });
    this.note = h("span", { class: "cw-note" }, "draw here");
    const group = `ink-${Math.random()}`;
    const choice = (/** @type {number} */ value, /** @type {string} */ text, /** @type {boolean} */ on) =>
      h("label", {}, h("input", { type: "radio", name: group, "data-ink": text, value, checked: on }), text);
    this.ink = h("fieldset", { class: "cw-inks", "aria-label": "colour to draw with" }, choice(BLACK, "black", true),
      choice(GREY, "grey", false), choice(WHITE, "erase", false));
    this.brush = h("input", { type: "range", name: "brush", min: 1, max: 15, value: 3, title: "width of the brush [cells]",
      "aria-label": "width of the brush" });
    this.extra = h("span", { class: "cw-extra" });
    this.playButton = button("play", "play or pause (space)", "▶ Play", () => view.toggle());
    this.scrub = h("input", { type: "range", name: "scrub", min: 0, max: 1, value: 0, step: 1, class: "cw-scrub",
      "aria-label": "time", oninput: () => view.seek(Number(this.scrub.value)) });
    this.clock = h("output", { class: "cw-clock", name: "clock" }, "t = 0");
    const speeds = [["-10", "slow"], ["1", "1 step"], ["2", "2 steps"], ["5", "5 steps"], ["10", "10 steps"], ["50", "50 steps"]];
    this.speed = h("select", { name: "speed", title: "steps a picture", "aria-label": "steps a picture" },
      speeds.map(([value, text]) => h("option", { value }, text)));
    this.speed.value = "1";
    this.rest = h("input", { type: "checkbox", name: "rest", checked: true });
    this.status = h("div", { class: "cw-status", role: "status" });
    host.append(h("div", { class: "cw-view", onkeydown: (/** @type {KeyboardEvent} */ e) => view.key(e) },
      h("div", { class: "cw-panes" },
        h("section", { class: "cw-pane" }, h("div", { class: "cw-head" }, this.tabs.input, this.tabs.start, this.frames, this.note), left),
        h("section", { class: "cw-pane" }, h("div", { class: "cw-head" }, this.tabs.x, this.tabs.y, this.layers,
          h("span", { class: "cw-note", title: "click a cell to see what it does; drag to paint the present state" }, "click a cell; drag to paint")), right)),
      h("div", { class: "cw-row" }, this.ink, h("label", { class: "cw-label" }, "width ", this.brush), this.extra),
      h("div", { class: "cw-row" }, button("restart", "to the start (Home)", "|◀", () => view.restart()),
        button("previous", "a step back (,)", "◀", () => view.go({ to: Math.max(view.first, view.index - 1) })), this.playButton,
        button("next", "a step on (.)", "▶|", () => view.go({ by: 1 })), this.scrub, this.clock, this.speed,
        h("label", { class: "cw-label", title: "stop when nothing changes, or at the template's own time" }, this.rest, "stop at rest")),
      h("div", { class: "cw-row cw-key" }, legend(), this.status)));
  }
}
