// A rigid rectangular block that rocks on its lower edges and neither slides nor lifts off (Housner 1963).
// `motion` has `interval` (s), `along` and `up` (m/s², up may be null); `alpha` is the critical angle, `radius` half
// of the diagonal (m). Rotations are over time, positive towards the azimuth; `fall` is the last time at which what
// fell could still have come back, `side` +1, −1 or 0.
function rock(motion, alpha, radius, amplitude) {
  const g = 9.80665, { interval, along, up } = motion, count = along.length, rest = Math.ceil(10 / interval);
  const frequency2 = 0.75 * g / radius, keep = Math.max(0, 1 - 1.5 * Math.sin(alpha) ** 2);
  const path = new Float32Array(count + rest);
  const sub = Math.max(1, Math.ceil(interval / 0.0025)), step = interval / sub;
  let theta = 0, omega = 0, side = 0, fall = null, lies = false, begun = null, from = 0, shown = path.length;
  // Horizontal and vertical acceleration over gravity, linear between samples, nothing after the last.
  const value = (samples, place) => {
    const low = Math.floor(place), part = place - low;
    return low + 1 < count ? amplitude * (samples[low] * (1 - part) + samples[low + 1] * part) / g : 0;
  };
  function acceleration(time, angle) {
    const place = time / interval, left = alpha - side * angle;
    const weight = 1 + (up ? value(up, place) : 0);
    return -frequency2 * (side * weight * Math.sin(left) + value(along, place) * Math.cos(left));
  }
  function advance(time, h) {
    const middle = time + h / 2;
    const k1 = acceleration(time, theta), w2 = omega + h / 2 * k1, k2 = acceleration(middle, theta + h / 2 * omega);
    const w3 = omega + h / 2 * k2, k3 = acceleration(middle, theta + h / 2 * w2);
    const w4 = omega + h * k3, k4 = acceleration(time + h, theta + h * w3);
    return [theta + h / 6 * (omega + 2 * w2 + 2 * w3 + w4), omega + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)];
  }
  function startsAt(time) {
    const a = value(along, time / interval), v = up ? value(up, time / interval) : 0;
    if (Math.abs(a) * Math.cos(alpha) <= (1 + v) * Math.sin(alpha)) return false;
    side = -Math.sign(a);
    if (begun === null) begun = time;
    return true;
  }
  for (let k = 1; k < path.length; k++) {
    for (let n = 0; n < sub && !lies; n++) {
      let time = (k - 1) * interval + n * step, left = step;
      while (left > 1e-9) {
        if (side === 0 && !startsAt(time)) break;
        let [angle, speed] = advance(time, left), h = left;
        if (side * angle < 0) {
          if (theta === 0) { side = omega = 0; break; }  // a bounce shorter than a step
          h = Math.max(left * theta / (theta - angle), 1e-9);
          speed = keep * advance(time, h)[1];
          angle = 0;
          side = Math.abs(speed) < 1e-6 ? 0 : Math.sign(speed);
          if (side === 0) speed = 0;
        }
        if (Math.abs(angle) > alpha && Math.abs(theta) <= alpha) from = time;
        theta = angle;
        omega = speed;
        time += h;
        left -= h;
        if (Math.abs(theta) >= Math.PI / 2) {
          theta = side * Math.PI / 2;
          fall = from;
          lies = true;
          break;
        }
      }
    }
    path[k] = theta;
    if (k >= count && (lies || side === 0)) { shown = k + 1; break; }
  }
  return { path: path.subarray(0, shown), interval, fall, side: lies ? side : 0, begun };
}
window.rock = rock;

// The block of the cell as a rigid one that rocks: `rock` of rocking.js, drawn in the frame of its base.
function sketchOf(box) {
  if (cube.sketch) {
    element("p", { class: "note" }, box, cube.sketch);
    return () => {};
  }
  const canvas = element("canvas", { role: "img", "aria-label": "the rocking block, its rotation over time" }, box);
  const row = element("div", { class: "play" }, box), button = element("button", { type: "button" }, row, "Play");
  const clock = element("input", { type: "range", min: 0, step: "any", "aria-label": "time" }, row);
  const time = element("output", {}, row);
  const drag = element("div", { class: "sliders" }, box);
  const found = element("p", { class: "verdict", "aria-live": "polite" }, box);
  const times = v => "× " + v.toFixed(2);
  const shows = [slider(drag, "amplitude", "motion", 0.2, 3, 0.05, times),
    slider(drag, "size", "size", 0.2, 5, 0.05, times)];
  element("p", { class: "note" }, box, "This is a sketch, and not the cube: a rigid block that rocks on its edges " +
    "(Housner 1963), computed in this page. It neither slides nor lifts off, and loses energy only where it changes " +
    "edges. The cube's blocks slide with friction and have springs and dashpots under their corners.");
  let run = null, now = 0, playing = 0, asked = false;
  function compute() {
    asked = false;
    box.hidden = !held.motion;
    if (!held.motion) { run = null; playing = 0; return; }
    const [north, east, up] = held.motion.parts, phi = cube.direction[at.a] / 360 * TURN;
    const ratio = cube.b_over_h[at.b], height = cube.height[at.height] * at.size;
    const along = north.map((value, k) => value * Math.cos(phi) + east[k] * Math.sin(phi));
    const motion = { interval: held.motion.interval, along: along, up: up || null };
    run = rock(motion, Math.atan(ratio), height * Math.hypot(1, ratio) / 2, at.amplitude);
    run.along = along;
    run.end = (run.path.length - 1) * run.interval;
    const own = !run.side ? run.begun === null ? "stands and never rocks" : "rocks and stands"
      : verdict({ to: cube.direction[at.a] + (run.side < 0 ? 180 : 0) })
        + ", past the point of no return at " + run.fall.toFixed(2) + " s";
    const c = cell(at.a, at.b), asComputed = at.amplitude === 1 && at.size === 1;
    const differ = asComputed && c.flag !== 2 && c.flag !== run.side;
    const when = c.time === null ? "" : "at " + c.time.toFixed(2) + " s";
    let text = "The sketch " + own + ". ";
    if (!asComputed) {
      text = "With " + at.amplitude.toFixed(2) + " times the motion and a block " + at.size.toFixed(2)
        + " times as large the sketch " + own + ". The cube says nothing of it.";
    } else if (differ) {
      text += "Here it disagrees with the cube, whose block " + verdict(c) + (when && " " + when) + ": go by the cube.";
    } else {
      text += c.flag === 2 ? "The cube has no outcome here." : "The cube says the same" + (when && ", " + when) + ".";
    }
    const slides = cube.friction[at.friction] < ratio;
    if (slides) text += " With µ below B/H a block slides before it rocks; the sketch cannot.";
    found.textContent = text;
    found.classList.toggle("differ", differ);
    clock.max = run.end;
    now = Math.min(Math.max(0, (run.begun === null ? 0 : run.begun) - 0.5), run.end);
    shows.forEach(show => { show(); });
    show();
  }
  function show() {
    const { context, width, height } = surface(canvas, 0.62), x = width / 2;
    const k = Math.min(Math.round(now / run.interval), run.path.length - 1), theta = run.path[k];
    const ratio = cube.b_over_h[at.b], alpha = Math.atan(ratio), floor = height * 0.66;
    const size = Math.min(floor - 14, 0.3 * width) * Math.min(1, at.size);
    clock.value = now;
    time.textContent = now.toFixed(1) + " s";
    context.fillStyle = "#d9d4c8";
    context.fillRect(0, floor, width, 8);
    context.save();
    context.translate(x + Math.sign(theta) * size * ratio / 2, floor);
    context.rotate(theta);
    context.fillStyle = Math.abs(theta) > alpha ? C.falls : "#8f887c";
    context.fillRect(-size * ratio / 2 - Math.sign(theta) * size * ratio / 2, -size, size * ratio, size);
    context.restore();
    context.fillStyle = INK;
    context.textBaseline = "top";
    context.fillText("H = " + (cube.height[at.height] * at.size).toPrecision(3) + " m", 4, 4);
    context.textAlign = "right";
    context.fillText(bearing(cube.direction[at.a]) + " →", width - 4, 4);
    context.textAlign = "left";
    // Acceleration of the base, and the rotation over time in critical angles.
    const push = (k < run.along.length ? run.along[k] * at.amplitude / 9.80665 : 0) * width / 4;
    context.fillStyle = C.fault;
    context.fillRect(Math.min(x, x + push), floor + 2, Math.abs(push), 4);
    const zero = floor + 8 + (height - floor - 8) / 2, tall = (height - floor - 12) / 2 / 1.2, wide = width / run.end;
    context.strokeStyle = "#c8c8c8";
    context.lineWidth = 0.7;
    for (const level of [-1, 0, 1]) line(context, 0, zero - level * tall, width, zero - level * tall);
    context.strokeStyle = INK;
    context.beginPath();
    run.path.forEach((angle, i) => {
      context.lineTo(i * run.interval * wide, zero - Math.max(-1.2, Math.min(1.2, angle / alpha)) * tall);
    });
    context.stroke();
    context.fillStyle = INK;
    context.textBaseline = "bottom";
    context.fillText("rotation, ± α", 4, zero - tall + 13);
    context.strokeStyle = C.falls;
    context.lineWidth = 1.5;
    line(context, now * wide, floor + 9, now * wide, height);
  }
  function play(begun) {
    let before = null;
    window.requestAnimationFrame(function frame(stamp) {
      if (begun !== playing || !run) return;
      if (before !== null) now = Math.min(run.end, now + (stamp - before) / 1000);
      before = stamp;
      show();
      if (now < run.end) window.requestAnimationFrame(frame); else { playing = 0; button.textContent = "Play"; }
    });
  }
  let turn = 0;
  button.addEventListener("click", () => {
    if (playing) { playing = 0; button.textContent = "Play"; return; }
    if (now >= run.end) now = Math.max(0, (run.begun || 0) - 0.5);
    playing = ++turn;
    button.textContent = "Pause";
    play(playing);
  });
  clock.addEventListener("input", () => { now = Number(clock.value); show(); });
  return () => {
    if (!asked) window.requestAnimationFrame(compute);
    asked = true;
  };
}
