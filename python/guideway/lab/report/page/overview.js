// All experiments with their claims.

/** Name of a source, in full or up to its colon. */
const sourceName = (data, key, whole) => {
  const found = list(data.sources).find(([name]) => name === key);
  return found ? (whole ? found[1] : found[1].split(":")[0]) : key;
};

function tally(experiments) {
  const counts = { holds: 0, "does not hold": 0, "cannot be judged": 0 };
  for (const { claims } of experiments) for (const claim of claims) counts[claim.verdict] = (counts[claim.verdict] || 0) + 1;
  return counts;
}

function showOverview(host, data, go) {
  const counts = tally(data.experiments);
  const runs = data.experiments.reduce((sum, e) => sum + e.runs.recorded, 0);
  const alarms = data.experiments.reduce((sum, e) => sum + e.alarms.length, 0);
  let wanted = "all";
  const tile = (value, text, tone) => make("div", { class: `tile ${tone || ""}` }, make("b", {}, count(value)), make("span", {}, text));
  const tiles = make("div", { class: "tiles" }, tile(data.experiments.length, data.experiments.length === 1 ? "experiment" : "experiments"), tile(runs, runs === 1 ? "run" : "runs"), ...Object.entries(counts).filter(() => data.experiments.some((e) => e.claims.length)).map(([name, n]) => tile(n, `${n === 1 ? "claim" : "claims"}: ${name}`, VERDICTS[name].tone)), ...(alarms ? [tile(alarms, "better than the optimum: alarm", "bad")] : []));
  const area = make("div", {});
  const paint = () => area.replaceChildren(...list(data.sources).flatMap(([key, name]) => {
    const kept = data.experiments.filter((e) => e.source === key && (wanted === "all" || e.claims.some((claim) => claim.verdict === wanted)));
    return kept.length ? [make("h3", { class: "source" }, name), make("div", { class: "rows" }, ...kept.map((e) => rowOf(e, wanted, go)))] : [];
  }));
  const total = Object.values(counts).reduce((a, b) => a + b, 0);
  const filter = total ? switches("Claims", [["all", "everything"], ...Object.keys(counts).filter((name) => counts[name]).map((name) => [name, `${name} (${counts[name]})`])], wanted, (value) => { wanted = value; paint(); }) : null;
  host.replaceChildren(make("div", { class: "lead" }, make("h2", {}, "All experiments")), tiles, ...(data.experiments.some((e) => e.quick) ? [make("p", { class: "note warn" }, "Some experiments were run in their quick version: fewer seeds, worlds or evaluations. Their verdicts are provisional.")] : []), ...(filter ? [make("div", { class: "tools" }, filter)] : []), area);
  paint();
}

function rowOf(e, wanted, go) {
  const claims = e.claims.filter((claim) => wanted === "all" || claim.verdict === wanted);
  const failed = e.runs.recorded - (e.status.ok || 0);
  const state = [plural(e.runs.recorded, "run") + (e.runs.missing ? ` of ${count(e.runs.expected)}` : ""), failed ? `${count(failed)} failed` : null, e.quick ? "quick version" : null];
  const items = claims.map((claim) => make("li", {}, badge(verdictOf(claim).tone, verdictOf(claim).sign), make("span", {}, claim.says, make("span", { class: "hush" }, `: ${claim.verdict}`))));
  return make("article", { class: "row" },
    make("div", { class: "row-head" }, make("h3", {}, make("a", { href: `#${encodeURIComponent(e.name)}`, onclick: (event) => { event.preventDefault(); go(e.name); } }, e.title)),
      make("p", { class: "meta" }, [e.source === "ours" ? null : [e.source, e.table].filter(Boolean).join(", "), ...state].filter(Boolean).join(" \u00b7 ")),
      e.alarms.length ? make("span", { class: "tag bad" }, `${count(e.alarms.length)} better than the optimum`) : null),
    items.length ? make("ul", { class: "row-claims" }, ...items) : make("p", { class: "hint" }, "No claims."));
}
