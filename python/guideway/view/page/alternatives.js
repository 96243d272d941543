// The set of alternatives of a plan: length against turns, coloured by clearance. Pointing at one shows its path on the map, pressing keeps it there.

const SPREAD = { width: 360, height: 210, left: 38, right: 14, top: 10, bottom: 34 };

/** Alternatives of a result that can be drawn. */
const alternativesOf = (data) => list(data.alternatives).map(record).filter((one) => finite(one.length) && finite(one.turns)).map((one) => ({ ...one, rows: pointsOf(one.grid_path) }));

/** The chart in `host`; `link.show(rows)` draws a path on the map, null takes it away. */
function makeAlternatives(host, link) {
  let [all, pinned, dots, facts] = [[], -1, [], null];

  const near = (one) => (finite(one.min_clearance) ? one.min_clearance : Math.max(0, ...all.map((other) => number(other.min_clearance))));
  const share = (one) => {
    const values = all.map(near);
    const [low, high] = [Math.min(...values), Math.max(...values)];
    return high > low ? (near(one) - low) / (high - low) : 1;
  };
  const colour = (part) => `color-mix(in oklab, var(--accent) ${Math.round(100 * part)}%, var(--mover))`;

  const point = (i) => {
    const one = all[i];
    dots.forEach((dot, k) => dot.classList.toggle("on", k === i));
    dots.forEach((dot, k) => dot.setAttribute("aria-pressed", String(k === pinned)));
    const parts = one ? [["length", `${exact(one.length)} m`], ["turns", String(one.turns)], ["clearance", finite(one.min_clearance) ? `${exact(one.min_clearance)} m` : "no obstacle"], ["energy", exact(one.energy)]] : [];
    facts.replaceChildren(...(one ? parts.map(([name, text]) => make("div", {}, make("dt", {}, capital(name)), make("dd", {}, text))) : [make("div", { class: "hint" }, "Point at an alternative to see its path; press to keep it.")]));
    link.show(one ? one.rows : null);
  };
  const pin = (i) => {
    pinned = pinned === i ? -1 : i;
    point(pinned);
  };

  const scales = () => {
    const [lengths, turns] = [all.map((one) => one.length), all.map((one) => one.turns)];
    const room = (values, least) => Math.max(least, 0.06 * (Math.max(...values) - Math.min(...values)));
    const [x0, x1] = [Math.min(...lengths) - room(lengths, 0.02 * lengths[0] + 1e-3), Math.max(...lengths) + room(lengths, 0.02 * lengths[0] + 1e-3)];
    const [y0, y1] = [Math.max(-0.5, Math.min(...turns) - room(turns, 0.6)), Math.max(...turns) + room(turns, 0.6)];
    const { width, height, left, right, top, bottom } = SPREAD;
    return { x0, x1, y0, y1, x: (v) => left + ((v - x0) / (x1 - x0)) * (width - left - right), y: (v) => height - bottom - ((v - y0) / (y1 - y0)) * (height - top - bottom) };
  };

  const frame = ({ x0, x1, y0, y1, x, y }) => {
    const { width, height, left, right, top, bottom } = SPREAD;
    const text = (words, at) => drawing("text", at, words);
    const across = ticksOf(x0, x1, 5);
    const up = ticksOf(y0, y1, 5);
    return [
      ...across.ticks.filter((v) => v >= x0 && v <= x1).flatMap((v) => [drawing("path", { d: `M${x(v)} ${top}V${height - bottom}`, class: "rule" }), text(metres(v, across.step), { x: x(v), y: height - bottom + 14, "text-anchor": "middle" })]),
      ...up.ticks.filter((v) => Number.isInteger(v) && v >= y0 && v <= y1).flatMap((v) => [drawing("path", { d: `M${left} ${y(v)}H${width - right}`, class: "rule" }), text(String(v), { x: left - 7, y: y(v) + 3.5, "text-anchor": "end" })]),
      text("length in m", { x: width - right, y: height - 4, "text-anchor": "end" }),
      text("turns", { x: 12, y: (height - bottom + top) / 2, "text-anchor": "middle", transform: `rotate(-90 12 ${(height - bottom + top) / 2})` }),
    ];
  };

  const dotOf = (one, i, scale) => {
    const words = `${exact(one.length)} m, ${one.turns} turns, ${finite(one.min_clearance) ? `${exact(one.min_clearance)} m clear` : "no obstacle near"}`;
    const dot = drawing("circle", { cx: scale.x(one.length), cy: scale.y(one.turns), r: 5.5, fill: "currentColor", tabindex: 0, role: "button", "aria-label": words });
    dot.style.color = colour(share(one));
    dot.addEventListener("pointerenter", () => point(i));
    dot.addEventListener("pointerleave", () => point(pinned));
    dot.addEventListener("focus", () => point(i));
    dot.addEventListener("blur", () => point(pinned));
    dot.addEventListener("click", () => pin(i));
    dot.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      event.stopPropagation();
      pin(i);
    });
    return dot;
  };

  return (data) => {
    const about = record(data.pareto);
    [all, pinned] = [alternativesOf(data), -1];
    host.hidden = !all.length;
    link.show(null);
    if (!all.length) return;
    const scale = scales();
    dots = all.map((one, i) => dotOf(one, i, scale));
    facts = make("dl", { class: "keys choice" });
    const values = all.map((one) => one.min_clearance).filter(finite);
    const ramp = values.length && Math.max(...values) > Math.min(...values) ? make("div", { class: "ramp choice" }, `${exact(Math.min(...values))} m clear`, make("i", {}), `${exact(Math.max(...values))} m`) : null;
    const note = about.complete === true ? `All ${all.length} lattice paths of which none is better in every respect.` : `${all.length} lattice paths; the search ended before the set was complete.`;
    const chart = drawing("svg", { viewBox: `0 0 ${SPREAD.width} ${SPREAD.height}`, class: "spread", role: "group", "aria-label": "Alternatives: length against turns" }, ...frame(scale), ...dots);
    host.replaceChildren(make("h2", {}, "Alternatives"), make("p", { class: "words" }, note), chart, ...(ramp ? [ramp] : []), facts);
    point(-1);
  };
}
