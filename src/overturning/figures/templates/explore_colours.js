// Colours of the map and their legend.
function ramp(stops, share) {
  const place = Math.min(Math.max(share, 0), 1);
  const high = Math.max(1, stops.findIndex(stop => stop[0] >= place)), low = high - 1;
  const part = (place - stops[low][0]) / (stops[high][0] - stops[low][0]);
  const channel = (stop, k) => parseInt(stops[stop][1].slice(1 + 2 * k, 3 + 2 * k), 16);
  const mixed = k => Math.round(channel(low, k) * (1 - part) + channel(high, k) * part);
  return "rgb(" + [0, 1, 2].map(mixed).join(",") + ")";
}
function gradient(stops) { return "linear-gradient(to right," + stops.map(s => s[1] + " " + 100 * s[0] + "%") + ")"; }
function hue(azimuth) { return C.azimuths[Math.floor(azimuth / 360 * C.azimuths.length) % C.azimuths.length]; }

// A hatch as the pattern of a canvas and as the background of a swatch.
function hatched(ground, lines, crossed) {
  const size = 6, density = Math.ceil(window.devicePixelRatio || 1), tile = element("canvas");
  tile.width = tile.height = size * density;
  const context = tile.getContext("2d");
  context.scale(density, density);
  context.fillStyle = ground;
  context.fillRect(0, 0, size, size);
  context.strokeStyle = lines;
  context.lineWidth = 0.8;
  for (const way of crossed ? [1, -1] : [1]) for (const shift of [-size, 0, size]) {
    context.beginPath();
    context.moveTo(way > 0 ? shift - 1 : size - shift + 1, size + 1);
    context.lineTo(way > 0 ? shift + size + 1 : -shift - 1, -1);
    context.stroke();
  }
  const fill = context.createPattern(tile, "repeat"), angles = crossed ? ["45deg", "135deg"] : ["135deg"];
  fill.setTransform(new DOMMatrix().scale(1 / density));
  const bands = "," + lines + " 0 1px,transparent 1px 4px)";
  const stripes = angles.map(angle => "repeating-linear-gradient(" + angle + bands);
  return { fill: fill, css: stripes + "," + ground };
}
const STANDS = hatched(C.stands, C.hatch, false), MISSING = hatched(C.missing, "#ffffff", true);
const BLUES = [[0, "#f4f4f2"], [1 / 3, "#9ec4e2"], [2 / 3, "#2a6fa8"], [1, "#0b2f55"]];
const LATE = 0.25;  // place of the latest fall in the ramp of probabilities; the earliest is dark

// Place of a time between the earliest and the latest fall of the record, 1 to `LATE`.
function early(time) {
  const [first, last] = cube.records[at.record].times;
  return 1 - (1 - LATE) * (time - first) / (last - first || 1);
}
const MODES = {
  azimuth: [say("azimuth of the fall"), c => c.flag >= MISSED ? MISSING.fill : c.to === null ? STANDS.fill : hue(c.to)],
  probability: [say("probability"), c => c.towards === null ? MISSING.fill
    : c.either === 0 && c.to === null ? STANDS.fill : ramp(C.probability, c.towards)],
  outcome: [say("outcome of the case itself"), c => c.flag >= MISSED ? MISSING.fill : c.to === null ? STANDS.fill
    : ramp(C.probability, c.flag === 1 ? 1 : 0)],
  rotation: [say(cube.space ? "largest tilt" : "largest rotation"),
    c => c.rotation === null ? MISSING.fill : ramp(BLUES, c.rotation / (inDegrees() ? 30 : 1))],
  time: [say("time of the fall"), c => c.flag >= MISSED ? MISSING.fill : c.to === null || c.time === null ? STANDS.fill
    : ramp(C.probability, early(c.time))],
};
const offered = Object.keys(MODES).filter(
  mode => mode === "probability" ? cube.ensemble : cube.space ? mode !== "outcome" : mode !== "azimuth");
// The colour of a cell; none where nothing was simulated.
function colourOf(c) { return c.computed ? MODES[at.colour][1](c) : null; }

function swatch(background, text) {
  const item = element("span", {}, legend);
  element("i", { style: "background:" + background }, item);
  item.append(text);
}
function scale(title, low, stops, high) {
  const item = element("span", {}, legend, say("{0}: {1}", title, low));
  element("i", { class: "scale", style: "background:" + gradient(stops) }, item);
  item.append(high);
}
function late() {
  return [[0, ramp(C.probability, 1)], ...[0.25, 0.5, 0.75, 1].map(s => [s, ramp(C.probability, 1 - (1 - LATE) * s)])];
}
const LEGENDS = {
  azimuth: () => {
    ["N", "E", "S", "W"].forEach((name, k) => { swatch(hue(90 * k), say("towards {0}", name)); });
    swatch(STANDS.css, say("stands"));
  },
  probability: () => {
    swatch(STANDS.css, say(cube.space ? "no run falls" : "no run falls, to either side"));
    scale(say(cube.space ? "probability of falling" : "probability of falling towards this azimuth"), "0",
      C.probability, "100 %");
    element("i", { class: "line" }, element("span", {}, legend)).after(
      say(cube.space ? "half of the runs fall" : "half of the runs fall, to either side"));
  },
  outcome: () => {
    swatch(ramp(C.probability, 1), say("falls towards this azimuth"));
    swatch(ramp(C.probability, 0), say("falls to the other side"));
    swatch(STANDS.css, say("stands"));
  },
  rotation: () => {
    scale(MODES.rotation[0], "0", BLUES, say(inDegrees() ? "30° and more" : "100 % of the toppling angle and more"));
  },
  time: () => {
    const times = cube.records[at.record].times;
    if (times) scale(say("time of the fall"), times[0].toFixed(1) + " s", late(), times[1].toFixed(1) + " s");
    swatch(STANDS.css, say("stands"));
  },
};
function drawLegend() {
  legend.textContent = "";
  LEGENDS[at.colour]();
  const here = [];
  for (let a = 0; a < A; a++) for (let b = 0; b < rings(); b++) here.push(cell(a, b));
  if (here.some(c => c.computed && c.flag >= MISSED)) swatch(MISSING.css, say("no outcome"));
  if (here.some(c => !c.computed)) swatch("none", say("not simulated"));
  if (kind === compass && cube.radiusEdges[0] > 0) {
    swatch("none", say("not simulated: B/H below {0}", Number(cube.radiusEdges[0].toPrecision(3))));
  }
  const normal = cube.records[at.record].normal;
  if (normal !== null) swatch(C.fault, say("fault normal {0}", bearing(normal)));
  const last = cube.rings - 1;
  if (rings() < B) element("span", {}, legend, say("no record has falls from B/H = {0} on", ratio(last)));
}
