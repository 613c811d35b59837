// Map of one block of a cube, the outcome of the selected cell, and the command that writes its film.
const root = document.getElementById("explorer"), cube = JSON.parse(root.querySelector("script").textContent);
const A = cube.direction.length, B = cube.b_over_h.length, C = cube.colours, S = cube.steps;
const INK = "#222222", TURN = 2 * Math.PI;
const sizes = [A, cube.height.length, B, cube.aspect.length, cube.friction.length, cube.element.length];
const at = {
  record: 0, aspect: 0, ...cube.shown, a: 0, b: 0,
  colour: cube.space ? "azimuth" : cube.ensemble ? "chance" : "flag",
};
const held = { record: -1, data: null };  // decoded cells of the selected record

// Decodes the cells of a record. They are in the page, or in a separate file that calls this function.
function hold(index, cells) {
  if (index !== at.record) return;
  held.record = index;
  held.data = {
    flag: new Int8Array(bytes(cells.flag)),
    towards: new Uint8Array(bytes(cells.towards)), away: new Uint8Array(bytes(cells.away)),
    rotation: words(cells.rotation), time: words(cells.time), timeStep: cells.timeStep,
    azimuth: cells.azimuth ? words(cells.azimuth) : null,
  };
}
function load() {
  const index = at.record;
  held.data = null;
  if (!cube.folder) return hold(index, cube.records[index].cells);
  const file = encodeURIComponent(cube.folder) + "/" + index + ".js";
  said.textContent = "Reading " + file + " …";
  const script = element("script", { src: file }, document.head);
  script.onload = () => { script.remove(); if (index === at.record) { settle(); draw(); } };
  script.onerror = () => {
    script.remove();
    if (index === at.record) said.textContent = file + " is missing: copy it next to this page.";
  };
}
window.explorerRecord = hold;

function cell(a, b) {
  let place = 0;
  [a, at.height, b, at.aspect, at.friction, at.element].forEach((index, k) => { place = place * sizes[k] + index; });
  const number = (name, step, missing) => held.data[name][place] === missing ? null : held.data[name][place] * step;
  const flag = held.data.flag[place], falls = flag === 1 || flag === -1, ran = held.data.towards[place] !== 255;
  // If the ensemble of a cell was not run, use the flag of the cell itself.
  const chance = (name, side) => ran ? number(name, S.chance, 255) : flag === 2 ? null : Number(flag === side);
  return {
    flag: flag, towards: chance("towards", 1), away: chance("away", -1), ran: ran,
    rotation: number("rotation", S.rotation, 65535), time: number("time", held.data.timeStep, 65535),
    to: !falls ? null : cube.space ? number("azimuth", S.azimuth, 65535)
      : (cube.direction[a] + (flag < 0 ? 180 : 0)) % 360,
  };
}
function bearing(azimuth) {
  const places = cube.space ? 1 : 100;
  const phi = ((Math.round(places * azimuth) / places % 360) + 360) % 360;
  if (phi % 90 === 0) return "NESW"[phi / 90];
  const north = phi < 90 || phi > 270, angle = north ? Math.min(phi, 360 - phi) : Math.abs(phi - 180);
  return (north ? "N" : "S") + Math.round(places * angle) / places + "°" + (phi < 180 ? "E" : "W");
}
function mix(stops, share) {
  const place = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const low = Math.min(Math.floor(place), stops.length - 2), part = place - low;
  const channel = (colour, k) => parseInt(colour.substr(1 + 2 * k, 2), 16);
  const mixed = k => Math.round(channel(stops[low], k) * (1 - part) + channel(stops[low + 1], k) * part);
  return "rgb(" + [0, 1, 2].map(mixed).join(",") + ")";
}
function hue(azimuth) { return C.azimuths[Math.floor(azimuth / 360 * C.azimuths.length) % C.azimuths.length]; }
const HEAT = [C.stands, "#f6c9a0", "#e58a4b", C.falls, C.darkest], BLUES = ["#f4f4f2", "#9ec4e2", "#2a6fa8", "#0b2f55"];
const LATE = 0.3;  // position of the latest fall along the colours HEAT; 0 is for cells that stand
// Rotations are in units of the critical angle α, or in degrees for elements without one; colours then end at 30°.
function inDegrees() { return cube.degrees[at.element]; }
const MODES = {
  azimuth: ["azimuth of the fall", c => c.flag === 2 ? C.missing : c.to === null ? C.stands : hue(c.to)],
  chance: ["probability", c => c.towards === null ? C.missing : c.away > 0.5 ? C.other : mix(HEAT, c.towards)],
  flag: ["outcome", c => ({ "1": C.falls, "-1": C.other, "0": C.stands }[c.flag] || C.missing)],
  rotation: [cube.space ? "largest tilt" : "largest rotation",
    c => c.rotation === null ? C.missing : mix(BLUES, c.rotation / (inDegrees() ? 30 : 1))],
  time: ["time of the fall",
    c => c.flag === 2 ? C.missing : c.time === null ? C.stands : mix(HEAT, 1 - (1 - LATE) * c.time / cube.longest)],
};
// Number of B/H rings to show: rings without any fall are left out, except in the map of rotations.
function rings() { return at.colour === "rotation" ? B : cube.records[at.record].rings; }

// Selection of record, block and colours.
const choices = element("div", { class: "choices" }, root);
function choice(name, label, options) {
  const box = element("label", { class: name }, choices, label), select = element("select", { "data-name": name }, box);
  options.forEach(pair => { element("option", { value: pair[0] }, select, pair[1]); });
  select.value = at[name];
  select.addEventListener("change", () => {
    at[name] = name === "colour" ? select.value : Number(select.value);
    if (name === "record") load();
    draw();
  });
  if (options.length === 1) box.hidden = true;
}
const numbered = (values, text) => { return values.map((value, index) => [index, text(value)]); };
choice("record", "record", numbered(cube.records, r => r.name));
choice("height", "height", numbered(cube.height, h => h + " m"));
choice("aspect", "depth over breadth", numbered(cube.aspect, String));
choice("friction", "friction µ", numbered(cube.friction, String));
choice("element", "element", numbered(cube.element, String));
const offered = Object.keys(MODES).filter(
  m => m === "chance" ? cube.ensemble : cube.space ? m !== "flag" : m !== "azimuth");
choice("colour", "colour", offered.map(m => [m, MODES[m][0]]));

// Map, sliders and text.
const both = element("div", { class: "both" }, root), left = element("div", {}, both), right = element("div", {}, both);
const TURNS = cube.space ? "orientation" : "azimuth";
const map = element("canvas", {
  tabindex: "0", role: "img", "aria-label": "map: " + TURNS + " and B/H; arrow keys move",
}, left);
const legend = element("div", { class: "legend" }, left), sliders = element("div", { class: "sliders" }, left);
element("p", { class: "note" }, left, (cube.space
  ? "Across: the orientation, the azimuth that the body faces. Upwards: slenderness B/H. Colour and arrow: "
    + "the azimuth to which it falls, north up."
  : (cube.mirrors ? "Angle: the azimuth towards which the block falls, north up, clockwise. "
    : "Angle: the azimuth that the scene faces, north up, clockwise, and the block falls towards or away from it. ")
    + "Radius: slenderness B/H, out to the first at which nothing falls under the record.") +
  " Point at a cell, tap it, or move with the arrow keys: ← → " + TURNS + ", ↑ ↓ B/H.");
function slider(parent, key, label, from, to, step, text) {
  const box = element("label", {}, parent, label);
  const input = element("input", {
    type: "range", min: from, max: to, step: step, "data-name": key, "aria-label": label,
  }, box);
  const output = element("output", {}, box);
  input.addEventListener("input", () => { at[key] = Number(input.value); draw(); });
  return most => {
    if (most !== undefined) input.max = most;
    input.value = at[key];
    output.textContent = text(at[key]);
  };
}
const showTurn = slider(sliders, "a", TURNS, 0, A - 1, 1, a => cube.direction[a] + "°");
const showRatio = slider(sliders, "b", "B/H", 0, B - 1, 1, b => String(Number(cube.b_over_h[b].toPrecision(3))));
const said = element("p", { class: "said", "aria-live": "polite" }, right);
element("h2", {}, right, "Film of this cell");
const filmed = element("div", { class: "film" }, right);
const command = element("code", {}, cube.film.missing ? null : filmed);
if (cube.film.missing) element("p", { class: "note" }, filmed, "No single command simulates it: " + cube.film.missing + ".");
else {
  const copy = element("button", { type: "button" }, filmed, "Copy");
  copy.addEventListener("click", () => { navigator.clipboard.writeText(command.textContent); });
  element("p", { class: "note" }, filmed, "This command, in the project's folder, simulates the cell and writes the film.");
}
function film() {
  const f = cube.film, record = cube.records[at.record].id, pulse = f.pulses[record];
  const words = ["overturning one --record", pulse ? "'" + pulse + "'" : record, ...f.options,
    cube.space ? "--orientation" : "--azimuth", cube.direction[at.a],
    "--height", f.heights[at.height], "--b-over-h", f.ratios[at.b]];
  if (cube.aspect[at.aspect] !== 1) words.push("--aspect", cube.aspect[at.aspect]);
  if (f.friction) words.push("--friction", cube.friction[at.friction]);
  command.textContent = words.concat("--animate fall.html").join(" ");
}
element("h2", {}, right, cube.space ? "At this orientation, by B/H" : "Along this azimuth, by B/H");
const strip = element("canvas", { role: "img", "aria-label": "probability of falling, by B/H" }, right);
element("h2", {}, right, "Neighbours");
const near = element("table", {}, right);

function line(context, x, y, x2, y2) {
  context.beginPath();
  context.moveTo(x, y);
  context.lineTo(x2, y2);
  context.stroke();
}
function arrow(context, x, y, angle, length) {
  const s = Math.sin(angle) * length / 2, c = -Math.cos(angle) * length / 2;
  line(context, x - s, y - c, x + s, y + c);
  for (const turn of [angle + 2.6, angle - 2.6]) {
    line(context, x + s, y + c, x + s + Math.sin(turn) * length * 0.35, y + c - Math.cos(turn) * length * 0.35);
  }
}
const kind = cube.space ? plane : compass;
function drawMap() {
  const { context, width } = surface(map, kind.ratio), colour = MODES[at.colour][1];
  for (let a = 0; a < A; a++) for (let b = 0; b < rings(); b++) {
    kind.path(context, width, a, b);
    context.fillStyle = context.strokeStyle = colour(cell(a, b));
    context.lineWidth = 0.6;
    context.fill();
    context.stroke();
  }
  context.fillStyle = INK;
  context.lineWidth = 0.7;
  kind.axes(context, width);
  kind.path(context, width, at.a, at.b);
  context.strokeStyle = "#ffffff";
  context.lineWidth = 4;
  context.stroke();
  context.strokeStyle = "#000000";
  context.lineWidth = 2;
  context.stroke();
}
function drawStrip() {
  const { context, width, height } = surface(strip, cube.space ? 0.24 : 0.36), count = rings(), wide = width / count;
  const middle = cube.space ? height - 4 : height / 2, tall = middle - 14;
  for (let b = 0; b < count; b++) {
    const c = cell(at.a, b);
    context.fillStyle = c.towards === null ? C.missing : cube.space && c.to !== null ? hue(c.to) : C.falls;
    if (c.towards === null) context.fillRect(b * wide + 1, middle - 3, wide - 2, 6);
    else context.fillRect(b * wide + 1, middle - c.towards * tall, wide - 2, c.towards * tall);
    context.fillStyle = C.other;
    if (c.away) context.fillRect(b * wide + 1, middle, wide - 2, c.away * tall);
  }
  context.fillStyle = context.strokeStyle = INK;
  context.lineWidth = 1;
  line(context, 0, middle, width, middle);
  context.strokeRect(at.b * wide + 0.5, 1, wide - 1, height - 2);
  context.textBaseline = "top";
  context.textAlign = "left";
  context.fillText(cube.space ? "falls" : "falls towards " + bearing(cube.direction[at.a]), 4, 2);
  context.textBaseline = "bottom";
  if (!cube.space) context.fillText("falls towards " + bearing(cube.direction[at.a] + 180), 4, height - 2);
}
function percent(p) {
  return p > 0 && p < 0.01 ? "less than 1 %" : p > 0.99 && p < 1 ? "more than 99 %" : Math.round(100 * p) + " %";
}
function verdict(c) { return c.to === null ? "stands" : "falls towards " + bearing(c.to); }
function sentence(a, b) {
  const c = cell(a, b), phi = cube.direction[a];
  const stone = cube.space ? "the body" : "the " + (cube.element[at.element] || "block");
  const where = (cube.space ? "Facing " : "Motion along ") + bearing(phi) + ", B/H = "
    + Number(cube.b_over_h[b].toPrecision(4)) + ": ";
  if (c.flag === 2) return where + "no outcome was found.";
  let text = where + stone + " " + verdict(c);
  if (c.time !== null) text += ", past the point of no return at " + c.time.toFixed(2) + " s";
  if (c.rotation !== null && c.flag === 0) text += ", largest " + (cube.space ? "tilt " : "rotation ")
    + (inDegrees() ? c.rotation.toFixed(1) + "°" : c.rotation.toFixed(2) + " α");
  text += ".";
  if (cube.ensemble && c.ran) text += " In its neighbourhood it falls " + (cube.space
    ? "with a probability of " + percent(c.towards) + "."
    : "towards " + bearing(phi) + " with a probability of " + percent(c.towards)
      + ", towards " + bearing(phi + 180) + " with " + percent(c.away) + ".");
  return text;
}
function drawNear() {
  near.textContent = "";
  const closed = !cube.space, head = element("tr", {}, near), last = rings() - 1;
  const about = [-1, 0, 1].map(k => closed ? (at.a + k + A) % A : at.a + k).filter(a => a >= 0 && a < A);
  const columns = about.filter((a, k) => about.indexOf(a) === k);
  element("th", {}, head, "B/H");
  columns.forEach(a => { element("th", {}, head, cube.direction[a] + "°"); });
  for (let b = Math.min(at.b + 1, last); b >= Math.max(at.b - 1, 0); b--) {
    const row = element("tr", {}, near);
    element("th", {}, row, String(Number(cube.b_over_h[b].toPrecision(4))));
    columns.forEach(a => {
      const c = cell(a, b);
      const outcome = c.flag === 2 ? "no outcome" : c.to === null ? "stands" : "→ " + bearing(c.to);
      element("td", a === at.a && b === at.b ? { class: "here" } : {}, row, outcome);
    });
  }
}
function drawLegend() {
  legend.textContent = "";
  const unit = inDegrees() ? ["10°", "30° and more"] : ["0.33 α", "α and more"];
  const entries = {
    azimuth: ["N", "E", "S", "W"].map((name, k) => [hue(90 * k), "towards " + name]).concat([[C.stands, "stands"]]),
    chance: cube.space ? [[C.stands, "stands"], [mix(HEAT, 0.5), "falls, 50 %"], [C.darkest, "100 %"]]
      : [[C.stands, "stands"], [mix(HEAT, 0.5), "falls towards the azimuth, 50 %"], [C.darkest, "100 %"],
        [C.other, "falls to the other side"]],
    flag: [[C.falls, "falls towards the azimuth"], [C.other, "falls to the other side"], [C.stands, "stands"]],
    rotation: [[BLUES[0], "0"], [BLUES[1], unit[0]], [BLUES[3], unit[1]]],
    time: [[C.darkest, "early"], [mix(HEAT, LATE), "late"], [C.stands, "stands"]],
  }[at.colour].concat([[C.missing, "no outcome"]]);
  entries.forEach(pair => {
    const item = element("span", {}, legend);
    element("i", { style: "background:" + pair[0] }, item);
    item.appendChild(document.createTextNode(pair[1]));
  });
  const normal = cube.records[at.record].normal;
  const fault = cube.space ? "fault normal " + bearing(normal) : "▮ fault normal";
  if (normal !== null) element("span", { style: "color:" + C.fault }, legend, fault);
  const last = Number(cube.b_over_h[rings() - 1].toPrecision(3));
  if (rings() < B) element("span", {}, legend, "no falls from B/H = " + last + " on");
}
function draw() {
  if (!held.data) return;
  at.b = Math.min(at.b, rings() - 1);
  drawMap();
  drawStrip();
  drawNear();
  drawLegend();
  showTurn();
  showRatio(rings() - 1);
  said.textContent = sentence(at.a, at.b);
  film();
}
function point(event) {
  const box = map.getBoundingClientRect();
  if (!held.data) return;
  const [turn, radius] = kind.place(event.clientX - box.left, event.clientY - box.top, box.width);
  const a = cube.directionEdges.findIndex((edge, k) => k < A && turn >= edge && turn < cube.directionEdges[k + 1]);
  const b = cube.radiusEdges.findIndex((edge, k) => k < rings() && radius >= edge && radius < cube.radiusEdges[k + 1]);
  if (a < 0 || b < 0 || (a === at.a && b === at.b)) return;
  at.a = a;
  at.b = b;
  draw();
}
map.addEventListener("pointermove", point);
map.addEventListener("pointerdown", point);
map.addEventListener("keydown", event => {
  const step = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
  if (!step || !held.data) return;
  at.a = cube.space ? Math.min(Math.max(at.a + step[0], 0), A - 1) : (at.a + step[0] + A) % A;
  at.b = Math.min(Math.max(at.b + step[1], 0), rings() - 1);
  draw();
  event.preventDefault();
});
window.addEventListener("resize", draw);
// The first selected cell is the broadest block that falls.
let settled = false;
function settle() {
  if (!settled) for (let b = 0; b < B; b++) for (let a = A - 1; a >= 0; a--) {
    if (cell(a, b).flag === 1) { at.a = a; at.b = b; }
  }
  settled = true;
  root.dataset.ready = "true";
}
load();
if (held.data) settle();
draw();
