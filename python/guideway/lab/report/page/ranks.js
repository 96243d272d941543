// Mean ranks with the critical difference: the diagram of Demsar where there is room, else a ladder; and the paired comparisons.

/** Draws ranks into `host`: methods on an axis of mean ranks, bars join those that are not told apart. */
function rankChart(host, view, data) {
  const paint = () => {
    const width = host.clientWidth;
    if (!width) return;
    const order = data.methods.map((name, i) => ({ name, rank: data.ranks[i], k: view.methods.indexOf(name) })).sort((a, b) => a.rank - b.rank);
    const side = 44 + 6.6 * Math.max(...order.map(({ name }) => name.length));
    const wide = width - 2 * side >= 170 && order.length <= 16;
    host.replaceChildren(wide ? classic(order, data, width, side) : ladder(order, data, width));
  };
  paint();
  onWidth(host, paint);
}

const rankText = (rank) => rank.toFixed(2);
const groupSpans = (order, data) => list(data.groups).map((names) => names.map((name) => order.findIndex((one) => one.name === name)).filter((i) => i >= 0)).filter((places) => places.length > 1).map((places) => [Math.min(...places), Math.max(...places)]);

function classic(order, data, width, side) {
  const n = order.length;
  const half = Math.ceil(n / 2);
  const [left, right] = [side, width - side];
  const x = (rank) => left + ((rank - 1) / Math.max(1, n - 1)) * (right - left);
  const spans = groupSpans(order, data);
  const axis = 46;
  const under = axis + 14 + spans.length * 9;
  const height = under + half * 22 + 12;
  const svg = drawing("svg", { viewBox: `0 0 ${width} ${height}`, height, class: "plot ranks", role: "img", "aria-label": rankWords(order, data) });
  svg.append(stroke(`M${left} ${axis}H${right}`, "spine"));
  for (let r = 1; r <= n; r += 1) svg.append(stroke(`M${x(r)} ${axis}v-6`, "spine"), label(x(r), axis - 10, String(r), { "text-anchor": "middle" }));
  if (finite(data.critical_difference)) {
    const end = x(1) + (data.critical_difference / Math.max(1, n - 1)) * (right - left);
    svg.append(stroke(`M${left} 16H${end}M${left} 12v8M${end} 12v8`, "spine"), label(end + 8, 20, `critical difference ${data.critical_difference.toFixed(2)}`, { class: "axis" }));
  }
  order.forEach((one, i) => {
    const near = i < half;
    const y = under + (near ? i : n - 1 - i) * 22 + 10;
    const edge = near ? left - 22 : right + 22;
    svg.append(stroke(`M${x(one.rank)} ${axis}V${y}H${edge}`, "elbow", { stroke: ink(one.k) }), drawing("circle", { cx: x(one.rank), cy: axis, r: 3.5, fill: ink(one.k) }));
    svg.append(label(near ? edge - 6 : edge + 6, y + 4, one.name, { "text-anchor": near ? "end" : "start", class: "name" }), label(near ? edge + 3 : edge - 3, y - 3, rankText(one.rank), { "text-anchor": near ? "start" : "end" }));
  });
  spans.forEach(([a, b], i) => svg.append(stroke(`M${x(order[a].rank) - 4} ${axis + 10 + i * 9}H${x(order[b].rank) + 4}`, "group")));
  return svg;
}

function ladder(order, data, width) {
  const n = order.length;
  const spans = groupSpans(order, data);
  const names = Math.min(width * 0.46, 8 + 6.6 * Math.max(...order.map(({ name }) => name.length)));
  const [left, right] = [names + 12, width - 14 - 8 * spans.length];
  const x = (rank) => left + ((rank - 1) / Math.max(1, n - 1)) * (right - left - 30);
  const height = n * 24 + 36;
  const svg = drawing("svg", { viewBox: `0 0 ${width} ${height}`, height, class: "plot ranks", role: "img", "aria-label": rankWords(order, data) });
  const y = (i) => 14 + i * 24;
  order.forEach((one, i) => svg.append(label(left - 10, y(i) + 4, one.name, { "text-anchor": "end", class: "name" }), stroke(`M${left} ${y(i)}H${x(one.rank)}`, "elbow", { stroke: ink(one.k) }), drawing("circle", { cx: x(one.rank), cy: y(i), r: 4, fill: ink(one.k) }), label(x(one.rank) + 8, y(i) + 4, rankText(one.rank))));
  spans.forEach(([a, b], i) => svg.append(stroke(`M${width - 8 - 8 * i} ${y(a) - 6}V${y(b) + 6}`, "group")));
  svg.append(label(left, height - 8, `mean rank${finite(data.critical_difference) ? `; critical difference ${data.critical_difference.toFixed(2)}` : ""}`, { class: "axis" }));
  return svg;
}

const rankWords = (order, data) => `Mean ranks of ${words(data.metric)}: ${order.map((one) => `${one.name} ${rankText(one.rank)}`).join(", ")}`;

/** What Friedman's test says, in a sentence. */
function friedmanWords(data) {
  const base = `${plural(data.blocks, "block")}: ${data.blocks_are}.`;
  if (!finite(data.p)) return `${base} Fewer than three methods or two blocks: no test.`;
  return `Friedman p ${data.p < 1e-4 ? "" : "= "}${pValue(data.p)} over ${base} Bars join methods that Nemenyi's test does not tell apart (5 %).`;
}

/** Paired comparisons of one measure and place as a table. */
function comparisonTable(rows) {
  const head = ["Pair", "Pairs", "Better", "Equal", "Worse", "Median difference", "p (Holm)", "A12"];
  const body = rows.map((row) => {
    const sure = finite(row.p_holm) && row.p_holm < 0.05;
    const better = sure ? (row.wins > row.losses ? "good" : "bad") : "";
    const cells = [row.pairs, row.wins, row.ties, row.losses].map((v) => make("td", { class: "n" }, count(v)));
    const pair = make("td", { class: "duo" }, make("b", {}, row.method), " and ", row.other, row.same_model ? null : make("span", { class: "tag warn", title: "Their models differ (such as lattice and any angle), and so do the optima" }, "other model"));
    return make("tr", { class: better }, pair, ...cells, make("td", { class: "n" }, finite(row.difference) ? show(row.difference) : "\u2013"), make("td", { class: "n p" }, pValue(row.p_holm)), make("td", { class: "effect" }, effect(row.a12)));
  });
  return make("div", { class: "wide" }, make("table", { class: "facts-table" }, make("thead", {}, make("tr", {}, ...head.map((text, i) => make("th", { class: i ? "n" : "", scope: "col" }, text)))), make("tbody", {}, ...body)));
}

/** A12 as a bar from the middle: right is where the first is better. */
function effect(value) {
  if (!finite(value)) return make("span", {}, "\u2013");
  const bar = make("i", {});
  bar.style.left = `${100 * Math.min(value, 0.5)}%`;
  bar.style.width = `${100 * Math.abs(value - 0.5)}%`;
  return make("span", { class: "a12" }, make("span", { class: "bar" }, bar), make("span", {}, value.toFixed(2)));
}
