// The picture view: an Anywidget module that shows input and state, draws into them, and plays the run.
// A notebook loads it with base.js, pane.js and controls.js as one file; so no two of their names are the same.

import { Link, h, paint } from "./base.js";
import { Controls } from "./controls.js";
import { Pane } from "./pane.js";

/** @typedef {import("./base.js").Content} Content */
/** @typedef {import("./base.js").Reply} Reply */
/** @typedef {import("./base.js").Model} Model */

/** The whole view. */
export class View extends Controls {
  /** @param {Link} link @param {HTMLElement} host */
  constructor(link, host) {
    super();
    this.link = link;
    this.playing = false;
    this.index = this.first = this.t = 0;
    this.goal = /** @type {number | null} */ (null);
    this.ended = false;
    /** @type {Content} */
    this.session = {};
    /** @type {Content} */
    this.changes = {};
    /** @type {Uint8Array} */
    this.input = new Uint8Array();
    /** @type {Uint8Array} */
    this.start = new Uint8Array();
    this.stroke = this.drawn = false;
    this.side = "input";
    this.show = "x";
    this.layer = this.frame = 0;
    /** @type {(row: number, col: number) => void} */
    this.inspected = () => {};
    /** @type {(content: Content) => void} */
    this.framed = () => {};
    this.left = new Pane("input u: draw here");
    this.right = new Pane("state x: click a cell");
    this.wait = h("p", { class: "cw-wait", role: "status", hidden: true });
    this.right.box.append(this.wait);
    this.build(host, this.left.box, this.right.box);
    this.turn("input");
    this.see("x");
    this.left.bind(this, () => this.side);
    this.right.bind(this, () => "state");
    link.failed = (text) => this.say(text, true);
    link.waits = (busy) => {
      this.wait.textContent = this.drawn ? "computing; loops are compiled when they are first used" : "compiling once, about a minute";
      this.wait.hidden = !busy;
    };
    link.seen.add((reply) => {
      if (reply.content.is === "planes") this.planes(reply);
      if (reply.content.notice) this.say(reply.content.notice);
    });
  }

  /** Takes the planes of a reply to open, set, draw or picture. @param {Reply} reply */
  planes(reply) {
    const now = (this.session = reply.content), [input, start] = reply.buffers.length ? reply.buffers : [this.input, this.start];
    const sizes = (/** @type {any} */ select, /** @type {number} */ count, /** @type {string} */ word) => {
      select.hidden = count < 2;
      if (select.options.length !== count)
        select.replaceChildren(...Array.from({ length: count }, (_, i) => h("option", { value: i }, `${word} ${i}`)));
    };
    sizes(this.layers, now.layers, "layer");
    sizes(this.frames, now.frames, "picture");
    this.layer = Math.min(this.layer, now.layers - 1);
    this.frame = Math.min(this.frame, Math.max(0, now.frames - 1));
    const unread = now.input !== "picture" && now.initial_state !== "picture";
    this.note.textContent = unread ? "not read by this template" : now.second ? "draw here, and the start" : "draw here";
    this.input = input;
    this.start = start;
    if (!this.stroke) this.left.show((this.side === "input" ? input : start).slice(), now.shape);
    if (!this.playing && !this.stroke) this.again(now.index);
  }

  /** After a change: goes to the same time again, or plays from the start if the network was at rest.
   * @param {number} index where the server's run is */
  again(index) {
    const to = this.goal ?? this.index;
    if (index === to && index > 0) this.go({ by: 0 });
    else if (this.ended) this.play();
    else this.go({ to });
  }

  /** Lets what comes next begin at x(0). */
  fresh() {
    this.pause();
    this.say("");
    [this.goal, this.ended] = [0, false];
    this.scrub.max = "20";
  }

  /** @param {string} side */
  turn(side) {
    this.side = side;
    for (const name of ["input", "start"]) this.tabs[name].setAttribute("aria-pressed", String(name === side));
    const bytes = side === "input" ? this.input : this.start;
    if (bytes.length) this.left.show(bytes.slice(), this.session.shape);
  }

  /** @param {string} show */
  see(show) {
    this.show = show;
    for (const name of ["x", "y"]) this.tabs[name].setAttribute("aria-pressed", String(name === show));
    if (this.session.shape && !this.playing) this.go({ by: 0 });
  }

  pick() {
    [this.layer, this.frame] = [Number(this.layers.value), Number(this.frames.value)];
    this.link.ask({ do: "planes", layer: this.layer, frame: this.frame }).catch(() => {});
  }

  /** @param {Content} where @returns {Promise<Reply>} */
  request(where) {
    return this.link.ask({ do: "frame", show: this.show, layer: this.layer, rest: this.rest.checked && this.playing, ...where });
  }

  /** @param {Reply} reply */
  frameOf({ content, buffers }) {
    if (this.goal === content.index) this.goal = null;
    [this.index, this.first, this.t] = [content.index, content.first, content.t];
    this.right.show(buffers[0], content.shape);
    this.drawn ||= content.index > 0;
    this.scrub.max = String(Math.max(Number(this.scrub.max), this.index, content.last || 0, 20));
    this.scrub.min = String(this.first);
    this.scrub.value = String(this.index);
    // after a change in mid-run the scrub begins there
    this.clock.textContent = `t = ${content.t.toFixed(content.t < 100 ? 2 : 1)}${this.first > 0 ? ", past gone" : ""}`;
    this.framed(content);
  }

  /** Goes by steps or to an index, over several requests where it takes long. @param {Content} where */
  go(where) {
    this.pause();
    return this.link.latest("go", async () => {
      let reply = await this.request(where);
      this.frameOf(reply);
      while (!reply.content.arrived && where.to !== undefined && !this.link.slots.get("go")?.next && !this.playing) {
        reply = await this.request(where);
        this.frameOf(reply);
      }
    });
  }

  /** @param {number} index */
  seek(index) {
    this.ended = false;
    return this.go({ to: index });
  }

  /** Goes to x(0), also where something was changed while it ran. */
  restart() {
    this.fresh();
    return this.link.ask({ do: "set", changes: {} }).catch(() => {});
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  pause() {
    this.playing = false;
    this.playButton.textContent = "▶ Play";
  }

  /** Plays from the present state, from the start if it is at rest. */
  async play() {
    if (this.playing) return;
    this.playing = true;
    this.playButton.textContent = "❚❚ Pause";
    this.say("");
    const run = (this.round = {});
    const mine = () => this.playing && this.round === run;
    const by = () => Math.max(1, Number(this.speed.value));
    try {
      if (this.ended) await this.link.ask({ do: "set", changes: {} });
      if (!mine()) return;
      this.ended = false;
      this.goal = null;
      let next = this.request({ by: by() });
      while (mine()) {
        const reply = await next;
        const wait = Number(this.speed.value) < 0 ? 10 : 1;
        for (let i = 0; i < wait; i++) await new Promise((done) => requestAnimationFrame(done));
        if (!mine()) {
          this.frameOf(reply);
          break;
        }
        if (reply.content.ended) {
          this.frameOf(reply);
          this.ended = true;
          this.pause();
          this.say(reply.content.settled ? `at rest after t = ${reply.content.t.toFixed(1)}` : `its time is over: t = ${reply.content.t.toFixed(1)}`);
          break;
        }
        next = this.request({ by: by() });
        this.frameOf(reply);
      }
    } catch {
      if (this.round === run) this.pause();
    }
  }

  /** Sends a change of the setup; it acts on the running network, or on the picture of the same time.
   * @param {Content} changes */
  change(changes) {
    this.changes = { ...this.changes, ...changes }; // of one thing the last wins, of several none is lost
    this.link.latest("set", () => {
      const all = this.changes;
      this.changes = {};
      const shown = { layer: this.layer, frame: this.frame };
      return this.link.ask({ do: "set", changes: all, live: this.playing, ...shown })
        .catch(() => this.link.ask({ do: "planes", ...shown })); // a refused change is taken back
    });
  }

  /** @param {string} text @param {boolean} [wrong] */
  say(text, wrong = false) {
    this.status.textContent = text;
    this.status.classList.toggle("cw-wrong", wrong);
  }

  /** @param {number} row @param {number} col */
  inspect(row, col) {
    this.right.point(row, col);
    this.inspected(row, col);
  }

  /** Shows failing cells in red; 255 is a cell that always fails. @param {Uint8Array | null} bytes @param {number[]} shape */
  mask(bytes, shape) {
    const red = new Uint32Array(256).map((_, i) => (i ? ((60 + Math.round(i * 0.76)) << 24) | (30 << 16) | (20 << 8) | 230 : 0));
    if (bytes) paint(this.right.overlay, bytes, shape, red);
    else this.right.overlay.width = this.right.overlay.height = 1;
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const target = /** @type {HTMLElement} */ (event.target);
    if (["INPUT", "SELECT", "BUTTON", "TEXTAREA"].includes(target.tagName)) return;
    const act = { " ": () => this.toggle(), ".": () => this.go({ by: 1 }), ",": () => this.go({ to: Math.max(this.first, this.index - 1) }),
      Home: () => this.restart() }[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  }
}

export default {
  /** @param {{model: Model, el: HTMLElement}} host */
  render({ model, el }) {
    el.style.height = "520px";
    const link = new Link(model), view = new View(link, el);
    link.ask({ do: "open" }).then(() => view.play()).catch(() => {});
  },
};
