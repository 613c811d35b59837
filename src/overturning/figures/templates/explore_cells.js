// Cells of a cube: decoding, the outcome of a cell, and its description in words.
const root = document.getElementById("explorer"), cube = JSON.parse(root.querySelector("script").textContent);
const A = cube.direction.length, B = cube.b_over_h.length, C = cube.colours, S = cube.steps;
const INK = "#222222", TURN = 2 * Math.PI, TURNS = cube.space ? "orientation" : "azimuth";
// Flags of cells without an outcome: from MISSED on, with the reason for those whose status tells it.
const MISSED = 2, REASONS = {
  12: "it still moves long after the record and may fall", 13: "the computation is unstable",
  14: "the computation ended with an error", 15: "it needs more steps than the budget of a case",
};
// Words of the page's language for an English text; {0}, {1} … stand for values.
function say(text, ...values) {
  return ((cube.words || {})[text] || text).replace(/\{(\d)\}/g, (_, place) => values[place]);
}
const sizes = [A, cube.height.length, B, cube.aspect.length, cube.friction.length, cube.element.length];
// The selection: indices of record, block and cell, the quantity in colour, and whether the cell is pinned.
const at = {
  ...cube.shown, a: 0, b: 0, pinned: false,
  colour: cube.space ? "azimuth" : cube.ensemble ? "probability" : "outcome",
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
window.explorerRecord = hold;

function cell(a, b) {
  let place = 0;
  [a, at.height, b, at.aspect, at.friction, at.element].forEach((index, k) => { place = place * sizes[k] + index; });
  const number = (name, step, missing) => held.data[name][place] === missing ? null : held.data[name][place] * step;
  const flag = held.data.flag[place], falls = flag === 1 || flag === -1, ran = held.data.towards[place] !== 255;
  // If the ensemble of a cell was not run, use the flag of the cell itself.
  const chance = (name, side) => ran ? number(name, S.chance, 255) : flag >= MISSED ? null : Number(flag === side);
  const towards = chance("towards", 1), away = chance("away", -1);
  return {
    flag: flag, towards: towards, away: away, ran: ran, computed: cube.computed[a],
    either: towards === null ? null : towards + (cube.space ? 0 : away),
    rotation: number("rotation", S.rotation[at.element], 65535), time: number("time", held.data.timeStep, 65535),
    to: !falls ? null : cube.space ? number("azimuth", S.azimuth, 65535)
      : (cube.direction[a] + (flag < 0 ? 180 : 0)) % 360,
  };
}
// Number of B/H rings to show. All records have the same, so that their maps have one scale; rings in which nothing
// falls under any record are left out, except where rotations are shown or the selected cell is there.
function rings() { return Math.max(at.colour === "rotation" ? B : cube.rings, at.b + 1); }

function ratio(b) { return String(Number(cube.b_over_h[b].toPrecision(4))); }
function bearing(azimuth) {
  const places = cube.space ? 1 : 100;
  const phi = ((Math.round(places * azimuth) / places % 360) + 360) % 360;
  if (phi % 90 === 0) return "NESW"[phi / 90];
  const north = phi < 90 || phi > 270, angle = north ? Math.min(phi, 360 - phi) : Math.abs(phi - 180);
  return (north ? "N" : "S") + Math.round(places * angle) / places + "°" + (phi < 180 ? "E" : "W");
}
function percent(p) {
  return p > 0 && p < 0.01 ? say("less than 1 %") : p > 0.99 && p < 1 ? say("more than 99 %")
    : Math.round(100 * p) + " %";
}
function outcome(c) {
  return !c.computed ? say("not simulated") : c.flag >= MISSED ? say("no outcome") : c.to === null ? say("stands")
    : say("falls towards {0}", bearing(c.to));
}
// Rotations are in units of the critical angle α, or in degrees for elements without one.
function inDegrees() { return cube.degrees[at.element]; }
function leaning(c) {
  if (inDegrees()) return say(" and leans to at most {0}°", c.rotation.toFixed(1));
  return say(" and leans to at most {0} % of the angle at which it would topple at rest", Math.round(100 * c.rotation));
}
function sentence(a, b) {
  const c = cell(a, b), phi = cube.direction[a];
  const name = cube.element[at.element];  // of a scene or stack; empty if there is one stone only
  const stone = cube.space && !name ? say("the body") : say("the {0}", say(name || "block"));
  const where = say(cube.space ? "Facing {0}, B/H = {1}: " : "Motion along {0}, B/H = {1}: ", bearing(phi), ratio(b));
  if (!c.computed) return where + say("this azimuth was not simulated.");
  if (c.flag in REASONS) return where + say("no outcome was found: {0}.", say(REASONS[c.flag]));
  if (c.flag >= MISSED) return where + say("no outcome was found.");
  let text = where + (c.to === null ? say("{0} {1}", stone, outcome(c))
    : say("{0} falls towards {1}", stone, bearing(c.to)));
  if (c.time !== null) text += say(", past the point of no return at {0} s", c.time.toFixed(2));
  if (c.rotation !== null && c.flag === 0) text += leaning(c);
  text += say(".");
  if (!cube.ensemble || !c.ran) return text;
  text += say(" With slightly changed motion and block it ");
  if (c.either === 0) return text + say("stands in every run.");
  if (cube.space) return text + say("falls with a probability of {0}.", percent(c.towards));
  return text + say("falls towards {0} with a probability of {1}, towards {2} with {3}.", bearing(phi),
    percent(c.towards), bearing(phi + 180), percent(c.away));
}
