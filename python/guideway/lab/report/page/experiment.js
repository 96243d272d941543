// One experiment: its claims, the table, the charts, comparisons, and what was run where.

/** What the parts of the page ask of an experiment. */
function viewOf(data, worlds) {
  const methods = [...new Set(data.cells.map((cell) => cell.method))];
  const places = [...new Set(data.cells.map((cell) => placeName(cell.world, cell.query)))];
  const index = new Map(data.cells.map((cell, i) => [`${placeName(cell.world, cell.query)}\u0000${cell.method}`, i]));
  const metrics = data.metrics.filter((metric) => metric.first && metric.name !== "success");
  const gap = data.metrics.find((metric) => metric.name === "gap");
  return {
    data, worlds, methods, places, index, hidden: new Set(), lit: null,
    metrics: metrics.length ? metrics : data.metrics.slice(0, 3),
    mixed: places.some((place) => new Set(data.cells.filter((cell) => placeName(cell.world, cell.query) === place && finite(cell.optimum)).map((cell) => cell.optimum.toPrecision(9))).size > 1),
    gapUnit: gap ? gap.unit : "",
    overall: new Map(data.overall.map((row) => [row.method, row])),
    cell: (place, method) => data.cells[index.get(`${place}\u0000${method}`)] || null,
    valuesOf: (place, method, name) => {
      const runs = data.drawing.cells[index.get(`${place}\u0000${method}`)];
      return runs ? list(runs.values[name]).filter(finite) : [];
    },
    printed: (place, method, name) => data.published.filter((p) => placeName(p.world, p.query) === place && p.method === method && p.metric === name),
  };
}

function showExperiment(host, data, worlds) {
  const view = viewOf(data, worlds);
  const results = make("div", {});
  const charts = make("div", { class: "charts" });
  const redraw = () => {
    table.paint();
    makeCharts(charts, view);
  };
  host.replaceChildren(
    headOf(data),
    ...warningsOf(data),
    ...(data.claims.length ? [claimsOf(data)] : []),
    section("Results", "A press on a cell shows its runs. Only certified runs are averaged; a run that failed counts in the success rate.", results),
    ...(data.published.length ? [printedTable(view)] : []),
    legendBar(view, redraw),
    charts,
    comparisonsOf(view),
    detailsOf(data),
  );
  const table = makeResults(results, view);
  makeCharts(charts, view);
}

function headOf(data) {
  const { recorded, expected } = data.runs;
  const bad = recorded - (data.status.ok || 0);
  const facts = [data.source === "ours" ? "our own experiment" : [data.source, data.table].filter(Boolean).join(", "), `${plural(recorded, "run")}${recorded === expected ? "" : ` of ${count(expected)}`}`, plural(data.seeds, "seed"), bad ? `${count(bad)} failed` : "all with a result"];
  return make("div", { class: "lead" }, make("h2", {}, data.title), make("p", { class: "meta" }, facts.filter(Boolean).join(" \u00b7 ")));
}

function warningsOf(data) {
  const out = [];
  if (data.alarms.length) {
    const worst = data.alarms.reduce((a, b) => (b.gap < a.gap ? b : a));
    out.push(make("p", { class: "note bad alarm", role: "alert" }, make("b", {}, `Alarm: ${plural(data.alarms.length, "run")} better than the proved optimum.`), ` The checker or the reference is wrong. Worst: ${worst.method} on ${placeName(worst.world, worst.query)}, seed ${worst.seed}, gap ${(100 * worst.gap).toExponential(2)} %.`));
  }
  if (data.quick) out.push(make("p", { class: "note warn" }, "Quick version: fewer seeds, worlds or evaluations than the experiment asks for. Verdicts are provisional."));
  if (data.runs.missing) out.push(make("p", { class: "note warn" }, `${plural(data.runs.missing, "run")} of ${count(data.runs.expected)} not done yet; guideway lab run goes on with --resume.`));
  if (data.digests.length > 1 || data.runs.unknown || data.runs.stale) out.push(make("p", { class: "note warn" }, `${data.runs.stale === data.runs.recorded ? "The" : "Some"} records come from another version of the experiment's file, or of a map or planner that it names.`));
  return out;
}

function claimsOf(data) {
  const item = (claim) => {
    const { tone, sign: kind, name } = verdictOf(claim);
    return make("li", { class: "claim" }, badge(tone, kind), make("div", {}, make("p", { class: "says" }, claim.says, claim.table ? make("span", { class: "where" }, ` ${claim.table}`) : null), becauseOf(claim, tone, name)));
  };
  return section("Claims", null, make("ul", { class: "claims" }, ...data.claims.map(item)));
}

/** Why: a sentence, or one for each method of a comparison. */
function becauseOf(claim, tone, name) {
  const rows = list(record(claim.numbers).comparisons);
  const word = make("b", { class: `${tone} word` }, name);
  if (rows.length < 2) return make("p", { class: "because" }, word, ` \u2014 ${claim.reason}`);
  const item = (row) => make("li", {}, make("b", {}, row.than), ": ", row.verdict === claim.verdict ? null : make("span", { class: `${verdictOf(row).tone} word` }, `${row.verdict}; `), row.reason);
  return make("div", { class: "because" }, word, make("ul", {}, ...rows.map(item)));
}

/** Figures in print beside ours. */
function printedTable(view) {
  const rows = view.data.published.map((p) => {
    const metric = view.data.metrics.find((m) => m.name === p.metric) || { name: p.metric, unit: "", digits: 4 };
    const off = finite(p.ours) && p.value !== 0 ? (100 * (p.ours - p.value)) / Math.abs(p.value) : null;
    return make("tr", {}, make("td", {}, p.table), make("td", {}, placeName(p.world, p.query)), make("td", {}, p.method), make("td", {}, `${headed(metric)} (${p.statistic})`), make("td", { class: "n" }, digitsOf(metric, p.value)), make("td", { class: "n" }, make("b", {}, digitsOf(metric, p.ours))), make("td", { class: "n" }, finite(off) ? minus(`${off > 0 ? "+" : ""}${off.toFixed(Math.abs(off) < 10 ? 2 : 0)} %`) : "\u2013"));
  });
  const head = ["Table", "World", "Method", "Measure", "In print", "Here", "Difference"].map((text, i) => make("th", { scope: "col", class: i > 3 ? "n" : "" }, text));
  const table = make("div", { class: "wide" }, make("table", { class: "facts-table" }, make("thead", {}, make("tr", {}, ...head)), make("tbody", {}, ...rows)));
  const more = make("details", { class: "fold", open: rows.length <= 12 }, make("summary", {}, `${plural(rows.length, "figure")} in print beside ours`), table);
  return make("section", { class: "block" }, more);
}

/** The methods as a legend that switches them on and off. */
function legendBar(view, redraw) {
  const bar = make("div", { class: "chips legend-bar", role: "group", "aria-label": "Methods shown" });
  const paint = () => bar.replaceChildren(...view.methods.map((name, k) => make("button", { type: "button", "aria-pressed": String(!view.hidden.has(name)), onclick: () => {
    if (view.hidden.has(name)) view.hidden.delete(name);
    else if (view.hidden.size + 1 < view.methods.length) view.hidden.add(name);
    paint();
    redraw();
    bar.children[k].focus();
  } }, swatch(k), name)));
  paint();
  return make("div", { class: "sticky" }, bar);
}

function makeCharts(host, view) {
  const { curves, ranks, growth } = view.data;
  const figures = [];
  const figure_ = (title, note, build, choices) => {
    const area = make("div", { class: "area" });
    const state = { value: choices && choices.length ? choices[0][0] : null };
    const pick = choices ? chooser(choices.label || "World", choices, view.kept[title] || state.value, (value) => { view.kept[title] = value; build(area, value); }) : null;
    figures.push({ node: make("figure", { class: "card" }, make("figcaption", {}, make("h3", {}, title), pick), area, note ? make("p", { class: "hint" }, note) : null), start: () => build(area, view.kept[title] || state.value) });
  };
  view.kept = view.kept || {};
  const withCurves = [...new Set(list(curves.convergence).map((c) => placeName(c.world, c.query)))].map((p) => [p, p]);
  if (withCurves.length) figure_("Convergence", "Best value so far: median of the certified runs, quartiles tinted.", (area, place) => convergenceChart(area, view, place), withCurves);
  if (list(curves.ecdf_evaluations.methods).length) figure_("Targets reached over evaluations", `Share of runs and ${curves.ecdf_evaluations.targets.length} targets (gaps of 50 % to 0.0001 % to the ${curves.ecdf_evaluations.reference === "exact" ? "exact optimum" : "best value found"}).`, (area) => ecdfChart(area, view, "evaluations"));
  if (list(curves.ecdf_time).length) figure_("Solved over time", "Share of runs with a certified result; processor time, of one machine.", (area) => ecdfChart(area, view, "time"));
  const spread = view.metrics.filter((metric) => !view.data.cells.some((cell) => cell.measures[metric.name] && cell.measures[metric.name].rate));
  const boxes = spread.flatMap((metric) => view.places.slice(0, 200).map((place) => [`${metric.name}\u0000${place}`, view.places.length > 1 ? `${metricName(metric)} \u00b7 ${place}` : metricName(metric)]));
  if (boxes.length) figure_("Spread over the seeds", "Box: quartiles and median; whiskers: extremes; dots: runs.", (area, key) => boxChart(area, view, view.metrics.find((m) => m.name === key.split("\u0000")[0]), key.split("\u0000")[1]), Object.assign(boxes, { label: "Measure" }));
  if (ranks.length) figure_("Ranks", null, (area, key) => {
    const data = ranks.find((one) => one.metric === key);
    const chartArea = make("div", {});
    area.replaceChildren(chartArea, make("p", { class: "hint" }, friedmanWords(data)));
    rankChart(chartArea, view, data);
  }, Object.assign(ranks.map((one) => [one.metric, words(one.metric)]), { label: "Measure" }));
  if (curves.profile) figure_("Performance profile", `Share of ${plural(curves.profile.problems, "problem")} (world, query, seed) that a method solves within a factor of the best.`, (area) => profileChart(area, view));
  const fits = new Map();
  for (const fit of growth) fits.set(`${fit.metric}\u0000${fit.group}`, [...(fits.get(`${fit.metric}\u0000${fit.group}`) || []), fit]);
  if (fits.size) figure_("Growth with size", null, (area, key) => {
    const chartArea = make("div", {});
    area.replaceChildren(chartArea, growthTable(view, fits.get(key)));
    growthChart(chartArea, view, fits.get(key));
  }, Object.assign([...fits.keys()].map((key) => [key, key.split("\u0000").map(words).filter(Boolean).join(" \u00b7 ")]), { label: "Measure" }));
  host.replaceChildren(...figures.map(({ node }) => node));
  figures.forEach(({ start }) => start());
}

function growthTable(view, fits) {
  const rows = fits.filter((fit) => !view.hidden.has(fit.method)).map((fit) => make("tr", {}, make("td", {}, swatch(view.methods.indexOf(fit.method)), ` ${fit.method}`), make("td", { class: "n" }, make("b", {}, fit.exponent.toFixed(2)), finite(fit.low) ? make("span", { class: "spread" }, ` [${minus(fit.low.toFixed(2))}, ${minus(fit.high.toFixed(2))}]`) : null), make("td", { class: "n" }, finite(fit.r2) ? fit.r2.toFixed(3) : "\u2013")));
  return make("table", { class: "facts-table" }, make("thead", {}, make("tr", {}, make("th", { scope: "col" }, "value = c size^p"), make("th", { scope: "col", class: "n" }, "p [95 %]"), make("th", { scope: "col", class: "n" }, "R\u00b2"))), make("tbody", {}, ...rows));
}

function comparisonsOf(view) {
  const rows = view.data.comparisons;
  if (!rows.length) return make("section", { hidden: true });
  const area = make("div", {});
  const metrics = [...new Set(rows.map((row) => row.metric))];
  const places = [["", "all worlds"], ...new Map(rows.filter((row) => row.world !== null).map((row) => [placeName(row.world, row.query), true])).keys()].map((p) => (Array.isArray(p) ? p : [p, p]));
  let [metric, place] = [metrics[0], ""];
  const paint = () => area.replaceChildren(comparisonTable(rows.filter((row) => row.metric === metric && (row.world === null ? "" : placeName(row.world, row.query)) === place)), ...(place === "" ? successTable(view.data.paired_success) : []));
  const bar = make("div", { class: "tools" }, switches("Measure", metrics.map((name) => [name, words(name)]), metric, (value) => { metric = value; paint(); }), chooser("Where", places, place, (value) => { place = value; paint(); }));
  paint();
  const note = "Wilcoxon's signed ranks of runs on the same world, query and seed, two sided, corrected by Holm; A12: how probably the first is better. Where neither depends on the seed, a world is one pair.";
  return make("section", { class: "block" }, make("details", { class: "fold", open: rows.length <= 24 }, make("summary", {}, "Paired comparisons"), make("p", { class: "hint" }, note), bar, area));
}

function successTable(rows) {
  if (!rows.length) return [];
  const head = ["Success", "Pairs", "Only the first", "Only the other", "p (McNemar, Holm)"].map((text, i) => make("th", { scope: "col", class: i ? "n" : "" }, text));
  const body = rows.map((row) => make("tr", {}, make("td", { class: "duo" }, make("b", {}, row.method), " and ", row.other), ...[row.pairs, row.only_method, row.only_other].map((v) => make("td", { class: "n" }, count(v))), make("td", { class: "n" }, pValue(row.p_holm))));
  return [make("div", { class: "wide" }, make("table", { class: "facts-table" }, make("thead", {}, make("tr", {}, ...head)), make("tbody", {}, ...body)))];
}

function detailsOf(data) {
  const rows = [["command", make("code", {}, data.command)], ["kind", data.kind], ["budget", plain(data.budget) || "none"], ["limits", plain(data.limits)], ["runs", Object.entries(data.status).map(([name, n]) => `${count(n)} ${name}`).join(", ")], ["Guideway", data.versions.join(", ")], ["digest", data.digests.map((d) => d.slice(0, 12)).join(", ")], ...data.machines.map((machine) => ["machine", plain(machine)])];
  const facts = make("dl", { class: "pairs" }, ...rows.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)]));
  const file = data.text ? make("details", { class: "fold inner" }, make("summary", {}, "The experiment's file"), make("pre", { class: "file", tabindex: 0 }, data.text)) : null;
  return section("Details", null, facts, file);
}
