// The page of the playground: the view and its panels over one websocket.

import { ExplorePanel } from "./explore.js";
import { LibraryPanel, ProgramsPanel } from "./library.js";
import { CellPanel, Rules } from "./panels.js";
import { SocketModel } from "./socket.js";
import { Link, h } from "./base.js";
import { View } from "./view.js";
import { Weights } from "./weights.js";

/** @typedef {import("./base.js").Content} Content */

const find = (/** @type {string} */ id) => /** @type {any} */ (document.getElementById(id));
const model = new SocketModel(() => start(), (reason) => view.say(reason || "the studio has ended; start it again", true));
const link = new Link(model);
/** @type {View} */
const view = new View(link, find("view"));
const weights = new Weights(find("panel-weights"), (network) => view.change({ network }));
const rules = new Rules(find("panel-run"), (changes) => view.change(changes));
/** @type {CellPanel} */
const cell = new CellPanel(find("panel-cell"), view);
const library = new LibraryPanel(find("panel-library"), view);
const explore = new ExplorePanel(find("panel-chips"), view);
const programs = new ProgramsPanel(find("panel-programs"), view, async (name) => {
  tab("weights");
  await library.take(name);
});
weights.reset = () => view.change({ network: "own" });

const tabs = ["weights", "run", "cell", "library", "chips", "programs"];

/** Shows one panel. @param {string} name */
function tab(name) {
  for (const one of tabs) {
    find(`panel-${one}`).hidden = one !== name;
    find(`tab-${one}`).setAttribute("aria-selected", String(one === name));
    find(`tab-${one}`).tabIndex = one === name ? 0 : -1;
  }
  if (name === "library") library.find().then(() => library.compare());
  if (name === "programs") programs.offer();
  if (name === "cell") cell.refresh();
}

for (const name of tabs) {
  find(`tab-${name}`).onclick = () => tab(name);
  find(`tab-${name}`).onkeydown = (/** @type {KeyboardEvent} */ event) => {
    const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!by) return;
    const next = tabs[(tabs.indexOf(name) + by + tabs.length) % tabs.length];
    tab(next);
    find(`tab-${next}`).focus();
  };
}

view.inspected = (row, col) => {
  tab("cell");
  cell.inspect(row, col);
};

let shownLink = "";
link.seen.add(({ content }) => {
  if (content.is !== "planes") return;
  find("name").textContent = content.name + (content.changed ? " (changed)" : "");
  find("summary").textContent = content.summary;
  find("summary").title = content.summary;
  weights.session = content;
  if (!link.slots.get("set")?.next) weights.show(content); // else a newer change is on its way
  rules.show(content);
  const grid = content.shape[0] === content.shape[1] ? String(content.shape[0]) : content.shape.join(" x ");
  if (![...size.options].some((one) => one.value === grid)) size.append(h("option", { value: grid }, content.shape.join(" x ")));
  size.value = grid;
  find("plan").textContent = content.plan.map((/** @type {string[]} */ row) => row[0]).join(" · ");
  find("plan").title = content.plan.map((/** @type {string[]} */ row) => row.join(": ")).join("\n");
  find("where").textContent = content.where;
  if (!explore.busy) view.mask(null, [1, 1]);
  shownLink = document.body.dataset.link = content.link;
  if (location.hash !== `#${shownLink}` && shownLink.length < 8000) history.replaceState(null, "", `#${shownLink}`);
});

let frames = 0, since = performance.now(), cells = 0, seconds = 0;
view.framed = (content) => {
  frames++;
  cells += content.cell_steps;
  seconds += content.seconds;
  const now = performance.now();
  if (now - since < 500) return;
  find("rate").textContent = view.playing ? `${((frames * 1000) / (now - since)).toFixed(0)} pictures/s` : "";
  if (seconds > 0) find("speed").textContent = `${(cells / seconds / 1e6).toFixed(0)} million cell-steps/s`;
  find("steps").textContent = `h = ${Number(view.session.h.toPrecision(4))}, ${view.speed.selectedOptions[0].text.replace("slow", "1 step")} a picture`;
  [frames, since, cells, seconds] = [0, now, 0, 0];
  if (!find("panel-cell").hidden) cell.refresh();
};

// Pictures: presets, size, noise, files.
const chosen = h("select", { name: "picture", title: "picture to begin with", "aria-label": "picture" });
const size = h("select", { name: "size", title: "size of the grid", "aria-label": "size of the grid", onchange: () => {
  const [rows, cols = rows] = size.value.split(" x ").map(Number);
  fresh({ rows, cols });
} },
  [16, 32, 64, 128, 256, 512].map((n) => h("option", { value: n }, `${n} x ${n}`)));
let seed = 0;
/** Asks for another picture and plays. @param {Content} what @param {Uint8Array[]} [buffers] */
async function fresh(what, buffers = []) {
  view.fresh();
  await link.ask({ do: "picture", seed, ...what }, buffers).then(() => view.play()).catch(() => {});
}
chosen.onchange = () => chosen.value && fresh({ name: chosen.value });
view.extra.append(chosen, h("button", { name: "again", title: "another one of these", onclick: () => {
  seed++;
  fresh({ name: chosen.value || view.session.made?.[0] || "curves" });
} }, "new"), size, h("button", { name: "noise", title: "add noise of 0.3", onclick: () => {
  seed++;
  fresh({ noise: 0.3 });
} }, "noise"), h("button", { name: "clear", onclick: () => fresh({ name: "white" }) }, "clear"));

/** Takes a picture file: at most 512 cells a side, dark is black. @param {Blob} file */
async function take(file) {
  const image = await createImageBitmap(file).catch(() => null);
  if (!image) {
    view.say("this is no picture that the browser can read", true);
    return;
  }
  const scale = Math.min(1, 512 / Math.max(image.width, image.height)), [cols, rows] = [image.width, image.height].map((n) => Math.max(4, Math.round(n * scale)));
  const canvas = new OffscreenCanvas(cols, rows), context = /** @type {OffscreenCanvasRenderingContext2D} */ (canvas.getContext("2d"));
  context.fillStyle = "#fff";
  context.fillRect(0, 0, cols, rows);
  context.drawImage(image, 0, 0, cols, rows);
  const { data } = context.getImageData(0, 0, cols, rows), bytes = new Uint8Array(rows * cols);
  for (let i = 0; i < bytes.length; i++) bytes[i] = Math.round(240 - ((0.299 * data[4 * i] + 0.587 * data[4 * i + 1] + 0.114 * data[4 * i + 2]) / 255) * 224);
  await fresh({ rows, cols }, [bytes]);
}
addEventListener("keydown", (event) => event.defaultPrevented || view.key(event));
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event) => {
  event.preventDefault();
  const file = event.dataTransfer?.files[0];
  if (file) take(file);
});
addEventListener("paste", (event) => {
  const file = [...(event.clipboardData?.files || [])].find((one) => one.type.startsWith("image/"));
  if (file) take(file);
});

// What can be taken away.
/** @param {string} text @param {string} what */
async function copy(text, what) {
  await navigator.clipboard?.writeText(text).catch(() => {});
  find("copied").textContent = text;
  find("copied-title").textContent = `${what} (copied)`;
  find("dialog").showModal();
}
find("copy-link").onclick = () => copy(`${location.origin}/#${shownLink}`, "Link to exactly this");
find("copy-python").onclick = async () => copy((await link.ask({ do: "code" })).content.python, "Python");
find("copy-command").onclick = async () => copy((await link.ask({ do: "code" })).content.command, "Command");
find("save").onchange = async () => {
  const what = find("save").value;
  find("save").value = "";
  view.pause();
  const { content, buffers } = await link.ask({ do: "save", what, layer: view.layer });
  const address = URL.createObjectURL(new Blob([new Uint8Array(buffers[0])]));
  h("a", { href: address, download: content.name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
  view.say(`saved ${content.name}, ${content.bytes} bytes`);
};
find("close").onclick = () => find("dialog").close();

async function start() {
  const open = (/** @type {string} */ text) => link.ask({ do: "open", link: text });
  const { content } = await open(location.hash.slice(1)).catch(() => open(""));
  rules.offer(content.known);
  rules.show(content);
  chosen.replaceChildren(h("option", { value: "" }, "picture ..."), ...content.known.pictures.map((/** @type {string} */ name) => h("option", { value: name }, name)));
  if (content.made) [seed, chosen.value] = [content.made[1], content.made[0]];
  view.play();
}
addEventListener("hashchange", () => {
  if (location.hash.slice(1) !== shownLink) {
    view.fresh();
    link.ask({ do: "open", link: location.hash.slice(1) }).then(() => view.play()).catch(() => {});
  }
});
tab("weights");
