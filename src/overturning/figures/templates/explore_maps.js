// The two maps of the explorer: by azimuth and B/H (2-D, polar), and by orientation and B/H (3-D).
// Azimuths count from the top, canvas angles from the right: subtract 90°.
const compass = {
  reach: width => (width / 2 - 30) / cube.radiusEdges[rings()],
  path: function (context, width, a, b) {
    const x = width / 2, scale = this.reach(width);
    const from = cube.directionEdges[a] - TURN / 4, to = cube.directionEdges[a + 1] - TURN / 4;
    context.beginPath();
    context.arc(x, x, cube.radiusEdges[b + 1] * scale, from, to);
    context.arc(x, x, Math.max(0, cube.radiusEdges[b]) * scale, to, from, true);
    context.closePath();
  },
  // Adds the border of a cell with the next B/H (outer), or with the next azimuth, to the path.
  border: function (context, width, a, b, outer) {
    const x = width / 2, scale = this.reach(width), low = cube.radiusEdges[b] * scale;
    const high = cube.radiusEdges[b + 1] * scale, turn = cube.directionEdges[a + 1];
    const s = Math.sin(turn), c = Math.cos(turn), from = cube.directionEdges[a] - TURN / 4;
    context.moveTo(x + s * high, x - c * high);
    if (outer) context.arc(x, x, high, turn - TURN / 4, from, true);
    else context.lineTo(x + s * low, x - c * low);
  },
  closed: cube.directionEdges[A] - cube.directionEdges[0] > TURN - 1e-6,
  place: function (x, y, width) {
    const first = cube.directionEdges[0], angle = Math.atan2(x - width / 2, width / 2 - y) - first;
    return [(angle % TURN + TURN) % TURN + first, Math.hypot(x - width / 2, y - width / 2) / this.reach(width)];
  },
  ratio: 1,
  axes: function (context, width) {
    const x = width / 2, rim = cube.radiusEdges[rings()], scale = this.reach(width);
    const normal = cube.records[at.record].normal;
    context.textBaseline = "middle";
    context.textAlign = "center";
    const sector = freeSector(normal), step = rim > 0.5 ? 0.2 : rim > 0.2 ? 0.1 : 0.05;
    for (let tick = step; tick < rim; tick += step) {
      context.strokeStyle = "#c8c8c8";
      context.beginPath();
      context.arc(x, x, tick * scale, 0, TURN);
      context.stroke();
      const text = String(Number(tick.toFixed(2)));
      context.strokeStyle = "#ffffff";
      context.lineWidth = 3;
      context.strokeText(text, x + Math.sin(sector) * tick * scale, x - Math.cos(sector) * tick * scale);
      context.lineWidth = 0.7;
      context.fillText(text, x + Math.sin(sector) * tick * scale, x - Math.cos(sector) * tick * scale);
    }
    for (const [colour, edge] of [["#777777", Math.max(0, cube.radiusEdges[0])], [INK, rim]]) {
      context.beginPath();
      context.strokeStyle = colour;
      context.arc(x, x, edge * scale, 0, TURN);
      context.stroke();
    }
    if (normal !== null) for (const turn of [0, Math.PI]) {
      const angle = normal / 360 * TURN + turn, s = Math.sin(angle), c = Math.cos(angle);
      context.strokeStyle = C.fault;
      context.lineWidth = 3;
      line(context, x + s * rim * scale, x - c * rim * scale, x + s * (rim * scale + 9), x - c * (rim * scale + 9));
    }
    ["N", "NE", "E", "SE", "S", "SW", "W", "NW"].forEach((name, k) => {
      const far = rim * scale + 19;
      context.fillText(name, x + Math.sin(k * TURN / 8) * far, x - Math.cos(k * TURN / 8) * far);
    });
  },
};
const LEFT = 40, LOW = 34, TOP = 8;
const plane = {
  spans: function (width) {
    const from = cube.directionEdges[0], low = cube.radiusEdges[0], height = width * this.ratio;
    return { x: v => LEFT + (v - from) / (cube.directionEdges[A] - from) * (width - LEFT - 8),
             y: v => height - LOW - (v - low) / (cube.radiusEdges[rings()] - low) * (height - LOW - TOP) };
  },
  path: function (context, width, a, b) {
    const { x, y } = this.spans(width), from = x(cube.directionEdges[a]), top = y(cube.radiusEdges[b + 1]);
    context.beginPath();
    context.rect(from, top, x(cube.directionEdges[a + 1]) - from, y(cube.radiusEdges[b]) - top);
  },
  border: function (context, width, a, b, outer) {
    const { x, y } = this.spans(width), right = x(cube.directionEdges[a + 1]), top = y(cube.radiusEdges[b + 1]);
    context.moveTo(right, top);
    context.lineTo(outer ? x(cube.directionEdges[a]) : right, outer ? top : y(cube.radiusEdges[b]));
  },
  closed: false,
  place: function (px, py, width) {
    const { x, y } = this.spans(width), e = cube.directionEdges, r = cube.radiusEdges;
    return [e[0] + (px - x(e[0])) / (x(e[A]) - x(e[0])) * (e[A] - e[0]),
      r[0] + (py - y(r[0])) / (y(r[1]) - y(r[0])) * (r[1] - r[0])];
  },
  ratio: 0.8,
  axes: function (context, width) {
    const { x, y } = this.spans(width), height = width * this.ratio;
    const wide = (width - LEFT) / A, tall = (height - LOW - TOP) / rings();
    const every = Math.ceil(11 / wide), up = Math.ceil(11 / tall);
    const length = Math.min(20, 0.75 * Math.min(wide * every, tall * up));
    if (at.colour === "azimuth") for (let a = 0; a < A; a += every) for (let b = 0; b < rings(); b += up) {
      const to = cell(a, b).to;
      if (to === null) continue;
      context.strokeStyle = Math.cos(to / 360 * TURN) > -0.3 ? INK : "#ffffff";
      context.lineWidth = 1.3;
      arrow(context, x(cube.direction[a]), y(cube.b_over_h[b]), to / 360 * TURN, length);
    }
    context.strokeStyle = INK;
    context.lineWidth = 0.7;
    context.strokeRect(LEFT, TOP, width - LEFT - 8, height - LOW - TOP);
    context.textBaseline = "top";
    context.textAlign = "center";
    const span = cube.directionEdges[A] - cube.directionEdges[0], step = span <= 100 ? 15 : span <= 200 ? 30 : 60;
    for (let tick = Math.ceil(cube.directionEdges[0] / step) * step; tick <= cube.directionEdges[A]; tick += step) {
      context.fillText(tick + "°", x(tick), height - LOW + 4);
    }
    context.fillText(say("orientation"), LEFT + (width - LEFT) / 2, height - LOW + 19);
    context.textBaseline = "middle";
    context.textAlign = "right";
    const every2 = Math.ceil(16 / tall);
    for (let b = 0; b < rings(); b += every2) {
      context.fillText(String(Number(cube.b_over_h[b].toPrecision(3))), LEFT - 5, y(cube.b_over_h[b]));
    }
    context.textAlign = "left";
    context.fillText("B/H", 0, TOP + 4);
  },
};
// Draws the borders between cells that are inside, by a function of their indices, and those that are not. Nothing is
// drawn next to a cell for which it returns null.
function drawEdges(context, width, colour, wide, inside) {
  context.beginPath();
  for (let a = 0; a < A; a++) for (let b = 0; b < rings(); b++) {
    const beside = a + 1 < A ? a + 1 : kind.closed ? 0 : -1, here = inside(a, b);
    const differs = other => here !== null && other !== null && here !== other;
    if (b + 1 < rings() && differs(inside(a, b + 1))) kind.border(context, width, a, b, true);
    if (beside >= 0 && differs(inside(beside, b))) kind.border(context, width, a, b, false);
  }
  context.strokeStyle = colour;
  context.lineWidth = wide;
  context.stroke();
}
// Azimuth of the radius labels: half-way between two named azimuths, with the fewest falls, not at the fault normal.
function freeSector(normal) {
  let best = 0, least = Infinity;
  for (let k = 0; k < 8; k++) {
    const middle = 22.5 + 45 * k;
    let count = normal !== null && Math.abs((middle - normal + 450) % 180 - 90) < 20 ? 1e6 : k === 2 ? -0.5 : 0;
    for (let a = 0; a < A; a++) if (Math.abs((cube.direction[a] - middle + 540) % 360 - 180) <= 12) {
      for (let b = 0; b < rings(); b++) count += Math.min(Math.abs(cell(a, b).flag), MISSED);
    }
    if (count < least) { least = count; best = middle; }
  }
  return best / 360 * TURN;
}
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
