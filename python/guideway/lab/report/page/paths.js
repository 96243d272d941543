// The runs of one cell: their paths on its world, their values, and the errors of those that failed.

const STATES = ["ok", "failed", "invalid", "timeout", "memory", "crashed"];
const ROLES = { best: "--role-best", median: "--role-median", worst: "--role-worst" };

/** Opens the dialog for a method on a place. */
function openRuns(view, place, method) {
  const dialog = document.getElementById("runs");
  const index = view.index.get(`${place}\u0000${method}`);
  const [cell, runs] = [view.data.cells[index], view.data.drawing.cells[index]];
  const close = make("button", { type: "button", class: "icon", "aria-label": "Close", onclick: () => dialog.close() }, drawing("svg", { viewBox: "0 0 14 14" }, drawing("path", { d: SIGNS.bad, class: "cross" })));
  const head = make("header", { class: "runs-head" }, make("div", {}, make("h2", { id: "runs-title" }, method), make("p", {}, `${place} \u00b7 ${plural(cell.n, "run")}`)), close);
  const picture = make("div", { class: "picture" });
  const body = make("div", { class: "runs-body" }, make("div", { class: "left" }, picture), make("div", { class: "right" }, summaryOf(view, cell), ...troubles(cell), runTable(view, cell, runs, (seed) => map && map.light(seed))));
  dialog.replaceChildren(head, body);
  dialog.showModal();
  const map = runs.paths.length ? pathMap(picture, runs.paths, view.worlds) : null;
  if (!map) picture.replaceChildren(make("p", { class: "hint" }, "No run of this cell left a path."));
}

function summaryOf(view, cell) {
  const rows = [["success", `${cell.success.hits} of ${cell.success.runs} (${(100 * cell.success.low).toFixed(0)}\u2013${(100 * cell.success.high).toFixed(0)} %)`]];
  for (const metric of view.metrics) {
    const stats = cell.measures[metric.name];
    if (stats) rows.push([headed(metric), stats.rate ? `${digitsOf(metric, stats.mean)} [${digitsOf(metric, stats.low)}, ${digitsOf(metric, stats.high)}]` : finite(stats.high) && stats.high > stats.mean ? `${digitsOf(metric, stats.mean)} \u00b1 ${digitsOf(metric, stats.high - stats.mean)}` : digitsOf(metric, stats.mean)]);
  }
  if (finite(cell.optimum)) rows.push(["optimum of its model", show(cell.optimum)]);
  if (cell.ert) rows.push(["evaluations expected to a gap of 1 %", finite(cell.ert.value) ? `${count(cell.ert.value)} (${cell.ert.successes} of ${cell.ert.runs} got there)` : `none of ${cell.ert.runs} got there`]);
  if (cell.convergence) rows.push(["last improvement (median)", `${count(cell.convergence.evaluations)} evaluations${finite(cell.convergence.gap) ? ` at a gap of ${(100 * cell.convergence.gap).toFixed(2)} %` : ""}`]);
  const time = timesOf(cell);
  if (time) rows.push(["computing time (median)", seconds(time.median)]);
  if (finite(cell.peak_mib)) rows.push(["memory of the process (peak)", `${cell.peak_mib.toFixed(0)} MiB`]);
  return make("dl", { class: "pairs" }, ...rows.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)]));
}

function troubles(cell) {
  return list(cell.errors).map((error) => make("p", { class: "note bad" }, make("b", {}, `${plural(error.seeds.length, "run")} ${error.status}`), ` ${[error.type, error.message].filter(Boolean).join(": ") || "no error was recorded"}`, make("span", { class: "seeds" }, ` seed${error.seeds.length > 1 ? "s" : ""} ${error.seeds.slice(0, 12).join(", ")}${error.seeds.length > 12 ? " \u2026" : ""}`)));
}

function runTable(view, cell, runs, light) {
  const names = view.metrics.filter((metric) => runs.values[metric.name]);
  const roles = new Map(runs.paths.map((path) => [path.seed, path.role]));
  const clock = ["cpu", "wall"].find((name) => runs.values[name]);
  const head = make("tr", {}, make("th", { scope: "col" }, "Seed"), ...names.map((metric) => make("th", { scope: "col", class: "n" }, metricName(metric))), clock ? make("th", { scope: "col", class: "n" }, "computing time") : null);
  const body = runs.seeds.map((seed, i) => {
    const role = roles.get(seed);
    const mark = role ? make("i", { class: "role", title: role }) : null;
    if (mark) mark.style.background = `var(${ROLES[role]})`;
    const failed = runs.states[i] !== 0;
    const values = failed ? [make("td", { colspan: names.length + (clock ? 1 : 0), class: "bad-text" }, STATES[runs.states[i]])] : [...names.map((metric) => make("td", { class: "n" }, digitsOf(metric, runs.values[metric.name][i]))), clock ? make("td", { class: "n" }, seconds(runs.values[clock][i])) : null];
    return make("tr", { tabindex: 0, onpointerenter: () => light(seed), onfocus: () => light(seed), onpointerleave: () => light(null), onblur: () => light(null) }, make("th", { scope: "row" }, String(seed), mark, role ? make("small", {}, role) : null), ...values);
  });
  return make("div", { class: "wide tall" }, make("table", { class: "facts-table" }, make("thead", {}, head), make("tbody", {}, ...body)));
}

/** The map with the paths; `light(seed)` brings one to the front. */
function pathMap(host, paths, worlds) {
  const numbers = [...new Set(paths.map((path) => path.world))];
  let [shown, lit] = [paths.find((path) => path.role === "best") ? paths.find((path) => path.role === "best").world : numbers[0], null];
  const canvas = make("canvas", { role: "img", "aria-label": `Paths of ${paths.length} runs` });
  const note = make("p", { class: "hint" });
  host.replaceChildren(canvas, legendOf(paths, numbers.some((number) => worlds[number] && list(worlds[number].movers).length)), note);
  const loaded = new Map();
  const colour = () => ({ near: styleOf("--near"), far: styleOf("--far"), wall: styleOf("--wall"), unknown: styleOf("--unknown"), forbidden: styleOf("--forbidden") });

  const bounds = (drawn) => {
    const world = worlds[shown];
    if (world) return world.bounds;
    const xs = drawn.flatMap(({ path }) => path.filter((_, i) => i % 2 === 0));
    const ys = drawn.flatMap(({ path }) => path.filter((_, i) => i % 2 === 1));
    const room = 0.05 * Math.max(Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys), 1e-6);
    return [Math.min(...xs) - room, Math.min(...ys) - room, Math.max(...xs) + room, Math.max(...ys) + room];
  };

  const paint = () => {
    const drawn = paths.filter((path) => path.world === shown);
    const [left, low, right, high] = bounds(drawn);
    const width = host.clientWidth;
    if (!width || !(right > left) || !(high > low)) return;
    const scale = Math.min(width / (right - left), Math.max(220, window.innerHeight * 0.62) / (high - low));
    const ratio = Math.max(1, window.devicePixelRatio || 1);
    const [w, h] = [(right - left) * scale, (high - low) * scale];
    [canvas.width, canvas.height] = [Math.round(w * ratio), Math.round(h * ratio)];
    [canvas.style.width, canvas.style.height] = [`${w}px`, `${h}px`];
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    const view = { width: w, height: h, scale, ratio, x: (v) => (v - left) * scale, y: (v) => h - (v - low) * scale, worldX: (px) => left + px / scale, worldY: (py) => low + (h - py) / scale };
    pen.fillStyle = styleOf("--far");
    pen.fillRect(0, 0, w, h);
    paintWorld(pen, view, worlds[shown], loaded.get(shown));
    if (worlds[shown]) paintMovers(pen, view, list(worlds[shown].movers));
    for (const path of [...drawn].sort((a, b) => Number(Boolean(a.role)) - Number(Boolean(b.role)))) paintPath(pen, view, path, lit);
    const ends = drawn[0].path;
    dot(pen, view, ends.slice(0, 2), false);
    dot(pen, view, ends.slice(-2), true);
    note.textContent = worlds[shown] ? (numbers.length > 1 ? "Each seed has a world of its own; this is that of the best run." : "") : "The map itself is not in this report; the paths are drawn alone.";
  };

  const show = async () => {
    paint();
    const world = worlds[shown];
    if (!world || loaded.has(shown)) return;
    loaded.set(shown, await loadWorld(world, colour()));
    paint();
  };
  show();
  onWidth(host, paint);
  return {
    light: (seed) => {
      lit = seed;
      const path = paths.find((one) => one.seed === seed);
      if (path && path.world !== shown) shown = path.world;
      show();
    },
  };
}

function paintWorld(pen, view, world, images) {
  if (!world) return;
  if (images && images.shadeLevels) drawRaster(pen, view, world, world.shade, images.shadeLevels, false);
  if (images && images.wallLevels) drawRaster(pen, view, world, world.walls, images.wallLevels, true);
  pen.fillStyle = styleOf("--wall");
  for (const shape of list(world.shapes)) {
    pen.beginPath();
    if (shape.disc) pen.arc(view.x(shape.disc.center[0]), view.y(shape.disc.center[1]), shape.disc.radius * view.scale, 0, 7);
    else list(shape.polygon && shape.polygon.points).forEach(([x, y], i) => (i ? pen.lineTo(view.x(x), view.y(y)) : pen.moveTo(view.x(x), view.y(y))));
    pen.fill();
  }
}

/** Where obstacles move: their tracks as wide as they are, and the obstacles at the beginning. */
function paintMovers(pen, view, movers) {
  [pen.strokeStyle, pen.fillStyle, pen.lineJoin, pen.lineCap] = [styleOf("--track"), styleOf("--track"), "round", "round"];
  for (const { track, at, half, cycle } of movers) {
    const line = () => {
      pen.beginPath();
      for (let i = 0; i + 1 < track.length; i += 2) (i ? pen.lineTo : pen.moveTo).call(pen, view.x(track[i]), view.y(track[i + 1]));
      if (cycle) pen.closePath();
    };
    line();
    [pen.globalAlpha, pen.lineWidth] = [0.16, Math.max(2, 2 * half * view.scale)];
    pen.stroke();
    line();
    [pen.globalAlpha, pen.lineWidth] = [0.8, 1];
    pen.stroke();
    pen.beginPath();
    pen.arc(view.x(at[0]), view.y(at[1]), Math.max(2, half * view.scale), 0, 7);
    pen.globalAlpha = 0.45;
    pen.fill();
  }
  pen.globalAlpha = 1;
}

function paintPath(pen, view, { path, role, seed }, lit) {
  const front = lit === seed;
  pen.beginPath();
  for (let i = 0; i + 1 < path.length; i += 2) (i ? pen.lineTo : pen.moveTo).call(pen, view.x(path[i]), view.y(path[i + 1]));
  [pen.lineJoin, pen.lineCap] = ["round", "round"];
  if (role || front) {
    pen.globalAlpha = lit !== null && !front ? 0.25 : 0.8;
    [pen.strokeStyle, pen.lineWidth] = [styleOf("--halo"), 5];
    pen.stroke();
  }
  pen.globalAlpha = front ? 1 : lit !== null ? 0.3 : role ? 1 : 0.28;
  [pen.strokeStyle, pen.lineWidth] = [styleOf(role ? ROLES[role] : front ? "--ink" : "--soft"), role || front ? 2.4 : 1.1];
  if (role === "median") pen.setLineDash([7, 4]);
  pen.stroke();
  pen.setLineDash([]);
  pen.globalAlpha = 1;
}

function dot(pen, view, [x, y], filled) {
  pen.beginPath();
  pen.arc(view.x(x), view.y(y), 5, 0, 7);
  [pen.fillStyle, pen.strokeStyle, pen.lineWidth] = [styleOf(filled ? "--ink" : "--halo"), styleOf(filled ? "--halo" : "--ink"), 2];
  pen.fill();
  pen.stroke();
}

function legendOf(paths, moving) {
  const roles = ["best", "median", "worst"].filter((role) => paths.some((path) => path.role === role));
  const item = (name, ink_, kind) => {
    const line = drawing("svg", { viewBox: "0 0 24 8", "aria-hidden": "true" }, drawing("path", { d: "M1 4H23", "stroke-width": { other: 1.2, track: 7 }[kind] || 2.6, "stroke-opacity": kind === "track" ? 0.35 : 1, "stroke-dasharray": kind === "median" ? "7 4" : "" }));
    line.style.stroke = `var(${ink_})`;
    return make("span", {}, line, name);
  };
  const others = paths.length - paths.filter((path) => path.role).length;
  return make("div", { class: "legendrow" }, ...roles.map((role) => item(role, ROLES[role], role)), others > 0 ? item(`${plural(others, "other")}`, "--soft", "other") : null, moving ? item("moving obstacles: tracks and where they begin", "--track", "track") : null);
}
