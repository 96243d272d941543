// What is drawn on the map, layer by layer. A pen is a 2-D context in CSS pixels; `view` maps metres to pixels.

const LAYERS = [
  { id: "shade", name: "Clearance shading", on: true },
  { id: "scent", name: "Pheromone", on: true },
  { id: "grid", name: "Metre grid", on: false },
  { id: "tree", name: "Search tree", on: true },
  { id: "crowd", name: "Population", on: true },
  { id: "classes", name: "Homotopy classes", on: true },
  { id: "raw", name: "Planner's raw path", on: true },
  { id: "optimum", name: "Exact optimum", on: true },
  { id: "final", name: "Smoothed path", on: true },
  { id: "points", name: "Its points", on: false },
  { id: "swept", name: "Swept footprint", on: true },
  { id: "driven", name: "Driven path", on: true },
  { id: "plans", name: "Plan in force, former plans", on: true },
  { id: "scan", name: "Lidar points", on: true },
  { id: "tracks", name: "Tracked obstacles", on: true },
  { id: "reach", name: "Reachable before rest", on: true },
  { id: "fan", name: "Candidates, chosen", on: true },
  { id: "heading", name: "Sub-goal", on: true },
  { id: "robot", name: "Robot", on: true },
  { id: "movers", name: "Moving obstacles", on: true },
  { id: "stops", name: "Start, goal, via", on: true },
];

const STYLE = {
  raw: { dash: [5, 4], width: 1.4 },
  optimum: { dash: [0.1, 5.2], width: 2.6 },
  final: { dash: [], width: 2.6 },
  alternative: { dash: [], width: 3 },
  planned: { dash: [7, 5], width: 1.6 },
  driven: { dash: [], width: 2.2 },
  former: { dash: [2, 5], width: 1.6 },
  chosen: { dash: [], width: 2.6 },
};

/** Strokes a line of rows [x, y], leaving out points closer than 0.6 pixels to the last one drawn. */
function strokeRows(pen, view, rows) {
  pen.beginPath();
  let [px, py] = [NaN, NaN];
  const n = rows.length;
  for (let i = 0; i < n; i += 1) {
    const [x, y] = [view.x(rows[i][0]), view.y(rows[i][1])];
    if (i === 0) pen.moveTo(x, y);
    else if (i === n - 1 || Math.abs(x - px) + Math.abs(y - py) > 0.6) pen.lineTo(x, y);
    else continue;
    [px, py] = [x, y];
  }
  pen.stroke();
}

/** A path with a halo, so that it reads on walls and shading alike. */
function drawPath(pen, view, rows, style, colour, halo) {
  if (rows.length < 2) return;
  pen.save();
  pen.lineJoin = "round";
  pen.lineCap = "round";
  if (halo) {
    pen.globalAlpha = 0.75;
    pen.strokeStyle = halo;
    pen.lineWidth = style.width + 2.4;
    strokeRows(pen, view, rows);
    pen.globalAlpha = 1;
  }
  pen.setLineDash(style.dash);
  pen.lineWidth = style.width;
  pen.strokeStyle = colour;
  strokeRows(pen, view, rows);
  pen.restore();
}

/** Outline of a footprint at a pose, as the current path of the pen. */
function traceFootprint(pen, view, shape, pose) {
  const corners = cornersOf(shape);
  if (!corners) {
    pen.moveTo(view.x(pose.x) + radiusOf(shape) * view.scale, view.y(pose.y));
    pen.arc(view.x(pose.x), view.y(pose.y), Math.max(0, radiusOf(shape) * view.scale), 0, 2 * Math.PI);
    return;
  }
  const [cos, sin] = [Math.cos(pose.yaw), Math.sin(pose.yaw)];
  corners.forEach(([x, y], i) => {
    const at = [view.x(pose.x + cos * x - sin * y), view.y(pose.y + sin * x + cos * y)];
    if (i) pen.lineTo(...at);
    else pen.moveTo(...at);
  });
  pen.closePath();
}

/** Fills and strokes a footprint; one with a rounded border gets it as a wide stroke. */
function paintFootprint(pen, view, shape, pose, colour, strength) {
  pen.beginPath();
  traceFootprint(pen, view, shape, pose);
  pen.fillStyle = pen.strokeStyle = colour;
  pen.lineJoin = "round";
  pen.globalAlpha = 0.36 * strength;
  pen.fill();
  if (cornersOf(shape) && number(shape.radius) > 0) {
    pen.lineWidth = 2 * shape.radius * view.scale;
    pen.stroke();
  }
  pen.globalAlpha = strength;
  pen.lineWidth = 1.8;
  pen.stroke();
}

const sweptSheet = document.createElement("canvas");

/** The floor that the footprint covers on its way, in one even tone. */
function drawSwept(pen, view, entry, colour) {
  const radius = radiusOf(entry.footprint);
  if (radius * view.scale < 1 || !entry.motion.line.n) return;
  const sheet = sweptSheet;
  if (sheet.width !== pen.canvas.width || sheet.height !== pen.canvas.height) [sheet.width, sheet.height] = [pen.canvas.width, pen.canvas.height];
  const ink = sheet.getContext("2d");
  ink.setTransform(1, 0, 0, 1, 0, 0);
  ink.clearRect(0, 0, sheet.width, sheet.height);
  ink.setTransform(view.ratio, 0, 0, view.ratio, 0, 0);
  ink.fillStyle = ink.strokeStyle = colour;
  if (cornersOf(entry.footprint)) {
    let last = null;
    for (const state of samplesOf(entry.motion)) {
      if (last && Math.hypot(state.x - last.x, state.y - last.y) < radius / 12 && Math.abs(wrap(state.yaw - last.yaw)) < 0.06) continue;
      ink.beginPath();
      traceFootprint(ink, view, entry.footprint, state);
      ink.fill();
      last = state;
    }
  } else {
    ink.lineWidth = 2 * radius * view.scale;
    ink.lineCap = ink.lineJoin = "round";
    strokeRows(ink, view, entry.rows);
  }
  pen.save();
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.globalAlpha = 0.15;
  pen.drawImage(sheet, 0, 0);
  pen.restore();
}

/** The robot at a state: body, nose, and a dot where it is small. */
function drawRobot(pen, view, entry, state, colour, halo) {
  pen.save();
  const [x, y] = [view.x(state.x), view.y(state.y)];
  const size = radiusOf(entry.footprint) * view.scale;
  if (entry.shadow) {
    drawShadow(pen, view, entry, state, colour);
    pen.restore();
    return;
  }
  const strength = entry.active ? 1 : 0.55;
  if (size > 2) paintFootprint(pen, view, entry.footprint, state, colour, strength);
  pen.globalAlpha = strength;
  const nose = clamp(size * 0.7, 7, 16);
  pen.translate(x, y);
  pen.rotate(-state.yaw);
  pen.beginPath();
  pen.moveTo(nose, 0);
  pen.lineTo(-0.6 * nose, 0.62 * nose);
  pen.lineTo(-0.3 * nose, 0);
  pen.lineTo(-0.6 * nose, -0.62 * nose);
  pen.closePath();
  pen.strokeStyle = halo;
  pen.lineWidth = 3;
  pen.stroke();
  pen.fillStyle = colour;
  pen.fill();
  pen.restore();
}

/** Where the plan wanted the robot to be, beside the robot that was driven: an outline only. */
function drawShadow(pen, view, entry, state, colour) {
  pen.strokeStyle = colour;
  pen.lineWidth = 1.5;
  pen.setLineDash([4, 3]);
  pen.beginPath();
  traceFootprint(pen, view, radiusOf(entry.footprint) * view.scale > 5 ? entry.footprint : { disc: 5 / view.scale }, state);
  pen.stroke();
}

/** Moving obstacles at a time, with the way they have come and go in the next seconds. */
function drawMovers(pen, view, movers, t, colour) {
  pen.save();
  pen.lineJoin = pen.lineCap = "round";
  for (const mover of movers) {
    const state = mover.at(t);
    if (!state) continue;
    drawTrail(pen, view, mover, t, colour);
    paintFootprint(pen, view, mover.shape, state, colour, 1);
    if (radiusOf(mover.shape) * view.scale < 4) {
      pen.beginPath();
      pen.arc(view.x(state.x), view.y(state.y), 4, 0, 2 * Math.PI);
      pen.fill();
    }
  }
  pen.restore();
}

function drawTrail(pen, view, mover, t, colour) {
  pen.strokeStyle = colour;
  for (const [from, to, alpha, dash] of [[t - 2.5, t, 0.45, []], [t, t + 2.5, 0.5, [2, 5]]]) {
    const rows = [];
    for (let i = 0; i <= 20; i += 1) {
      const state = mover.at(from + ((to - from) * i) / 20);
      if (state) rows.push([state.x, state.y]);
    }
    pen.globalAlpha = alpha;
    pen.lineWidth = 1.6;
    pen.setLineDash(dash);
    strokeRows(pen, view, rows);
  }
  pen.setLineDash([]);
}

/** A lettered pin whose tip stands on the point; with a heading, an arrow on the floor. */
function drawPin(pen, view, point, letter, colour) {
  const [x, y] = [view.x(point[0]), view.y(point[1])];
  pen.save();
  if (finite(point[2])) {
    pen.strokeStyle = colour.ink;
    pen.lineWidth = 2;
    pen.beginPath();
    const [tx, ty] = [x + 22 * Math.cos(point[2]), y - 22 * Math.sin(point[2])];
    pen.moveTo(x, y);
    pen.lineTo(tx, ty);
    for (const side of [2.6, -2.6]) {
      pen.moveTo(tx, ty);
      pen.lineTo(tx + 6 * Math.cos(point[2] + side), ty - 6 * Math.sin(point[2] + side));
    }
    pen.stroke();
  }
  pen.beginPath();
  pen.moveTo(x, y);
  pen.bezierCurveTo(x - 3, y - 7, x - 9, y - 10, x - 9, y - 17);
  pen.arc(x, y - 17, 9, Math.PI, 0);
  pen.bezierCurveTo(x + 9, y - 10, x + 3, y - 7, x, y);
  pen.fillStyle = colour.ink;
  pen.strokeStyle = colour.halo;
  pen.lineWidth = 3;
  pen.stroke();
  pen.fill();
  pen.fillStyle = colour.halo;
  pen.font = "600 11px system-ui, sans-serif";
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillText(letter, x, y - 16.6);
  pen.restore();
}

/** Static discs and polygons of a scene, below them what is only forbidden. */
function drawShapes(pen, view, shapes, colour) {
  const all = list(shapes).map(record);
  for (const shape of [...all.filter((one) => one.forbidden), ...all.filter((one) => !one.forbidden)]) {
    pen.fillStyle = shape.forbidden ? colour.forbidden : colour.wall;
    pen.beginPath();
    if (shape.disc) traceFootprint(pen, view, { disc: number(shape.disc.radius) }, { x: number(list(shape.disc.center)[0]), y: number(list(shape.disc.center)[1]), yaw: 0 });
    else traceFootprint(pen, view, shape, { x: 0, y: 0, yaw: 0 });
    pen.fill();
  }
}

/** Rulers in metres along the left and lower edge, an optional grid, and a scale bar. */
function drawAxes(pen, view, colour, grid) {
  const step = roundStep(72 / view.scale);
  const band = 24;
  pen.save();
  pen.font = "11px system-ui, sans-serif";
  const along = (low, high) => {
    const ticks = [];
    for (let v = Math.ceil(low / step) * step; v <= high; v += step) ticks.push(Math.abs(v) < step / 2 ? 0 : v);
    return ticks;
  };
  const xs = along(view.worldX(0), view.worldX(view.width));
  const ys = along(view.worldY(view.height), view.worldY(0));
  if (grid) {
    pen.strokeStyle = colour.grid;
    pen.lineWidth = 1;
    pen.beginPath();
    for (const v of xs) lineBetween(pen, Math.round(view.x(v)) + 0.5, 0, Math.round(view.x(v)) + 0.5, view.height);
    for (const v of ys) lineBetween(pen, 0, Math.round(view.y(v)) + 0.5, view.width, Math.round(view.y(v)) + 0.5);
    pen.stroke();
  }
  pen.globalAlpha = 0.86;
  pen.fillStyle = colour.surface;
  pen.fillRect(0, view.height - band, view.width, band);
  pen.fillRect(0, 0, band + 6, view.height - band);
  pen.globalAlpha = 1;
  pen.fillStyle = colour.soft;
  pen.strokeStyle = colour.faint;
  pen.textBaseline = "middle";
  pen.textAlign = "center";
  pen.beginPath();
  for (const v of xs.filter((value) => view.x(value) > band + 16 && view.x(value) < view.width - 30)) {
    pen.fillText(metres(v, step), view.x(v), view.height - band / 2 + 2);
    lineBetween(pen, Math.round(view.x(v)) + 0.5, view.height - band, Math.round(view.x(v)) + 0.5, view.height - band + 4);
  }
  for (const v of ys.filter((value) => view.y(value) < view.height - band - 16 && view.y(value) > 10)) {
    lineBetween(pen, band + 2, Math.round(view.y(v)) + 0.5, band + 6, Math.round(view.y(v)) + 0.5);
    pen.save();
    pen.translate(band / 2, view.y(v));
    pen.rotate(-Math.PI / 2);
    pen.fillText(metres(v, step), 0, 0);
    pen.restore();
  }
  pen.stroke();
  pen.textAlign = "left";
  pen.fillText("m", 10, view.height - band / 2 + 2);
  drawScaleBar(pen, view, colour, step, band);
  pen.restore();
}

function drawScaleBar(pen, view, colour, step, band) {
  const width = step * view.scale;
  const [right, y] = [view.width - 16, view.height - band - 14];
  const text = step < 1 ? `${metres(step, step)} m` : step >= 1000 ? `${step / 1000} km` : `${step} m`;
  for (const [style, line] of [[colour.halo, 5], [colour.ink, 2]]) {
    pen.strokeStyle = style;
    pen.lineWidth = line;
    pen.lineCap = line > 2 ? "round" : "butt";
    pen.beginPath();
    lineBetween(pen, right - width, y, right, y);
    lineBetween(pen, right - width, y - 4, right - width, y + 1);
    lineBetween(pen, right, y - 4, right, y + 1);
    pen.stroke();
  }
  pen.textAlign = "center";
  pen.font = "600 11.5px system-ui, sans-serif";
  pen.lineWidth = 3.5;
  pen.lineJoin = "round";
  pen.strokeStyle = colour.halo;
  pen.strokeText(text, right - width / 2, y - 11);
  pen.fillStyle = colour.ink;
  pen.fillText(text, right - width / 2, y - 11);
}

function lineBetween(pen, x0, y0, x1, y1) {
  pen.moveTo(x0, y0);
  pen.lineTo(x1, y1);
}
