// The page: what is shown, what time it is, and the wires between map, time bar, plots and facts.

const byId = (id) => document.getElementById(id);
const bundle = JSON.parse(byId("data").textContent);
const entries = list(bundle.entries).map(makeEntry);
const state = {
  t: 0, ghost: null, alternative: null, generation: null, playing: false, rate: 1, active: 0,
  visible: new Set(entries.map((_, i) => i)),
  layers: Object.fromEntries(LAYERS.map((layer) => [layer.id, layer.on])),
};

/** What the page needs of one result, ready to draw. */
function makeEntry(source, index) {
  const data = record(source.data);
  const run = source.kind === "run";
  const motion = run ? makeDrive(data) : makeMotion(data);
  const query = record(data.query);
  const robot = record(data.robot);
  const footprint = record(Object.keys(record(robot.footprint)).length ? robot.footprint : query.footprint);
  const stops = [[query.start, "S"], ...list(query.via).map((point, i) => [point, String(i + 1)]), [query.goal, "G"]];
  return {
    kind: run ? "run" : "plan", index, label: String(source.label), data, motion, footprint, profile: record(source.profile),
    world: finite(source.world) ? list(bundle.worlds)[source.world] : null,
    rows: run ? motion.rows.map((row) => [row[1], row[2]]) : pointsOf(data.polyline),
    raw: pointsOf(list(data.raw_path).length ? data.raw_path : data.grid_path), optimum: pointsOf(record(data.reference).path),
    scent: scentOf(data), crowd: crowdOf(data), generations: generationsOf(data), classes: classesOf(data), tree: treeOf(data),
    planned: run ? pointsOf(record(data.plan).polyline) : [], movers: list(data.movers).map(record).map(makeMover), replay: run ? replayOf(data) : null, stops: stops.filter(([point]) => pointsOf([point]).length), curves: null,
  };
}

const current = () => entries[state.active];
const shownEntries = () => entries.filter((entry) => state.visible.has(entry.index) || entry.index === state.active);
const duration = () => Math.max(0, ...shownEntries().filter((entry) => entry.motion.timed === current().motion.timed).map((entry) => entry.motion.duration));
const unit = () => (current() && !current().motion.timed ? "m" : "s");

/** The rectangle around the active path, with room. */
function pathBox() {
  const rows = shownEntries().flatMap((entry) => [...entry.rows.filter((_, i) => i % Math.ceil(entry.rows.length / 2000 || 1) === 0), ...entry.stops.map(([point]) => point)]);
  if (!rows.length) return worldBox();
  const [xs, ys] = [rows.map((row) => row[0]), rows.map((row) => row[1])];
  const room = 0.06 * Math.max(Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys), 1) + (current() ? radiusOf(current().footprint) : 0);
  return [Math.min(...xs) - room, Math.min(...ys) - room, Math.max(...xs) + room, Math.max(...ys) + room];
}

function worldBox() {
  const world = current() && current().world;
  if (world && list(world.bounds).length === 4 && world.bounds.every(finite)) return world.bounds;
  return entries.some((entry) => entry.rows.length) ? pathBox() : [0, 0, 10, 10];
}

/** The first view: the whole map, unless the path would be small in it. */
function homeBox() {
  const [whole, path] = [worldBox(), pathBox()];
  const size = (box) => Math.max(box[2] - box[0], box[3] - box[1]);
  return size(path) < 0.45 * size(whole) ? path : whole;
}

/** The plan that a drive set out with, if it is in the report; null for plans. */
function partnerOf(entry) {
  const key = (other) => JSON.stringify([record(other.data.query).start, record(other.data.query).goal]);
  return entry.kind === "run" ? entries.find((other) => other.kind === "plan" && key(other) === key(entry)) || null : null;
}

/** The result whose raw path and optimum are drawn. */
const leading = () => (current() ? partnerOf(current()) || current() : null);

const scene = () => ({
  entries: shownEntries().map((entry) => Object.assign(entry, { active: entry.index === state.active, shadow: entry.kind === "plan" && shownEntries().some((other) => other.kind === "run"), leading: entry === leading() })),
  world: current() ? current().world : null, layers: state.layers, t: state.t, ghost: state.ghost, alternative: state.alternative, generation: state.generation, home: homeBox(),
});

/** Width of the map that the open list of layers hides on its left, pixels. */
function covered() {
  const legend = byId("legend");
  return legend.open ? legend.offsetLeft + legend.offsetWidth + 12 : 0;
}

const say = (text) => {
  byId("nomap").textContent = text;
  byId("nomap").hidden = !text;
};

// ---- pointer on the map ----

/** The state of the active motion nearest to a pixel, if it is near. */
function nearest(px, py) {
  const entry = current();
  if (!entry) return null;
  let [best, found] = [18, null];
  for (const sample of samplesOf(entry.motion)) {
    const d = Math.hypot(map.view.x(sample.x) - px, map.view.y(sample.y) - py);
    if (d < best) [best, found] = [d, sample];
  }
  return found;
}

function showTip(px, py, sample) {
  const tip = byId("tip");
  tip.hidden = !sample;
  if (!sample) return;
  const entry = current();
  const lines = entry.motion.timed ? [["at", `${show(sample.t)} s`], ["speed", `${show(sample.v)} m/s`]] : [];
  lines.push(["along", `${show(sample.s)} m`]);
  const free = curvesOf(entry).clearance;
  if (free && free.x.length) lines.push(["clearance", `${show(lookUp(free.x, free.y, sample.t))} m`]);
  tip.replaceChildren(...lines.map(([name, text]) => make("div", {}, make("span", {}, `${name} `), make("b", {}, text))));
  const box = byId("map").getBoundingClientRect();
  const left = px + 18 + tip.offsetWidth > box.width ? px - 18 - tip.offsetWidth : px + 18;
  tip.style.transform = `translate(${left}px, ${clamp(py - 20, 4, box.height - tip.offsetHeight - 4)}px)`;
}

const map = makeMap(byId("canvas"), scene, {
  hover: (px, py) => {
    const sample = nearest(px, py);
    byId("canvas").classList.toggle("pointing", Boolean(sample));
    showTip(px, py, sample);
    setGhost(sample ? sample.t : null);
  },
  leave: () => {
    byId("tip").hidden = true;
    setGhost(null);
  },
  tap: (px, py) => {
    const sample = nearest(px, py);
    if (sample) seek(sample.t);
  },
  trouble: say,
  covered,
});
const plots = makePlots(byId("plots"), { hover: (t) => setGhost(t), seek: (t) => seek(t) });

const fillAlternatives = makeAlternatives(byId("alternatives"), {
  show: (rows) => {
    state.alternative = rows;
    map.ask();
  },
});

function setGhost(t) {
  if (t === state.ghost) return;
  state.ghost = t;
  plots.move(state.t, t);
  map.ask();
}

// ---- time ----

function setTime(t) {
  const end = duration();
  state.t = clamp(t, 0, end);
  const slider = byId("slider");
  slider.value = String(state.t);
  slider.setAttribute("aria-valuetext", `${show(state.t)} ${unit()}`);
  slider.style.setProperty("--done", `${end > 0 ? (100 * state.t) / end : 0}%`);
  byId("clock").replaceChildren(make("b", {}, state.t.toFixed(2)), ` / ${end.toFixed(2)} ${unit()}`);
  plots.move(state.t, state.ghost);
  sayState();
  map.ask();
}

/** Why the robot stops, or that it has a new plan, over the map. */
function sayState() {
  const entry = current();
  const said = entry && entry.replay ? stateWords(entry.replay, Math.min(state.t, entry.motion.duration)) : null;
  byId("now").hidden = !said;
  if (said) [byId("now").textContent, byId("now").className] = [said[0], `now ${said[1]}`];
}

function seek(t) {
  play(false);
  setTime(t);
}

function play(on) {
  if (state.playing === on) return;
  state.playing = on && duration() > 0;
  byId("play").classList.toggle("playing", state.playing);
  byId("play").setAttribute("aria-label", state.playing ? "Pause" : "Play");
  if (!state.playing) return;
  if (state.t >= duration() - 1e-9) setTime(0);
  let before = null;
  const tick = (now) => {
    if (!state.playing) return;
    setTime(state.t + (before === null ? 0 : Math.min(0.25, (now - before) / 1000) * state.rate));
    before = now;
    if (state.t >= duration()) play(false);
    else requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
}

const EVENT_KINDS = [["collision", /collision|collide/], ["replan", /replan/], ["stop", /stop|brake|no-plan|blocked|blind/], ["goal", /goal|dear|tabu|expired|appeared/], ["go", /^go$/], ["turn", /turn/]];

function fillMarks() {
  const end = duration();
  const entry = current();
  const marks = shownEntries().flatMap((other) => list(other.data.events)).map(record).filter((event) => finite(event.t));
  if (entry && entry.kind === "plan") for (const piece of entry.motion.pieces) if (piece.turn !== undefined) marks.push({ t: piece.t, kind: "turn", reason: `in place by ${show((piece.turn * 180) / Math.PI)}\u00b0` });
  byId("marks").replaceChildren(...marks.slice(0, 400).map((event) => {
    const kind = (EVENT_KINDS.find(([, pattern]) => pattern.test(String(event.kind).toLowerCase())) || ["other"])[0];
    const text = `${capital(words(event.kind || "event"))} at ${show(event.t)} s${event.reason ? `: ${plain(event.reason)}` : ""}`;
    const mark = make("button", { type: "button", class: kind, title: text, "aria-label": text, tabindex: -1, onclick: () => seek(event.t) });
    mark.style.left = `${end > 0 ? clamp((100 * event.t) / end, 0, 100) : 0}%`;
    return mark;
  }));
}

// ---- plots ----

function curvesOf(entry) {
  if (!entry.curves) {
    entry.curves = entry.kind === "run" ? driveCurves(entry.motion, entry.profile) : planCurves(entry.motion, entry.profile);
    if (entry.kind === "plan") entry.curves.ceiling = ceilingCurve(entry.motion, entry.data.speed_ceiling);
  }
  return entry.curves;
}

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const limitLines = (values) => values.filter(([value]) => finite(value)).map(([y, name]) => ({ y, name }));

function plotSpecs() {
  const entry = current();
  if (!entry) return [];
  const shown = shownEntries().filter((other) => other.motion.timed === entry.motion.timed);
  const limits = { ...record(entry.data.robot), ...record(record(entry.data.trajectory).limits) };
  const collect = (key, fill) => shown.sort((a, b) => (a === entry) - (b === entry)).map((other) => ({ ...(curvesOf(other)[key] || curve()), bold: other === entry, lead: other === partnerOf(entry), fill, colour: () => entryColour(other.index), breaks: key === "separation" ? 0.5 : 0 })).filter((series) => series.x.length);
  const ceiling = entry.curves && entry.curves.ceiling && entry.curves.ceiling.x.length ? [{ ...entry.curves.ceiling, ceiling: true }] : [];
  const nearby = collect("separation", true);
  const wanted = number(record(entry.data.query).clearance);
  const asked = (k) => (entry.replay && commandCurve(entry.replay, k).x.length ? [{ ...commandCurve(entry.replay, k), bold: false, dash: [3, 3], colour: () => css("soft") }] : []);
  const [pitch, roll] = tiltCurves(entry.data);
  const specs = [
    { title: "Speed", unit: "m/s", series: [...asked(0), ...collect("speed", true)], lines: limitLines([[limits.speed, "limit"]]) },
    { title: "Acceleration", unit: "m/s\u00b2", signed: true, series: collect("acceleration"), lines: limitLines([[limits.acceleration, "limits"], [finite(limits.deceleration) ? -limits.deceleration : null, "limits"]]) },
    { title: "Jerk", unit: "m/s\u00b3", signed: true, series: collect("jerk"), lines: limitLines([[limits.jerk, "limits"], [finite(limits.jerk) ? -limits.jerk : null, "limits"]]) },
    { title: "Curvature", unit: "1/m", signed: true, series: collect("curvature"), lines: [] },
    { title: "Turn rate", unit: "rad/s", signed: true, series: [...asked(1), ...collect("turnRate")], lines: limitLines([[limits.turn_rate, "limits"], [finite(limits.turn_rate) ? -limits.turn_rate : null, "limits"]]) },
    { title: "Clearance", unit: "m", series: collect("clearance", true), lines: limitLines([[wanted > 0 ? wanted : null, "asked for"]]) },
    { title: "Distance to movers", unit: "m", series: nearby, lines: [] },
    { title: "Tilt", unit: "\u00b0", signed: true, series: pitch.x.length ? [{ ...pitch, bold: true, colour: () => entryColour(entry.index) }, { ...roll, bold: true, dash: [4, 3], colour: () => css("mover") }] : [], lines: [{ y: NaN, name: "pitch, dashed: roll" }] },
  ].filter((spec) => spec.series.length && spec.series.some((series) => series.bold || series.lead || spec.title === "Speed"));
  if (specs.length && specs[0].title === "Speed" && ceiling.length) {
    specs[0].series = [...ceiling, ...specs[0].series];
    specs[0].lines.push({ y: NaN, name: "shaded: ceiling" });
  }
  for (const spec of specs.filter((one) => ["Speed", "Turn rate"].includes(one.title) && one.series.some((series) => series.dash))) spec.lines.push({ y: NaN, name: "dashed: commanded" });
  return specs;
}

// ---- layers, theme, start ----

function hasLayer(id) {
  const some = (test) => entries.some(test);
  const tests = {
    shade: () => some((e) => e.world && e.world.shade), scent: () => some((e) => e.scent), crowd: () => some((e) => e.crowd.length || e.generations.length), classes: () => some((e) => e.classes.length), tree: () => some((e) => e.tree.length), raw: () => some((e) => e.raw.length > 1), optimum: () => some((e) => e.optimum.length > 1), final: () => some((e) => (e.kind === "plan" ? e.rows : e.planned).length > 1),
    points: () => some((e) => e.rows.length > 1), swept: () => some((e) => radiusOf(e.footprint) > 0), driven: () => some((e) => e.kind === "run"), robot: () => some((e) => e.rows.length),
    ...Object.fromEntries(["plans", "scan", "tracks", "reach", "fan", "heading"].map((name) => [name, () => some((e) => e.replay && e.replay.has[name])])),
    movers: () => some((e) => e.movers.length), stops: () => some((e) => e.stops.length), grid: () => true,
  };
  return tests[id]();
}

function swatch(id) {
  const own = `var(--entry-${current() ? current().index % 6 : 0})`;
  const line = (style, stroke) => drawing("path", { d: "M1 6H25", fill: "none", stroke, "stroke-width": style.width, "stroke-dasharray": style.dash.join(" "), "stroke-linecap": "round" });
  const box = (attributes) => drawing("rect", { x: 3, y: 0, width: 20, height: 12, rx: 2.5, ...attributes });
  const runColour = () => `var(--entry-${(entries.find((e) => e.kind === "run") || { index: 0 }).index % 6})`;
  const planColour = () => (current() && current().kind === "plan" ? own : `var(--entry-${(entries.find((e) => e.kind === "plan") || { index: 0 }).index % 6})`);
  const shapes = {
    shade: () => box({ fill: "var(--near)", stroke: "var(--line)" }), scent: () => box({ fill: "var(--scent-2)" }),
    tree: () => drawing("path", { d: "M2 11L9 6L7 1M9 6L17 7L24 3M17 7L22 11", fill: "none", stroke: "var(--soft)", "stroke-width": 1 }),
    classes: () => drawing("path", { d: "M2 6C8 -2 18 -2 24 6C18 14 8 14 2 6", fill: "none", stroke: "var(--mover)", "stroke-width": 1.4, "stroke-dasharray": "6 3" }),
    crowd: () => drawing("path", { d: "M1 10C9 10 10 2 25 2M1 10C12 11 16 7 25 2M1 10C5 3 12 1 25 2", fill: "none", stroke: "var(--ink)", "stroke-width": 1.1, opacity: 0.6 }), grid: () => drawing("path", { d: "M8 0V12M18 0V12M2 3H24M2 9H24", stroke: "var(--faint)", "stroke-width": 1, fill: "none" }),
    raw: () => line(STYLE.raw, "var(--soft)"), optimum: () => line(STYLE.optimum, "var(--ink)"), final: () => (entries.some((e) => e.kind === "plan") ? line(STYLE.final, planColour()) : line(STYLE.planned, "var(--soft)")), driven: () => line(STYLE.driven, runColour()),
    points: () => drawing("path", { d: "M2 4h4v4H2zM11 4h4v4H11zM20 4h4v4H20z", fill: planColour() }), swept: () => box({ fill: own, "fill-opacity": 0.2 }),
    plans: () => line(STYLE.planned, "var(--ink)"), scan: () => drawing("path", { d: "M3 8h3v3H3zM8 4h3v3H8zM13 2h3v3h-3zM18 3h3v3h-3z", fill: "var(--bad)" }),
    tracks: () => drawing("path", { d: "M3 6a4.5 4.5 0 1 0 9 0a4.5 4.5 0 1 0 -9 0M8 6H23L20 3.6M23 6L20 8.4", fill: "none", stroke: "var(--ink)", "stroke-width": 1.3 }),
    reach: () => drawing("circle", { cx: 13, cy: 6, r: 6, fill: "var(--mover)", "fill-opacity": 0.15, stroke: "var(--mover)", "stroke-dasharray": "2 2" }),
    fan: () => drawing("g", {}, drawing("path", { d: "M2 6C10 6 16 2 24 0M2 6C10 6 16 10 24 12", fill: "none", stroke: "var(--soft)", "stroke-width": 1 }), drawing("path", { d: "M2 6H24", stroke: "var(--good)", "stroke-width": 2.4 })),
    heading: () => drawing("g", {}, drawing("circle", { cx: 13, cy: 6, r: 5, fill: "none", stroke: runColour(), "stroke-width": 1.8 }), drawing("circle", { cx: 13, cy: 6, r: 1.8, fill: runColour() })),
    robot: () => drawing("path", { d: "M21 6L7 12L10 6L7 0Z", fill: own }), movers: () => box({ fill: "var(--mover)", "fill-opacity": 0.3, stroke: "var(--mover)", "stroke-width": 1.6 }),
    stops: () => drawing("path", { d: "M13 12C12 9 8 8 8 4.6A5 4.6 0 0 1 18 4.6C18 8 14 9 13 12Z", fill: "var(--ink)" }),
  };
  return drawing("svg", { viewBox: "0 0 26 12", class: "swatch", "aria-hidden": "true" }, shapes[id]());
}

/** A line of the legend for one of several plans; a click makes it the one in front. */
function keyOf(entry) {
  const line = drawing("path", { d: "M1 6H25", fill: "none", stroke: `var(--entry-${entry.index % 6})`, "stroke-width": STYLE.final.width, "stroke-linecap": "round" });
  const swatch = drawing("svg", { viewBox: "0 0 26 12", class: "swatch", "aria-hidden": "true" }, line);
  return make("button", { type: "button", class: "key", "aria-pressed": String(entry === current()), onclick: () => choose(entry.index) }, swatch, entry.label);
}

function fillLayers() {
  const plans = entries.filter((e) => e.kind === "plan");
  const straight = plans.length > 0 && plans.every((e) => record(e.data.path).degree === 1);
  byId("layers").replaceChildren(...LAYERS.filter((layer) => hasLayer(layer.id)).flatMap((layer) => {
    const box = make("input", { type: "checkbox", onchange: (event) => {
      state.layers[layer.id] = event.target.checked;
      map.ask(true);
    } });
    box.checked = state.layers[layer.id];
    const name = layer.id !== "final" ? layer.name : plans.length > 1 ? "Final paths" : !plans.length ? "Planned path" : straight ? "Final path" : layer.name;
    const row = make("label", {}, box, swatch(layer.id), name);
    if (layer.id === "final" && plans.length > 1) return [row, ...plans.map(keyOf)];
    const scent = leading() && leading().scent;
    if (layer.id === "scent" && scent) return [row, make("div", { class: "ramp scent", title: "Strongest pheromone out of a cell, logarithmic scale" }, plain(Number(scent.low.toPrecision(2))), make("i", {}), plain(Number(scent.high.toPrecision(2))))];
    const reach = current() && current().world && current().world.shade ? current().world.shade.reach : null;
    return layer.id === "shade" && finite(reach) ? [row, make("div", { class: "ramp" }, "0", make("i", {}), `${show(reach)} m`)] : [row];
  }));
}

function refresh() {
  const entry = current();
  byId("slider").max = String(duration());
  byId("slider").setAttribute("aria-label", unit() === "m" ? "Distance along the path" : "Time");
  fillCompare(byId("compare"), entries, { active: state.active, visible: state.visible, choose, toggle });
  if (entry) {
    fillVerdict(byId("verdict"), entry, partnerOf(entry), entries.length > 1);
    fillAlternatives(entry.data);
    fillDetails(byId("details"), entry, partnerOf(entry), { seek, shown: shownEntries(), breed });
  }
  fillLayers();
  fillMarks();
  if (entry) curvesOf(entry);
  plots.build(plotSpecs(), { end: duration() || 1, unit: unit() });
  setTime(state.t);
  map.ask(true);
}

/** Shows the population of a generation, by its number in the trace. */
function breed(number) {
  state.generation = number;
  map.ask(true);
}

function choose(i) {
  state.generation = null;
  state.active = i;
  refresh();
}

function toggle(i, on) {
  if (on) state.visible.add(i);
  else state.visible.delete(i);
  refresh();
}

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  map.restyle();
  plots.repaint();
}

function watchTheme() {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const asked = (/theme=(dark|light)/.exec(location.hash) || [])[1];
  let chosen = asked || null;
  const apply = () => setTheme(chosen || (dark.matches ? "dark" : "light"));
  dark.addEventListener("change", apply);
  byId("theme").addEventListener("click", () => {
    chosen = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    apply();
  });
  addEventListener("beforeprint", () => {
    document.documentElement.dataset.theme = "light";
    plots.repaint();
  });
  addEventListener("afterprint", apply);
  apply();
}

function watchKeys() {
  const nudge = (event) => ((event.shiftKey ? 0.05 : 0.005) * duration());
  const keys = {
    " ": () => play(!state.playing), ArrowRight: (e) => seek(state.t + nudge(e)), ArrowLeft: (e) => seek(state.t - nudge(e)), Home: () => seek(0), End: () => seek(duration()),
    "+": () => zoomBy(1.4), "=": () => zoomBy(1.4), "-": () => zoomBy(1 / 1.4), 0: () => fitTo(worldBox()), f: () => fitTo(pathBox()), F: () => fitTo(pathBox()),
  };
  addEventListener("keydown", (event) => {
    const field = event.target instanceof HTMLElement ? event.target.closest("select, summary, button, input[type=checkbox]") : null;
    if (event.ctrlKey || event.metaKey || event.altKey || !(event.key in keys) || (field && [" ", "ArrowLeft", "ArrowRight", "Home", "End"].includes(event.key))) return;
    event.preventDefault();
    keys[event.key](event);
  });
}

const fitTo = (box) => {
  map.view.fit(box, covered());
  map.ask(true);
};
const zoomBy = (factor) => {
  map.view.zoom(factor);
  map.ask(true);
};

function subtitle() {
  const entry = current();
  if (!entry) return "No results in this report.";
  const { source, width, height, resolution } = record(entry.data.world);
  const parts = [];
  if (source && source !== bundle.title) parts.push(String(source));
  if (finite(width) && finite(height) && finite(resolution) && width > 0) parts.push(`${width} \u00d7 ${height} cells of ${plain(resolution)} m`, `${show(width * resolution)} \u00d7 ${show(height * resolution)} m`);
  if (entries.length > 1) parts.push(`${entries.length} results`);
  else if (entry.data.planner) parts.push(String(entry.data.planner));
  return parts.join("  \u00b7  ");
}

function start() {
  byId("title").textContent = String(bundle.title);
  byId("subtitle").textContent = subtitle();
  byId("legend").open = matchMedia(entries.some((entry) => entry.replay) ? "(min-width: 1700px)" : "(min-width: 1000px)").matches; // a replay has many layers
  for (const rate of [0.25, 0.5, 1, 2, 4, 8, 16]) byId("rate").append(make("option", { value: rate, selected: rate === 1 }, `${rate}\u00d7`));
  byId("rate").addEventListener("change", (event) => { state.rate = Number(event.target.value); });
  byId("play").addEventListener("click", () => play(!state.playing));
  byId("slider").addEventListener("input", (event) => seek(Number(event.target.value)));
  byId("in").addEventListener("click", () => zoomBy(1.4));
  byId("out").addEventListener("click", () => zoomBy(1 / 1.4));
  byId("fit").addEventListener("click", () => fitTo(worldBox()));
  byId("focus").addEventListener("click", () => fitTo(pathBox()));
  watchTheme();
  watchKeys();
  if (!entries.length) {
    byId("verdict").hidden = byId("plots").hidden = byId("details").hidden = byId("time").hidden = true;
    say("There is no result in this report.");
    return;
  }
  state.t = Math.max(0, Number((/\bt=([\d.]+)/.exec(location.hash) || [])[1]) || 0);
  const runs = entries.filter((entry) => entry.kind === "run");
  if (runs.length === 1 && partnerOf(runs[0])) state.active = runs[0].index;
  const asked = entries.find((entry) => entry.data.asked === true);
  if (asked) state.active = asked.index;
  refresh();
}

start();
