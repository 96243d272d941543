// The charts of an experiment: convergence, distributions, profile, growth, boxes. `view` says which methods are shown.

const shownMethods = (view) => view.methods.map((name, k) => ({ name, k })).filter(({ name }) => !view.hidden.has(name));
const lineOf = (points, k, view, name) => stroke(through(points), "curve", { stroke: ink(k), "stroke-dasharray": dash(k), "stroke-width": view.lit === name ? 2.8 : 1.7, opacity: view.lit && view.lit !== name ? 0.25 : 1 });

/** The value that holds at a place of rows [[place, value]]; null before the first. */
function holding(rows, at, column = 1) {
  let found = null;
  for (const row of rows) {
    if (row[0] > at) break;
    found = row[column];
  }
  return found;
}

function span(values, air = 0.06) {
  const known = values.filter(finite);
  if (!known.length) return [0, 1];
  const [low, high] = [Math.min(...known), Math.max(...known)];
  const room = (high - low || Math.abs(high) * 0.02 || 1) * air;
  return [low - room, high + room];
}

/** Best value over evaluations: median and quartile band of each method on one world. */
function convergenceChart(host, view, place) {
  const rows = new Map(list(view.data.curves.convergence).filter((c) => placeName(c.world, c.query) === place).map((c) => [c.method, c.rows]));
  const shown = shownMethods(view).filter(({ name }) => rows.has(name));
  const every = shown.flatMap(({ name }) => rows.get(name));
  const places = every.map((row) => row[0]).filter((v) => v > 0);
  const [low, high] = span(every.flatMap((row) => row.slice(1)));
  const x = { name: "evaluations", low: Math.max(1, Math.min(...places, 1e9)), high: Math.max(...places, 2), log: true };
  if (x.high <= x.low) x.high = x.low * 10;
  chart(host, {
    label: `Best value over evaluations on ${place}`, x, y: { name: "best", low, high, show: (v) => axisText(v, high - low) },
    draw: (pen, group) => {
      for (const { name, k } of shown) {
        const own = rows.get(name);
        const side = (column) => steps([...own, [x.high, ...own[own.length - 1].slice(1)]].map((row) => (finite(row[column]) ? [pen.x(row[0]), pen.y(row[column])] : null)));
        const [top, bottom] = [side(3), side(1)].map((points) => points.filter(Boolean));
        if (top.length && bottom.length) group.append(stroke(`${through([...top, ...bottom.reverse()])}Z`, "area", { fill: ink(k), opacity: view.lit === name ? 0.25 : view.lit ? 0.04 : 0.13 }));
      }
      for (const { name, k } of shown) {
        const own = rows.get(name);
        group.append(lineOf(steps([...own, [x.high, ...own[own.length - 1].slice(1)]].map((row) => (finite(row[2]) ? [pen.x(row[0]), pen.y(row[2])] : null))), k, view, name));
      }
      return group;
    },
    read: (at) => [`${count(at)} evaluations`, ...shown.map(({ name, k }) => ({ k, name, value: show(holding(rows.get(name), at, 2)) }))],
  });
}

const axisText = (v, range) => metres(v, roundStep(Math.max(range, 1e-9) / 5));

/** Shares of methods over an axis, as steps. */
function shareChart(host, view, { rows, x, label: said, read }) {
  const shown = shownMethods(view).filter(({ name }) => rows.has(name));
  chart(host, {
    label: said, x, y: { name: "share of runs", low: 0, high: 1.02, show: (v) => `${Math.round(100 * v)} %` },
    draw: (pen, group) => {
      for (const { name, k } of shown) {
        const own = rows.get(name);
        if (!own.length) continue;
        const points = [[x.low, own[0][0] <= x.low ? own[0][1] : 0], ...own.filter((row) => row[0] > x.low), [x.high, own[own.length - 1][1]]];
        group.append(lineOf(steps(points.map((row) => [pen.x(row[0]), pen.y(row[1])])), k, view, name));
      }
      return group;
    },
    read: (at) => [read(at), ...shown.map(({ name, k }) => ({ k, name, value: `${(100 * (holding(rows.get(name), at) || 0)).toFixed(1)} %` }))],
  });
}

function boundsOf(rows) {
  const places = [...rows.values()].flat().map((row) => row[0]).filter((v) => v > 0);
  const low = Math.min(...places, 1e12);
  return [low, Math.max(...places, low * 1.5)];
}

/** A round time in few letters. */
const brief = (v) => (v >= 0.999 ? `${+v.toPrecision(2)} s` : v >= 0.000999 ? `${+(v * 1e3).toPrecision(2)} ms` : `${+(v * 1e6).toPrecision(2)} \u00b5s`);

const byMethod = (entries) => new Map(list(entries).map((entry) => [entry.method, entry.rows]));

function ecdfChart(host, view, kind) {
  const rows = byMethod(kind === "time" ? view.data.curves.ecdf_time : view.data.curves.ecdf_evaluations.methods);
  const [low, high] = boundsOf(rows);
  const over = kind === "time" ? { x: { name: "time", low: low * 0.8, high: high * 1.25, log: true, show: brief }, read: seconds } : { x: { name: "evaluations", low, high: high * 1.1, log: true }, read: (at) => `${count(at)} evaluations` };
  shareChart(host, view, { rows, label: `Distribution over ${kind}`, ...over });
}

function profileChart(host, view) {
  const rows = byMethod(view.data.curves.profile.methods);
  const [, high] = boundsOf(rows);
  const log = high > 8;
  shareChart(host, view, { rows, label: "Performance profile", x: { name: `${words(view.data.curves.profile.metric)} over the best method's`, low: 1, high: Math.max(1.02, 1 + (high - 1) * 1.06), log }, read: (at) => `within ${at.toFixed(3)} times the best` });
}

/** Growth with the size of the world: points and fitted lines of one measure and group. */
function growthChart(host, view, fits) {
  const own = fits.filter((fit) => !view.hidden.has(fit.method));
  const every = own.flatMap((fit) => fit.points);
  const [xs, ys] = [every.map((p) => p[0]), every.map((p) => p[1]).filter((v) => v > 0)];
  const time = ["cpu", "wall", "plan", "plan_cpu"].includes(fits[0].metric);
  chart(host, {
    label: "Growth with size", left: 58, height: 250, x: { name: "size of the world", low: Math.min(...xs) / 1.1, high: Math.max(...xs) * 1.1, log: true },
    y: { name: words(fits[0].metric), low: Math.min(...ys, 1e12) / 1.3, high: Math.max(...ys, 1e-12) * 1.3, log: true, show: time ? brief : power },
    draw: (pen, group) => {
      for (const fit of own) {
        const k = view.methods.indexOf(fit.method);
        const ends = [Math.min(...fit.points.map((p) => p[0])), Math.max(...fit.points.map((p) => p[0]))];
        group.append(lineOf(ends.map((v) => [pen.x(v), pen.y(fit.factor * v ** fit.exponent)]), k, view, fit.method));
        for (const [px, py] of fit.points) if (py > 0) group.append(drawing("circle", { cx: pen.x(px), cy: pen.y(py), r: 3, fill: ink(k), class: "dot", opacity: view.lit && view.lit !== fit.method ? 0.2 : 0.85 }));
      }
      return group;
    },
  });
}

/** Boxes of a measure per method on one world: quartiles, median, all runs as dots. */
function boxChart(host, view, metric, place) {
  const paint = () => {
    const width = host.clientWidth;
    const rows = shownMethods(view).map((method) => ({ ...method, values: view.valuesOf(place, method.name, metric.name) })).filter((row) => row.values.length);
    if (!width || !rows.length) return host.replaceChildren(make("p", { class: "hint" }, "No certified run has a value."));
    const names = Math.min(width * 0.34, 8 + 6.6 * Math.max(...rows.map(({ name }) => name.length)));
    const [low, high] = span(rows.flatMap((row) => row.values), 0.05);
    const each = 30;
    const pen = { left: names + 10, right: 14, top: 6, bottom: 34, width, height: rows.length * each + 44 };
    const s = scaleOf({ low, high });
    pen.x = (v) => pen.left + s(v) * (width - pen.left - pen.right);
    const svg = drawing("svg", { viewBox: `0 0 ${width} ${pen.height}`, height: pen.height, class: "plot", role: "img", "aria-label": `${metricName(metric)} of all runs on ${place}` });
    const ticks = ticksOf(low, high, (width - pen.left) / 80);
    for (const v of ticks.ticks.filter((t) => t >= low && t <= high)) svg.append(stroke(`M${Math.round(pen.x(v)) + 0.5} ${pen.top}V${pen.height - pen.bottom}`, "rule"), label(pen.x(v), pen.height - pen.bottom + 14, metres(v, ticks.step), { "text-anchor": "middle" }));
    svg.append(label(width - pen.right, pen.height - 4, headed(metric), { "text-anchor": "end", class: "axis" }));
    rows.forEach((row, i) => svg.append(...boxOf(row, pen.top + (i + 0.5) * each, pen, names)));
    host.replaceChildren(svg);
  };
  paint();
  onWidth(host, paint);
}

function boxOf({ name, k, values }, y, pen, names) {
  const sorted = [...values].sort((a, b) => a - b);
  const at = (q) => {
    const place = q * (sorted.length - 1);
    const i = Math.floor(place);
    return sorted[i] + (place - i) * ((sorted[i + 1] ?? sorted[i]) - sorted[i]);
  };
  const [least, q1, middle, q3, most] = [0, 0.25, 0.5, 0.75, 1].map((q) => pen.x(at(q)));
  const most_letters = Math.floor(names / 6.2);
  const shown = name.length > most_letters ? `${name.slice(0, most_letters - 1)}\u2026` : name;
  const dots = sorted.slice(0, 400).map((v, i) => drawing("circle", { cx: pen.x(v).toFixed(1), cy: (y + ((i * 0.618034) % 1 - 0.5) * 12).toFixed(1), r: 1.7, fill: ink(k), opacity: 0.4 }));
  return [
    label(pen.left - 10, y + 4, shown, { "text-anchor": "end", class: "name" }, drawing("title", {}, name)),
    stroke(`M${least} ${y}H${q1}M${q3} ${y}H${most}M${least} ${y - 4}V${y + 4}M${most} ${y - 4}V${y + 4}`, "whisker", { stroke: ink(k) }),
    drawing("rect", { x: q1, y: y - 8, width: Math.max(1, q3 - q1), height: 16, rx: 2, fill: ink(k), "fill-opacity": 0.16, stroke: ink(k), "stroke-width": 1 }),
    ...dots,
    stroke(`M${middle} ${y - 9}V${y + 9}`, "middle", { stroke: ink(k) }),
  ];
}
