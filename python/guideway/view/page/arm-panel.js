// The facts beside the arm: verdict, key figures, use of limits, what holds the motion back, tables.

const jointName = (motion, joint) => (finite(joint) ? words(motion.joints[joint] || `joint ${joint + 1}`).replace(/ joint$/, "") : "other");
/** A constraint as text: kind and joint. */
const holdName = (motion, one) => (finite(one.joint) ? `${one.kind} of ${jointName(motion, one.joint)}` : words(one.name || "nothing named"));
const spaced = (value, unit) => `${value}\u00a0${unit}`;
const block = (title, ...nodes) => (nodes.some(Boolean) ? make("div", {}, make("h2", {}, title), ...nodes.filter(Boolean)) : null);

/** Name of a check for people: "torque_rate of elbow_joint" as "torque rate of elbow". */
function checkName(motion, check) {
  const joint = motion.joints.indexOf(check.joint);
  const name = words(check.limit || check.name || "check");
  return joint < 0 ? words(check.name || name) : `${name} of ${jointName(motion, joint)}`;
}

function verdictOf(motion) {
  const { certificate } = motion;
  if (motion.trials.length && (!certificate || certificate.ok === true)) return learnedVerdict(motion);
  if (!certificate) return ["none", "Limits not checked", "This file holds no certificate."];
  const collision = record(certificate.collision);
  if (certificate.ok === true) {
    const near = certificate.collision ? ", nothing collides" : "";
    return ["good", `All limits kept${near}`, `Checked at ${plain(certificate.samples)} instants of the motion itself, between the solver's points too${certificate.collision ? `; ${plain(collision.pairs)} pairs of bodies proved apart all along the path` : "; collisions were not checked"}.`];
  }
  const failed = list(certificate.checks).map(record).filter((check) => check.ok === false);
  const title = failed.length ? (failed.length === 1 ? "A check failed" : `${failed.length} checks failed`) : "The arm collides";
  return ["bad", title, null];
}

/** What went wrong, a sentence each. */
function troubles(motion) {
  const certificate = record(motion.certificate);
  const out = list(certificate.checks).map(record).filter((check) => check.ok === false).map((check) => {
    const when = finite(check.t) ? ` at ${check.t.toFixed(3)} s` : "";
    if (finite(check.ratio)) return `${capital(checkName(motion, check))} reaches ${(100 * check.ratio).toFixed(check.ratio < 1.001 ? 4 : 2)} % of its limit${when}.`;
    if (finite(check.margin)) return `${capital(words(check.name || "range"))} is left by ${show(-check.margin)} rad${when}.`;
    return `${capital(words(check.name || "check"))} failed${when}${finite(check.gap) ? `: off by ${show(check.gap)}` : ""}.`;
  });
  const { hit } = record(certificate.collision);
  if (hit) out.push(`${capital(words(plain(record(hit).pair)))} ${number(record(hit).distance) <= 0 ? "overlap" : `come as near as ${show(1000 * record(hit).distance)} mm`} at ${show(record(hit).s)} rad of the path.`);
  return out;
}

/** Seconds that bounds of jerk and torque rate cost, one row [name, seconds, joint] per bound. */
function priceOf(motion) {
  const { price } = motion.report;
  const rows = Array.isArray(price) ? price.filter(Array.isArray) : finite(price) ? [["jerk", price]] : Object.entries(record(price));
  return rows.filter(([, value]) => finite(value)).map(([name, value]) => {
    const [kind, owner] = String(name).split(" of ");
    const numbered = /^joint (\d+)$/.exec(owner || "");
    const joint = numbered ? Number(numbered[1]) - 1 : motion.joints.indexOf(owner);
    return [joint >= 0 && joint < motion.joints.length ? `${words(kind)} of ${jointName(motion, joint)}` : words(name), value, joint >= 0 ? joint : null];
  });
}

const priceSum = (motion) => priceOf(motion).reduce((sum, row) => sum + row[1], 0);

/** Rows of a name, a bar and a text, in the colour of a joint. */
function bars(rows) {
  const most = Math.max(...rows.map((row) => row.part), 1e-12);
  return make("div", { class: "held" }, ...rows.flatMap(({ name, joint, part, text }) => {
    const bar = make("i", {});
    bar.style.width = `${100 * clamp(part / Math.max(1, most), 0, 1)}%`;
    const cells = [make("span", { class: "who" }, make("i", {}), capital(name)), make("div", { class: "bar" }, bar), make("span", { class: "n" }, text)];
    cells.forEach((cell) => cell.style.setProperty("--who", jointInk(joint)));
    return cells;
  }));
}

function priceBars(motion) {
  const [rows, sum] = [priceOf(motion).filter((row) => row[1] > 0).sort((one, two) => two[1] - one[1]), priceSum(motion)];
  return rows.length ? bars(rows.map(([name, value, joint]) => ({ name, joint, part: value / sum, text: `${exact(value)} s` }))) : null;
}

function keyFigures(motion) {
  const certificate = record(motion.certificate);
  const used = list(certificate.checks).map(record).filter((check) => finite(check.ratio)).sort((a, b) => b.ratio - a.ratio)[0];
  const { closest } = record(certificate.collision);
  const solver = record(motion.report.solver);
  const seconds = [motion.report.seconds, solver.seconds].find(finite);
  const price = priceSum(motion);
  return [
    ["Duration", exact(motion.duration), "s"],
    finite(motion.oracleDuration) ? ["Over the optimum", `${(100 * (motion.duration / motion.oracleDuration - 1)).toFixed(1)}`, "%"] : null,
    finite(motion.path.length) ? ["Path of the joints", show(motion.path.length), "rad"] : null,
    priceOf(motion).length ? ["Price of jerk", `${price >= 0 ? "+" : "\u2212"}${exact(Math.abs(price))}`, "s"] : null,
    used ? ["Largest use", (100 * used.ratio).toFixed(1), "%"] : null,
    record(closest).distance !== undefined && finite(record(closest).distance) ? ["Least clearance", atLeast(record(closest).distance), "m"] : null,
    finite(seconds) ? ["Computing time", seconds < 1 ? show(1000 * seconds) : show(seconds), seconds < 1 ? "ms" : "s"] : null,
    motion.tool.length ? ["Fastest of the tool", show(motion.fastest), "m/s"] : null,
  ].filter(Boolean);
}

function fillVerdict(host, motion) {
  const [kind, title, text] = verdictOf(motion);
  const bad = troubles(motion);
  const keys = keyFigures(motion).map(([name, value, unit]) => make("div", {}, make("dt", {}, name), make("dd", {}, value, make("small", {}, unit))));
  const nodes = [
    make("div", { class: `status ${kind}` }, make("span", { class: "badge" }, sign(kind)), title),
    text ? make("p", { class: "words" }, text) : null,
    bad.length ? make("ul", { class: "trouble" }, ...bad.map((line) => make("li", {}, line))) : null,
    learningWords(motion),
    make("dl", { class: "keys" }, ...keys),
  ];
  host.replaceChildren(...nodes.filter(Boolean));
}

const bestOf = (motion) => motion.trials.find((trial) => trial.number === motion.best) || null;

/** Where the trials are what speaks for a motion. */
function learnedVerdict(motion) {
  const best = bestOf(motion);
  if (!best) return ["none", `Learned from ${motion.trials.length} trials`, "This motion has not been run yet."];
  if (best.clean === false || best.accepted === false) return ["warn", "Every trial had a violation", `The motion shown is that of trial ${best.number}, the nearest to none.`];
  const checked = motion.certificate ? "Speeds, accelerations, ranges and the path were certified; torques were measured, which proves nothing of the next run." : null;
  return ["good", "No violation measured", checked];
}

function learningWords(motion) {
  const best = bestOf(motion);
  if (!best || best.clean === false || best.accepted === false) return null;
  const bound = finite(best.lower_bound) && best.lower_bound > 0 ? `, at most ${(100 * (best.duration / best.lower_bound - 1)).toFixed(1)}\u00a0% slower than anything the learner still holds possible` : "";
  const truth = finite(best.true) ? ` Its true torque reaches ${over(best.true)}\u00a0% of a limit.` : "";
  return make("p", { class: "words" }, `Trial ${best.number} of ${motion.trials.length} is the fastest without a measured violation${bound}.${truth}`);
}

/** How far each limit is used, and where. */
function useTable(motion, seek) {
  const checks = list(record(motion.certificate).checks).map(record).filter((check) => finite(check.ratio));
  if (!checks.length) return null;
  const rows = checks.map((check) => {
    const tone = check.ok === false ? "bad" : "good";
    const name = make("button", { type: "button", onclick: () => seek(number(check.t)) }, capital(checkName(motion, check)));
    const bar = make("i", {});
    bar.style.width = `${Math.min(100, 100 * check.ratio)}%`;
    return make("tr", { class: tone }, make("td", {}, name), make("td", { class: "bar" }, make("div", {}, bar)), make("td", { class: "n" }, `${(100 * check.ratio).toFixed(2)} %`), make("td", { class: "where" }, finite(check.t) ? `${check.t.toFixed(2)} s` : ""));
  });
  return make("table", { class: "uses" }, make("tbody", {}, ...rows));
}

/** Other checks: continuity, ranges, collisions. */
function checkList(motion) {
  const certificate = record(motion.certificate);
  const rows = list(certificate.checks).map(record).filter((check) => !finite(check.ratio)).map((check) => {
    const more = finite(check.margin) ? `${show(check.margin)} rad left` : finite(check.gap) ? (check.gap < 1e-12 ? "no gaps" : `gaps up to ${check.gap.toExponential(0).replace("-", "\u2212")}`) : "";
    return [check.ok, check.limit === "range" && check.joint ? `Joint ranges, nearest ${checkName(motion, { ...check, limit: "end" }).replace("end of ", "")}` : capital(words(check.name || "check")), more];
  });
  const collision = record(certificate.collision);
  if (certificate.collision) {
    const { closest } = collision;
    rows.push([collision.ok, closest ? `Clearance, nearest ${words(record(closest).pair)}` : "Nothing to collide with", closest && finite(closest.distance) ? `${atLeast(closest.distance)} m` : ""]);
  }
  const lines = rows.map(([ok, name, more]) => make("li", { class: ok === false ? "bad" : "good" }, sign(ok === false ? "bad" : "good"), make("span", {}, name), make("span", { class: "more" }, more)));
  return lines.length ? make("ul", { class: "checks" }, ...lines) : null;
}

/** What holds the motion back, by share of its time. */
function heldBy(motion) {
  const sums = new Map();
  for (const one of motion.stretches) {
    const name = holdName(motion, one);
    const entry = sums.get(name) || { name, joint: one.joint, time: 0, count: 0 };
    entry.time += finite(one.ends) ? one.ends - one.begins : one.to - one.from;
    entry.count += 1;
    sums.set(name, entry);
  }
  const rows = [...sums.values()].sort((a, b) => b.time - a.time).slice(0, 14);
  const whole = [...sums.values()].reduce((sum, entry) => sum + entry.time, 0) || 1;
  if (!rows.length) return null;
  return bars(rows.map((entry) => ({ ...entry, part: entry.time / whole, text: entry.time < 0.005 * whole ? "< 1 %" : `${((100 * entry.time) / whole).toFixed(0)} %` })));
}

const UNITS = { speed: "rad/s", acceleration: "rad/s\u00b2", deceleration: "rad/s\u00b2", jerk: "rad/s\u00b3", torque: "N m", torque_rate: "N m/s", tip_speed: "m/s", tip_acceleration: "m/s\u00b2" };

function limitTable(motion) {
  const kinds = Object.keys(UNITS).filter((kind) => Array.isArray(motion.limits[kind]));
  if (!kinds.length) return null;
  const head = make("tr", {}, make("th", { scope: "col" }, "Joint"), ...kinds.map((kind) => make("th", { scope: "col" }, capital(words(kind)), make("small", {}, UNITS[kind]))));
  const rows = motion.joints.map((_, j) => make("tr", {}, make("td", {}, jointName(motion, j)), ...kinds.map((kind) => make("td", {}, plain(motion.limits[kind][j])))));
  return make("div", { class: "scroll" }, make("table", { class: "versus" }, make("thead", {}, head), make("tbody", {}, ...rows)));
}

const pairs = (rows) => {
  const kept = rows.filter(([, value]) => value !== null && value !== undefined && value !== "");
  return kept.length ? make("table", {}, make("tbody", {}, ...kept.map(([name, value]) => make("tr", {}, make("th", { scope: "row" }, name), make("td", { class: "w" }, value))))) : null;
};

function robotTable(motion) {
  const robot = record(motion.robot);
  const payload = record(robot.payload);
  const friction = record(robot.friction);
  const numbers = (values, unit) => (list(values).some((value) => value) ? spaced(plain(values), unit) : "none");
  return pairs([
    ["Robot", robot.name && plain(robot.name)],
    ["Moved link", robot.tip && `${plain(robot.tip)}, in the frame of ${plain(robot.frame)}`],
    ["Payload", finite(payload.mass) ? (payload.mass ? `${trimmed(payload.mass)} kg at (${list(payload.at).map(plain).join(", ")}) m` : "none") : null],
    ["Masses", robot.inertials && { given: "of the description", none: "not known", estimated: "estimated" }[robot.inertials]],
    ["Viscous friction", robot.friction ? numbers(friction.viscous, "N m s/rad") : null],
    ["Coulomb friction", robot.friction ? numbers(friction.coulomb, "N m") : null],
  ]);
}

const SOLVER = {
  points: "Points tried", refinements: "Rounds that refined the grid", tightenings: "Rounds that tightened limits", first_excess: "Excess between points at first, share of the limit",
  excess: "Excess between points at last", slowed: "Slowed down as a whole to", seconds: "Computing time", steps: "Steps to limited jerk", jerk_tightenings: "Rounds that tightened jerk", jerk_slowed: "Slowed down at one place at most by",
};

function methodTable(motion) {
  const { report, path, plant } = motion;
  const solver = Object.entries(record(report.solver)).filter(([name, value]) => finite(value) && !(name === "slowed" && value === 0)).map(([name, value]) => [SOLVER[name] || capital(words(name)), name === "seconds" ? `${show(1000 * value)} ms` : plain(value)]);
  const walk = record(report.path);
  return pairs([
    ["Method", report.method && plain(report.method)],
    ["Path", path.source && plain(path.source)],
    ["Spline within", finite(walk.deviation) ? (walk.deviation < 1e-4 ? `${show(1e6 * walk.deviation)} \u00b5m of the tool's path` : `${show(1000 * walk.deviation)} mm of the tool's path`) : null],
    ["Smallest singular value", finite(walk.smallest_singular_value) ? walk.smallest_singular_value.toFixed(4) : null],
    ["Points of the grid", motion.points ? plain(motion.points) : null],
    ...solver,
    ["Override", finite(report.override) ? percent(report.override) : null],
    ["Learner", motion.learner && words(motion.learner)],
    ["Plant", plant && plain(plant)],
  ]);
}

function fillDetails(host, motion, seek) {
  host.replaceChildren(...[
    block("What holds the motion back", heldBy(motion), make("p", { class: "small" }, "Share of the duration during which a limit is the one that keeps the motion from being faster.")),
    block("What smoothness costs", priceBars(motion), make("p", { class: "small" }, "Time lost to each bound of jerk or torque rate, against the fastest motion without them.")),
    block("Use of the limits", useTable(motion, seek), checkList(motion)),
    block("Limits", limitTable(motion)),
    block(motion.trials.length ? "Robot, as the learner knew it" : "Robot", robotTable(motion)),
    block("How it was found", methodTable(motion)),
  ].filter((node, i) => node && (i !== 0 || motion.stretches.length) && (i !== 1 || priceOf(motion).length)));
}

/** Several motions beside each other; `choose(i)` brings one to the front. */
function fillCompare(host, motions, active, choose) {
  host.hidden = motions.length < 2;
  if (host.hidden) return;
  const columns = [["Duration", "s", (one) => exact(one.duration)], ["Largest use", "%", (one) => {
    const ratios = list(record(one.certificate).checks).map((check) => record(check).ratio).filter(finite);
    return ratios.length ? (100 * Math.max(...ratios)).toFixed(1) : "\u2013";
  }], ["Tool", "m/s", (one) => (one.tool.length ? show(one.fastest) : "\u2013")], ["Checked", "", (one) => (one.certificate ? (one.certificate.ok ? "kept" : "failed") : "\u2013")]];
  const head = make("tr", {}, make("th", { scope: "col" }, ""), ...columns.map(([name, unit]) => make("th", { scope: "col" }, name, make("small", {}, unit))));
  const rows = motions.map((one, i) => make("tr", { class: i === active ? "active" : null }, make("td", {}, make("div", { class: "who" }, make("button", { type: "button", "aria-pressed": String(i === active), onclick: () => choose(i) }, one.label))), ...columns.map(([, , write]) => make("td", {}, write(one)))));
  host.replaceChildren(make("h2", {}, "Motions"), make("div", { class: "scroll" }, make("table", { class: "versus" }, make("thead", {}, head), make("tbody", {}, ...rows))));
}
