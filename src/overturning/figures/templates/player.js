// Player of films of polygons (2-D) and bodies (3-D) on canvases. Each film is in an element of the class "film" that
// contains a script element with its data (JSON).
"use strict";
(function () {
  const INK = "#222222", STONE = "#c9c4ba", EDGE = "#222222", BASE = "#8a8a86", FORCE = "#c44a00", LINE = "#0072b2";
  const SECOND = "#009e73";
  const RATES = [1, 0.5, 0.2, 0.1];

  function unpack(packed) { return Float64Array.from(words(packed.data, true), value => value * packed.scale); }

  function seconds(value) { return value.toFixed(2) + " s"; }

  function Film(root) {
    const film = JSON.parse(root.querySelector("script").textContent);
    const end = film.start + (film.frames - 1) * film.interval;
    const view = { azimuth: 2.7, elevation: 0.42 };
    const state = { time: film.start, playing: false, rate: 1, forces: false, last: null, view: view };
    const [left, right, bottom, top] = film.view;
    const panels = film.panels.map(prepare);

    root.setAttribute("tabindex", "0");
    root.setAttribute("role", "group");
    root.setAttribute("aria-label", film.title + ": animation. Space plays and pauses, arrow keys step.");
    if (film.title) element("h3", { class: "film-title" }, root, film.title);
    const row = element("div", { class: "film-panels", style: "--panels: " + Math.min(panels.length, 3) }, root);
    panels.forEach(panel => {
      const box = element("div", { class: "film-panel" }, row);
      element("div", { class: "film-heading" }, box, panel.title);
      panel.scene = element("canvas", { role: "img", "aria-label": panel.title + ": the block on its base" }, box);
      panel.trace = element("canvas", { role: "img", "aria-label": panel.title + ": acceleration of the base" }, box);
      panel.status = element("div", { class: "film-outcome", "aria-live": "polite" }, box);
    });
    const bar = element("div", { class: "film-controls" }, root);
    const play = element("button", { type: "button", class: "film-play" }, bar);
    const slider = element("input", {
      type: "range", min: film.start, max: end, step: "any", value: film.start, "aria-label": "time",
    }, bar);
    const clock = element("output", { class: "film-clock" }, bar);
    const speed = element("select", { "aria-label": "speed" }, bar);
    RATES.forEach(rate => {
      element("option", { value: rate }, speed, rate === 1 ? "real time" : "1/" + Math.round(1 / rate) + " speed");
    });
    const withForces = panels.some(panel => panel.force);
    let box = null;
    if (withForces) {
      const label = element("label", {}, bar);
      box = element("input", { type: "checkbox" }, label);
      label.appendChild(document.createTextNode(" contact forces"));
    }
    if (film.note) element("p", { class: "film-note" }, root, film.note);

    function prepare(panel) {
      const made = Object.assign({}, panel, { traces: panel.motions.map(unpack) });
      made.bodies = panel.bodies.map(body => {
        return Object.assign({}, body, { position: unpack(body.position), rotation: unpack(body.rotation) });
      });
      made.solid = made.bodies.find(body => body.faces.length > 0);
      if (made.solid) made.solid.reach = spaceView.reach(made.solid);
      if (panel.force) { made.force = unpack(panel.force); made.forcePoint = unpack(panel.forcePoint); }
      return made;
    }

    // Linear interpolation between frames; after its last frame a body stays at rest.
    function pick(values, width, offset, at) {
      const rows = values.length / width, low = Math.min(Math.floor(at), rows - 1), high = Math.min(low + 1, rows - 1);
      const part = Math.min(Math.max(at - low, 0), 1);
      return values[low * width + offset] * (1 - part) + values[high * width + offset] * part;
    }

    function drawScene(panel, at) {
      if (panel.solid) {
        const { context, width, height } = surface(panel.scene, 0.82);
        spaceView.draw(context, width, height, panel.solid, at, pick, state.view);
        return;
      }
      const ratio = Math.min(1.1, (top - bottom) / (right - left));
      const { context, width, height } = surface(panel.scene, ratio);
      const scale = Math.min(width / (right - left), height / (top - bottom));
      const centre = (left + right) / 2;
      function x(s) { return width / 2 + (s - centre) * scale; }
      function y(z) { return height - (z - bottom) * scale; }
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
      });
      if (state.forces && panel.force) drawForces(context, panel, at, x, y, scale);
      context.fillStyle = INK;
      context.textBaseline = "top";
      context.textAlign = "left";
      context.fillText("← " + panel.sides[0], 4, 4);
      context.textAlign = "right";
      context.fillText(panel.sides[1] + " →", width - 4, 4);
    }

    // The arrow for a force of one weight is a third of the view long.
    function drawForces(context, panel, at, x, y, scale) {
      const unit = (top - bottom) / 3;
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

    function drawTrace(panel) {
      const { context, width, height } = surface(panel.trace, 0.26);
      const edge = 4, foot = 16, head = 14, middle = head + (height - head - foot) / 2;
      let largest = 0;
      panels.forEach(other => {
        for (const values of other.traces) for (const v of values) largest = Math.max(largest, Math.abs(v));
      });
      const tall = (height - head - foot) / 2 / (largest || 1);
      function x(time) { return edge + (time - film.start) / (end - film.start || 1) * (width - 2 * edge); }
      context.strokeStyle = "#c8c8c8";
      context.lineWidth = 1;
      context.beginPath();
      context.moveTo(edge, middle);
      context.lineTo(width - edge, middle);
      context.stroke();
      panel.traces.forEach((values, which) => {
        context.strokeStyle = which ? SECOND : LINE;
        context.beginPath();
        for (let i = 0; i < values.length; i++) {
          const at = film.start + i * panel.motionInterval;
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
      context.textBaseline = "top";
      context.textAlign = "left";
      const scale = "±" + (largest >= 100 ? largest.toFixed(0) : largest.toPrecision(2)) + " Gal";
      const lines = panel.traces.length > 1 ? "base: north (blue), east (green), scale " : "base acceleration, scale ";
      const what = width < 240 ? "base: " : lines;
      context.fillText(what + scale, edge, 0);
      context.textBaseline = "bottom";
      context.fillText(seconds(film.start), edge, height);
      context.textAlign = "right";
      context.fillText(seconds(end), width - edge, height);
    }

    function draw() {
      const at = (state.time - film.start) / film.interval;
      panels.forEach(panel => {
        drawScene(panel, at);
        drawTrace(panel);
        const known = panel.outcomeTime === null ? state.time >= end - 1e-9 : state.time >= panel.outcomeTime;
        const text = known ? panel.outcome : "\u00a0";
        if (panel.status.textContent !== text) panel.status.textContent = text;
      });
      slider.value = state.time;
      clock.textContent = seconds(state.time);
      const ended = state.time >= end - 1e-9;
      const label = state.playing ? "Pause" : ended ? "Again" : "Play";
      if (play.textContent !== label) play.textContent = label;
      root.dataset.state = state.playing ? "playing" : ended ? "ended" : "paused";
      root.dataset.time = state.time.toFixed(4);
    }

    function tick(now) {
      if (!state.playing) return;
      if (state.last !== null) state.time += Math.min((now - state.last) / 1000, 0.25) * state.rate;
      state.last = now;
      if (state.time >= end) { state.time = end; state.playing = false; }
      draw();
      if (state.playing) window.requestAnimationFrame(tick);
    }

    function setPlaying(on) {
      if (on && state.time >= end - 1e-9) state.time = film.start;
      state.playing = on;
      state.last = null;
      draw();
      if (on) window.requestAnimationFrame(tick);
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

    function setRate(index) {
      speed.selectedIndex = (index + RATES.length) % RATES.length;
      state.rate = RATES[speed.selectedIndex];
      root.dataset.rate = String(state.rate);
    }

    play.addEventListener("click", () => { setPlaying(!state.playing); });
    slider.addEventListener("input", () => { state.playing = false; seek(Number(slider.value)); });
    speed.addEventListener("change", () => { setRate(speed.selectedIndex); });
    if (box) box.addEventListener("change", () => { setForces(box.checked); });
    // A single film on the page receives all keys; of several films only the one with the focus does.
    const alone = document.querySelectorAll(".film").length === 1;
    (alone ? document : root).addEventListener("keydown", event => {
      if (event.altKey || event.ctrlKey || event.metaKey) return;
      const inControl = event.target !== root && event.target !== document.body;
      const step = event.shiftKey ? 0.5 : film.interval;
      switch (event.key) {
        case " ": if (inControl && event.target !== slider) return; setPlaying(!state.playing); break;
        case "ArrowRight": if (event.target === speed) return; state.playing = false; seek(state.time + step); break;
        case "ArrowLeft": if (event.target === speed) return; state.playing = false; seek(state.time - step); break;
        case "Home": state.playing = false; seek(film.start); break;
        case "End": state.playing = false; seek(end); break;
        case "a": spaceView.turn(state.view, -0.1, 0); draw(); break;
        case "d": spaceView.turn(state.view, 0.1, 0); draw(); break;
        case "f": setForces(!state.forces); break;
        case "s": setRate(speed.selectedIndex + 1); break;
        default: return;
      }
      event.preventDefault();
    });
    panels.forEach(panel => { if (panel.solid) spaceView.listen(panel.scene, state.view, draw); });
    window.addEventListener("resize", draw);
    window.addEventListener("beforeprint", () => { seek(end); });
    root.dataset.end = end.toFixed(4);
    setForces(false);
    setRate(0);
    draw();
    root.dataset.ready = "true";
  }

  function start() { document.querySelectorAll(".film").forEach(Film); }
  if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", start);
  else start();
})();
