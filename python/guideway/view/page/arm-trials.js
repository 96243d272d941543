// Learning: how long each trial took, how far it went over its limits, and all trials in a table.

/** Integer ticks from 1 to `count`. */
function trialTicks(count, most) {
  const step = Math.max(1, roundStep(count / most) | 0);
  return { step, ticks: Array.from({ length: count }, (_, k) => k + 1).filter((k) => k === 1 || k % step === 0) };
}

/** A small chart over trials: `marks(x, y)` draws into it. */
function trialChart(width, title, unit, numbers, [low, high], marks) {
  const [height, left, right, top, bottom] = [150, 44, 10, 16, 20];
  const last = Math.max(...numbers, 2);
  const x = (n) => left + 12 + ((width - left - right - 24) * (n - 1)) / (last - 1);
  const y = (v) => height - bottom - ((height - bottom - top) * (v - low)) / (high - low);
  const box = { width, height, left, right, top, bottom, x, y, xs: trialTicks(last, 10), ys: ticksOf(low, high, 4), nameX: null, nameY: unit };
  return make("div", {}, make("h3", {}, title), drawing("svg", { viewBox: `0 0 ${width} ${height}`, class: "chart", role: "img", "aria-label": title }, ...frameOf(box), ...marks(x, y, box)));
}

function durationChart(motion, width) {
  const rows = motion.trials.filter((trial) => finite(trial.duration));
  const bounds = rows.filter((trial) => finite(trial.lower_bound));
  const best = motion.oracleDuration;
  const values = [...rows.map((trial) => trial.duration), ...bounds.map((trial) => trial.lower_bound), ...(finite(best) ? [best] : [])];
  const air = 0.1 * (Math.max(...values) - Math.min(...values) || 0.1);
  return trialChart(width, "Duration of each trial", "s", rows.map((trial) => trial.number), [Math.min(...values) - air, Math.max(...values) + air], (x, y, { left, right }) => [
    ...(finite(best) ? [stroked(`M${left} ${y(best)}H${width - right}`, "oracle"), label(width - right, y(best) - 5, `true optimum ${best.toFixed(3)} s`, { "text-anchor": "end", class: "name" })] : []),
    ...(bounds.length ? [stroked(joined(bounds.map((one) => one.number), bounds.map((one) => one.lower_bound), x, y), "line", { stroke: "var(--soft)", "stroke-dasharray": "2 3" }), label(x(bounds[0].number), y(bounds[0].lower_bound) + 13, "lower bound", { class: "name" })] : []),
    stroked(joined(rows.map((one) => one.number), rows.map((one) => one.duration), x, y), "line", { stroke: "var(--accent)" }),
    ...rows.map((one) => drawing("circle", { cx: x(one.number), cy: y(one.duration), r: rows.length > 25 ? 2.2 : 4, fill: one.clean === false ? "var(--bad)" : "var(--accent)", stroke: "var(--surface)", "stroke-width": 1.2 })),
  ]);
}

function violationChart(motion, width) {
  const rows = motion.trials.filter((trial) => finite(trial.measured) || finite(trial.true));
  if (!rows.length) return null;
  const part = (key) => rows.filter((one) => finite(one[key])).map((one) => [one.number, 100 * (1 + one[key])]);
  const [measured, exactly] = [part("measured"), part("true")];
  const values = [...measured, ...exactly].map((one) => one[1]).concat([100]);
  const air = 0.12 * (Math.max(...values) - Math.min(...values) || 4);
  return trialChart(width, "Largest torque of each trial", "% of its limit", rows.map((one) => one.number), [Math.min(...values) - air, Math.max(...values) + air], (x, y, { left, right, top }) => [
    drawing("rect", { x: left, y: top, width: width - left - right, height: Math.max(0, y(100) - top), class: "over" }), stroked(`M${left} ${y(100)}H${width - right}`, "limit"),
    ...(exactly.length ? [stroked(joined(exactly.map((one) => one[0]), exactly.map((one) => one[1]), x, y), "line", { stroke: "var(--soft)", "stroke-dasharray": "2 3" })] : []),
    stroked(joined(measured.map((one) => one[0]), measured.map((one) => one[1]), x, y), "line", { stroke: "var(--accent)" }),
    ...measured.map(([n, v]) => drawing("circle", { cx: x(n), cy: y(v), r: rows.length > 25 ? 2.2 : 4, fill: (rows.find((one) => one.number === n) || {}).clean === false ? "var(--bad)" : "var(--accent)", stroke: "var(--surface)", "stroke-width": 1.2 })),
  ]);
}

const over = (part) => (finite(part) ? (100 * (1 + part)).toFixed(1) : "\u2013");
const ratio = (a, b) => (finite(a) && finite(b) && b > 0 ? (a / b).toFixed(3) : "\u2013");

function trialTable(motion, point) {
  const known = (read) => motion.trials.some((trial) => finite(read(trial)));
  const columns = [
    ["Trial", "", (one) => String(one.number)],
    ["Duration", "s", (one) => exact(one.duration)],
    ...(known((one) => one.lower_bound) ? [["T / T", "lower", (one) => ratio(one.duration, one.lower_bound)]] : []),
    ...(finite(motion.oracleDuration) ? [["T / T*", "optimum", (one) => ratio(one.duration, motion.oracleDuration)]] : []),
    ["Measured", "% of limit", (one) => over(one.measured)],
    ...(known((one) => one.true) ? [["True", "% of limit", (one) => over(one.true)]] : []),
    ...(known((one) => one.samples) ? [["Over", "samples", (one) => plain(one.samples)]] : []),
    ["", "", (one) => (one.stopped ? "stopped" : one.number === motion.best ? "best" : one.clean ? "clean" : "")],
  ];
  const head = make("tr", {}, ...columns.map(([name, unit]) => make("th", { scope: "col" }, name, make("small", {}, unit))));
  const rows = motion.trials.map((one) => make("tr", { class: one.number === motion.best ? "best" : null, tabindex: 0, onpointerenter: () => point(one.number), onpointerleave: () => point(null), onfocus: () => point(one.number), onblur: () => point(null) },
    ...columns.map(([name, , write]) => make("td", { class: one.clean === false && ["Measured", "Over", "True"].includes(name) && write(one) !== "0" ? "bad" : null }, write(one)))));
  return make("div", { class: "scroll tall" }, make("table", { class: "versus tried" }, make("thead", {}, head), make("tbody", {}, ...rows)));
}

/** Fills the section on learning; `point(number | null)` shows a trial in the phase plane. */
function fillTrials(host, motion, point) {
  host.hidden = !(motion && motion.trials.length);
  if (host.hidden) return;
  const draw = () => {
    const space = host.clientWidth - 28;
    const width = space > 500 ? (space - 22) / 2 : space;
    const charts = [durationChart(motion, width), violationChart(motion, width)].filter(Boolean);
    const who = motion.learner ? `, learner ${words(motion.learner)}` : "";
    host.replaceChildren(make("h2", {}, `Learning: ${motion.trials.length} trials${who}`), make("div", { class: "pairplots" }, ...charts), trialTable(motion, point));
  };
  draw();
}
