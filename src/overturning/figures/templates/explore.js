// A polar map of one block of a cube, and what is known of the cell pointed at. No library, no network.
"use strict";
(function () {
  const root = document.getElementById("explorer"), cube = JSON.parse(root.querySelector("script").textContent);
  const sizes = [cube.records.length, cube.azimuth.length, cube.height.length, cube.b_over_h.length, cube.friction.length, cube.element.length];
  const [, A, , B] = sizes, C = cube.colours, INK = "#222222";
  const data = {
    flag: new Int8Array(bytes(cube.data.flag)), towards: new Uint8Array(bytes(cube.data.towards)), away: new Uint8Array(bytes(cube.data.away)),
    rotation: words(cube.data.rotation), time: words(cube.data.time),
  };
  const at = { record: 0, height: 0, friction: cube.friction.length - 1, element: 0, colour: cube.ensemble ? "chance" : "flag", a: 0, b: 0 };

  function bytes(text) {
    const binary = atob(text), made = new Uint8Array(binary.length);
    for (let i = 0; i < binary.length; i++) made[i] = binary.charCodeAt(i);
    return made.buffer;
  }
  function words(text) {
    const view = new DataView(bytes(text)), made = new Uint16Array(view.byteLength / 2);
    for (let i = 0; i < made.length; i++) made[i] = view.getUint16(2 * i, true);
    return made;
  }
  function element(name, attributes, parent, text) {
    const made = document.createElement(name);
    for (const key in attributes) made.setAttribute(key, attributes[key]);
    if (text !== undefined) made.textContent = text;
    if (parent) parent.appendChild(made);
    return made;
  }
  function cell(a, b) {
    let place = 0;
    [at.record, a, at.height, b, at.friction, at.element].forEach(function (index, k) { place = place * sizes[k] + index; });
    const number = function (name, step, missing) { return data[name][place] === missing ? null : data[name][place] * step; };
    return {
      flag: data.flag[place], towards: number("towards", cube.steps.chance, 255), away: number("away", cube.steps.chance, 255),
      rotation: number("rotation", cube.steps.rotation, 65535), time: number("time", cube.steps.time, 65535),
    };
  }
  function bearing(azimuth) {
    const phi = ((azimuth % 360) + 360) % 360;
    if (phi % 90 === 0) return "NESW"[phi / 90];
    const north = phi < 90 || phi > 270, angle = north ? Math.min(phi, 360 - phi) : Math.abs(phi - 180);
    return (north ? "N" : "S") + Math.round(100 * angle) / 100 + "°" + (phi < 180 ? "E" : "W");
  }
  function mix(stops, share) {
    const place = Math.min(Math.max(share, 0), 1) * (stops.length - 1), low = Math.min(Math.floor(place), stops.length - 2), part = place - low;
    const channel = function (colour, k) { return parseInt(colour.substr(1 + 2 * k, 2), 16); };
    return "rgb(" + [0, 1, 2].map(function (k) { return Math.round(channel(stops[low], k) * (1 - part) + channel(stops[low + 1], k) * part); }).join(",") + ")";
  }
  const HEAT = [C.stands, "#f6c9a0", "#e58a4b", C.falls, C.darkest], BLUES = ["#f4f4f2", "#9ec4e2", "#2a6fa8", "#0b2f55"];
  let longest = 0;
  for (const value of data.time) if (value !== 65535) longest = Math.max(longest, value * cube.steps.time);
  const MODES = {
    chance: ["probability", function (c) { return c.towards === null ? C.missing : c.away > 0.5 ? C.other : mix(HEAT, c.towards); }],
    flag: ["outcome", function (c) { return { "1": C.falls, "-1": C.other, "0": C.stands }[c.flag] || C.missing; }],
    rotation: ["largest rotation", function (c) { return c.rotation === null ? C.missing : mix(BLUES, c.rotation); }],
    time: ["time of the fall", function (c) { return c.flag === 2 ? C.missing : c.time === null ? C.stands : mix(HEAT, 1 - c.time / (longest || 1)); }],
  };

  // Choices.
  const choices = element("div", { class: "choices" }, root);
  function choice(name, label, options) {
    const box = element("label", { class: name }, choices, label), select = element("select", { "data-name": name }, box);
    options.forEach(function (pair) { element("option", { value: pair[0] }, select, pair[1]); });
    select.value = at[name];
    select.addEventListener("change", function () { at[name] = name === "colour" ? select.value : Number(select.value); draw(); });
    if (options.length === 1) box.hidden = true;
    return select;
  }
  const numbered = function (values, text) { return values.map(function (value, index) { return [index, text(value)]; }); };
  choice("record", "record", numbered(cube.records, function (r) { return r.name; }));
  choice("height", "height", numbered(cube.height, function (h) { return h + " m"; }));
  choice("friction", "friction µ", numbered(cube.friction, String));
  choice("element", "element", numbered(cube.element, String));
  choice("colour", "colour", Object.keys(MODES).filter(function (m) { return m !== "chance" || cube.ensemble; }).map(function (m) { return [m, MODES[m][0]]; }));

  // Map, sliders, and what is said.
  const both = element("div", { class: "both" }, root), left = element("div", {}, both), right = element("div", {}, both);
  const map = element("canvas", { tabindex: "0", role: "img", "aria-label": "polar map: azimuth of the fall and B/H; arrow keys move" }, left);
  const legend = element("div", { class: "legend" }, left), sliders = element("div", { class: "sliders" }, left);
  function slider(key, label, count, text) {
    const box = element("label", {}, sliders, label);
    const input = element("input", { type: "range", min: 0, max: count - 1, step: 1, "data-name": key, "aria-label": label }, box);
    const output = element("output", {}, box);
    input.addEventListener("input", function () { at[key] = Number(input.value); draw(); });
    return function () { input.value = at[key]; output.textContent = text(at[key]); };
  }
  const shown = [
    slider("a", "azimuth", A, function (a) { return cube.azimuth[a] + "°"; }),
    slider("b", "B/H", B, function (b) { return cube.b_over_h[b].toPrecision(3).replace(/0+$/, ""); }),
  ];
  const said = element("p", { class: "said", "aria-live": "polite" }, right);
  element("h2", {}, right, "Along this azimuth, by B/H");
  const strip = element("canvas", { role: "img", "aria-label": "probability of falling to either side, by B/H" }, right);
  element("h2", {}, right, "Neighbours");
  const near = element("table", {}, right);

  function surface(canvas, ratio) {
    const density = window.devicePixelRatio || 1, width = canvas.clientWidth || 300, height = Math.round(width * ratio);
    canvas.style.height = height + "px";
    canvas.width = Math.round(width * density);
    canvas.height = Math.round(height * density);
    const context = canvas.getContext("2d");
    context.setTransform(density, 0, 0, density, 0, 0);
    context.clearRect(0, 0, width, height);
    context.font = "12px system-ui, sans-serif";
    return { context: context, width: width, height: height };
  }
  const outer = cube.radiusEdges[B];
  function reach(width) { return width / 2 - 22; }
  // A canvas counts angles from the right; an azimuth counts from the top: a quarter turn less.
  function wedge(context, x, a, b, scale) {
    const from = cube.azimuthEdges[a] - Math.PI / 2, to = cube.azimuthEdges[a + 1] - Math.PI / 2;
    context.beginPath();
    context.arc(x, x, cube.radiusEdges[b + 1] * scale, from, to);
    context.arc(x, x, Math.max(0, cube.radiusEdges[b]) * scale, to, from, true);
    context.closePath();
  }
  function drawMap() {
    const { context, width } = surface(map, 1), x = width / 2, scale = reach(width) / outer, colour = MODES[at.colour][1];
    for (let a = 0; a < A; a++) for (let b = 0; b < B; b++) {
      wedge(context, x, a, b, scale);
      context.fillStyle = context.strokeStyle = colour(cell(a, b));
      context.lineWidth = 0.6;
      context.fill();
      context.stroke();
    }
    context.strokeStyle = "#c8c8c8";
    context.lineWidth = 0.7;
    context.fillStyle = INK;
    context.textBaseline = "middle";
    for (const tick of [0.2, 0.4, 0.6, 0.8, 1]) if (tick < outer) {
      context.beginPath();
      context.arc(x, x, tick * scale, 0, 2 * Math.PI);
      context.stroke();
      context.textAlign = "left";
      context.fillText(String(tick), x + tick * scale * Math.cos(0.4) + 2, x + tick * scale * Math.sin(0.4));
    }
    context.beginPath();
    context.strokeStyle = INK;
    context.arc(x, x, outer * scale, 0, 2 * Math.PI);
    context.stroke();
    const normal = cube.records[at.record].normal;
    if (normal !== null) {
      const angle = normal / 180 * Math.PI, s = Math.sin(angle) * outer * scale, c = Math.cos(angle) * outer * scale;
      context.strokeStyle = C.fault;
      context.lineWidth = 1.6;
      context.setLineDash([6, 4]);
      context.beginPath();
      context.moveTo(x - s, x + c);
      context.lineTo(x + s, x - c);
      context.stroke();
      context.setLineDash([]);
    }
    context.textAlign = "center";
    ["N", "NE", "E", "SE", "S", "SW", "W", "NW"].forEach(function (name, k) {
      const angle = k * Math.PI / 4, far = outer * scale + 12;
      context.fillText(name, x + Math.sin(angle) * far, x - Math.cos(angle) * far);
    });
    wedge(context, x, at.a, at.b, scale);
    context.strokeStyle = "#ffffff";
    context.lineWidth = 4;
    context.stroke();
    context.strokeStyle = "#000000";
    context.lineWidth = 2;
    context.stroke();
  }
  function drawStrip() {
    const { context, width, height } = surface(strip, 0.36), middle = height / 2, wide = width / B, tall = middle - 14;
    for (let b = 0; b < B; b++) {
      const c = cell(at.a, b);
      if (c.towards === null) {
        context.fillStyle = C.missing;
        context.fillRect(b * wide + 1, middle - 3, wide - 2, 6);
        continue;
      }
      context.fillStyle = C.falls;
      context.fillRect(b * wide + 1, middle - c.towards * tall, wide - 2, c.towards * tall);
      context.fillStyle = C.other;
      context.fillRect(b * wide + 1, middle, wide - 2, c.away * tall);
    }
    context.fillStyle = context.strokeStyle = INK;
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(0, middle);
    context.lineTo(width, middle);
    context.stroke();
    context.strokeRect(at.b * wide + 0.5, 1, wide - 1, height - 2);
    context.textBaseline = "top";
    context.fillText("falls towards " + bearing(cube.azimuth[at.a]), 4, 2);
    context.textBaseline = "bottom";
    context.fillText("falls towards " + bearing(cube.azimuth[at.a] + 180), 4, height - 2);
  }
  function percent(p) { return Math.round(100 * p) + " %"; }
  function sentence(a, b) {
    const stone = "the " + (cube.element[at.element] || "block"), c = cell(a, b), phi = cube.azimuth[a], where = "Motion along " + bearing(phi) + ", B/H = " + Number(cube.b_over_h[b].toPrecision(4)) + ": ";
    if (c.flag === 2) return where + "no outcome was found.";
    let text = where + (c.flag === 0 ? stone + " stands" : stone + " falls towards " + bearing(c.flag > 0 ? phi : phi + 180));
    if (c.time !== null) text += ", past the point of no return at " + c.time.toFixed(2) + " s";
    if (c.rotation !== null && c.flag === 0) text += ", largest rotation " + c.rotation.toFixed(2) + " α";
    text += ".";
    if (cube.ensemble) text += " In its neighbourhood it falls towards " + bearing(phi) + " with a probability of " + percent(c.towards) + ", towards " + bearing(phi + 180) + " with " + percent(c.away) + ".";
    return text;
  }
  function drawNear() {
    near.textContent = "";
    const head = element("tr", {}, near), columns = [-1, 0, 1].map(function (k) { return (at.a + k + A) % A; });
    element("th", {}, head, "B/H");
    columns.forEach(function (a) { element("th", {}, head, cube.azimuth[a] + "°"); });
    for (let b = Math.min(at.b + 1, B - 1); b >= Math.max(at.b - 1, 0); b--) {
      const row = element("tr", {}, near);
      element("th", {}, row, String(Number(cube.b_over_h[b].toPrecision(4))));
      columns.forEach(function (a) {
        const c = cell(a, b), to = { "1": bearing(cube.azimuth[a]), "-1": bearing(cube.azimuth[a] + 180) }[c.flag];
        element("td", a === at.a && b === at.b ? { class: "here" } : {}, row, c.flag === 2 ? "no outcome" : to ? "→ " + to : "stands");
      });
    }
  }
  function drawLegend() {
    legend.textContent = "";
    const entries = {
      chance: [[C.stands, "stands"], [mix(HEAT, 0.5), "falls towards the azimuth, 50 %"], [C.darkest, "100 %"], [C.other, "falls to the other side"]],
      flag: [[C.falls, "falls towards the azimuth"], [C.other, "falls to the other side"], [C.stands, "stands"]],
      rotation: [[BLUES[0], "0"], [BLUES[1], "0.33 α"], [BLUES[3], "α and more"]],
      time: [[C.darkest, "early"], [mix(HEAT, 0.3), "late"], [C.stands, "stands"]],
    }[at.colour].concat([[C.missing, "no outcome"]]);
    entries.forEach(function (pair) {
      const item = element("span", {}, legend);
      element("i", { style: "background:" + pair[0] }, item);
      item.appendChild(document.createTextNode(pair[1]));
    });
    if (cube.records[at.record].normal !== null) element("span", { style: "color:" + C.fault }, legend, "– – fault normal");
  }
  function draw() {
    drawMap();
    drawStrip();
    drawNear();
    drawLegend();
    shown.forEach(function (show) { show(); });
    said.textContent = sentence(at.a, at.b);
  }
  function point(event) {
    const box = map.getBoundingClientRect(), x = event.clientX - box.left - box.width / 2, y = event.clientY - box.top - box.height / 2;
    const radius = Math.hypot(x, y) / (reach(box.width) / outer);
    const turn = 2 * Math.PI, first = cube.azimuthEdges[0];
    const angle = ((Math.atan2(x, -y) - first) % turn + turn) % turn + first;
    const a = cube.azimuthEdges.findIndex(function (edge, k) { return k < A && angle >= edge && angle < cube.azimuthEdges[k + 1]; });
    const b = cube.radiusEdges.findIndex(function (edge, k) { return k < B && radius >= edge && radius < cube.radiusEdges[k + 1]; });
    if (a < 0 || b < 0 || (a === at.a && b === at.b)) return;
    at.a = a;
    at.b = b;
    draw();
  }
  map.addEventListener("pointermove", point);
  map.addEventListener("pointerdown", point);
  map.addEventListener("keydown", function (event) {
    const step = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!step) return;
    at.a = (at.a + step[0] + A) % A;
    at.b = Math.min(Math.max(at.b + step[1], 0), B - 1);
    draw();
    event.preventDefault();
  });
  window.addEventListener("resize", draw);
  // It begins with the broadest block that falls.
  for (let b = 0; b < B; b++) for (let a = A - 1; a >= 0; a--) if (cell(a, b).flag === 1) { at.a = a; at.b = b; }
  draw();
  root.dataset.ready = "true";
})();
