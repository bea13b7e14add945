// The picture view: an Anywidget module that shows input and state, draws into them, and plays the run.
// It imports nothing, so that a notebook can load it as one file; the page gives it a model over a websocket.

/** @typedef {{[key: string]: any}} Content */
/** @typedef {{content: Content, buffers: Uint8Array[]}} Reply */
/** @typedef {{send(content: Content, callbacks?: any, buffers?: any[]): void, on(event: string, call: any): void}} Model */

export const WHITE = 16, GREY = 128, BLACK = 240;

/** Makes an element: h("button", {class: "x", onclick: f}, "text").
 * @param {string} tag @param {Content} [props] @param {...any} inside @returns {any} */
export function h(tag, props = {}, ...inside) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(props)) {
    if (value === undefined || value === null || value === false) continue;
    if (typeof value === "function") element.addEventListener(key.slice(2), value);
    else if (key === "value") /** @type {any} */ (element).value = value;
    else element.setAttribute(key, value === true ? "" : String(value));
  }
  element.append(...inside.flat().filter((one) => one !== null && one !== undefined));
  return element;
}

/** Colours of the 256 palette indices as little-endian RGBA: grey inside [-1, 1], orange above, blue below. */
export const PALETTE = (() => {
  const mix = (/** @type {number[]} */ a, /** @type {number[]} */ b, /** @type {number} */ s) =>
    a.map((v, i) => Math.round(v + (b[i] - v) * s));
  const colours = new Uint32Array(256);
  for (let i = 0; i < 256; i++) {
    const level = Math.round(255 - ((i - WHITE) * 255) / (BLACK - WHITE));
    const [r, g, b] = i > BLACK ? mix([64, 26, 8], [205, 98, 20], (i - BLACK - 1) / 14)
      : i < WHITE ? mix([224, 240, 252], [112, 176, 224], (WHITE - 1 - i) / 15) : [level, level, level];
    colours[i] = (255 << 24) | (b << 16) | (g << 8) | r;
  }
  return colours;
})();

/** The pixels of each canvas, used again for every picture. @type {WeakMap<HTMLCanvasElement, ImageData>} */
const IMAGES = new WeakMap();

/** Draws palette indices (rows, cols) into a canvas of as many pixels.
 * @param {HTMLCanvasElement} canvas @param {Uint8Array} bytes @param {number[]} shape @param {Uint32Array} [colours] */
export function paint(canvas, bytes, shape, colours = PALETTE) {
  const [rows, cols] = shape, context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  if (canvas.width !== cols || canvas.height !== rows) [canvas.width, canvas.height] = [cols, rows];
  let image = IMAGES.get(canvas);
  if (image?.width !== cols || image.height !== rows) IMAGES.set(canvas, (image = context.createImageData(cols, rows)));
  const pixels = new Uint32Array(image.data.buffer);
  for (let i = 0; i < pixels.length; i++) pixels[i] = colours[bytes[i]];
  context.putImageData(image, 0, 0);
}

/** Requests and their replies over a model; of requests in one slot only the last one waits. */
export class Link {
  /** @param {Model} model */
  constructor(model) {
    this.model = model;
    this.number = 0;
    /** @type {Map<number, {yes: (reply: Reply) => void, no: (error: Error) => void}>} */
    this.asked = new Map();
    /** @type {Map<string, {busy: boolean, next: null | (() => Promise<any>)}>} */
    this.slots = new Map();
    /** @type {Set<(reply: Reply) => void>} */
    this.seen = new Set();
    /** @type {(text: string) => void} */
    this.failed = () => {};
    /** @type {(busy: boolean) => void} */
    this.waits = () => {};
    model.on("msg:custom", (/** @type {Content} */ content, /** @type {any[]} */ buffers) => {
      const views = (buffers || []).map((b) => (b instanceof Uint8Array ? b : new Uint8Array(b.buffer || b)));
      const waits = this.asked.get(content.id);
      this.asked.delete(content.id);
      if (content.is === "error") {
        this.failed(content.text);
        waits?.no(new Error(content.text));
        return;
      }
      const reply = { content, buffers: views };
      for (const call of this.seen) call(reply);
      waits?.yes(reply);
    });
  }

  /** @param {Content} content @param {Uint8Array[]} [buffers] @returns {Promise<Reply>} */
  ask(content, buffers = []) {
    const id = ++this.number;
    let waited = false;
    const late = setTimeout(() => this.waits((waited = true)), 2500);
    return new Promise((yes, no) => {
      const over = (/** @type {any} */ call) => (/** @type {any} */ value) => {
        clearTimeout(late);
        if (waited) this.waits(false);
        call(value);
      };
      this.asked.set(id, { yes: over(yes), no: over(no) });
      this.model.send({ ...content, id }, undefined, buffers);
    });
  }

  /** Asks when the slot's last request is answered; what waited in the slot is dropped.
   * @param {string} slot @param {() => Promise<any>} make */
  async latest(slot, make) {
    const state = this.slots.get(slot) || { busy: false, next: null };
    this.slots.set(slot, state);
    state.next = make;
    if (state.busy) return;
    state.busy = true;
    while (state.next) {
      const go = state.next;
      state.next = null;
      await go().catch(() => {});
    }
    state.busy = false;
  }
}

/** One canvas with a marked cell and an overlay; it fits its box and knows which cell a pointer is on. */
class Pane {
  /** @param {string} label */
  constructor(label) {
    this.shape = [1, 1];
    /** @type {Uint8Array} */
    this.bytes = new Uint8Array([WHITE]);
    this.canvas = h("canvas", { tabindex: 0, role: "img", "aria-label": label });
    this.overlay = h("canvas", { class: "cw-overlay" });
    this.mark = h("div", { class: "cw-mark", hidden: true });
    this.stack = h("div", { class: "cw-stack" }, this.canvas, this.overlay, this.mark);
    this.box = h("div", { class: "cw-box" }, this.stack);
    this.cursor = [0, 0];
    new ResizeObserver(() => this.fit()).observe(this.box);
  }

  /** @param {Uint8Array} bytes @param {number[]} shape */
  show(bytes, shape) {
    const grown = shape[0] !== this.shape[0] || shape[1] !== this.shape[1];
    [this.bytes, this.shape] = [bytes, shape];
    paint(this.canvas, bytes, shape);
    if (grown) {
      this.fit();
      this.mark.hidden = true;
      this.overlay.width = this.overlay.height = 1;
    }
  }

  fit() {
    const [rows, cols] = this.shape, { clientWidth: width, clientHeight: height } = this.box;
    const scale = Math.min(width / cols, height / rows), whole = scale > 2 ? Math.floor(scale) : scale;
    this.stack.style.width = `${cols * whole}px`;
    this.stack.style.height = `${rows * whole}px`;
  }

  /** @param {PointerEvent} event @returns {[number, number]} */
  cell(event) {
    const at = this.canvas.getBoundingClientRect(), [rows, cols] = this.shape;
    const row = Math.floor(((event.clientY - at.top) / at.height) * rows);
    const col = Math.floor(((event.clientX - at.left) / at.width) * cols);
    return [Math.max(0, Math.min(rows - 1, row)), Math.max(0, Math.min(cols - 1, col))];
  }

  /** @param {number} row @param {number} col */
  point(row, col) {
    const [rows, cols] = this.shape;
    this.cursor = [row, col];
    this.mark.hidden = false;
    Object.assign(this.mark.style, {
      left: `${(col / cols) * 100}%`, top: `${(row / rows) * 100}%`, width: `${100 / cols}%`, height: `${100 / rows}%`,
    });
  }
}

/** The whole view. */
export class View {
  /** @param {Link} link @param {HTMLElement} host */
  constructor(link, host) {
    this.link = link;
    this.playing = false;
    this.index = this.first = this.t = 0;
    this.goal = /** @type {number | null} */ (null);
    this.ended = false;
    /** @type {Content} */
    this.session = {};
    /** @type {Uint8Array} */
    this.input = new Uint8Array();
    /** @type {Uint8Array} */
    this.start = new Uint8Array();
    this.stroke = false;
    /** @type {{[key: string]: any}} */
    this.tabs = {};
    this.side = "input";
    this.show = "x";
    this.layer = this.frame = 0;
    /** @type {(row: number, col: number) => void} */
    this.inspected = () => {};
    /** @type {(content: Content) => void} */
    this.framed = () => {};
    this.left = new Pane("input u: draw here");
    this.right = new Pane("state x: click a cell");
    this.build(host);
    this.bind(this.left, () => this.side);
    this.bind(this.right, () => "state");
    link.failed = (text) => this.say(text, true);
    link.waits = (busy) => this.say(busy ? "computing; loops are compiled when they are first used" : "");
    link.seen.add((reply) => {
      if (reply.content.is === "planes") this.planes(reply);
      if (reply.content.notice) this.say(reply.content.notice);
    });
  }

  /** @param {HTMLElement} host */
  build(host) {
    const button = (/** @type {string} */ name, /** @type {string} */ title, /** @type {string} */ text, /** @type {any} */ act) =>
      h("button", { name, title, "aria-label": title, onclick: act }, text);
    const tab = (/** @type {string} */ name, /** @type {string} */ text, /** @type {any} */ act) =>
      h("button", { name, class: "cw-tab", onclick: act }, text);
    this.tabs = {
      input: tab("input", "Input u", () => this.turn("input")), start: tab("start", "Start x(0)", () => this.turn("start")),
      x: tab("x", "State x", () => this.see("x")), y: tab("y", "Output y", () => this.see("y")),
    };
    this.layers = h("select", { name: "layer", title: "layer", "aria-label": "layer", hidden: true, onchange: () => this.pick() });
    this.frames = h("select", { name: "frame", title: "picture of the sequence", "aria-label": "picture of the sequence", hidden: true,
      onchange: () => this.pick() });
    this.note = h("span", { class: "cw-note" }, "draw here");
    const group = `ink-${Math.random()}`;
    const choice = (/** @type {number} */ value, /** @type {string} */ text, /** @type {boolean} */ on) =>
      h("label", {}, h("input", { type: "radio", name: group, "data-ink": text, value, checked: on }), text);
    this.ink = h("fieldset", { class: "cw-inks", "aria-label": "colour to draw with" }, choice(BLACK, "black", true),
      choice(GREY, "grey", false), choice(WHITE, "erase", false));
    this.brush = h("input", { type: "range", name: "brush", min: 1, max: 15, value: 3, title: "width of the brush [cells]",
      "aria-label": "width of the brush" });
    this.extra = h("span", { class: "cw-extra" });
    this.playButton = button("play", "play or pause (space)", "▶ Play", () => this.toggle());
    this.scrub = h("input", { type: "range", name: "scrub", min: 0, max: 1, value: 0, step: 1, class: "cw-scrub",
      "aria-label": "time", oninput: () => this.seek(Number(this.scrub.value)) });
    this.clock = h("output", { class: "cw-clock", name: "clock" }, "t = 0");
    const speeds = [["-10", "slow"], ["1", "1 step"], ["2", "2 steps"], ["5", "5 steps"], ["10", "10 steps"], ["50", "50 steps"]];
    this.speed = h("select", { name: "speed", title: "steps a picture", "aria-label": "steps a picture" },
      speeds.map(([value, text]) => h("option", { value }, text)));
    this.speed.value = "1";
    this.rest = h("input", { type: "checkbox", name: "rest", checked: true });
    this.status = h("div", { class: "cw-status", role: "status" });
    host.append(h("div", { class: "cw-view", onkeydown: (/** @type {KeyboardEvent} */ e) => this.key(e) },
      h("div", { class: "cw-panes" },
        h("section", { class: "cw-pane" }, h("div", { class: "cw-head" }, this.tabs.input, this.tabs.start, this.frames, this.note), this.left.box),
        h("section", { class: "cw-pane" }, h("div", { class: "cw-head" }, this.tabs.x, this.tabs.y, this.layers,
          h("span", { class: "cw-note", title: "click a cell to see what it does; drag to paint the present state" }, "click a cell; drag to paint")), this.right.box)),
      h("div", { class: "cw-row" }, this.ink, h("label", { class: "cw-label" }, "width ", this.brush), this.extra),
      h("div", { class: "cw-row" }, button("restart", "to the start (Home)", "|◀", () => this.restart()),
        button("previous", "a step back (,)", "◀", () => this.go({ to: Math.max(this.first, this.index - 1) })), this.playButton,
        button("next", "a step on (.)", "▶|", () => this.go({ by: 1 })), this.scrub, this.clock, this.speed,
        h("label", { class: "cw-label", title: "stop when nothing changes, or at the template's own time" }, this.rest, "stop at rest")),
      h("div", { class: "cw-row cw-key" }, this.legend(), this.status)));
    this.turn("input");
    this.see("x");
  }

  legend() {
    const part = (/** @type {string} */ name, /** @type {string} */ text) => [h("i", { class: `cw-${name}` }), text];
    return h("span", { class: "cw-legend" }, part("below", "x < -1"), part("inside", "-1 to +1"), part("above", "x > +1"));
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
    this.scrub.max = String(Math.max(Number(this.scrub.max), this.index, content.last || 0, 20));
    this.scrub.min = String(this.first);
    this.scrub.value = String(this.index);
    this.clock.textContent = `t = ${content.t.toFixed(content.t < 100 ? 2 : 1)}`;
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
    this.link.latest("set", () => this.link.ask({ do: "set", changes, live: this.playing, layer: this.layer, frame: this.frame }));
  }

  /** @param {string} text @param {boolean} [wrong] */
  say(text, wrong = false) {
    this.status.textContent = text;
    this.status.classList.toggle("cw-wrong", wrong);
  }

  /** @param {Pane} pane @param {() => string} plane */
  bind(pane, plane) {
    const ink = () => Number(/** @type {any} */ (this.ink.querySelector("input:checked")).value);
    let last = /** @type {any} */ (null), dirty = /** @type {any} */ (null), moved = false, value = BLACK;
    const dab = (/** @type {number} */ row, /** @type {number} */ col) => {
      const size = Number(this.brush.value), r = (size - 1) / 2, [rows, cols] = pane.shape;
      for (let i = Math.ceil(row - r); i <= row + r; i++)
        for (let j = Math.ceil(col - r); j <= col + r; j++) {
          const inside = size < 4 || (i - row) ** 2 + (j - col) ** 2 <= r * r + 0.5;
          if (!inside || i < 0 || j < 0 || i >= rows || j >= cols) continue;
          pane.bytes[i * cols + j] = value;
          dirty = dirty ? [Math.min(dirty[0], i), Math.min(dirty[1], j), Math.max(dirty[2], i), Math.max(dirty[3], j)] : [i, j, i, j];
        }
    };
    const line = (/** @type {number[]} */ from, /** @type {number[]} */ to) => {
      const steps = Math.max(Math.abs(to[0] - from[0]), Math.abs(to[1] - from[1]), 1);
      for (let k = 0; k <= steps; k++)
        dab(Math.round(from[0] + ((to[0] - from[0]) * k) / steps), Math.round(from[1] + ((to[1] - from[1]) * k) / steps));
      paint(pane.canvas, pane.bytes, pane.shape);
      this.link.latest(`draw ${plane()}`, send);
    };
    const send = async () => {
      if (!dirty) return;
      const [top, left, bottom, right] = dirty, cols = pane.shape[1], wide = right - left + 1;
      dirty = null;
      const bytes = new Uint8Array((bottom - top + 1) * wide);
      for (let i = top; i <= bottom; i++) bytes.set(pane.bytes.subarray(i * cols + left, i * cols + right + 1), (i - top) * wide);
      await this.link.ask({ do: "draw", plane: plane(), row: top, col: left, rows: bottom - top + 1, cols: wide,
        live: this.playing, layer: this.layer, frame: this.frame }, [bytes]);
    };
    const state = () => plane() === "state";
    const begin = (/** @type {number[]} */ cell) => {
      this.stroke = true;
      if (state()) this.pause();
      pane.bytes = pane.bytes.slice();
      line(cell, cell);
    };
    const end = () => {
      this.link.latest(`draw ${plane()}`, async () => {
        await send();
        this.stroke = false;
        if (!state()) await this.restart();
        this.ended = false;
        this.play();
      });
    };
    pane.canvas.addEventListener("pointerdown", (/** @type {PointerEvent} */ event) => {
      pane.canvas.setPointerCapture(event.pointerId);
      value = event.button === 2 ? WHITE : ink();
      [last, moved] = [pane.cell(event), false];
      if (!state()) begin(last);
    });
    pane.canvas.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => {
      if (!last) return;
      const cell = pane.cell(event);
      if (cell[0] === last[0] && cell[1] === last[1]) return;
      if (state() && !moved) begin(last);
      moved = true;
      line(last, cell);
      last = cell;
    });
    const up = () => {
      if (!last) return;
      if (state() && !moved) this.inspect(last[0], last[1]);
      else end();
      last = null;
    };
    pane.canvas.addEventListener("pointerup", up);
    pane.canvas.addEventListener("pointercancel", up);
    pane.canvas.addEventListener("contextmenu", (/** @type {Event} */ event) => event.preventDefault());
    pane.canvas.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
      const move = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] }[event.key];
      if (move) pane.point(Math.max(0, Math.min(pane.shape[0] - 1, pane.cursor[0] + move[0])),
        Math.max(0, Math.min(pane.shape[1] - 1, pane.cursor[1] + move[1])));
      else if (event.key === "Enter" && state()) this.inspect(pane.cursor[0], pane.cursor[1]);
      else if (event.key === "Enter") {
        value = ink();
        begin(pane.cursor);
        end();
      } else return;
      event.preventDefault();
    });
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
