// What a continuous planner left behind: populations, homotopy classes, a tree, and the closed loop between path and speed.

/** Populations by generation, as rows of points. */
const generationsOf = (data) => list(record(data.trace).population).map(record).map((one) => ({ number: number(one.generation), paths: list(one.paths).map(pointsOf).filter((rows) => rows.length > 1) })).filter((one) => one.paths.length);

/** The population that the map shows: of the generation asked for, or the last one. */
function crowdAt(entry, asked) {
  if (!entry.generations.length) return entry.crowd;
  return (entry.generations[asked] || entry.generations[entry.generations.length - 1]).paths;
}

const classesOf = (data) => list(record(data.trace).classes).map(record).map((one) => ({ ...one, rows: pointsOf(one.path) })).filter((one) => one.rows.length > 1);

const treeOf = (data) => list(record(data.trace).tree).filter((edge) => Array.isArray(edge) && edge.length > 3 && edge.slice(0, 4).every(finite));

function drawTree(pen, view, edges, colour) {
  pen.save();
  pen.strokeStyle = colour;
  pen.lineWidth = 0.8;
  pen.globalAlpha = 0.7;
  pen.beginPath();
  for (const [x0, y0, x1, y1] of edges) lineBetween(pen, view.x(x0), view.y(y0), view.x(x1), view.y(y1));
  pen.stroke();
  pen.restore();
}

/** The shortest path of every class, dashed, with its number beside its middle. */
function drawClasses(pen, view, classes, colour) {
  pen.save();
  pen.lineJoin = pen.lineCap = "round";
  pen.font = "600 11px system-ui, sans-serif";
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  const taken = [];
  classes.forEach((one, i) => {
    pen.strokeStyle = colour.mover;
    pen.lineWidth = one.chosen ? 2 : 1.3;
    pen.setLineDash([6, 4]);
    strokeRows(pen, view, one.rows);
    const at = labelPlace(view, one.rows, taken);
    taken.push(at);
    pen.setLineDash([]);
    pen.lineWidth = 3.5;
    pen.strokeStyle = colour.halo;
    pen.strokeText(String(i + 1), ...at);
    pen.fillStyle = colour.mover;
    pen.fillText(String(i + 1), ...at);
  });
  pen.restore();
}

/** A place on a line, near its middle and away from other labels, pixels. */
function labelPlace(view, rows, taken) {
  const spots = [0.5, 0.4, 0.6, 0.3, 0.7, 0.22, 0.78].map((part) => alongRows(rows, part)).map(([x, y]) => [view.x(x), view.y(y)]);
  return spots.find(([x, y]) => taken.every((other) => Math.hypot(other[0] - x, other[1] - y) > 18)) || spots[0];
}

/** The point at a part of the length of a line. */
function alongRows(rows, part) {
  const steps = rows.slice(1).map((row, i) => Math.hypot(row[0] - rows[i][0], row[1] - rows[i][1]));
  let left = part * steps.reduce((sum, step) => sum + step, 0);
  for (let i = 0; i < steps.length; i += 1) {
    if (left <= steps[i] && steps[i] > 0) return [0, 1].map((k) => rows[i][k] + (left / steps[i]) * (rows[i + 1][k] - rows[i][k]));
    left -= steps[i];
  }
  return rows[rows.length - 1];
}

/** A slider over the generations; `breed(number)` shows one on the map. */
function generationSlider(entry, breed) {
  const all = entry.generations;
  if (all.length < 2) return null;
  const words = make("output", { class: "small" }, `generation ${all[all.length - 1].number}`);
  const slider = make("input", { type: "range", min: 0, max: all.length - 1, step: 1, value: all.length - 1, "aria-label": "Generation on the map", oninput: (event) => {
    const k = Number(event.target.value);
    words.textContent = `generation ${all[k].number}`;
    breed(k);
  } });
  return make("label", { class: "generation" }, make("span", {}, "Population on the map"), slider, words);
}

const regionsOf = (rows) => list(rows).map(record).filter((one) => finite(one.from) && finite(one.to));

/** Speed along the path before and after its correction, under the ceiling. */
function speedChart(data) {
  const { ceiling, before, after, regions_before: marked } = record(record(data.trace).speed);
  const [top, first, last] = [ceiling, before, after].map(pointsOf);
  if (top.length < 2 || last.length < 2) return null;
  const { width, height, left, right, top: head, bottom } = CHART;
  const end = Math.max(top[top.length - 1][0], last[last.length - 1][0]);
  const high = 1.08 * Math.max(...top.concat(first, last).map((row) => row[1]));
  const x = (s) => left + ((width - left - right) * s) / end;
  const y = (v) => height - bottom - ((height - head - bottom) * v) / high;
  const path = (rows) => rows.map(([s, v], i) => `${i ? "L" : "M"}${x(s).toFixed(1)} ${y(v).toFixed(1)}`).join("");
  const line = (rows, attributes) => drawing("path", { d: path(rows), fill: "none", "stroke-linejoin": "round", ...attributes });
  const [up, along] = [ticksOf(0, high, 4), ticksOf(0, end, 6)];
  const svg = drawing("svg", { viewBox: `0 0 ${width} ${height}`, class: "course", role: "img", "aria-label": `Speed along the path, ${regionsOf(marked).length} overspeed regions before the correction` },
    ...up.ticks.flatMap((v) => [drawing("path", { d: `M${left} ${y(v).toFixed(1)}H${width - right}`, class: "rule" }), chartText(left - 7, y(v) + 3.5, metres(v, up.step), { "text-anchor": "end" })]),
    ...along.ticks.map((s) => chartText(x(s), height - bottom + 15, metres(s, along.step), { "text-anchor": "middle" })),
    ...regionsOf(marked).map((one) => drawing("rect", { x: x(one.from), y: head, width: Math.max(1.5, x(one.to) - x(one.from)), height: height - head - bottom, class: "region" })),
    drawing("path", { d: `${path(top)}L${x(end)} ${head}L${x(0)} ${head}Z`, class: "lid" }),
    line(first, { stroke: "var(--soft)", "stroke-width": 1.3, "stroke-dasharray": "5 4" }), line(last, { stroke: "var(--accent)", "stroke-width": 2.2 }),
    drawing("path", { d: `M${left} ${height - bottom}H${width - right}`, class: "rule floor" }),
    chartText(width - right, height - 2, "along the path, m", { "text-anchor": "end" }), chartText(left - 7, 9, "m/s", { "text-anchor": "end" }));
  return svg;
}

function speedWords(data) {
  const { regions_before: marked, regions_after: left, before, movers } = record(record(data.trace).speed);
  const alone = record(movers).timed ? " as if there were no movers" : "";
  const [found, rest] = [regionsOf(marked).length, regionsOf(left).length];
  const parts = [`Shaded: above the ceiling of bends and clearance. ${list(before).length ? `Dashed: the first pass, ${found ? `too fast in ${found} ${found === 1 ? "region" : "regions"} (tinted)` : "nowhere too fast"}.` : ""}`, `Line: the motion${alone}${rest ? `, still too fast in ${rest}` : found ? ", nowhere too fast" : ""}.`];
  return make("p", { class: "small" }, parts.join(" "));
}

/** The loop between search and speed, a row per stage. */
function stageTable(data) {
  const stages = list(record(data.trace).loop).map(record);
  if (!stages.length) return null;
  const head = make("tr", {}, ...["Stage", "Objective", "Too fast in", "Nodes", "Left", "Fed back"].map((text) => make("th", { scope: "col" }, text)));
  const fed = (one) => list(one.fed_back).map(plain).join("; ") || "\u2013";
  const rows = stages.map((one) => make("tr", {}, make("td", {}, plain(one.stage)), make("td", {}, finite(one.value) ? one.value.toFixed(4) : "\u2013"), make("td", {}, String(list(one.found).length)), make("td", {}, plain(one.nodes)), make("td", {}, String(list(one.remaining).length)), make("td", { class: "w" }, fed(one))));
  return make("div", { class: "scroll" }, make("table", { class: "versus" }, make("thead", {}, head), make("tbody", {}, ...rows)));
}

function classTable(classes) {
  if (!classes.length) return null;
  const head = make("tr", {}, ...[["Class", ""], ["Shortest", "m"], ["Best objective", ""]].map(([text, unit]) => make("th", { scope: "col" }, text, make("small", {}, unit))));
  const rows = classes.map((one, i) => make("tr", { class: one.chosen ? "active" : null }, make("td", {}, `${i + 1}${one.chosen ? " (this path)" : ""}`), make("td", {}, exact(one.length)), make("td", {}, finite(one.best) ? one.best.toFixed(4) : "\u2013")));
  return make("table", { class: "versus" }, make("thead", {}, head), make("tbody", {}, ...rows));
}

/** Parts of the objective, its lower bound and the gap between them. */
function objectiveTable(data) {
  const { objective, bound } = record(data.trace);
  if (!objective) return null;
  const units = { length: "m", time: "s", turning: "rad/s", clearance: "m" };
  const names = { value: "Value", length: "Length", time: "Time of the first pass", turning: "Sum of turn accelerations", clearance: "Least clearance", overspeed: "Share of overspeed" };
  const row = (label, value, unit) => make("tr", {}, make("th", { scope: "row" }, label), make("td", { class: "n" }, value), make("td", { class: "u" }, unit));
  const rows = Object.entries(names).filter(([key]) => finite(objective[key])).map(([key, name]) => row(name, key === "value" ? objective[key].toFixed(5) : exact(objective[key]), units[key] || ""));
  if (finite(record(bound).lower)) rows.push(row("Proved lower bound", bound.lower.toFixed(5), ""), row("Gap to it", percent(number(bound.gap)).replace(" %", ""), "%"));
  return make("table", {}, make("tbody", {}, ...rows));
}

/** What the motion does about movers, in words. */
function moverWords(data) {
  const told = record(record(data.trace).speed).movers;
  if (!told) return null;
  const many = `${number(told.movers)} ${told.movers === 1 ? "mover" : "movers"}`;
  if (!told.timed) return make("p", {}, `Not kept off: the motion knows nothing of the ${many}. ${plain(told.reason)}.`);
  const other = told.way ? ` It takes way ${told.way + 1} of ${told.ways} past the obstacles.` : "";
  const brake = told.passive ? "A brake anywhere ends out of their reach." : "No brake is sure to end out of their reach.";
  return make("p", {}, `Keeps off ${many} at all times, ${number(told.delay).toFixed(2)} s later than alone (${number(told.waiting).toFixed(2)} s waiting).${other} ${brake}`);
}

const loopBlocks = ({ data, classes }) => {
  const chart = speedChart(data);
  return [
    block("Speed before and after correction", chart, chart && speedWords(data)),
    block("Movers", moverWords(data)),
    block("Closed loop", stageTable(data)),
    block("Homotopy classes", classTable(classes)),
    block("Objective", objectiveTable(data)),
  ];
};
