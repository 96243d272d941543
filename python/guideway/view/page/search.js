// What a search left behind: pheromone and the last population on the map, the best cost over the iterations.

/** Pheromone as cells with their part, 0 to 1, of a logarithmic scale of at most three decades; null without any. */
function scentOf(data) {
  const { resolution, origin } = record(data.world);
  const best = new Map();
  for (const row of list(record(data.trace).legs).flatMap((leg) => list(record(leg).pheromone))) {
    if (!Array.isArray(row) || !row.slice(0, 3).every(finite) || !(row[2] > 0)) continue;
    const key = `${row[0]} ${row[1]}`;
    if (!best.has(key) || best.get(key)[2] < row[2]) best.set(key, row);
  }
  const cells = [...best.values()];
  if (!cells.length || !(resolution > 0) || list(origin).length < 2) return null;
  const most = (k, sense) => cells.reduce((found, cell) => (sense * cell[k] > sense * found ? cell[k] : found), cells[0][k]);
  const [left, right, lower, upper, high] = [most(0, -1), most(0, 1), most(1, -1), most(1, 1), most(2, 1)];
  const low = Math.max(most(2, -1), high / 1000);
  const [width, height] = [right - left + 1, upper - lower + 1];
  if (width * height > 3e7) return null;
  const part = (value) => (high > low ? clamp(Math.log(value / low) / Math.log(high / low), 0, 1) : 1);
  return { left, lower, width, height, low, high, resolution, origin, cells: cells.map(([x, y, value]) => [x - left, upper - y, part(value)]), sheet: null };
}

/** The colour of a part of the scale: even steps of lightness, away from the ground. */
function scentColour(part, colour) {
  const stops = [0, 1, 2, 3, 4].map((i) => rgb(colour[`scent-${i}`]));
  const place = clamp(part, 0, 1) * (stops.length - 1);
  const i = Math.min(Math.floor(place), stops.length - 2);
  return blend(stops[i], stops[i + 1], place - i);
}

/** One pixel per cell, in the colours of the theme. */
function scentSheet(scent, colour) {
  if (scent.sheet && scent.sheet.colour === colour) return scent.sheet.canvas;
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [scent.width, scent.height];
  const pen = canvas.getContext("2d");
  const image = pen.createImageData(scent.width, scent.height);
  for (const [x, y, part] of scent.cells) image.data.set([...scentColour(part, colour), Math.round(255 * Math.min(1, 0.35 + 2 * part))], 4 * (y * scent.width + x));
  pen.putImageData(image, 0, 0);
  scent.sheet = { colour, canvas };
  return canvas;
}

function drawScent(pen, view, scent, colour) {
  const k = scent.resolution * view.scale;
  pen.save();
  pen.translate(view.x(scent.origin[0]), view.y(scent.origin[1]));
  pen.rotate(-number(scent.origin[2]));
  pen.imageSmoothingEnabled = k < 1;
  pen.drawImage(scentSheet(scent, colour), scent.left * k, -(scent.lower + scent.height) * k, scent.width * k, scent.height * k);
  pen.restore();
}

/** The paths of the last population, best first. */
const crowdOf = (data) => list(record(data.trace).legs).flatMap((leg) => list(record(leg).paths)).map(pointsOf).filter((rows) => rows.length > 1);

function drawCrowd(pen, view, crowd, colour) {
  pen.save();
  pen.lineJoin = pen.lineCap = "round";
  pen.strokeStyle = colour;
  pen.lineWidth = 1.2;
  pen.globalAlpha = 0.55;
  for (const rows of crowd) strokeRows(pen, view, rows);
  pen.restore();
}

/** How the best cost of a plan came about: rows [iteration, m], the last iteration, where the swarm ended, the optimum of the same model; or null. */
function courseOf(entry) {
  const { search, reference, trace, query } = entry.data;
  const rows = pointsOf(record(search).history);
  const legs = list(record(trace).legs).map(record);
  const aim = record(trace).objective;
  if (!rows.length || (!legs.length && rows.length < 3)) return null;
  const end = Math.max(rows[rows.length - 1][0], legs.length === 1 ? number(record(search).iterations) : 0);
  if (!(end > 0)) return null;
  const { grid_optimum: grid, any_angle_optimum: any } = record(reference);
  const optimum = aim ? record(record(trace).bound).lower : record(query).material === "heavy" ? null : list(entry.data.grid_path).length ? grid : any;
  return { entry, rows, end, unit: aim ? "" : "m", mark: aim ? "lower bound" : "exact optimum", split: legs.length === 1 && finite(legs[0].swarm_iterations) ? Math.min(end, legs[0].swarm_iterations) : null, optimum: finite(optimum) ? optimum : null };
}

const CHART = { width: 440, height: 172, left: 48, right: 12, top: 14, bottom: 30 };

/** The chart of the best cost: the plan in front bold with its optimum, others thin. */
function convergenceOf(entry, others) {
  const own = courseOf(entry);
  if (!own) return null;
  const all = [...others.filter((other) => other !== entry && other.kind === "plan").map(courseOf).filter((other) => other && other.unit === own.unit), own];
  const values = all.flatMap((course) => course.rows.map((row) => row[1])).concat(own.optimum === null ? [] : [own.optimum]);
  let [low, high] = [Math.min(...values), Math.max(...values)];
  if (high - low < 1e-3 * Math.abs(high)) [low, high] = [low - 0.01 * Math.abs(low || 1), high + 0.01 * Math.abs(high || 1)];
  const air = 0.1 * (high - low);
  [low, high] = [low - air, high + air];
  const end = Math.max(...all.map((course) => course.end));
  const { width, height, left, right, top, bottom } = CHART;
  const x = (i) => left + ((width - left - right) * i) / end;
  const y = (v) => height - bottom - ((height - top - bottom) * (v - low)) / (high - low);
  const svg = drawing("svg", { viewBox: `0 0 ${width} ${height}`, class: "course", role: "img", "aria-label": `Best cost over ${end} iterations, at last ${show(own.rows[own.rows.length - 1][1])} ${own.unit}` });
  svg.append(...chartFrame({ x, y, low, high, end, unit: own.unit || "f" }), ...chartStages(own, x), ...all.map((course) => chartLine(course, course === own, { x, y })), ...chartOptimum(own, { x, y, end }));
  return make("div", {}, svg, make("p", { class: "small" }, courseWords(own)));
}

const chartText = (x, y, text, more = {}) => drawing("text", { x, y, ...more }, text);

function chartFrame({ x, y, low, high, end, unit }) {
  const { width, height, left, right, bottom } = CHART;
  const floor = height - bottom;
  const [up, along] = [ticksOf(low, high, 5), ticksOf(0, end, 6)];
  return [
    ...up.ticks.flatMap((v) => [drawing("path", { d: `M${left} ${y(v).toFixed(1)}H${width - right}`, class: "rule" }), chartText(left - 7, y(v) + 3.5, metres(v, up.step), { "text-anchor": "end" })]),
    ...along.ticks.filter(Number.isInteger).map((i) => chartText(x(i), floor + 15, String(i), { "text-anchor": "middle" })),
    drawing("path", { d: `M${left} ${floor}H${width - right}`, class: "rule floor" }),
    chartText(width - right, height - 2, "iteration", { "text-anchor": "end" }), chartText(left - 7, 9, unit, { "text-anchor": "end" }),
  ];
}

/** Where the swarm searches and where the ants do. */
function chartStages(course, x) {
  if (course.split === null) return [];
  const { height, top, bottom } = CHART;
  const [from, to, last] = [x(0), x(course.split), x(course.end)];
  const stages = [[from, to, "swarm"], [to, last, "colony"]].filter(([a, b]) => b - a > 44);
  return [
    drawing("rect", { x: from, y: top, width: Math.max(0, to - from), height: height - top - bottom, class: "stage" }),
    ...stages.map(([a, b, text]) => chartText((a + b) / 2, top + 12, text, { "text-anchor": "middle" })),
  ];
}

function chartLine({ entry, rows, end }, bold, { x, y }) {
  const steps = rows.map((row, i) => (i ? `H${x(row[0]).toFixed(1)}V${y(row[1]).toFixed(1)}` : `M${x(row[0]).toFixed(1)} ${y(row[1]).toFixed(1)}`)).join("");
  const last = rows[rows.length - 1];
  const colour = `var(--entry-${entry.index % 6})`;
  const line = drawing("path", { d: `${steps}H${x(end).toFixed(1)}`, fill: "none", stroke: colour, "stroke-width": bold ? 2.2 : 1.3, "stroke-linejoin": "round", opacity: bold ? 1 : 0.7 });
  return drawing("g", {}, line, ...(bold ? [drawing("circle", { cx: x(last[0]), cy: y(last[1]), r: 3.6, fill: colour, stroke: "var(--surface)", "stroke-width": 1.5 })] : []));
}

function chartOptimum({ optimum, mark }, { x, y, end }) {
  if (optimum === null) return [];
  const line = drawing("path", { d: `M${x(0)} ${y(optimum).toFixed(1)}H${x(end)}`, fill: "none", stroke: "var(--ink)", "stroke-width": STYLE.optimum.width, "stroke-dasharray": STYLE.optimum.dash.join(" "), "stroke-linecap": "round" });
  return [line, chartText(x(end), y(optimum) - 7, `${mark} ${exact(optimum)}`, { "text-anchor": "end", class: "name" })];
}

function courseWords({ rows, end, optimum, split, unit }) {
  const [when, best] = rows[rows.length - 1];
  const gap = optimum > 0 ? best / optimum - 1 : NaN;
  const place = split === null ? "" : when < split || (when === split && split === end) ? ", by the swarm" : ", by the ants";
  const found = when ? `iteration ${when} of ${end}` : "the first population";
  const above = !finite(gap) ? "" : unit && gap < 5e-7 ? ": the optimum" : `: ${percent(gap)} above the ${unit ? "optimum" : "lower bound"}`;
  return `${unit ? `${exact(best)} ${unit}` : `Objective ${exact(best)}`}, found in ${found}${when ? place : ""}${above}.`;
}
