// The table of methods and worlds: sortable, each cell opens its runs.

const STATISTICS = [["mean", "mean \u00b1 95 %"], ["median", "median [quartiles]"], ["best", "best"], ["worst", "worst"]];
const SUCCESS = { name: "success", unit: "%", better: "higher", digits: 1 };
const TIME = { name: "time", unit: "", better: "lower", digits: 4 };
const CLOCKS = ["plan_cpu", "cpu", "plan", "wall"];
const MOST_ROWS = 60;

const timesOf = (cell) => CLOCKS.map((name) => record(cell.times)[name]).find(Boolean) || null;

/** The statistics that a cell has of a measure: of success its rate, of time that of the method's own work. */
function statsOf(cell, metric) {
  if (!cell) return null;
  if (metric === SUCCESS) return finite(cell.success.share) ? { mean: 100 * cell.success.share, low: 100 * cell.success.low, high: 100 * cell.success.high, n: cell.n } : null;
  return metric === TIME ? timesOf(cell) : cell.measures[metric.name] || null;
}

const valueOf = (stats, statistic, metric) => {
  if (!stats) return null;
  if (metric === SUCCESS) return stats.mean;
  if (metric === TIME && (statistic === "best" || statistic === "worst")) return statistic === "best" ? stats.least : stats.most;
  return stats[statistic] ?? null;
};

/** A cell's number with its spread, as nodes. */
function figures(stats, statistic, metric) {
  const said = metric === TIME ? seconds : (v) => digitsOf(metric, v);
  const main = make("b", {}, said(valueOf(stats, statistic, metric)));
  if (metric === SUCCESS) return [main, make("span", { class: "spread" }, ` ${stats.low.toFixed(0)}\u2013${stats.high.toFixed(0)}`)];
  if (statistic === "mean" && stats.rate && !stats.worlds) return [main, make("span", { class: "spread" }, ` [${said(stats.low)}, ${said(stats.high)}]`)];
  if (statistic === "mean" && finite(stats.high) && stats.high > stats.mean && metric !== TIME && !stats.worlds) return [main, make("span", { class: "spread" }, ` \u00b1 ${digitsOf(metric, stats.high - stats.mean)}`)];
  if (statistic === "median" && finite(stats.q1) && stats.q3 > stats.q1) return [main, make("span", { class: "spread" }, ` [${said(stats.q1)}, ${said(stats.q3)}]`)];
  return [main];
}

/** Builds the table into `host`. */
function makeResults(host, view) {
  const wide = view.places.length > Math.max(8, view.methods.length);
  let [metric, statistic, sorted, down, whole] = [view.metrics[0] || SUCCESS, "mean", null, false, false];
  const scroller = make("div", { class: "wide tall-table" });
  const every = [...view.metrics, SUCCESS, TIME];
  const bar = make("div", { class: "tools" },
    switches("Measure", every.map((m, i) => [i, m === TIME ? "computing time" : metricName(m)]), 0, (i) => { metric = every[i]; sorted = null; paint(); }),
    chooser("Statistic", STATISTICS, statistic, (value) => { statistic = value; paint(); }));
  host.replaceChildren(bar, scroller);

  const many = view.places.length > 1;
  const cellAt = (row, column) => (wide ? view.cell(row, column) : view.cell(column, row));
  const all = many ? [{ all: true, name: "all" }] : [];
  const rows = () => (wide ? view.places.map((name) => ({ name })) : shownMethods(view).map(({ name, k }) => ({ name, k })));
  const columns = () => (wide ? shownMethods(view).map(({ name, k }) => ({ name, k })) : [...view.places.map((name) => ({ name })), ...all]);
  const statsAt = (row, column) => (column.all ? meanOf(view.overall.get(row.name)) : row.all ? meanOf(view.overall.get(column.name)) : statsOf(cellAt(row.name, column.name), metric));
  /** Over all worlds only the mean is told: worlds are no repetitions of each other. */
  const meanOf = (all_) => {
    const stats = statsOf(all_, metric);
    return stats && metric !== SUCCESS && metric !== TIME ? { ...stats, worlds: true } : stats;
  };

  const ordered = () => {
    const given = rows();
    if (sorted !== null && columns()[sorted]) {
      const column = columns()[sorted];
      const key = (row) => valueOf(statsAt(row, column), column.all ? "mean" : statistic, metric) ?? Infinity * (down ? -1 : 1);
      given.sort((a, b) => (down ? key(b) - key(a) : key(a) - key(b)));
    }
    return wide && many ? [{ all: true, name: "mean of all worlds" }, ...given] : given;
  };

  /** Best values, per place: the best row of a column, or the best column of a row. */
  const bestOf = (place) => {
    if (!metric.better) return null;
    const whole_ = (cell) => place !== null || !cell || metric === SUCCESS || metric === TIME || record(cell.measures[metric.name]).n === cell.instances;
    const cells = shownMethods(view).map(({ name }) => (place === null ? view.overall.get(name) : view.cell(place, name))).filter(whole_);
    const optima = new Set(cells.filter((cell) => cell && finite(cell.optimum)).map((cell) => cell.optimum.toPrecision(9)));
    if ((optima.size > 1 || (place === null && view.mixed)) && metric.name === view.data.reference) return null;
    const values = cells.map((cell) => valueOf(statsOf(cell, metric), place === null ? "mean" : statistic, metric)).filter(finite);
    if (values.length < 2 || Math.max(...values) === Math.min(...values)) return null;
    return metric.better === "lower" ? Math.min(...values) : Math.max(...values);
  };

  const paint = () => {
    const heads = columns();
    const lines = ordered();
    const kept = whole ? lines : lines.slice(0, MOST_ROWS);
    const best = new Map([null, ...view.places].map((place) => [place, bestOf(place)]));
    const head = make("tr", {}, make("th", { scope: "col", class: "corner" }, wide ? "World" : "Method"), ...heads.map((column, i) => make("th", { scope: "col", "aria-sort": sorted === i ? (down ? "descending" : "ascending") : "none" },
      make("button", { type: "button", class: "sort", onclick: () => sort(i) }, column.k === undefined ? null : swatch(column.k), column.all ? "mean of all worlds" : column.name))));
    const body = kept.map((row) => make("tr", {}, make("th", { scope: "row", class: row.name.length > 36 ? "long" : null }, row.k === undefined ? null : swatch(row.k), row.name), ...heads.map((column) => entry(row, column, best))));
    const caption = make("caption", { class: "hush" }, `${metric === TIME ? "computing time" : metricName(metric)} of ${view.data.title}`);
    const rest = lines.length > kept.length ? make("button", { type: "button", class: "more", onclick: () => { whole = true; paint(); } }, `Show all ${lines.length} rows`) : null;
    scroller.replaceChildren(make("table", { class: "grid" }, caption, make("thead", {}, head), make("tbody", {}, ...body)), ...(rest ? [rest] : []));
  };

  const sort = (i) => {
    [sorted, down] = sorted === i ? (down ? [null, false] : [i, true]) : [i, metric.better === "higher"];
    paint();
    const button = scroller.querySelectorAll("thead .sort")[i];
    if (button) button.focus();
  };

  const entry = (row, column, best) => {
    const stats = statsAt(row, column);
    const place = column.all || row.all ? null : wide ? row.name : column.name;
    const method = wide ? column.name : row.name;
    const cell = place === null ? view.overall.get(method) : view.cell(place, method);
    if (!cell) return make("td", { class: "void" }, "\u2013");
    const part = place === null && stats && stats.worlds && stats.n < cell.instances;
    const top = !part && finite(best.get(place)) && valueOf(stats, place === null ? "mean" : statistic, metric) === best.get(place);
    const how = place === null ? "mean" : statistic;
    const lines = [make("span", { class: `figure${top ? " winner" : ""}` }, ...(stats && finite(valueOf(stats, how, metric)) ? figures(stats, how, metric) : [make("b", {}, "\u2013")])), ...(part ? [make("span", { class: "tag warn" }, `${stats.n} of ${plural(cell.instances, "world")}`)] : []), ...notes(cell, place, method)];
    if (place === null) return make("td", { class: "overall" }, ...lines);
    return make("td", {}, make("button", { type: "button", class: "cell", "aria-label": `${method} on ${place}: the runs`, onclick: () => openRuns(view, place, method) }, ...lines));
  };

  /** What stands below a number: failures, gap, the figure in print. */
  const notes = (cell, place, method) => {
    const out = [];
    const { failed, n } = cell;
    if (failed > 0) out.push(make("span", { class: `tag ${failed < n ? "warn" : "bad"}` }, `${failed} of ${n} failed`));
    if (metric.name === view.data.reference && metric !== SUCCESS && cell.measures.gap && place !== null) out.push(make("span", { class: "under" }, `gap ${gapText(view, cell.measures.gap.mean)}`));
    for (const print of place === null ? [] : view.printed(place, method, metric.name)) out.push(make("span", { class: "under print", title: `${print.table}: ${print.statistic}` }, `printed ${digitsOf(metric, print.value)}${print.statistic === "mean" ? "" : ` (${print.statistic})`}`));
    return out;
  };

  paint();
  return { paint };
}

const swatch = (k) => {
  const mark = drawing("svg", { viewBox: "0 0 16 4", class: "swatch line", "aria-hidden": "true" }, drawing("path", { d: "M0 2H16", stroke: ink(k), "stroke-width": 3, "stroke-dasharray": dash(k) }));
  return mark;
};

/** A gap in percent, whatever the unit of the records. */
function gapText(view, value) {
  if (!finite(value)) return "\u2013";
  const share = view.gapUnit === "%" ? value : 100 * value;
  return `${minus(share.toFixed(Math.abs(share) < 10 ? 2 : 1))} %`;
}
