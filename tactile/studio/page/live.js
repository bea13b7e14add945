// The page of the live array view: asks for frames, plays and scrubs, and shows rate, losses and curves.

import { Link, h } from "./base.js";
import { Fingers } from "./fingers.js";
import { plot } from "./panels.js";
import { Ribbon } from "./ribbon.js";
import { SocketModel } from "./socket.js";
import { Thresholds } from "./thresholds.js";

/** @typedef {import("./base.js").Content} Content */

const STEP = 0.01, SERIES = 300, IDLE = 400;
const find = (/** @type {string} */ id) => /** @type {any} */ (document.getElementById(id));
const model = new SocketModel(() => start(), (reason) => say(reason || "the studio has ended; start it again", true));
const link = new Link(model);
const uPlot = /** @type {any} */ (globalThis).uPlot;
/** @type {Fingers} */
let fingers;
/** @type {Ribbon} */
let ribbon;
/** @type {Thresholds} */
let thresholds;
/** @type {Content} */
let known = {};
/** @type {Content} */
let frame = { times: [0, 0] };
let playing = true, t = 0, wanted = false, shown = performance.now(), drawn = 0, asked = 0, said = "", bad = false, answer = "";

/** @param {string} text @param {boolean} [wrong] */
function say(text, wrong = false) {
  find("summary").textContent = find("summary").title = text;
  find("summary").classList.toggle("wrong", wrong);
}

/** Keeps what came of a request. @param {string} text @param {boolean} [wrong] */
function note(text, wrong = false) {
  say((said = text), (bad = wrong));
}
link.failed = (text) => note(text, true);

/** Whether the newest frames are shown as they come. */
const follows = () => known.live && playing;

/** Where the time axes begin. */
const from = () => Math.max(frame.times[0], t - known.span);

/** Asks for the frame of the time, one at a time. */
async function ask() {
  wanted = false;
  const { content, buffers } = await link.ask({ do: "frame", ...(follows() ? {} : { t }) });
  status(content);
  if (!content.times) return;
  frame = content;
  if (follows()) t = content.t;
  fingers.show(content, buffers);
  const [first, last] = content.times;
  ribbon.show(content.events, content.t, from());
  Object.assign(find("scrub"), { min: first, max: Math.max(last, first + STEP) });
  find("scrub").value = t;
  find("clock").textContent = `t = ${content.t.toFixed(3)} s`;
  document.body.dataset.t = content.t;
}

/** @param {Content} content */
function status({ status: now, failure, full, times, over, compiling }) {
  find("rate").textContent = now.rate;
  find("losses").textContent = find("losses").title = now.losses;
  find("state").textContent = [now.tare, now.state].filter(Boolean).join("; ");
  find("record").setAttribute("aria-pressed", String(Boolean(now.recording)));
  find("record").textContent = now.recording ? `■ Stop ${now.recording}` : "● Record";
  const lost = now.lost ? `the port is lost: ${now.lost}` : "";
  find("record").disabled = Boolean(lost) && !now.recording;
  find("record").title = lost || "record every byte of the port; begin while nothing is in contact";
  if (now.answer && now.answer !== answer) note(`tare ${now.answer}`, now.answer.includes("refused"));
  answer = now.answer;
  const trouble = [...new Set([failure, lost, now.warning])].filter(Boolean).join("; ") || (full ? `memory is full: the first ${times[1].toFixed(0)} s are shown` : "");
  const waits = times || said || trouble ? "" : over ? "no frame has come" : compiling ? "compiling once, about a minute" : "waiting for frames";
  say([trouble, said, waits].filter(Boolean).join("; "), bad || Boolean(trouble));
}

/** Time, pressing, friction and roughness of the last seconds. */
async function curves() {
  drawn = performance.now();
  const { buffers } = await link.ask({ do: "series", ...(follows() ? {} : { t }) });
  if (!buffers.length) return;
  const tables = buffers.map((bytes) => {
    const all = new Float32Array(bytes.slice().buffer), n = all.length / 4;
    return [0, 1, 2, 3].map((k) => Array.from(all.subarray(k * n, (k + 1) * n), (v) => (Number.isNaN(v) ? null : v)));
  });
  const names = ["t", ...known.arrays.map((/** @type {Content} */ a) => a.name)];
  [1, 2, 3].forEach((k) => {
    const data = uPlot.join(tables.map((table) => [table[0], table[k]]));
    const x = { time: false, range: [from(), from() + known.span] };
    plot(find("charts").children[k - 1].lastChild, names, data, { height: k === 1 && names.length > 2 ? 84 : 106, axes: [{}, { space: 15 }], legend: { show: k === 1 && names.length > 2, live: false }, scales: { x }, series: names.slice(1).map(() => ({ width: 1.5 })) });
  });
}

/** Computes the events again with the thresholds of the sliders. */
function again() {
  if (thresholds.any) thresholds.compute();
  link.latest("again", async () => {
    const found = thresholds.any ? await link.ask({ do: "thresholds", t, ...thresholds.chosen }).catch(() => null) : null;
    if (link.slots.get("again")?.next) return; // other thresholds are chosen meanwhile
    thresholds.say((ribbon.again = found && found.content));
    wanted = true;
  });
}

/** Shows the frames until the page is closed: as they come, at the recording's own time, or when something changed. */
async function run() {
  for (;;) {
    await new Promise((done) => requestAnimationFrame(done));
    const now = performance.now(), passed = (now - shown) / 1000;
    if (playing && !known.live) {
      t = Math.min(t + passed * Number(find("speed").value), frame.times?.[1] ?? 0);
      if (frame.over && t >= frame.times[1]) pause();
    }
    const fresh = playing || wanted;
    [shown, asked] = [now, fresh || now - asked > IDLE ? now : asked];
    if (asked !== now) continue;
    await ask().catch(() => {});
    if (fresh && now - drawn > SERIES) await curves().catch(() => {});
  }
}

function pause() {
  playing = false;
  find("play").textContent = "▶ Play";
  if (thresholds.any) again();
}

function play() {
  if (!known.live && frame.over && t >= frame.times[1]) t = frame.times[0];
  [playing, shown] = [true, performance.now()];
  find("play").textContent = "❚❚ Pause";
}

/** @param {number} to */
function seek(to) {
  pause();
  [t, wanted, drawn] = [Math.max(frame.times[0], Math.min(frame.times[1], to)), true, 0];
}

const keys = { " ": () => (playing ? pause() : play()), ".": () => seek(t + STEP), ",": () => seek(t - STEP), Home: () => seek(frame.times[0]), End: () => seek(frame.times[1]) };
find("play").onclick = keys[" "];
find("on").onclick = keys["."];
find("back").onclick = keys[","];
find("first").onclick = keys.Home;
find("scrub").oninput = () => seek(Number(find("scrub").value));
find("smooth").onchange = () => {
  fingers.smooth = find("smooth").checked;
  wanted = true;
};
addEventListener("resize", () => (wanted = true));
addEventListener("keydown", (event) => {
  const target = /** @type {HTMLElement} */ (event.target), act = /** @type {any} */ (keys)[event.key];
  if (!act || event.ctrlKey || event.altKey || event.metaKey || (["INPUT", "SELECT", "BUTTON"].includes(target.tagName) && ![".", ","].includes(event.key))) return;
  event.preventDefault();
  act();
});
/** Sends a request and shows what came of it. @param {Content} what */
const order = (what) => link.ask(what).then(({ content }) => note(content.text, content.warning)).catch(() => {});
find("tare").onclick = () => order({ do: "tare", force: find("force").checked });
find("record").onclick = () => order({ do: "record", on: find("record").getAttribute("aria-pressed") !== "true" });

async function start() {
  const { content, buffers } = await link.ask({ do: "open" });
  known = content;
  document.title = `tactile studio: ${content.title}`;
  find("name").textContent = content.title;
  find("port").hidden = !content.port;
  find("speed").hidden = content.live;
  fingers = new Fingers(find("fingers"), find("legend"), content, buffers);
  ribbon = new Ribbon(find("ribbon"), find("events"), content, seek);
  thresholds = new Thresholds(find("thresholds"), content, again);
  find("charts").append(...["pressing [N]", "friction", "roughness [%]"].map((title) => h("div", {}, h("h3", {}, title), h("div"))));
  play();
  run();
}
