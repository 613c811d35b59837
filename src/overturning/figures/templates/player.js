// Player of films of polygons (2-D) and bodies (3-D) on canvases. Each film is in an element of the class "film" that
// contains a script element with its data (JSON).
"use strict";
(function () {
  const INK = "#222222", STONE = "#c9c4ba", EDGE = "#222222", BASE = "#8a8a86", FORCE = "#c44a00", LINE = "#0072b2";
  const SECOND = "#009e73", MARK = "#6d6d69", EARTH = "#dcdcd8";
  let films = 0;

  function unpack(packed) { return Float64Array.from(words(packed.data, true), value => value * packed.scale); }

  function seconds(value) { return value.toFixed(2) + " s"; }

  function Film(root) {
    const film = JSON.parse(root.querySelector("script").textContent), say = film.words, number = ++films;
    const end = film.start + (film.frames - 1) * film.interval;
    const view = { azimuth: 2.7, elevation: spaceView.elevation };
    const state = { time: film.start, playing: false, rate: 1, forces: false, earth: false, last: null, view: view };
    const rates = film.speeds.map(pair => pair[0]);
    const panels = film.panels.map(prepare);

    root.setAttribute("tabindex", "0");
    root.setAttribute("role", "group");
    root.setAttribute("aria-label", film.title + ": " + say.animation);
    if (film.title) element("h3", { class: "film-title" }, root, film.title);
    const row = element("div", { class: "film-panels", style: "--panels: " + Math.min(panels.length, 3) }, root);
    panels.forEach(panel => {
      const box = element("div", { class: "film-panel" }, row);
      element("div", { class: "film-heading" }, box, panel.title);
      panel.scene = element("canvas", { role: "img", "aria-label": panel.title + ": " + say.scene }, box);
      panel.traces.forEach(trace => {
        const peak = trace.rows.reduce((most, row) => row.reduce((one, v) => Math.max(one, Math.abs(v)), most), 0);
        const size = (peak >= 100 ? peak.toFixed(0) : Number(peak.toPrecision(2))) + " Gal";
        element("div", { class: "film-label" }, box, trace.label + (peak ? ", " + say.peak + " " + size : ""));
        trace.canvas = element("canvas", { role: "img", "aria-label": panel.title + ": " + trace.label }, box);
      });
      panel.status = element("div", { class: "film-outcome", "aria-live": "polite" }, box);
    });
    const bar = element("div", { class: "film-controls" }, root);
    const play = element("button", { type: "button", class: "film-play" }, bar);
    const slider = element("input", {
      type: "range", min: film.start, max: end, step: "any", value: film.start, "aria-label": say.time,
    }, bar);
    const clock = element("output", { class: "film-clock" }, bar);
    const speed = element("fieldset", { class: "film-speed" }, bar);
    element("legend", {}, speed, say.speed);
    const choices = film.speeds.map(pair => {
      const label = element("label", {}, speed);
      const choice = element("input", { type: "radio", name: "film-speed-" + number, value: pair[0] }, label);
      element("span", {}, label, pair[1]);
      return choice;
    });
    const withForces = panels.some(panel => panel.force), withGround = panels.some(panel => panel.ground);
    function tick(text, tip) {
      const label = element("label", { class: "film-tick", title: tip }, bar);
      const box = element("input", { type: "checkbox", "aria-description": tip }, label);
      label.appendChild(document.createTextNode(" " + text));
      return box;
    }
    const earth = withGround ? tick(say.ground, say.groundTip) : null;
    const box = withForces ? tick(say.forces, say.forcesTip) : null;
    if (film.note) element("p", { class: "film-note" }, root, film.note);
    const strip = root.querySelector(".film-strip");
    if (strip) root.appendChild(strip);

    function prepare(panel) {
      const made = Object.assign({}, panel);
      made.traces = panel.traces.map(trace => ({ label: trace.label, rows: trace.rows.map(unpack) }));
      if (panel.ground) made.ground = unpack(panel.ground);
      made.bodies = panel.bodies.map(body => {
        return Object.assign({}, body, { position: unpack(body.position), rotation: unpack(body.rotation) });
      });
      const solids = made.bodies.filter(body => body.faces.length > 0);
      made.solids = solids.length ? solids : null;
      if (made.solids) made.solids.reach = spaceView.reach(made.solids, made.ground);
      if (panel.force) { made.force = unpack(panel.force); made.forcePoint = unpack(panel.forcePoint); }
      return made;
    }

    // Linear interpolation between frames; after its last frame a body stays at rest.
    function pick(values, width, offset, at) {
      const rows = values.length / width, low = Math.min(Math.floor(at), rows - 1), high = Math.min(low + 1, rows - 1);
      const part = Math.min(Math.max(at - low, 0), 1);
      return values[low * width + offset] * (1 - part) + values[high * width + offset] * part;
    }

    // Displacement of the ground as seen from the camera; zero where the camera moves with the ground.
    function shift(panel, at) {
      const width = panel.solids ? 3 : 2;
      return [0, 1, 2].slice(0, width).map(k => state.earth && panel.ground ? pick(panel.ground, width, k, at) : 0);
    }

    // A bar of a round length, at most a quarter of the width, with its length below it.
    function drawScaleBar(context, width, height, scale) {
      const length = roundNumber(0.25 * width / scale), x = 8, y = height - 18;
      const [unit, name] = length < 0.009 ? [1e-3, " mm"] : length < 0.9 ? [1e-2, " cm"] : [1, " m"];
      const text = Math.round(length / unit) + name;
      context.fillStyle = "rgba(255, 255, 255, 0.85)";
      context.fillRect(x - 4, y - 7, Math.max(length * scale, context.measureText(text).width) + 8, 23);
      context.strokeStyle = context.fillStyle = INK;
      context.lineWidth = 1.5;
      context.beginPath();
      context.moveTo(x, y - 4);
      context.lineTo(x, y);
      context.lineTo(x + length * scale, y);
      context.lineTo(x + length * scale, y - 4);
      context.stroke();
      context.textAlign = "left";
      context.textBaseline = "top";
      context.fillText(text, x, y + 2);
      return length;
    }

    function drawScene(panel, at) {
      const moved = shift(panel, at);
      if (panel.solids) {
        const { context, width, height } = surface(panel.scene, 0.82);
        const scale = spaceView.draw(context, width, height, panel.solids, at, pick, state.view, moved, state.earth);
        root.dataset.bar = drawScaleBar(context, width, height, scale);
        return;
      }
      const [left, right, bottom, top] = state.earth ? film.earthView : film.view;
      const ratio = Math.min(1.1, Math.max(0.5, (top - bottom) / (right - left)));
      const { context, width, height } = surface(panel.scene, ratio);
      const scale = Math.min(width / (right - left), height / (top - bottom));
      const centre = (left + right) / 2;
      function x(s) { return width / 2 + (s + moved[0] - centre) * scale; }
      function y(z) { return height - (z + moved[1] - bottom) * scale; }
      // Lines fixed to the earth, and marks on the ground: one of them moves.
      const gap = roundNumber(70 / scale);  // 28 to 70 pixels
      if (state.earth) {
        context.strokeStyle = EARTH;
        context.lineWidth = 1;
        for (let s = Math.ceil(-width / scale / gap) * gap; s < width / scale; s += gap) {
          context.beginPath();
          context.moveTo(width / 2 + s * scale, 20);
          context.lineTo(width / 2 + s * scale, y(0));
          context.stroke();
        }
      }
      panel.bodies.forEach(body => {
        const s0 = pick(body.position, 2, 0, at), z0 = pick(body.position, 2, 1, at);
        const angle = pick(body.rotation, 1, 0, at), cosine = Math.cos(angle), sine = Math.sin(angle);
        context.beginPath();
        body.vertices.forEach(v => {
          context.lineTo(x(s0 + v[0] * cosine + v[1] * sine), y(z0 - v[0] * sine + v[1] * cosine));
        });
        context.closePath();
        context.fillStyle = body.free ? STONE : BASE;
        context.fill();
        if (body.free) { context.strokeStyle = EDGE; context.lineWidth = 1.2; context.stroke(); }
        else drawMarks(context, body, s0, z0, x, y, gap);
      });
      if (state.forces && panel.force) drawForces(context, panel, at, x, y, (top - bottom) / 3);
      root.dataset.bar = drawScaleBar(context, width, height, scale);
      context.fillStyle = INK;
      context.textBaseline = "top";
      context.textAlign = "left";
      context.fillText("← " + panel.sides[0], 4, 4);
      context.textAlign = "right";
      context.fillText(panel.sides[1] + " →", width - 4, 4);
    }

    // Strokes on the upper side of a body that the ground moves.
    function drawMarks(context, body, s0, z0, x, y, gap) {
      const upper = Math.max.apply(null, body.vertices.map(v => v[1])), across = body.vertices.map(v => v[0]);
      context.strokeStyle = MARK;
      context.lineWidth = 1;
      const least = Math.min.apply(null, across), most = Math.max.apply(null, across);
      for (let s = Math.ceil(least / gap) * gap; s < most; s += gap) {
        context.beginPath();
        context.moveTo(x(s0 + s), y(z0 + upper));
        context.lineTo(x(s0 + s) - 5, y(z0 + upper) + 7);
        context.stroke();
      }
    }

    // The arrow for a force of one weight is as long as the unit, m.
    function drawForces(context, panel, at, x, y, unit) {
      context.strokeStyle = context.fillStyle = FORCE;
      context.lineWidth = 2;
      for (let k = 0; k < panel.points; k++) {
        const w = 2 * panel.points;
        const fs = pick(panel.force, w, 2 * k, at), fz = pick(panel.force, w, 2 * k + 1, at), size = Math.hypot(fs, fz);
        if (size < 0.01) continue;
        const s = pick(panel.forcePoint, w, 2 * k, at), z = pick(panel.forcePoint, w, 2 * k + 1, at);
        const length = Math.min(size, 3) * unit, tipS = s + fs / size * length, tipZ = z + fz / size * length;
        const angle = Math.atan2(y(tipZ) - y(z), x(tipS) - x(s));
        context.beginPath();
        context.moveTo(x(s), y(z));
        context.lineTo(x(tipS), y(tipZ));
        context.stroke();
        context.beginPath();
        context.moveTo(x(tipS), y(tipZ));
        context.lineTo(x(tipS) - 8 * Math.cos(angle - 0.4), y(tipZ) - 8 * Math.sin(angle - 0.4));
        context.lineTo(x(tipS) - 8 * Math.cos(angle + 0.4), y(tipZ) - 8 * Math.sin(angle + 0.4));
        context.fill();
      }
    }

    // All traces of a film have one scale.
    function drawTrace(panel, trace, last) {
      const foot = last ? 16 : 2, wide = trace.canvas.clientWidth || 300;
      const { context, width, height } = surface(trace.canvas, (foot + Math.max(40, 0.15 * wide)) / wide);
      const edge = 4, head = 2, middle = head + (height - head - foot) / 2;
      const tall = (height - head - foot) / 2 / (film.peak || 1);
      function x(time) { return edge + (time - film.start) / (end - film.start || 1) * (width - 2 * edge); }
      context.strokeStyle = "#c8c8c8";
      context.lineWidth = 1;
      context.beginPath();
      context.moveTo(edge, middle);
      context.lineTo(width - edge, middle);
      context.stroke();
      trace.rows.forEach((values, which) => {
        context.strokeStyle = which ? SECOND : LINE;
        context.beginPath();
        for (let i = 0; i < values.length; i++) {
          const at = film.start + i * panel.traceInterval;
          if (at > end) break;
          context.lineTo(x(at), middle - values[i] * tall);
        }
        context.stroke();
      });
      context.strokeStyle = FORCE;
      context.lineWidth = 2;
      context.beginPath();
      context.moveTo(x(state.time), head);
      context.lineTo(x(state.time), height - foot);
      context.stroke();
      context.fillStyle = INK;
      if (!last) return;
      context.textAlign = "right";
      context.textBaseline = "bottom";
      context.fillText(seconds(end), width - edge, height);
      context.textAlign = "left";
      context.fillText(seconds(film.start), edge, height);
    }

    function draw() {
      const at = (state.time - film.start) / film.interval;
      panels.forEach(panel => {
        drawScene(panel, at);
        panel.traces.forEach((trace, k) => { drawTrace(panel, trace, k === panel.traces.length - 1); });
        const known = panel.outcomeTime === null ? state.time >= end - 1e-9 : state.time >= panel.outcomeTime;
        const text = known ? panel.outcome : "\u00a0";
        if (panel.status.textContent !== text) panel.status.textContent = text;
      });
      slider.value = state.time;
      clock.textContent = seconds(state.time);
      const ended = state.time >= end - 1e-9;
      const label = state.playing ? say.pause : ended ? say.again : say.play;
      if (play.textContent !== label) play.textContent = label;
      root.dataset.state = state.playing ? "playing" : ended ? "ended" : "paused";
      root.dataset.time = state.time.toFixed(4);
    }

    function step(now) {
      if (!state.playing) return;
      if (state.last !== null) state.time += Math.min((now - state.last) / 1000, 0.25) * state.rate;
      state.last = now;
      if (state.time >= end) { state.time = end; state.playing = false; }
      draw();
      if (state.playing) window.requestAnimationFrame(step);
    }

    function setPlaying(on) {
      if (on && state.time >= end - 1e-9) state.time = film.start;
      state.playing = on;
      state.last = null;
      draw();
      if (on) window.requestAnimationFrame(step);
    }

    function seek(time) {
      state.time = Math.min(Math.max(time, film.start), end);
      draw();
    }

    function setForces(on) {
      state.forces = on && withForces;
      if (box) box.checked = state.forces;
      root.dataset.forces = String(state.forces);
      draw();
    }

    function setEarth(on) {
      state.earth = on && withGround;
      if (earth) earth.checked = state.earth;
      root.dataset.earth = String(state.earth);
      draw();
    }

    function setRate(index) {
      const which = (index + rates.length) % rates.length;
      choices[which].checked = true;
      state.rate = rates[which];
      root.dataset.rate = String(state.rate);
    }

    play.addEventListener("click", () => { setPlaying(!state.playing); });
    slider.addEventListener("input", () => { state.playing = false; seek(Number(slider.value)); });
    choices.forEach((choice, k) => { choice.addEventListener("change", () => { setRate(k); }); });
    if (earth) earth.addEventListener("change", () => { setEarth(earth.checked); });
    if (box) box.addEventListener("change", () => { setForces(box.checked); });
    // A single film on the page receives all keys; of several films only the one with the focus does.
    const alone = document.querySelectorAll(".film").length === 1;
    (alone ? document : root).addEventListener("keydown", event => {
      if (event.altKey || event.ctrlKey || event.metaKey) return;
      const inControl = event.target !== root && event.target !== document.body;
      const forward = event.shiftKey ? 0.5 : film.interval, inSpeed = choices.includes(event.target);
      switch (event.key) {
        case " ": if (inControl && event.target !== slider) return; setPlaying(!state.playing); break;
        case "ArrowRight": if (inSpeed) return; state.playing = false; seek(state.time + forward); break;
        case "ArrowLeft": if (inSpeed) return; state.playing = false; seek(state.time - forward); break;
        case "Home": state.playing = false; seek(film.start); break;
        case "End": state.playing = false; seek(end); break;
        case "a": spaceView.turn(state.view, -0.1, 0); draw(); break;
        case "d": spaceView.turn(state.view, 0.1, 0); draw(); break;
        case "f": setForces(!state.forces); break;
        case "g": setEarth(!state.earth); break;
        case "s": setRate(rates.indexOf(state.rate) + 1); break;
        default: return;
      }
      event.preventDefault();
    });
    panels.forEach(panel => { if (panel.solids) spaceView.listen(panel.scene, state.view, draw); });
    new ResizeObserver(draw).observe(row);  // also when a folded part of the page is opened
    root.dataset.end = end.toFixed(4);
    setForces(false);
    setEarth(false);
    setRate(0);
    draw();
    root.dataset.ready = "true";
  }

  function start() { document.querySelectorAll(".film").forEach(Film); }
  if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", start);
  else start();
})();
