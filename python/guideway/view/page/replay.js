// A drive looked at step by step: what was seen, what could be reached, what was weighed and what was chosen.

const numbersOf = (row, count) => Array.isArray(row) && row.length >= count && row.slice(0, count).every(finite);

/** The trace of a drive, ready to draw; null where there is none. */
function replayOf(data) {
  const steps = list(record(data.trace).steps).map(record).filter((step) => finite(step.t)).sort((a, b) => a.t - b.t).map((step) => ({
    t: step.t, state: plain(step.state === undefined ? "drive" : step.state), points: scanOf(step), chosen: pointsOf(step.chosen), goal: pointsOf([step.sub_goal])[0] || null,
    tracks: list(step.tracks).filter((row) => numbersOf(row, 3)), discs: list(step.discs).filter((row) => numbersOf(row, 3)),
    fan: list(step.fan).map(pointsOf).filter((rows) => rows.length > 1), command: numbersOf(step.command, 2) ? step.command : null,
  }));
  const plans = list(record(data.trace).plans).map(record).map((plan) => ({ t: number(plan.t), reason: plain(plan.reason), rows: pointsOf(plan.path) })).filter((plan) => plan.rows.length > 1);
  if (!steps.length && plans.length < 2) return null;
  const some = (test) => steps.some(test);
  const has = { scan: some((s) => s.points.length), tracks: some((s) => s.tracks.length), reach: some((s) => s.discs.length), fan: some((s) => s.fan.length || s.chosen.length > 1), heading: some((s) => s.goal), plans: plans.length > 1 };
  return { steps, plans, has, t: Float64Array.from(steps, (step) => step.t), last: steps.length ? steps[steps.length - 1].t : 0 };
}

/** Where the rays of a scan end, map frame. */
function scanOf({ pose, rays, ranges }) {
  if (!numbersOf(pose, 3) || !numbersOf(rays, 2)) return [];
  return list(ranges).flatMap((range, i) => (finite(range) && range > 0 ? [[pose[0] + range * Math.cos(pose[2] + rays[0] + i * rays[1]), pose[1] + range * Math.sin(pose[2] + rays[0] + i * rays[1])]] : []));
}

/** The step at a time; null before the first one. */
const stepAt = (replay, t) => (replay.steps.length && t >= replay.t[0] - 1e-6 ? replay.steps[floorIndex(replay.t, t + 1e-6)] : null);

/** The number of the plan in force at a time. */
function planAt(replay, t) {
  let found = 0;
  replay.plans.forEach((plan, i) => {
    if (plan.t <= t + 1e-6) found = i;
  });
  return found;
}

/** Everything of a step that lies under the robot. */
function drawReplay(pen, view, { replay, index }, t, layers, colour) {
  if (layers.plans && replay.has.plans) drawPlans(pen, view, replay, t, colour);
  const step = stepAt(replay, t);
  if (!step) return;
  pen.save();
  pen.lineJoin = pen.lineCap = "round";
  if (layers.reach) step.discs.forEach(([x, y, r]) => drawReach(pen, view, x, y, r, colour.mover));
  if (layers.tracks) step.tracks.forEach((track) => drawTrack(pen, view, track, colour));
  if (layers.fan) drawFan(pen, view, step, colour);
  if (layers.scan) drawScan(pen, view, step.points, colour);
  if (layers.heading && step.goal) drawHeading(pen, view, step.goal, entryColour(index), colour.halo);
  pen.restore();
}

/** Plans in force before, faint, and now. */
function drawPlans(pen, view, replay, t, colour) {
  const now = planAt(replay, t);
  replay.plans.slice(Math.max(0, now - 3), now).forEach((plan) => drawPath(pen, view, plan.rows, STYLE.former, colour.faint, null));
  if (now > 0) drawPath(pen, view, replay.plans[now].rows, STYLE.planned, colour.ink, colour.halo);
}

/** All that a mover could reach before the robot stands. */
function drawReach(pen, view, x, y, r, colour) {
  pen.beginPath();
  pen.arc(view.x(x), view.y(y), Math.max(0, r) * view.scale, 0, 2 * Math.PI);
  pen.fillStyle = pen.strokeStyle = colour;
  pen.globalAlpha = 0.1;
  pen.fill();
  pen.globalAlpha = 0.7;
  pen.lineWidth = 1;
  pen.setLineDash([2, 3]);
  pen.stroke();
  pen.setLineDash([]);
  pen.globalAlpha = 1;
}

/** A tracked obstacle with the way it goes in a second. */
function drawTrack(pen, view, [x, y, r, vx, vy], colour) {
  pen.strokeStyle = colour.ink;
  pen.lineWidth = 1.4;
  pen.beginPath();
  pen.arc(view.x(x), view.y(y), Math.max(3, Math.max(0, r) * view.scale), 0, 2 * Math.PI);
  pen.stroke();
  const [speed, angle] = [Math.hypot(number(vx), number(vy)), Math.atan2(-number(vy), number(vx))];
  if (speed < 0.05) return;
  const [tx, ty] = [view.x(x + vx), view.y(y + vy)];
  pen.beginPath();
  lineBetween(pen, view.x(x), view.y(y), tx, ty);
  for (const side of [2.6, -2.6]) lineBetween(pen, tx, ty, tx + 6 * Math.cos(angle + side), ty + 6 * Math.sin(angle + side));
  pen.stroke();
}

/** Candidates, and the one that was chosen. */
function drawFan(pen, view, step, colour) {
  pen.strokeStyle = colour.soft;
  pen.lineWidth = 1;
  pen.globalAlpha = 0.75;
  step.fan.forEach((rows) => strokeRows(pen, view, rows));
  pen.globalAlpha = 1;
  drawPath(pen, view, step.chosen, STYLE.chosen, colour.good, colour.halo);
}

function drawScan(pen, view, points, colour) {
  const side = clamp(0.05 * view.scale, 2.5, 5);
  pen.fillStyle = colour.bad;
  for (const [x, y] of points) pen.fillRect(view.x(x) - side / 2, view.y(y) - side / 2, side, side);
}

/** Where the robot heads for: a ring with a dot. */
function drawHeading(pen, view, [x, y], colour, halo) {
  for (const [style, width] of [[halo, 5], [colour, 2]]) {
    pen.strokeStyle = style;
    pen.lineWidth = width;
    pen.beginPath();
    pen.arc(view.x(x), view.y(y), 7, 0, 2 * Math.PI);
    pen.stroke();
  }
  pen.fillStyle = colour;
  pen.beginPath();
  pen.arc(view.x(x), view.y(y), 2.5, 0, 2 * Math.PI);
  pen.fill();
}

/** What the robot does at a time, in words: [text, kind]; null for plain driving. */
function stateWords(replay, t) {
  const step = replay && stepAt(replay, t);
  if (step && step.state !== "drive") return [`Stops: ${step.state}`, "bad"];
  const now = replay ? planAt(replay, t) : 0;
  if (now > 0 && t - replay.plans[now].t < 1.5) return [`New plan: ${replay.plans[now].reason}`, "warn"];
  return null;
}

/** Commanded speed or turn rate over time. */
function commandCurve(replay, k) {
  const out = curve();
  if (replay) replay.steps.filter((step) => step.command).forEach((step) => push(out, step.t, step.command[k]));
  return out;
}

/** Pitch and roll that a simulated base measured, degrees. */
function tiltCurves(data) {
  const rows = list(record(record(data.plant).tilt).rows).filter((row) => numbersOf(row, 3));
  return [1, 2].map((k) => ({ x: rows.map((row) => row[0]), y: rows.map((row) => row[k]) }));
}

/** How long steps took, by class of a quarter of a decade, as bars; null where it is not known. */
function histogram(times, name) {
  const counts = list(record(times).counts).map((n) => Math.max(0, number(n)));
  const total = counts.reduce((sum, n) => sum + n, 0);
  if (counts.length !== 24 || !total) return null;
  const [width, height, floor] = [560, 118, 92];
  const [first, last] = [counts.findIndex((n) => n > 0), 23 - [...counts].reverse().findIndex((n) => n > 0)];
  const [low, high] = [Math.max(0, Math.min(first - 1, Math.floor(first / 4) * 4)), Math.min(24, Math.max(last + 2, Math.ceil((last + 1) / 4) * 4, low4(first)))];
  const x = (k) => 8 + ((width - 16) * (k - low)) / (high - low);
  const most = Math.max(...counts);
  const bars = counts.slice(low, high).map((n, i) => {
    const h = n ? Math.max(1.5, ((floor - 14) * n) / most) : 0;
    const about = `${n} of ${total}, ${duration3(low + i)} to ${duration3(low + i + 1)}`;
    return drawing("rect", { class: "bar", x: x(low + i) + 1, y: floor - h, width: Math.max(1, x(1) - x(0) - 2), height: h, rx: 1.5 }, drawing("title", {}, about));
  });
  const ticks = [0, 4, 8, 12, 16, 20, 24].filter((k) => k >= low && k <= high).map((k) => svgText(duration3(k), { x: clamp(x(k), 18, width - 24), y: floor + 16, "text-anchor": "middle" }));
  const marks = [["p50", "half"], ["p99", "99 %"]].filter(([key]) => finite(times[key]) && times[key] > 0).flatMap(([key, words]) => {
    const at = x(clamp(4 * (Math.log10(times[key]) + 6), low, high));
    return [drawing("path", { class: "rank", d: `M${at} 12V${floor}` }), svgText(words, { x: clamp(at, 14, width - 16), y: 9, "text-anchor": "middle", class: "name" })];
  });
  const frame = drawing("path", { class: "floor", d: `M8 ${floor}H${width - 8}`, fill: "none" });
  return drawing("svg", { viewBox: `0 0 ${width} ${height}`, class: "course steps", role: "img", "aria-label": `${name}: ${total} times, half of them within ${show(1000 * number(times.p50))} ms` }, frame, ...bars, ...marks, ...ticks);
}

const low4 = (first) => Math.floor(first / 4) * 4 + 8;
const svgText = (words, attributes) => drawing("text", attributes, words);

/** The edge of a class of the histogram as a time. */
function duration3(k) {
  const seconds = 10 ** (k / 4 - 6);
  const [factor, name] = seconds < 0.99e-3 ? [1e6, "\u00b5s"] : seconds < 0.99 ? [1e3, "ms"] : [1, "s"];
  const value = seconds * factor;
  return `${value >= 100 ? Math.round(value) : Number(value.toPrecision(2))} ${name}`;
}
