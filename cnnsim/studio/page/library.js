// The panels Library and Programs.

import { h, paint } from "./base.js";

/** @typedef {import("./base.js").Content} Content */
/** @typedef {import("./base.js").Reply} Reply */

const VERDICT = new Uint32Array(256).fill(0xff3ad1e6).fill(0xffdadada, 0, 1).fill(0xff2a1ed2, 1, 2);

/** A small picture with a title. @param {string} title @param {Uint8Array} bytes @param {number[]} shape @param {Uint32Array} [colours] */
function picture(title, bytes, shape, colours) {
  const canvas = h("canvas", { role: "img", "aria-label": title });
  paint(canvas, bytes, shape, colours);
  return h("figure", {}, canvas, h("figcaption", {}, title));
}

export class LibraryPanel {
  /** @param {HTMLElement} host @param {import("./view.js").View} view */
  constructor(host, view) {
    this.view = view;
    const find = () => view.link.latest("library", () => this.find());
    this.words = h("input", { type: "search", name: "words", placeholder: "search: edge, fill, wave ...", "aria-label": "search the library", oninput: find });
    this.tag = h("select", { name: "tag", "aria-label": "tag", onchange: find }, h("option", { value: "" }, "all tags"));
    this.count = h("span", { class: "count" });
    this.list = h("ul", { class: "list" });
    this.example = h("div", { class: "example" });
    host.append(h("div", { class: "line" }, this.words, this.tag), this.count, this.list, this.example);
    this.number = 0;
  }

  async find() {
    const { content } = await this.view.link.ask({ do: "library", words: this.words.value, tag: this.tag.value });
    if (this.tag.options.length < 2) this.tag.append(...content.tags.map((/** @type {string} */ tag) => h("option", { value: tag }, tag)));
    this.count.textContent = `${content.found.length} of ${content.of} templates`;
    this.list.replaceChildren(...content.found.map((/** @type {Content} */ row) => h("li", {},
      h("button", { "data-name": row.name, title: row.summary, onclick: () => this.take(row.name) }, h("b", {}, row.name), ` ${row.kind === "linear" ? "" : `(${row.kind}) `}`, h("span", {}, row.summary)))));
  }

  /** @param {string} name @param {number} [example] */
  async take(name, example) {
    this.number = example ?? 0;
    this.view.fresh();
    await this.view.link.ask(example === undefined ? { do: "template", name } : { do: "template", name, example });
    await this.compare();
    this.view.play();
  }

  /** Shows the worked example beside what the present numbers give. */
  async compare() {
    const { session } = this.view;
    if (!session.examples) {
      this.example.replaceChildren(h("p", {}, "This template has no worked example."));
      return;
    }
    this.number = Math.min(this.number, session.examples - 1);
    const { content, buffers } = await this.view.link.ask({ do: "compare", example: this.number, layer: this.view.layer });
    const shape = content.shape, verdict = h("b", { class: content.passed ? "pass" : "fail", name: "verdict" }, content.passed ? "PASS" : "FAIL");
    const all = h("span", { name: "all" });
    this.example.replaceChildren(h("h3", {}, `Worked example ${this.number} of ${session.name} `, verdict),
      h("div", { class: "strip" }, picture("given", buffers[0], shape), picture("expected", buffers[1], shape), picture("these numbers", buffers[2], shape), picture(`differs: ${content.wrong}`, buffers[3], shape, VERDICT)),
      content.said ? h("p", { class: "about" }, content.said) : "",
      h("div", { class: "line" }, session.examples > 1 ? h("button", { name: "next-example", onclick: () => {
        this.number = (this.number + 1) % session.examples;
        this.compare();
      } }, "next example") : "",
      h("button", { name: "use-example", onclick: () => this.take(session.name, this.number) }, "run it on this"),
      h("button", { name: "check", onclick: async () => {
        const { passed } = (await this.view.link.ask({ do: "check" })).content;
        const good = passed.filter(Boolean).length;
        all.textContent = `${good} of ${passed.length} pass`;
        all.className = good === passed.length ? "pass" : "fail";
      } }, "check all"), all));
  }
}

export class ProgramsPanel {
  /** @param {HTMLElement} host @param {import("./view.js").View} view @param {(name: string) => void} open */
  constructor(host, view, open) {
    this.view = view;
    this.open = open;
    this.list = h("select", { name: "program", "aria-label": "program" });
    this.said = h("p", { class: "about" });
    this.strip = h("ol", { class: "steps" });
    this.step = h("div", { class: "example" });
    host.append(h("p", { class: "about" }, "A program runs on the picture of this page; each step shows what it writes."),
      h("div", { class: "line" }, this.list, h("button", { name: "run-program", onclick: () => this.run() }, "run")), this.said, this.step, this.strip);
  }

  async offer() {
    if (this.list.options.length) return;
    const { found } = (await this.view.link.ask({ do: "programs" })).content;
    this.list.append(...found.map((/** @type {Content} */ row) => h("option", { value: row.name, title: row.summary }, row.name)));
    this.list.value = "skeleton";
  }

  async run() {
    this.view.pause();
    const { content, buffers } = await this.view.link.ask({ do: "program", name: this.list.value });
    const numbers = Object.entries(content.numbers).map(([name, value]) => `${name} = ${value}`).join(", ");
    this.said.textContent = `${content.summary} ${content.ran} steps ran${content.shown < content.ran ? `, the first ${content.shown} are shown` : ""}. ${numbers}`;
    this.step.replaceChildren();
    this.strip.replaceChildren(...content.steps.map((/** @type {Content} */ row) => {
      const seen = row.plane === undefined ? h("span", { class: "wire" }, String(row.value)) : picture(row.to, buffers[row.plane], row.shape);
      return h("li", {}, h("button", { title: row.does, onclick: () => this.show(row, buffers) }, h("small", {}, row.number), seen));
    }));
  }

  /** @param {Content} row @param {Uint8Array[]} buffers */
  show(row, buffers) {
    this.step.replaceChildren(h("h3", {}, `Step ${row.number}`), h("p", {}, `${row.does} → ${row.to}`),
      row.plane === undefined ? h("p", { class: "wire" }, String(row.value)) : h("div", { class: "strip large" }, picture(row.to, buffers[row.plane], row.shape)),
      row.template ? h("button", { name: "open-step", onclick: () => this.open(row.template) }, `open ${row.template} here`) : "");
  }
}
