// The thresholds on sliders, and how many events they make of the last seconds.

import { h } from "./base.js";
import { short } from "./fingers.js";

/** @typedef {import("./base.js").Content} Content */

/** The largest level of a slider over that of the run. */
const RANGE = 40;

export class Thresholds {
  /** @param {HTMLElement} host @param {Content} known @param {(chosen: Content) => void} changed */
  constructor(host, known, changed) {
    const { thresholds, arrays: [{ factor, unit }] } = known;
    /** @type {Content} */
    this.chosen = {};
    this.changed = changed;
    this.result = h("p", { id: "again", role: "status" });
    this.options = h("code", { id: "options" });
    /** @type {[any, any, (value: number) => string, number][]} */
    this.fields = [];
    const slider = (/** @type {string} */ label, /** @type {string} */ id, /** @type {number} */ at, /** @type {number} */ most, /** @type {(at: number) => string} */ text, /** @type {(at: number) => void} */ act) => {
      const output = h("output", {}, text(at)), input = h("input", { type: "range", id, min: 0, max: most, step: most / 100, value: at, oninput: () => {
        output.textContent = text(Number(input.value));
        act(Number(input.value));
        this.changed(this.chosen);
      } });
      input.value = at;
      this.fields.push([input, output, text, at]);
      return h("label", { class: "setting" }, h("span", {}, label), input, output);
    };
    const level = (/** @type {string} */ label, /** @type {string} */ name) => {
      const most = RANGE * thresholds[name] || 1, value = (/** @type {number} */ at) => Number((most * at * at).toPrecision(3)); // fine steps near 0
      return slider(label, name, Math.sqrt(thresholds[name] / most), 1, (at) => `${short(value(at) * factor)} ${unit}`, (at) => {
        this.chosen[name] = value(at);
        if (name !== "contact_level") for (const other of ["dead_band", "hysteresis"]) this.chosen[other] ??= thresholds[other]; // a pair of the command line
      });
    };
    const sigma = (/** @type {string} */ label, /** @type {number} */ k) => slider(label, `sigma-${k}`, thresholds.sigmas[k], 20, (v) => `${short(v, 2)} σ`, (value) => {
      this.chosen.sigmas = Object.assign([...(this.chosen.sigmas || thresholds.sigmas)], { [k]: value });
    });
    host.append(h("h3", {}, "Thresholds", h("button", { id: "reset", onclick: () => this.reset() }, "reset")),
      h("p", { class: "about", title: "Once the noise is measured, a lowest level that is not chosen is a twentieth of its default." },
        "Each taxel switches at the larger of its lowest level and its multiple of the noise."),
      h("h4", { title: unit === "‰" ? "strain in thousandths" : undefined }, `Lowest level [${unit}]`), level("dead band", "dead_band"), level("hysteresis", "hysteresis"), level("contact", "contact_level"),
      h("h4", { title: "σ: standard deviation of a taxel without a load" }, "Multiple of the noise [σ]"), sigma("dead band", 0), sigma("hysteresis", 1), sigma("contact", 2), this.result, this.options);
    this.say(null);
  }

  get any() {
    return Object.keys(this.chosen).length > 0;
  }

  reset() {
    this.chosen = {};
    for (const [input, output, text, value] of this.fields) [input.value, output.textContent] = [value, text(value)];
    this.say(null);
    this.changed(this.chosen);
  }

  /** Says that the events are being computed. */
  compute() {
    this.result.textContent = "computing ...";
    this.options.textContent = "";
  }

  /** @param {Content | null} again */
  say(again) {
    this.result.textContent = again ? `${again.count} events in the last ${again.seconds} s; the run has ${again.now}.` : "Move a slider: the events of the last seconds are computed again.";
    this.options.textContent = again?.options || "";
  }
}
