// The thresholds on sliders, and how many events they make of the last seconds.

import { h } from "./base.js";
import { short } from "./fingers.js";

/** @typedef {import("./base.js").Content} Content */

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
    const slider = (/** @type {string} */ label, /** @type {string} */ id, /** @type {number} */ value, /** @type {number} */ most, /** @type {(value: number) => string} */ text, /** @type {(value: number) => void} */ act) => {
      const output = h("output", {}), input = h("input", { type: "range", id, min: 0, max: most, step: "any", value, oninput: () => {
        output.textContent = text(Number(input.value));
        act(Number(input.value));
        this.changed(this.chosen);
      } });
      input.step = most / 100;
      input.value = value;
      output.textContent = text(value);
      this.fields.push([input, output, text, value]);
      return h("label", { class: "setting" }, h("span", {}, label), input, output);
    };
    const level = (/** @type {string} */ label, /** @type {string} */ name) => slider(label, name, thresholds[name], 10 * thresholds[name] || 1, (v) => `${short(v * factor)} ${unit}`, (value) => {
      this.chosen[name] = value;
      if (name !== "contact_level") for (const other of ["dead_band", "hysteresis"]) this.chosen[other] ??= thresholds[other]; // a pair of the command line
    });
    const sigma = (/** @type {string} */ label, /** @type {number} */ k) => slider(label, `sigma-${k}`, thresholds.sigmas[k], 20, (v) => `${short(v, 2)} σ`, (value) => {
      this.chosen.sigmas = Object.assign([...(this.chosen.sigmas || thresholds.sigmas)], { [k]: value });
    });
    host.append(h("h3", {}, "Thresholds", h("button", { id: "reset", onclick: () => this.reset() }, "as the run")),
      level("dead band", "dead_band"), level("hysteresis", "hysteresis"), level("contact", "contact_level"),
      sigma("dead band", 0), sigma("hysteresis", 1), sigma("contact", 2), this.result, this.options);
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

  /** @param {Content | null} again */
  say(again) {
    this.result.textContent = again ? `${again.count} events in the last ${again.seconds} s; the run has ${again.now}.` : "Move a slider: the events of the last seconds are computed again.";
    this.options.textContent = again?.options || "";
  }
}
