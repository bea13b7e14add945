// The panel Chips: how precise a chip must be, and what accuracy costs, on the picture of the page.

import { h } from "./base.js";
import { plot } from "./panels.js";

/** @typedef {import("./base.js").Content} Content */

export class ExplorePanel {
  /** @param {HTMLElement} host @param {import("./view.js").View} view */
  constructor(host, view) {
    this.view = view;
    this.busy = false;
    this.sigma = h("input", { type: "range", name: "sigma", min: 0, max: 0.3, step: 0.005, value: 0.05, oninput: () => this.label() });
    this.size = h("output");
    this.count = h("input", { type: "number", name: "chips", min: 1, max: 1000, value: 20 });
    this.start = h("button", { name: "run-chips", onclick: () => (this.busy ? (this.busy = false) : this.chips()) }, "run");
    this.result = h("p", { name: "chips-result" }, "Each chip has its own errors in A, B and z. Cells that go wrong on some chips turn red in the picture.");
    this.accuracy = h("button", { name: "run-accuracy", onclick: () => (this.busy ? (this.busy = false) : this.precision()) }, "measure");
    this.said = h("p", { class: "about", name: "accuracy-result" }, "Runs this picture by several schemes and steps, and compares the end with a precise solution.");
    this.chart = h("div");
    host.append(h("h3", {}, "Mismatch of chips"), h("label", { class: "setting" }, h("span", {}, "sigma of each entry"), this.sigma, this.size),
      h("label", { class: "setting" }, h("span", {}, "chips"), this.count, this.start), this.result,
      h("h3", {}, "Accuracy against time"), this.accuracy, this.said, this.chart);
    this.label();
  }

  label() {
    this.size.textContent = `${(this.sigma.value * 100).toFixed(1)} %`;
  }

  async chips() {
    const { link } = this.view, chips = Number(this.count.value);
    [this.busy, this.start.textContent] = [true, "stop"];
    this.view.pause();
    try {
      for (let k = 0; k < chips && this.busy; k++) {
        const { content, buffers } = await link.ask({ do: "chip", sigma: Number(this.sigma.value), seed: 1, first: k === 0, layer: this.view.layer });
        this.view.mask(buffers[0], content.shape);
        this.result.textContent = `${content.good} of ${content.count} chips have no wrong cell; ${(content.share * 100).toFixed(2)} % of all cells are wrong.`;
      }
    } catch {
      this.view.mask(null, [1, 1]);
    }
    [this.busy, this.start.textContent] = [false, "run"];
  }

  async precision() {
    const { link } = this.view;
    [this.busy, this.accuracy.textContent] = [true, "stop"];
    this.view.pause();
    /** @type {Map<string, Content[]>} */
    const found = new Map();
    try {
      for (let number = 0, of = 1; number < of && this.busy; number++) {
        const { content } = await link.ask({ do: "precision", number });
        of = content.of;
        if (content.row && content.row.error > 0) found.set(content.scheme, [...(found.get(content.scheme) || []), content.row]);
        this.said.textContent = `${content.shape.join(" x ")} cells, t = ${Number(content.time.toPrecision(4))}; truth: ${content.reference}. ${number + 1} of ${of} settings.`;
        this.draw(found);
      }
    } catch {}
    [this.busy, this.accuracy.textContent] = [false, "measure"];
  }

  /** @param {Map<string, Content[]>} found */
  draw(found) {
    const rows = /** @type {Content[]} */ ([...found].flatMap(([scheme, list]) => list.map((row) => ({ scheme, ...row })))).sort((a, b) => a.seconds - b.seconds);
    if (rows.length < 2) return;
    const names = [...found.keys()], times = rows.map((row) => row.seconds * 1e3);
    const series = names.map((name) => rows.map((row) => (row.scheme === name ? row.error : null)));
    plot(this.chart, ["time", ...names], [times, ...series], { height: 210, series: names.map(() => ({ spanGaps: true, points: { show: true, size: 7 } })),
      scales: { x: { time: false, distr: 3 }, y: { distr: 3 } }, axes: [{ label: "milliseconds", labelSize: 16, labelFont: "11px system-ui", size: 34 }, { label: "error of x", labelSize: 16, labelFont: "11px system-ui", size: 46 }] });
  }
}
