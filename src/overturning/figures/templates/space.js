// Draws convex 3-D bodies on a canvas in parallel projection (axes east, north, up); the mouse rotates the view.
const spaceView = (function () {
  "use strict";
  const STONE = [201, 196, 186], EDGE = "#222222", FLOOR = "#e9e9e6", LINE = "#c4c4c0", INK = "#222222";
  const NORTH = "#0072b2", SHADOW = "#b9b9b4", TRAIL = "#c44a00", LIGHT = [0.35, -0.5, 0.79];
  const ELEVATION = 0.42, LETTERS = 1.1;  // of the camera at first, rad; distance of the letters / half of the floor

  // Rows of the view matrix: right, up, and towards the viewer at an azimuth (clockwise from north) and elevation.
  function camera(view) {
    const a = view.azimuth, e = view.elevation, c = Math.cos(e), s = Math.sin(e);
    return [[-Math.cos(a), Math.sin(a), 0], [-s * Math.sin(a), -s * Math.cos(a), c],
      [c * Math.sin(a), c * Math.cos(a), s]];
  }

  function dot(a, b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

  // Rotation q v q* of a vector by a quaternion (w, u): v + 2 u × (u × v + w v).
  function turned(q, v) {
    const [w, x, y, z] = q;
    const a = y * v[2] - z * v[1] + w * v[0], b = z * v[0] - x * v[2] + w * v[1], c = x * v[1] - y * v[0] + w * v[2];
    return [v[0] + 2 * (y * c - z * b), v[1] + 2 * (z * a - x * c), v[2] + 2 * (x * b - y * a)];
  }

  function pose(body, at, pick) {
    const q = [0, 1, 2, 3].map(k => pick(body.rotation, 4, k, at));
    const size = Math.hypot(q[0], q[1], q[2], q[3]) || 1;
    const place = [0, 1, 2].map(k => pick(body.position, 3, k, at));
    return { place: place, q: q.map(part => part / size) };
  }

  function corner(at, v) {
    const r = turned(at.q, v);
    return [at.place[0] + r[0], at.place[1] + r[1], at.place[2] + r[2]];
  }

  // Half-width of the floor, height of the middle of the view, and half of the height of the view from the ground and
  // from the earth, past which the ground moves by (east, north, up). The view contains all corners in every frame from
  // every direction, and the letters at the floor from the first elevation.
  function reach(bodies, ground) {
    const begin = [bodies[0].position[0], bodies[0].position[1]], found = [];
    bodies.forEach(body => {
      for (let i = 0; 3 * i < body.position.length; i++) {
        const now = pose(body, i, (values, width, offset, at) => values[width * at + offset]);
        body.vertices.forEach(v => {
          const p = corner(now, v);
          found.push([Math.hypot(p[0] - begin[0], p[1] - begin[1]), p[2]]);
        });
      }
    });
    const most = values => values.reduce((one, other) => Math.max(one, other), 0);
    const top = most(found.map(p => p[1])), middle = top / 2, floor = Math.max(most(found.map(p => p[0])), middle);
    const letters = LETTERS * floor * Math.sin(ELEVATION) + middle * Math.cos(ELEVATION);
    const extent = 1.03 * Math.max(most(found.map(p => Math.hypot(p[0], p[1] - middle))), letters);
    let moves = 0;
    for (let i = 0; ground && i < ground.length; i += 3) {
      moves = Math.max(moves, Math.hypot(ground[i], ground[i + 1], ground[i + 2]));
    }
    return { middle: middle, floor: floor, extent: extent, earthExtent: extent + moves };
  }

  // Draws a frame, with the ground displaced by `moved`; returns the scale, pixels per m.
  function draw(context, width, height, bodies, at, pick, view, moved, earth) {
    const far = bodies.reach, rows = camera(view), half = far.floor, begin = pose(bodies[0], 0, pick).place;
    const scale = Math.min(width, height) / 2 / (earth ? far.earthExtent : far.extent);
    const centre = [begin[0], begin[1], far.middle];
    function screen(p, fixed) {
      const d = [0, 1, 2].map(k => p[k] - centre[k] + (fixed ? 0 : moved[k]));
      return [width / 2 + scale * dot(rows[0], d), height / 2 - scale * dot(rows[1], d)];
    }
    function path(points, fixed) {
      context.beginPath();
      points.forEach(p => { const [x, y] = screen(p, fixed); context.lineTo(x, y); });
    }
    function fill(points, colour) { path(points); context.closePath(); context.fillStyle = colour; context.fill(); }
    function stroke(points, colour, wide, fixed) {
      path(points, fixed);
      context.strokeStyle = colour;
      context.lineWidth = wide;
      context.stroke();
    }
    function level(x, y) { return [begin[0] + x, begin[1] + y, 0]; }

    const cells = 6;
    fill([level(-half, -half), level(half, -half), level(half, half), level(-half, half)], FLOOR);
    for (let i = 0; i <= cells; i++) {
      const s = half * (2 * i / cells - 1);
      stroke([level(s, -half), level(s, half)], LINE, 0.7);
      stroke([level(-half, s), level(half, s)], LINE, 0.7);
    }
    if (earth) {  // where the ground was at first
      context.setLineDash([5, 4]);
      const square = [[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]].map(p => level(p[0] * half, p[1] * half));
      stroke(square, INK, 1, true);
      context.setLineDash([]);
    }
    stroke([level(0, 0.72 * half), level(0, half)], NORTH, 2);
    stroke([level(-0.05 * half, 0.9 * half), level(0, half), level(0.05 * half, 0.9 * half)], NORTH, 2);
    context.fillStyle = INK;
    context.textAlign = "center";
    context.textBaseline = "middle";
    [["N", 0, LETTERS], ["E", LETTERS, 0], ["S", 0, -LETTERS], ["W", -LETTERS, 0]].forEach(mark => {
      const [x, y] = screen(level(mark[1] * half, mark[2] * half));
      context.fillText(mark[0], x, y);
    });

    const placed = bodies.map(body => {
      const now = pose(body, at, pick);
      return { body: body, depth: dot(rows[2], now.place), corners: body.vertices.map(v => corner(now, v)) };
    });
    placed.forEach(one => one.body.faces.forEach(face => {
      fill(face.map(k => [one.corners[k][0], one.corners[k][1], 0]), SHADOW);
    }));
    // Path of the centre of the top face of the last body.
    const last = bodies[bodies.length - 1];
    const trail = [], top = [0, 0, Math.max.apply(null, last.vertices.map(v => v[2]))];
    for (let i = 0; i <= at; i++) trail.push(corner(pose(last, i, pick), top));
    // The nearest body last.
    placed.sort((a, b) => a.depth - b.depth).forEach(one => one.body.faces.forEach(face => {
      const corners = one.corners;
      const [a, b, c] = [corners[face[0]], corners[face[1]], corners[face[2]]];
      const u = [b[0] - a[0], b[1] - a[1], b[2] - a[2]], v = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
      const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
      if (dot(rows[2], n) <= 0) return;
      const bright = 0.72 + 0.28 * dot(LIGHT, n) / Math.hypot(n[0], n[1], n[2]);
      const points = face.map(k => corners[k]);
      fill(points, "rgb(" + STONE.map(part => Math.round(part * bright)).join(",") + ")");
      stroke(points.concat([points[0]]), EDGE, 1.1);
    }));
    if (trail.length > 1) stroke(trail, TRAIL, 1.4);
    return scale;
  }

  // Dragging rotates the view; vertical swipes on a touch screen still scroll the page.
  function listen(canvas, view, redraw) {
    canvas.style.touchAction = "pan-y";
    canvas.style.cursor = "grab";
    let last = null;
    canvas.addEventListener("pointerdown", event => {
      last = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", event => {
      if (last === null) return;
      turn(view, 0.01 * (event.clientX - last[0]), 0.01 * (event.clientY - last[1]));
      last = [event.clientX, event.clientY];
      redraw();
    });
    ["pointerup", "pointercancel"].forEach(name => { canvas.addEventListener(name, () => { last = null; }); });
  }

  function turn(view, across, down) {
    view.azimuth += across;
    view.elevation = Math.min(Math.max(view.elevation + down, 0.03), 1.55);
  }

  return { draw: draw, listen: listen, turn: turn, reach: reach, elevation: ELEVATION };
})();
