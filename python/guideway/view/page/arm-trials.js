// Learning: how long each trial took, how far it went over its limits, and all trials in a table.

const DOTTED = { stroke: "var(--soft)", "stroke-dasharray": "2 3" };

/** Integer ticks from 1 to `count`. */
function trialTicks(count, most) {
  const step = Math.max(1, roundStep(count / most) | 0);
  return { step, ticks: Array.from({ length: count }, (_, k) => k + 1).filter((k) => k === 1 || k % step === 0) };
}

/** A small chart over trials: `marks(x, y)` draws into it. */
function trialChart(width, title, key, unit, numbers, [low, high], marks) {
  const [height, left, right, top, bottom] = [138, 38, 8, 8, 20];
  const last = Math.max(...numbers, 2);
  const x = (n) => left + 12 + ((width - left - right - 24) * (n - 1)) / (last - 1);
  const y = (v) => height - bottom - ((height - bottom - top) * (v - low)) / (high - low);
  const box = { width, height, left, right, top, bottom, x, y, xs: trialTicks(last, 10), ys: ticksOf(low, high, 4), nameX: null, nameY: null };
  return make("div", {}, make("h3", {}, `${title}, ${unit}`), make("div", { class: "legendrow" }, ...key), drawing("svg", { viewBox: `0 0 ${width} ${height}`, class: "chart", role: "img", "aria-label": title }, ...frameOf(box), ...marks(x, y, box)));
}

const point2 = (rows, x, y) => (one) => drawing("circle", { cx: x(one.number), cy: y(one.value), r: rows.length > 25 ? 2.2 : 4, fill: one.clean === false ? "var(--bad)" : "var(--accent)", stroke: "var(--surface)", "stroke-width": 1.2 });

/** Durations; trials far slower than the others are cut off, with their value beside an arrow. */
function durationChart(motion, width) {
  const rows = motion.trials.filter((trial) => finite(trial.duration)).map((trial) => ({ ...trial, value: trial.duration }));
  if (!rows.length) return null;
  const bounds = rows.filter((trial) => finite(trial.lower_bound));
  const optimum = motion.oracleDuration;
  const fastest = Math.min(...rows.map((trial) => trial.duration));
  const shown = rows.filter((trial) => rows.length < 3 || trial.duration <= 1.25 * fastest);
  const base = bounds.filter((trial) => trial.lower_bound >= 0.8 * fastest);
  const values = [...shown.map((trial) => trial.duration), ...base.map((trial) => trial.lower_bound), ...(finite(optimum) ? [optimum] : [])];
  const air = 0.15 * (Math.max(...values) - Math.min(...values) || 0.1);
  const [low, high] = [Math.min(...values) - air, Math.max(...values) + (shown.length < rows.length ? 2 : 1) * air];
  const key = [...(finite(optimum) ? [keyOf("oracle", `optimum ${exact(optimum)}`)] : []), ...(base.length ? [keyOf("line", "lower bound", DOTTED)] : [])];
  return trialChart(width, "Duration", key, "s", rows.map((trial) => trial.number), [low, high], (x, y, { left, right, top }) => [
    ...(finite(optimum) ? [stroked(`M${left} ${y(optimum)}H${width - right}`, "oracle")] : []),
    stroked(joined(base.map((one) => one.number), base.map((one) => one.lower_bound), x, y), "line", DOTTED),
    stroked(joined(shown.map((one) => one.number), shown.map((one) => one.value), x, y), "line", { stroke: "var(--accent)" }),
    ...shown.map(point2(rows, x, y)),
    ...rows.filter((one) => !shown.includes(one)).slice(0, 8).flatMap((one) => [drawing("path", { d: `M${x(one.number) - 4} ${top + 10}h8l-4 -8z`, fill: one.clean === false ? "var(--bad)" : "var(--accent)" }), label(x(one.number) + 7, top + 10, one.duration.toFixed(2))]),
  ]);
}

function violationChart(motion, width) {
  const rows = motion.trials.filter((trial) => finite(trial.measured)).map((trial) => ({ ...trial, value: 100 * (1 + trial.measured) }));
  const exactly = motion.trials.filter((trial) => finite(trial.true)).map((trial) => [trial.number, 100 * (1 + trial.true)]);
  if (!rows.length) return null;
  const values = [...rows.map((one) => one.value), ...exactly.map((one) => one[1]), 100];
  const air = 0.12 * (Math.max(...values) - Math.min(...values) || 4);
  const key = [keyOf("line", "measured", { stroke: "var(--accent)" }), ...(exactly.length ? [keyOf("line", "true", DOTTED)] : [])];
  return trialChart(width, "Largest torque", key, "% of the limit", rows.map((one) => one.number), [Math.min(...values) - air, Math.max(...values) + air], (x, y, { left, right, top }) => [
    drawing("rect", { x: left, y: top, width: width - left - right, height: Math.max(0, y(100) - top), class: "over" }), stroked(`M${left} ${y(100)}H${width - right}`, "limit"),
    stroked(joined(exactly.map((one) => one[0]), exactly.map((one) => one[1]), x, y), "line", DOTTED),
    stroked(joined(rows.map((one) => one.number), rows.map((one) => one.value), x, y), "line", { stroke: "var(--accent)" }),
    ...rows.map(point2(rows, x, y)),
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
function makeTrials(host, point) {
  let [motion, wide] = [null, 0];
  const charts = make("div", { class: "pairplots" });
  const draw = () => {
    if (!motion || host.hidden || !charts.clientWidth || charts.clientWidth === wide) return;
    wide = charts.clientWidth;
    const columns = wide >= 420 ? 2 : 1;
    charts.style.gridTemplateColumns = `repeat(${columns}, minmax(0, 1fr))`;
    const width = (wide - 22 * (columns - 1)) / columns;
    charts.replaceChildren(...[durationChart(motion, width), violationChart(motion, width)].filter(Boolean));
  };
  onWidth(host, draw);
  return (next) => {
    [motion, wide] = [next, 0];
    host.hidden = !(motion && motion.trials.length);
    if (host.hidden) return;
    const who = motion.learner ? `, learner ${words(motion.learner)}` : "";
    const simulated = motion.trials.some((trial) => finite(trial.true)) ? " True is the torque of the simulated plant itself." : "";
    const note = make("p", { class: "small" }, `Red: counted as a violation, beyond what noise explains.${simulated} Point at a row to see its profile in the phase plane.`);
    host.replaceChildren(make("h2", {}, `Learning: ${motion.trials.length} trials${who}`), charts, trialTable(motion, point), note);
    draw();
  };
}
