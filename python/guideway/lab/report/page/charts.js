// Charts as SVG: a frame with linear or logarithmic axes, lines, bands and steps; drawn anew when the width changes.

/** Round ticks of a logarithmic axis. */
function powersOf(low, high, most) {
  const [from, to] = [Math.floor(Math.log10(low) + 1e-9), Math.ceil(Math.log10(high) - 1e-9)];
  const every = Math.max(1, Math.ceil((to - from + 1) / most));
  const parts = to - from <= 1 ? [1, 2, 3, 5, 7] : to - from <= 2 ? [1, 2, 5] : [1];
  const ticks = [];
  for (let k = from; k <= to; k += every) for (const part of every === 1 ? parts : [1]) ticks.push(part * 10 ** k);
  return ticks.filter((v) => v >= low * (1 - 1e-9) && v <= high * (1 + 1e-9));
}

/** Maps a value to 0..1 on an axis { low, high, log }. */
function scaleOf({ low, high, log }) {
  if (!log) return (v) => (high > low ? (v - low) / (high - low) : 0.5);
  const [a, b] = [Math.log(low), Math.log(high)];
  return (v) => (b > a ? (Math.log(Math.max(v, low * 1e-3)) - a) / (b - a) : 0.5);
}

/** A chart of `spec` in `host`: { x, y: axes with name, low, high, log, show }, height, draw(pen), label, read(x) }. */
function chart(host, spec) {
  const paint = () => {
    const width = host.clientWidth;
    if (!width) return;
    const height = spec.height || 230;
    const size = { width, height, left: spec.left || 50, right: 12, top: 20, bottom: 34 };
    const [sx, sy] = [scaleOf(spec.x), scaleOf(spec.y)];
    const pen = { ...size, x: (v) => size.left + sx(v) * (width - size.left - size.right), y: (v) => height - size.bottom - sy(v) * (height - size.top - size.bottom) };
    const svg = drawing("svg", { viewBox: `0 0 ${width} ${height}`, height, class: "plot", role: "img", "aria-label": spec.label });
    svg.append(...axesOf(spec, pen), clip(pen), spec.draw(pen, drawing("g", { "clip-path": `url(#${pen.clip})` })));
    host.replaceChildren(svg);
    if (spec.read) watch(host, svg, spec, pen);
  };
  paint();
  onWidth(host, paint);
  return { paint };
}

let clips = 0;
function clip(pen) {
  clips += 1;
  pen.clip = `clip${clips}`;
  return drawing("clipPath", { id: pen.clip }, drawing("rect", { x: pen.left - 1, y: pen.top - 2, width: Math.max(0, pen.width - pen.left - pen.right + 3), height: pen.height - pen.top - pen.bottom + 4 }));
}

const stroke = (d, kind, more = {}) => drawing("path", { d, class: kind, ...more });
const label = (x, y, text, more = {}) => drawing("text", { x, y, ...more }, text);

function axesOf({ x, y }, pen) {
  const across = x.log ? { ticks: powersOf(x.low, x.high, pen.width / 60) } : ticksOf(x.low, x.high, (pen.width - pen.left) / 90);
  const up = y.log ? { ticks: powersOf(y.low, y.high, pen.height / 34) } : ticksOf(y.low, y.high, pen.height / 42);
  const floor = pen.height - pen.bottom;
  const inside = (axis) => (v) => v >= axis.low - 1e-9 * Math.abs(axis.low) && v <= axis.high + 1e-9 * Math.abs(axis.high);
  const said = (axis, all) => axis.show || ((v) => (axis.log ? power(v) : metres(v, all.step)));
  const out = [];
  for (const v of up.ticks.filter(inside(y))) out.push(stroke(`M${pen.left} ${Math.round(pen.y(v)) + 0.5}H${pen.width - pen.right}`, "rule"), label(pen.left - 7, pen.y(v) + 3.5, said(y, up)(v), { "text-anchor": "end" }));
  let last = -99;
  for (const v of across.ticks.filter(inside(x))) {
    const text = said(x, across)(v);
    out.push(stroke(`M${Math.round(pen.x(v)) + 0.5} ${pen.top}V${floor}`, "rule"));
    if (pen.x(v) - last < 12 + 6 * text.length) continue;
    last = pen.x(v);
    out.push(label(clamp(last, pen.left, pen.width - pen.right - 3 * text.length), floor + 14, text, { "text-anchor": "middle" }));
  }
  out.push(stroke(`M${pen.left} ${floor + 0.5}H${pen.width - pen.right}`, "zero"), label(pen.width - pen.right, pen.height - 4, x.name, { "text-anchor": "end", class: "axis" }));
  if (y.name) out.push(label(4, 10, y.name, { class: "axis" }));
  return out;
}

/** A line through points in pixels; null breaks it. */
const through = (points) => points.reduce(([d, open], p) => (p ? [`${d}${open ? "L" : "M"}${p[0].toFixed(1)} ${p[1].toFixed(1)}`, true] : [d, false]), ["", false])[0];

/** Points of steps: each value holds until the next place. */
const steps = (points) => points.flatMap((p, i) => (p && i + 1 < points.length && points[i + 1] ? [p, [points[i + 1][0], p[1]]] : [p]));

/** A hand that follows the pointer and says what is there. */
function watch(host, svg, spec, pen) {
  const hand = stroke("M0 0", "hand", { visibility: "hidden" });
  const tip = make("div", { class: "tip readout", hidden: true });
  svg.append(hand);
  host.append(tip);
  const invert = (px) => {
    const part = clamp((px - pen.left) / (pen.width - pen.left - pen.right), 0, 1);
    return spec.x.log ? Math.exp(Math.log(spec.x.low) + part * (Math.log(spec.x.high) - Math.log(spec.x.low))) : spec.x.low + part * (spec.x.high - spec.x.low);
  };
  svg.addEventListener("pointermove", (event) => {
    const px = event.clientX - svg.getBoundingClientRect().left;
    const rows = spec.read(invert(px));
    if (!rows || px < pen.left - 4 || px > pen.width - pen.right + 4) return leave();
    hand.setAttribute("d", `M${Math.round(px) + 0.5} ${pen.top}V${pen.height - pen.bottom}`);
    hand.setAttribute("visibility", "visible");
    tip.hidden = false;
    tip.replaceChildren(...rows.map((row) => (typeof row === "string" ? make("b", {}, row) : entryOf(row))));
    const room = tip.offsetWidth + 14;
    tip.style.transform = `translate(${px + room > pen.width ? Math.max(0, px - room) : px + 12}px, ${pen.top}px)`;
  });
  const leave = () => {
    tip.hidden = true;
    hand.setAttribute("visibility", "hidden");
  };
  svg.addEventListener("pointerleave", leave);
}

function entryOf({ k, name, value }) {
  const mark = make("i", {});
  mark.style.background = ink(k);
  return make("div", {}, mark, make("span", {}, name), make("b", {}, value));
}
