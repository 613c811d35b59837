// The address of a cell, "#record=rinaldi&azimuth=30&b_over_h=0.3…": it has values, so that it holds for a finer study.
const PLAIN = at.colour;
const AXES = ["height", "aspect", "friction", "element"];

function address() {
  const parts = new URLSearchParams({ record: cube.records[at.record].id });
  if (at.pinned) {
    parts.set(TURNS, cube.direction[at.a]);
    parts.set("b_over_h", cube.b_over_h[at.b]);
  }
  AXES.forEach(name => { if (cube[name].length > 1) parts.set(name, cube[name][at[name]]); });
  if (at.colour !== PLAIN) parts.set("colour", at.colour);
  return "#" + parts;
}

// Sets the selection to that of the page's address; returns a sentence for each part that the study does not have.
function readAddress() {
  const parts = new URLSearchParams(window.location.hash.slice(1)), doubts = [];
  Object.assign(at, cube.shown, { colour: PLAIN });
  const known = (name, text, names) => {
    const index = names.indexOf(text);
    if (index < 0) doubts.push(say("This study has no {0} “{1}”.", say(name), text));
    return index;
  };
  const nearest = (name, text, values) => {
    const value = text.trim() === "" ? NaN : Number(text), turn = name === "azimuth" ? 360 : Infinity;
    if (!Number.isFinite(value)) {
      doubts.push(say("{0} “{1}” is not a number.", say(name), text));
      return -1;
    }
    const apart = values.map(one => {
      const gap = Math.abs(one - value);
      return turn === 360 ? Math.abs((gap + 180) % 360 - 180) : gap;
    });
    const index = apart.indexOf(Math.min(...apart));
    if (apart[index] > 1e-6) doubts.push(say("No {0} {1} here; the nearest is {2}.", say(name), text, values[index]));
    return index;
  };
  const take = (name, key, find, values) => {
    if (!parts.has(name)) return false;
    const index = find(name, parts.get(name), values);
    if (index >= 0) at[key] = index;
    return index >= 0;
  };
  take("record", "record", known, cube.records.map(one => one.id));
  AXES.forEach(name => { take(name, name, name === "element" ? known : nearest, cube[name]); });
  if (parts.has("colour")) {
    const index = known("colour", parts.get("colour"), offered);
    if (index >= 0) at.colour = offered[index];
  }
  [at.a, at.b] = cube.records[at.record].clear;
  const cells = [take(TURNS, "a", nearest, cube.direction), take("b_over_h", "b", nearest, cube.b_over_h)];
  at.pinned = cells.some(Boolean);
  return doubts;
}
