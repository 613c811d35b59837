// The page: choices, map, outcome of the selected cell, and the command that writes its film.
// Hovering previews a cell; a click, a key, a slider or the address pins it; Escape releases it.
function load() {
  const index = at.record;
  held.data = null;
  if (!cube.folder) return hold(index, cube.records[index].cells);
  const file = encodeURIComponent(cube.folder) + "/" + index + ".js";
  answer.textContent = say("Reading {0} …", file);
  const script = element("script", { src: file }, document.head);
  script.onload = () => { script.remove(); if (index === at.record) show(); };
  script.onerror = () => {
    script.remove();
    if (index === at.record) answer.textContent = say("{0} is missing: copy it next to this page.", file);
  };
}

// Selection of record, block and colours.
const choices = element("div", { class: "choices" }, root), selects = {};
// A single option is shown as text; it is left out if `single` is false, as nothing would be learnt from it.
function choice(name, label, options, single) {
  const box = element("label", { class: name }, choices, label);
  const select = selects[name] = element("select", { "data-name": name }, box);
  options.forEach(pair => { element("option", { value: pair[0] }, select, pair[1]); });
  select.addEventListener("change", () => {
    at[name] = name === "colour" ? select.value : Number(select.value);
    if (name === "record" && !at.pinned) [at.a, at.b] = cube.records[at.record].clear;
    if (name === "record") load();
    writeAddress();
    draw();
  });
  if (options.length > 1) return;
  if (single) element("span", { class: "single" }, box, options[0][1]);
  (single ? select : box).hidden = true;
}
const numbered = (values, text) => { return values.map((value, index) => [index, text(value)]); };
choice("record", say("record"), numbered(cube.records, r => r.name), true);
choice("height", say("height"), numbered(cube.height, h => h + " m"), true);
choice("aspect", say("depth over breadth"), numbered(cube.aspect, String), cube.aspect[0] !== 1);
choice("friction", say("friction µ"), numbered(cube.friction, String), cube.film.friction);
choice("element", say("element"), numbered(cube.element, name => say(name)), false);
choice("colour", say("colour"), offered.map(mode => [mode, MODES[mode][0]]), false);
const doubts = element("p", { class: "note doubts", role: "status" }, root);

// Map, sliders and text.
const both = element("div", { class: "both" }, root), left = element("div", { class: "map" }, both);
const map = element("canvas", {
  tabindex: "0", role: "application", "aria-roledescription": say("map"), "aria-describedby": "keys",
}, left);
const preview = element("p", { class: "preview", "aria-hidden": "true" }, left);
const legend = element("div", { class: "legend" }, left), sliders = element("div", { class: "sliders" }, left);
element("p", { class: "note", id: "keys" }, left, (cube.space
  ? say("Across: the orientation, the azimuth that the body faces. Upwards: slenderness B/H. Colour and arrow: the " +
    "azimuth to which it falls, north up.")
  : say(cube.mirrors ? "Angle: the azimuth towards which the block falls, north up, clockwise. "
    : "Angle: the azimuth that the scene faces, north up, clockwise, and the block falls towards or away from it. ")
    + say("Radius: slenderness B/H, stouter outwards, on one scale for all records.")) +
  say(" Hover over a cell to preview it, click or tap it to pin it, or move with the arrow keys: ← → {0}, ↑ ↓ B/H. " +
    "Escape releases the cell.", say(TURNS)));
function slider(key, label, count, text) {
  const box = element("label", {}, sliders, label);
  const input = element("input", {
    type: "range", min: 0, max: count - 1, step: 1, "data-name": key, "aria-label": label,
  }, box);
  const output = element("output", {}, box);
  input.addEventListener("input", () => { at[key] = Number(input.value); pin(); });
  return c => {
    input.value = at[key];
    output.textContent = text(at[key]);
    input.setAttribute("aria-valuetext", say("{0}: {1}", text(at[key]), outcome(c)));
  };
}
const showTurn = slider("a", say(TURNS), A, a => cube.direction[a] + "°"), showRatio = slider("b", "B/H", B, ratio);

const panel = element("section", { class: "answer", "aria-label": say("outcome of the cell") }, both);
const answer = element("p", { class: "sentence", "aria-live": "polite" }, panel);
const pinned = element("p", { class: "pin" }, panel), state = element("span", {}, pinned);
function button(parent, text, act) {
  const made = element("button", { type: "button" }, parent, text);
  made.addEventListener("click", act);
  return made;
}
async function copy(made, text) {
  const label = made.textContent;
  let done = true;
  try { await navigator.clipboard.writeText(text); } catch (_) {  // not offered to pages without a secure address
    const box = element("textarea", {}, document.body);
    box.value = text;
    box.select();
    done = document.execCommand("copy");
    box.remove();
    made.focus();
  }
  made.textContent = say(done ? "Copied" : "Could not copy: select the text");
  setTimeout(() => { made.textContent = label; }, 2000);
}
const link = button(pinned, say("Copy link"), () => { copy(link, window.location.href.split("#")[0] + address()); });
const release = button(pinned, say("Release"), () => { unpin(); });

const more = element("div", { class: "more" }, both);
element("h2", {}, more, say("Film of this cell"));
const filmed = element("div", { class: "film" }, more);
const command = element("code", {}, cube.film.missing ? null : filmed);
if (!cube.film.missing) {
  const copier = button(filmed, say("Copy command"), () => { copy(copier, command.textContent); });
}
element("p", { class: "note" }, filmed, cube.film.missing
  ? say("No single command simulates it: {0}.", cube.film.missing)
  : say("This command, in the project's folder, simulates the cell and writes the film."));
function film() {
  const f = cube.film, record = cube.records[at.record].id, pulse = f.pulses[record];
  const words = ["overturning one --record", pulse ? "'" + pulse + "'" : record, ...f.options,
    "--" + TURNS, cube.direction[at.a], "--height", f.heights[at.height], "--b-over-h", f.ratios[at.b]];
  if (cube.aspect[at.aspect] !== 1) words.push("--aspect", cube.aspect[at.aspect]);
  if (f.friction) words.push("--friction", cube.friction[at.friction]);
  command.textContent = "";
  // A line does not break inside an option, where its hyphens would be misread.
  words.concat("--animate fall.html").join(" ").split(" ").forEach((word, k) => {
    command.append(k ? " " : "");
    element("span", {}, command, word);
  });
}
element("h2", {}, more, say(cube.space ? "At this orientation, by B/H" : "Along this azimuth, by B/H"));
const strip = element("canvas", { role: "img", "aria-label": say("probability of falling, by B/H") }, more);
element("h2", {}, more, say("Neighbours"));
const near = element("table", {}, more);

// The map without the selected cell is drawn once for each record, block and size.
const base = element("canvas");
let drawn = "";
function drawMap() {
  const { context, width } = surface(map, kind.ratio);
  const key = [map.width, held.record, at.colour, rings(), ...AXES.map(name => at[name])].join();
  if (key !== drawn) {
    drawCells(context, width);
    [base.width, base.height] = [map.width, map.height];
    base.getContext("2d").drawImage(map, 0, 0);
    drawn = key;
  } else {
    context.drawImage(base, 0, 0, width, map.height * width / map.width);
  }
  outline(context, width, at.a, at.b, !at.pinned);
  if (at.pinned && hovered) outline(context, width, ...hovered, true);
}
function drawCells(context, width) {
  for (let a = 0; a < A; a++) for (let b = 0; b < rings(); b++) {
    const colour = colourOf(cell(a, b));
    if (colour === null) continue;
    kind.path(context, width, a, b);
    context.fillStyle = context.strokeStyle = colour;
    context.lineWidth = 0.6;
    context.fill();
    context.stroke();
  }
  drawEdges(context, width, "#777777", 0.7, (a, b) => cube.computed[a]);
  if (at.colour === "probability") {
    // Around the cells of which at least half of the runs fall, to whichever side.
    drawEdges(context, width, "#000000", 1.4, (a, b) => {
      const { computed, either } = cell(a, b);
      return computed && either !== null ? either >= 0.5 : null;
    });
  }
  context.fillStyle = INK;
  context.lineWidth = 0.7;
  kind.axes(context, width);
}
function outline(context, width, a, b, dashed) {
  for (const [colour, wide] of [["#ffffff", 5], ["#000000", 2.5]]) {
    kind.path(context, width, a, b);
    context.setLineDash(dashed && wide < 5 ? [4, 3] : []);
    context.strokeStyle = colour;
    context.lineWidth = wide;
    context.stroke();
  }
  context.setLineDash([]);
}
function drawStrip() {
  const { context, width, height } = surface(strip, cube.space ? 0.24 : 0.36), count = rings(), wide = width / count;
  const middle = cube.space ? height - 4 : height / 2, tall = middle - 18;
  for (let b = 0; b < count; b++) {
    const c = cell(at.a, b);
    if (c.towards === null) {
      context.fillStyle = C.missing;
      context.fillRect(b * wide + 1, middle - 3, wide - 2, 6);
      continue;
    }
    context.fillStyle = cube.space && c.to !== null ? hue(c.to) : ramp(C.probability, 0.7);
    context.fillRect(b * wide + 1, middle - c.towards * tall, wide - 2, c.towards * tall);
    if (!cube.space) context.fillRect(b * wide + 1, middle, wide - 2, c.away * tall);
  }
  context.fillStyle = context.strokeStyle = INK;
  context.lineWidth = 1;
  line(context, 0, middle, width, middle);
  context.strokeRect(at.b * wide + 0.5, 1, wide - 1, height - 2);
  context.textBaseline = "top";
  context.textAlign = "left";
  context.fillText(say(cube.space ? "falls" : "falls towards {0}", bearing(cube.direction[at.a])), 4, 2);
  context.textBaseline = "bottom";
  if (!cube.space) context.fillText(say("falls towards {0}", bearing(cube.direction[at.a] + 180)), 4, height - 2);
}
// The last direction is next to the first one: on the full circle, whose last step is no longer than the others.
const CLOSED = !cube.space || cube.direction[0] + 360 - cube.direction[A - 1]
  <= 1.001 * Math.max(...cube.direction.map((turn, a) => a ? turn - cube.direction[a - 1] : 0));
function shortOutcome(c) { return c.computed && c.to !== null ? "→ " + bearing(c.to) : outcome(c); }
function drawNear() {
  near.textContent = "";
  const head = element("tr", {}, near);
  const about = [-1, 0, 1].map(k => CLOSED ? (at.a + k + A) % A : at.a + k).filter(a => a >= 0 && a < A);
  const columns = about.filter((a, k) => about.indexOf(a) === k);
  element("th", { scope: "col" }, head, "B/H");
  columns.forEach(a => { element("th", { scope: "col" }, head, cube.direction[a] + "°"); });
  for (let b = Math.min(at.b + 1, B - 1); b >= Math.max(at.b - 1, 0); b--) {
    const row = element("tr", {}, near);
    element("th", { scope: "row" }, row, ratio(b));
    columns.forEach(a => {
      element("td", a === at.a && b === at.b ? { class: "here" } : {}, row,
        shortOutcome(cell(a, b)));
    });
  }
}
function drawState() {
  answer.textContent = sentence(at.a, at.b);
  const name = say("Map by {0} and B/H. ", say(TURNS)) + (at.pinned ? say("Pinned: ") : "");
  map.setAttribute("aria-label", name + answer.textContent);
  state.textContent = say(at.pinned ? "Pinned." : "Preview: click a cell of the map to pin it.");
  link.hidden = release.hidden = !at.pinned;
  preview.textContent = at.pinned && hovered ? say("Under the pointer: {0}", sentence(...hovered)) : "";
  Object.keys(selects).forEach(name => { selects[name].value = at[name]; });
}
function draw() {
  if (!held.data) return;
  drawMap();
  drawStrip();
  drawNear();
  drawLegend();
  drawState();
  showTurn(cell(at.a, at.b));
  showRatio(cell(at.a, at.b));
  film();
}

// Pinning, and the address.
let hovered = null;
function writeAddress() {
  if (window.location.protocol !== "about:") window.history.replaceState(null, "", address());
  doubts.textContent = "";
}
function pin() {
  at.pinned = true;
  writeAddress();
  draw();
}
function unpin() {
  at.pinned = false;
  writeAddress();
  draw();
}
function cellAt(event) {
  const box = map.getBoundingClientRect();
  const [turn, radius] = kind.place(event.clientX - box.left, event.clientY - box.top, box.width);
  const a = cube.directionEdges.findIndex((edge, k) => k < A && turn >= edge && turn < cube.directionEdges[k + 1]);
  const b = cube.radiusEdges.findIndex((edge, k) => k < rings() && radius >= edge && radius < cube.radiusEdges[k + 1]);
  return a < 0 || b < 0 ? null : [a, b];
}
function hover(found) {
  if (String(found) === String(hovered)) return;
  hovered = found;
  if (found && !at.pinned) [at.a, at.b] = found;
  draw();
}
map.addEventListener("pointermove", event => { if (held.data) hover(cellAt(event)); });
["pointerleave", "pointercancel"].forEach(name => { map.addEventListener(name, () => { hover(null); }); });
map.addEventListener("click", event => {
  const found = held.data ? cellAt(event) : null;
  if (!found) return;
  [at.a, at.b] = found;
  pin();
});
map.addEventListener("keydown", event => {
  const steps = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1], Enter: [0, 0] };
  const step = steps[event.key];
  if (!step || !held.data || event.altKey || event.ctrlKey || event.metaKey) return;
  at.a = CLOSED ? (at.a + step[0] + A) % A : Math.min(Math.max(at.a + step[0], 0), A - 1);
  at.b = Math.min(Math.max(at.b + step[1], 0), B - 1);
  pin();
  event.preventDefault();
});
document.addEventListener("keydown", event => {
  if (event.key === "Escape" && at.pinned && event.target.tagName !== "SELECT") unpin();
});
window.addEventListener("resize", draw);
window.addEventListener("hashchange", open);

// Shows the cell of the address, or a clear case: one that falls in every run.
function open() {
  const found = readAddress();
  hovered = null;
  if (held.record !== at.record || !held.data) load();
  doubts.textContent = found.join(" ");
  if (held.data) show();
}
function show() {
  draw();
  root.dataset.ready = "true";
}
open();
