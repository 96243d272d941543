// The facts beside the map. Every text from a file goes through textContent.

const METRICS = {
  length: ["Length", "m"], turns: ["Turns", ""], total_turning: ["Total turning", "rad"], min_clearance: ["Least clearance", "m"],
  max_curvature: ["Largest curvature", "1/m"], smoothness: ["Smoothness (0 to 1)", ""], energy: ["Energy", "grid units"], drive_energy: ["Energy of the drive", "J"],
};
const LIMITS = {
  speed: ["Speed", "m/s"], acceleration: ["Acceleration", "m/s\u00b2"], deceleration: ["Deceleration", "m/s\u00b2"], jerk: ["Jerk", "m/s\u00b3"],
  turn_rate: ["Turn rate", "rad/s"], turn_acceleration: ["Turn acceleration", "rad/s\u00b2"], lateral_acceleration: ["Lateral acceleration", "m/s\u00b2"],
};
const SEARCH = { seconds: ["Time to plan", "s"], raw_length: ["Length of the raw path", "m"], iterations: ["Iterations", ""], evaluations: ["Paths judged", ""], stop: ["Ended because", ""] };

/** A table of a record: [label, unit] by key, other keys by their own name. */
function tableOf(values, known, skip = []) {
  const kept = Object.entries(record(values)).filter(([key, value]) => !skip.includes(key) && !(Array.isArray(value) && !value.length));
  const units = kept.some(([key, value]) => finite(value) && known[key] && known[key][1]);
  const rows = kept.map(([key, value]) => {
    const [label, unit] = known[key] || [capital(words(key)), ""];
    if (finite(value)) return make("tr", {}, make("th", { scope: "row" }, label), make("td", { class: "n" }, [METRICS, RUN_NAMES, STEP_NAMES, PLANT_NAMES].includes(known) && !Number.isInteger(value) ? exact(value) : plain(value)), units ? make("td", { class: "u" }, unit) : null);
    const text = /^[0-9a-f]{40,}$/.test(value) ? `${value.slice(0, 12)}\u2026` : value === null ? (known === LIMITS ? "no limit" : "\u2013") : plain(value);
    return make("tr", {}, make("th", { scope: "row" }, label), make("td", { class: "w", colspan: units ? 2 : 1, title: typeof value === "string" ? value : null }, text));
  });
  return rows.length ? make("table", {}, make("tbody", {}, ...rows)) : null;
}

const block = (title, ...children) => (children.some(Boolean) ? make("section", {}, make("h2", {}, title), ...children) : null);

/** How much longer than the shortest path of all the final path of a plan is, as a part of it; null where that is not known. */
function gapOf(data) {
  const [length, best, given] = [record(data.metrics).length, record(data.reference).any_angle_optimum, record(data.reference).any_angle_gap];
  return finite(length) && finite(best) && best > 0 ? length / best - 1 : finite(given) ? given : null;
}

/** How far a result is from the best possible, in words. */
function gapWords(data) {
  const { grid_gap: grid, proved } = record(data.reference);
  const any = gapOf(data);
  const best = proved === false ? "best path known (not proved to be the shortest)" : "proved optimum";
  if (finite(any)) {
    if (any < -1e-7) return proved === false ? `${percent(-any)} shorter than the best path known before.` : `${percent(-any)} shorter than the ${best}: one of the two is wrong.`;
    return any < 5e-7 ? `Exactly as short as the ${best}.` : `${percent(any)} longer than the ${best}.`;
  }
  if (finite(grid)) return grid < 5e-7 ? "Exactly as short as the best path on the grid." : `${percent(grid)} longer than the best path on the grid.`;
  return "";
}

/** Status of a result: [kind, headline, sentences]. */
function verdictOf(entry) {
  const { data } = entry;
  if (entry.kind === "run") return runVerdict(entry);
  const certificate = record(data.certificate);
  const [kind, head] = certificate.ok === true ? ["good", "Certified"] : certificate.ok === false ? ["bad", "Certificate failed"] : ["none", "Not certified"];
  const sentences = [gapWords(data)];
  if (finite(record(data.metrics).min_clearance)) {
    const asked = number(record(data.query).clearance);
    sentences.push(`Keeps ${show(data.metrics.min_clearance)} m from every obstacle${asked > 0 ? `; ${show(asked)} m was asked for` : ""}.`);
  }
  if (!entry.motion.timed) sentences.push("No timing was asked for: the bar below the map runs along the path.");
  return [kind, head, sentences];
}

function runVerdict({ data, motion }) {
  const when = show(finite(data.time) ? data.time : motion.duration);
  const heads = { arrived: ["good", `Arrived after ${when} s`], collision: ["bad", `Collided${record(data.collision).with ? ` with ${plain(data.collision.with)}` : ""} after ${when} s`], timeout: ["warn", `Out of time after ${when} s`], stuck: ["warn", `Stuck after ${when} s`] };
  const [kind, head] = heads[data.outcome] || ["none", data.outcome ? capital(plain(data.outcome)) : "Drive"];
  const sentences = [];
  if (record(data.collision).unavoidable === true) sentences.push("A robot at rest would have been hit as well.");
  if (data.cancelled === true) sentences.push("The drive was cancelled; this is what was driven until then.");
  if (finite(data.min_separation)) sentences.push(`${data.outcome === "collision" ? "Least" : "Never closer than"} ${atLeast(data.min_separation)} m ${data.outcome === "collision" ? "distance to" : "to"} an obstacle.`);
  const counts = [[data.replans, "replan", "replans"], [data.emergency_stops, "emergency stop", "emergency stops"]];
  const said = counts.filter(([n]) => finite(n)).map(([n, one, more]) => `${n || "no"} ${n === 1 ? one : more}`);
  if (said.length) sentences.push(`${capital(said.join(", "))}.`);
  return [kind, head, sentences];
}

const keyFigure = (label, value, unit) => make("div", {}, make("dt", {}, label), make("dd", {}, value, unit ? make("small", {}, unit) : ""));

function keyFigures({ kind, data, motion }) {
  const metrics = record(data.metrics);
  if (kind === "run") {
    return [
      keyFigure("Time", show(finite(data.time) ? data.time : motion.duration), "s"), keyFigure("Driven", show(motion.line.length), "m"),
      keyFigure("Least distance", atLeast(data.min_separation), "m"), keyFigure("Replans", finite(data.replans) ? String(data.replans) : "\u2013", ""),
    ];
  }
  const gap = gapOf(data);
  return [
    keyFigure("Length", show(finite(metrics.length) ? metrics.length : motion.line.length), "m"), keyFigure("Duration", motion.timed ? show(motion.duration) : "\u2013", motion.timed ? "s" : ""),
    keyFigure("Least clearance", show(metrics.min_clearance), "m"), keyFigure("Over the optimum", finite(gap) ? percent(gap).replace(" %", "") : "\u2013", finite(gap) ? "%" : ""),
  ];
}

const noteOf = (kind, title, items) => (items.length ? make("div", { class: `note ${kind}` }, title, make("ul", {}, ...items.map((item) => make("li", {}, plain(item))))) : null);

/** The verdict on a result, and, for a drive, on the plan that it set out with. */
function fillVerdict(host, entry, partner, several) {
  const both = [entry, partner].filter(Boolean);
  const statuses = both.flatMap((each) => {
    const [kind, head, sentences] = verdictOf(each);
    const title = several ? `${each.label}: ${head.charAt(0).toLowerCase()}${head.slice(1)}` : head;
    return [make("div", { class: "status" }, make("span", { class: `badge ${kind}` }, sign(kind)), make("span", {}, title)), make("p", { class: "words" }, sentences.filter(Boolean).join(" "))];
  });
  const notes = both.flatMap(({ data }) => [noteOf("warn", "Could not be met:", list(data.unmet)), noteOf("warn", "Take note:", list(data.warnings))]);
  host.replaceChildren(...statuses, make("dl", { class: "keys" }, ...keyFigures(entry)), ...notes.filter(Boolean));
}

/** Certificate checks as a list; each may be a text or a record with a name and `ok`. */
function checksOf(certificate) {
  const items = [];
  const add = (ok, name, more) => {
    const kind = ok === true ? "good" : ok === false ? "bad" : "none";
    items.push(make("li", { class: kind }, sign(kind), make("span", {}, capital(words(name)), make("span", { class: "hush" }, ok === true ? " (passed)" : ok === false ? " (failed)" : "")), make("span", { class: "more" }, more)));
  };
  if (typeof certificate.collision_free === "boolean") add(certificate.collision_free, "Free of collision", finite(certificate.step) ? `sampled every ${plain(certificate.step)} m` : "");
  for (const check of list(certificate.checks).slice(0, 200)) {
    if (check && typeof check === "object" && !Array.isArray(check)) {
      const { name, check: other, ok, passed, at, ...rest } = check;
      if (ok === false && at !== null && at !== undefined) rest.at = at;
      add(typeof ok === "boolean" ? ok : passed, name || other || "Check", plain(rest));
    } else add(certificate.ok, plain(check), "");
  }
  return items.length ? make("ul", { class: "checks" }, ...items) : null;
}

function referenceTable(data) {
  const { any_angle_optimum: any, grid_optimum: grid, grid_path_length: own, any_angle_gap: anyGap, grid_gap: gridGap, proved } = record(data.reference);
  const [length, raw] = [record(data.metrics).length, record(data.search).raw_length];
  if (!finite(any) && !finite(grid)) return null;
  const row = (label, value, unit) => make("tr", {}, make("th", { scope: "row" }, label), make("td", { class: "n" }, value), make("td", { class: "u" }, unit));
  return make("table", {}, make("tbody", {}, ...[
    finite(any) ? row("Shortest of all", exact(any), "m") : null, finite(length) ? row("This path", exact(length), "m") : null, gapOf(data) !== null ? row("Longer by", percent(gapOf(data)).replace(" %", ""), "%") : null,
    finite(raw) && finite(any) ? row("Planner's raw path", exact(raw), "m") : null, finite(anyGap) ? row("Longer by", percent(anyGap).replace(" %", ""), "%") : null,
    finite(grid) ? row("Shortest on the grid", exact(grid), "m") : null, finite(own) ? row("Raw path on the grid", exact(own), "m") : null, finite(gridGap) ? row("Longer by", percent(gridGap).replace(" %", ""), "%") : null,
    typeof proved === "boolean" ? row("Optimum proved", proved ? "yes" : "no", "") : null,
  ].filter(Boolean)));
}

/** What a path of least energy was chosen from, the best first. */
function candidateTable(data) {
  const rows = list(data.candidates).map(record).filter((row) => finite(row.drive_energy)).sort((a, b) => a.drive_energy - b.drive_energy);
  if (!rows.length) return null;
  const name = (row) => `${row.refine === "bspline" ? `B-spline, ${trimmed(row.spacing)} m` : `${row.stretch ? "Wider" : "Wide"} bends`}${row.room ? `, ${trimmed(row.room)} m more room` : ""}`;
  const head = make("tr", {}, ...[["", ""], ["Length", "m"], ["Turns", ""], ["Drive", "J"]].map(([text, unit]) => make("th", { scope: "col" }, text, make("small", {}, unit))));
  const body = rows.map((row) => make("tr", { class: row.chosen ? "active" : null }, make("td", {}, name(row)), make("td", {}, show(row.length)), make("td", {}, plain(row.turns)), make("td", {}, show(row.drive_energy))));
  return make("div", { class: "scroll" }, make("table", { class: "versus" }, make("thead", {}, head), make("tbody", {}, ...body)));
}

const RUN_TABLES = ["outcome", "time", "driven", "movers", "events", "query", "robot", "obstacles", "warnings", "unmet", "world", "guideway", "schema", "label", "polyline", "raw_path", "path", "trajectory", "plan", "commands", "step_seconds", "parameters", "collision", "cancelled", "min_separation", "trace", "plant", "plan_seconds"];
const RUN_NAMES = {
  "separation static": ["Least distance to the building", "m"], "separation movers": ["Least distance to movers", "m"], "tracking tte": ["Off the path, root mean square", "m"], "tracking path_error": ["Off the path, mean", "m"],
  "tracking worst": ["Off the path, at most", "m"], "tracking tpe": ["Distance to the goal at the end", "m"], "tracking length": ["Driven length", "m"], "tracking length_deviation": ["Driven length against plan", "m"], "tracking ts": ["Turning per length", "\u00b0/m"],
  "tracking ssf": ["Speed steps", ""], "tracking asf": ["Acceleration steps", ""], "tracking stopped": ["Time at rest on the way", "s"], "energy ttec": ["Energy per length", "J/m"], "energy moec": ["Energy of the drive", "W h"],
  min_separation: ["Least distance to an obstacle", "m"], replans: ["Replans", ""], emergency_stops: ["Emergency stops", ""], energy: ["Energy", "J"], driven_length: ["Driven length", "m"] };
const PLANT_NAMES = {
  name: ["Plant", ""], simulator: ["Simulator", ""], mass: ["Mass", "kg"], height: ["Centre of gravity above the floor", "m"], "tilt max": ["Tilt, at most", "\u00b0"], "tilt mean": ["Tilt, mean", "\u00b0"],
  "tilt rms": ["Tilt, root mean square", "\u00b0"], "tilt psi": ["Posture stability index", "%"], "tilt ms": ["Motion stability, mean", "%"], "slip rms": ["Slip along, root mean square", "m/s"], "slip max": ["Slip along, at most", "m/s"],
  "slip lateral_rms": ["Slip across, root mean square", "m/s"], "slip lateral_max": ["Slip across, at most", "m/s"], contacts: ["Contacts with obstacles", ""], "energy work": ["Put into the wheels", "J"], "energy braked": ["Braked away by the wheels", "J"] };
const STEP_NAMES = { mean: ["Mean", "ms"], p50: ["Half within", "ms"], p95: ["95 % within", "ms"], p99: ["99 % within", "ms"], max: ["Longest", "ms"] };

const flat = (values, head = "") => Object.assign({}, ...Object.entries(record(values)).map(([key, value]) => (value && typeof value === "object" && !Array.isArray(value) ? flat(value, `${head}${key} `) : { [`${head}${key}`]: value })));

/** Tables of a plan: how it was found, what came out, the certificate, the distance to the optimum. */
const planBlocks = (entry, chart, breed) => [
  block(entry.data.trace && entry.data.trace.objective ? "Objective over the generations" : "Best path over the iterations", chart, generationSlider(entry, breed)),
  ...loopBlocks(entry),
  ...factBlocks(entry),
];

const factBlocks = ({ data }) => [
  block("Metrics of the plan", tableOf(data.metrics, METRICS)),
  block("Candidates for least energy", candidateTable(data)),
  block("Certificate", checksOf(record(data.certificate))),
  block("Against the optimum", referenceTable(data)),
];

/** What a plant measured, without rows and shapes. */
function plantFigures(data) {
  const plant = record(data.plant);
  const kept = Object.entries(plant).filter(([key, value]) => key !== "body" && !Array.isArray(value));
  return kept.length > 1 ? Object.fromEntries(kept.map(([key, value]) => [key, key === "tilt" ? { ...record(value), rows: [] } : value])) : {};
}

/** Tables of a drive: figures, events, time of a control step. */
function runBlocks({ data }, seek, skip) {
  const figures = Object.fromEntries(Object.entries(data).filter(([key]) => !RUN_TABLES.includes(key) && !skip.includes(key)));
  const times = (values) => tableOf(Object.fromEntries(Object.entries(record(values)).filter(([, value]) => finite(value)).map(([key, value]) => [key, 1000 * value])), STEP_NAMES);
  const timed = (title, values) => (record(values).counts && !histogram(values, title) ? null : block(title, histogram(values, title), times(values)));
  return [
    block("Drive", tableOf(flat(figures), RUN_NAMES)), block("Measured by the plant", tableOf(flat(plantFigures(data)), PLANT_NAMES)), block("Events", eventList(data.events, seek)),
    timed("Time of one control step", data.step_seconds), timed("Time of one new plan", data.plan_seconds),
  ];
}

function fillDetails(host, entry, partner, { seek, shown, breed }) {
  const { data } = entry;
  const source = partner ? partner.data : data;
  const search = record(source.search);
  const named = ["planner", "controller", "seed"];
  const planner = { ...Object.fromEntries(named.filter((key) => data[key] !== undefined).map((key) => [key, data[key]])), ...record(data.parameters) };
  const settings = [
    block(entry.kind === "run" ? "Controller" : "Planner", tableOf(planner, {})),
    block("Search", tableOf(search, SEARCH, search.evaluations === 0 ? ["history", "evaluations"] : ["history"])),
    block("Limits", tableOf(record(source.trajectory).limits, LIMITS)),
    block("Robot", tableOf(record(data.robot), LIMITS)),
    block("Task", tableOf(data.query, { clearance: ["Clearance", "m"], half_width: ["Half-width of a long load", "m"], arrival: ["Arrived within", "m"] })),
    block("Map", tableOf(data.world, { resolution: ["Resolution", "m"], width: ["Width", "cells"], height: ["Height", "cells"] })),
  ];
  const results = entry.kind === "run" ? [...runBlocks(entry, seek, named), ...(partner ? planBlocks(partner, convergenceOf(partner, []), breed) : [])] : planBlocks(entry, convergenceOf(entry, shown), breed);
  host.replaceChildren(...results.filter(Boolean), make("div", { class: "pair" }, ...settings.filter(Boolean)));
}

function eventList(events, seek) {
  const rows = list(events).map(record).slice(0, 500).map((event) => make("li", {}, make("button", { type: "button", onclick: () => seek(number(event.t)) },
    make("span", { class: "when" }, `${number(event.t).toFixed(2)} s`), make("span", {}, capital(words(event.kind || "event"))), make("span", { class: "why" }, event.reason ? plain(event.reason) : ""))));
  return rows.length ? make("ul", { class: "events" }, ...rows) : null;
}

const COLUMNS = [
  ["Length", "m", (e) => (e.kind === "run" ? e.motion.line.length : record(e.data.metrics).length), show, -1],
  ["Gap", "%", (e) => gapOf(e.data), (v) => percent(v).replace(" %", ""), -1],
  ["Time", "s", (e) => (e.kind === "run" && finite(e.data.time) ? e.data.time : e.motion.timed ? e.motion.duration : null), show, -1],
  ["Clear", "m", (e) => (e.kind === "run" ? e.data.min_separation : record(e.data.metrics).min_clearance), show, 1],
  ["Turning", "rad", (e) => record(e.data.metrics).total_turning, show, -1],
  ["Search", "s", (e) => record(e.data.search).seconds, show, -1],
  ["Curvature", "1/m", (e) => record(e.data.metrics).max_curvature, show, -1],
];

/** Columns for the products of one query: what they are made for. */
const PRODUCT_COLUMNS = [
  COLUMNS[0], ["Turns", "", (e) => record(e.data.metrics).turns, String, -1], COLUMNS[3], ["Energy", "units", (e) => record(e.data.metrics).energy, show, -1],
  ["Drive", "J", (e) => record(e.data.metrics).drive_energy, show, -1], COLUMNS[2], COLUMNS[4], COLUMNS[6],
];

/** The comparison of several results; `choose(i)` makes one active, `toggle(i, on)` shows or hides it. */
function fillCompare(host, entries, { active, visible, choose, toggle }) {
  host.hidden = entries.length < 2;
  if (host.hidden) return;
  const products = entries.every((entry) => entry.data.product);
  const used = (products ? PRODUCT_COLUMNS : COLUMNS).filter(([, , read]) => entries.some((entry) => finite(read(entry))));
  const best = used.map(([, , read, , better]) => {
    const values = entries.filter((entry) => entry.kind === "plan").map(read).filter(finite);
    return values.length > 1 && Math.min(...values) < Math.max(...values) ? (better < 0 ? Math.min(...values) : Math.max(...values)) : NaN;
  });
  const head = make("tr", {}, make("th", { scope: "col" }, ""), ...used.map(([name, unit]) => make("th", { scope: "col" }, name, make("small", {}, unit))));
  const rows = entries.map((entry, i) => {
    const box = make("input", { type: "checkbox", "aria-label": `Show ${entry.label}`, onchange: (event) => toggle(i, event.target.checked) });
    box.checked = visible.has(i);
    const who = make("div", { class: "who" }, box, make("i", {}), make("button", { type: "button", "aria-pressed": String(i === active), onclick: () => choose(i) }, entry.label));
    who.style.setProperty("--who", `var(--entry-${entry.index % 6})`);
    const failed = record(entry.data.certificate).ok === false || (entry.kind === "run" && entry.data.outcome !== undefined && entry.data.outcome !== "arrived");
    const cells = used.map(([, , read, write], k) => {
      const value = read(entry);
      const top = entry.kind === "plan" && finite(value) && value === best[k];
      return make("td", { class: top ? "best" : null }, finite(value) ? write(value) : "\u2013");
    });
    if (failed) who.append(make("span", { class: "poor" }, entry.kind === "run" ? plain(entry.data.outcome) : "failed"));
    return make("tr", { class: i === active ? "active" : null }, make("td", {}, who), ...cells);
  });
  host.replaceChildren(make("h2", {}, products ? "Products of one query" : "Results"), make("div", { class: "scroll" }, make("table", { class: "versus" }, make("thead", {}, head), make("tbody", {}, ...rows))));
}
