// The phase plane: path speed over the place along the path, below the curve that no motion exceeds. Units: rad, rad/s.

const joined = (xs, ys, x, y) => {
  let [text, open] = ["", false];
  for (let i = 0; i < xs.length; i += 1) {
    if (!finite(ys[i]) || !finite(xs[i])) {
      open = false;
      continue;
    }
    text += `${open ? "L" : "M"}${x(xs[i]).toFixed(1)} ${y(ys[i]).toFixed(1)}`;
    open = true;
  }
  return text;
};

const push2 = (xs, ys, x, y) => {
  xs.push(x);
  ys.push(y);
};
const label = (x, y, text, attributes = {}) => drawing("text", { x, y, ...attributes }, text);
const stroked = (d, kind, more = {}) => drawing("path", { d, class: kind, ...more });
const jointInk = (joint) => (joint === null || joint === undefined ? "var(--soft)" : `var(--joint-${joint % 8})`);
const tryInk = (k, count) => `color-mix(in oklab, var(--accent) ${Math.round(22 + (78 * k) / Math.max(1, count - 1))}%, var(--surface))`;

/** A line of a legend. */
const keyOf = (kind, text, more = {}) => make("span", {}, drawing("svg", { viewBox: "0 0 24 9" }, stroked("M0 4.5H24", kind, more)), text);

/** A chart's frame: ticks, rules and the names of both axes. */
function frameOf({ width, height, left, right, top, bottom, x, y, xs, ys, nameX, nameY }) {
  const floor = height - bottom;
  return [
    ...ys.ticks.filter((v) => y(v) >= top - 0.5 && y(v) <= floor + 0.5).flatMap((v) => [stroked(`M${left} ${Math.round(y(v)) + 0.5}H${width - right}`, v === 0 ? "zero" : "rule"), label(left - 6, clamp(y(v), top + 4, floor) + 3.5, metres(v, ys.step), { "text-anchor": "end" })]),
    ...xs.ticks.filter((v) => x(v) <= width - right + 0.5).flatMap((v) => [stroked(`M${Math.round(x(v)) + 0.5} ${top}V${floor}`, "rule"), label(x(v), height - 5, metres(v, xs.step), { "text-anchor": "middle" })]),
    ...(nameX ? [label(width - right, height - 5, nameX, { "text-anchor": "end", class: "name" })] : []),
    ...(nameY ? [label(4, top - 6, nameY, { class: "name" })] : []),
  ];
}

/** Builds the phase plane into `host`; `link.hover(t | null)` and `link.seek(t)` are told what the pointer does. */
function makePhase(host, link) {
  let [motion, others, mark, axes, nodes] = [null, [], null, null, null];
  const caption = make("div", { class: "caption" });
  const keys = make("div", { class: "legendrow" });
  const out = make("output", {});
  const area = make("div", {});
  host.replaceChildren(caption, keys, area);
  caption.append(make("h2", {}, "Phase plane"), out);

  const build = (next, rest) => {
    [motion, others, mark] = [next, rest, null];
    host.hidden = !(motion && list(motion.phase.s).length > 1);
    if (!host.hidden) paint();
  };

  const kindsOf = () => [...new Set(motion.stretches.map((one) => one.kind || "other"))].sort((a, b) => LANES.indexOf(a) - LANES.indexOf(b));

  const paint = () => {
    if (!motion || host.hidden || !area.clientWidth) return;
    const { phase, trials, oracle } = motion;
    const kinds = kindsOf();
    const lanes = kinds.length ? 8 + 12 * kinds.length : 0;
    const [width, left, right, top] = [area.clientWidth, kinds.length ? 84 : 66, 12, 18];
    const height = Math.round(clamp(innerHeight * 0.24, 170, 260)) + lanes;
    const bottom = 20 + lanes;
    const runs = trials.filter((trial) => trial.profile);
    const speeds = [phase.v, ...others.map((one) => one.phase.v), ...runs.map((one) => one.profile.v), oracle ? oracle.v : []].flatMap((row) => list(row)).filter(finite);
    const fastest = Math.max(1e-9, ...speeds);
    const curve = list(phase.second || phase.first).filter(finite);
    const high = clamp(curve.length ? 1.04 * Math.max(...curve) : 0, 1.12 * fastest, 1.6 * fastest);
    const end = Math.max(phase.s[phase.s.length - 1], 1e-9);
    const x = (s) => left + ((width - left - right) * s) / end;
    const y = (v) => height - bottom - ((height - bottom - top) * v) / high;
    const box = { width, height, left, right, top, bottom };
    const svg = drawing("svg", { viewBox: `0 0 ${width} ${height}`, class: "chart", role: "img", "aria-label": `Path speed over the path, up to ${show(fastest)} rad/s on ${show(end)} rad` });
    const clip = drawing("clipPath", { id: "inside" }, drawing("rect", { x: left, y: top, width: width - left - right, height: height - bottom - top + 2 }));
    svg.append(clip, ...frameOf({ ...box, x, y, xs: ticksOf(0, end, (width - left - right) / 80), ys: ticksOf(0, high, 5), nameX: null, nameY: "path speed, rad/s" }));
    const inside = drawing("g", { "clip-path": "url(#inside)" });
    inside.append(...ceilings(phase, x, y, top), ...others.map((one) => stroked(joined(one.phase.s, list(one.phase.v), x, y), "line", { stroke: "var(--soft)", "stroke-opacity": 0.8 })));
    runs.forEach((trial, k) => inside.append(stroked(joined(trial.profile.s, trial.profile.v, x, y), "line", { stroke: tryInk(k, runs.length), "data-trial": trial.number })));
    inside.append(stroked(joined(phase.s, list(phase.v), x, y), "halo"), ...profileLines(x, y));
    if (oracle) inside.append(stroked(joined(oracle.s, oracle.v, x, y), "oracle"));
    nodes = { marked: stroked("", "line bold", { stroke: "var(--ink)" }), ghost: stroked("", "ghost"), hand: stroked(`M0 ${top}V${height - bottom + lanes}`, "hand"), spot: drawing("circle", { r: 5, class: "spot" }) };
    inside.append(nodes.marked);
    svg.append(inside, ...laneNodes(kinds, x, box), label(left - 16, height - 5, "path, rad", { "text-anchor": "end", class: "name" }), nodes.ghost, nodes.hand, nodes.spot);
    axes = { x, y, end, box, runs };
    watch(svg);
    area.replaceChildren(svg);
    fillKeys(phase, runs);
    move(...last);
    point(mark);
  };

  const ceilings = (phase, x, y, top) => {
    const curve = phase.second || phase.first;
    if (!curve) return [];
    const shape = phase.s.map((s, i) => `${i ? "L" : "M"}${x(s).toFixed(1)} ${Math.max(-20, finite(curve[i]) ? y(curve[i]) : -20).toFixed(1)}`).join("");
    const lid = stroked(`${shape}L${x(phase.s[phase.s.length - 1])} ${top - 20}L${x(phase.s[0])} ${top - 20}Z`, "over");
    const lines = [phase.first && phase.second ? stroked(joined(phase.s, phase.first, x, y), "first") : null, stroked(joined(phase.s, curve, x, y), "second")];
    return [lid, ...lines.filter(Boolean)];
  };

  /** The chosen profile, a piece for each stretch in the colour of the joint that holds it back. */
  const profileLines = (x, y) => {
    const { phase, stretches } = motion;
    if (!stretches.length) return [stroked(joined(phase.s, list(phase.v), x, y), "line bold", { stroke: "var(--accent)" })];
    return stretches.map((one) => {
      const within = phase.s.map((s, i) => i).filter((i) => phase.s[i] > one.from && phase.s[i] < one.to);
      const [s, v] = [[one.from], [lookUp(phase.s, phase.v, one.from)]];
      within.forEach((i) => push2(s, v, phase.s[i], phase.v[i]));
      push2(s, v, one.to, lookUp(phase.s, phase.v, one.to));
      return stroked(joined(s, v, x, y), "line bold", { stroke: jointInk(one.joint) });
    });
  };

  /** Below the plane, a lane for each kind of limit with the stretches where it holds the motion back. */
  const laneNodes = (kinds, x, { width, height, left, right, bottom }) => kinds.flatMap((kind, k) => {
    const at = height - bottom + 8 + 12 * k;
    const bars = motion.stretches.filter((one) => (one.kind || "other") === kind).map((one) => {
      const bar = drawing("rect", { x: x(one.from), y: at, width: Math.max(1, x(one.to) - x(one.from)), height: 8, fill: jointInk(one.joint) });
      bar.append(drawing("title", {}, String(one.name)));
      return bar;
    });
    return [drawing("rect", { x: left, y: at, width: width - left - right, height: 8, class: "lane", rx: 2 }), ...bars, label(left - 6, at + 7.5, kind, { "text-anchor": "end", class: "name" })];
  });

  const fillKeys = (phase, runs) => {
    const seen = [...new Set(motion.stretches.map((one) => one.joint))].filter((joint) => joint !== null && joint !== undefined).sort((a, b) => a - b);
    const parts = motion.stretches.length ? seen.map((joint) => keyOf("line bold", jointName(motion, joint), { stroke: jointInk(joint) })) : [keyOf("line bold", runs.length ? "best trial" : "the motion", { stroke: "var(--accent)" })];
    if (runs.length) parts.push(make("span", { class: "ramp tries" }, "trials: first", make("i", {}), "last"));
    if (motion.oracle) parts.push(keyOf("oracle", "true optimum"));
    if (others.length) parts.push(keyOf("line", "other motions", { stroke: "var(--soft)" }));
    if (phase.second) parts.push(keyOf("second", phase.kinematic ? "fastest that joint speeds and accelerations allow" : "maximum velocity curve"));
    if (phase.first) parts.push(keyOf(phase.second ? "first" : "second", phase.second ? "joint speeds alone" : "fastest that joint speeds allow"));
    keys.replaceChildren(...parts);
  };

  const timeOf = (s) => lookUp(list(motion.course.s), motion.course.t, s);
  const watch = (svg) => {
    let down = false;
    const at = (event) => timeOf(clamp(((event.clientX - svg.getBoundingClientRect().left - axes.box.left) / (axes.box.width - axes.box.left - axes.box.right)) * axes.end, 0, axes.end));
    svg.addEventListener("pointerdown", (event) => {
      down = event.button === 0;
      if (down) link.seek(at(event));
    });
    svg.addEventListener("pointermove", (event) => {
      if (down && event.buttons) link.seek(at(event));
      link.hover(at(event));
    });
    svg.addEventListener("pointerup", () => { down = false; });
    svg.addEventListener("pointerleave", () => {
      down = false;
      link.hover(null);
    });
  };

  let last = [0, null];
  const move = (t, ghost) => {
    last = [t, ghost];
    if (!axes || !motion || !list(motion.course.s).length) return;
    const at = (time) => [lookUp(motion.course.t, motion.course.s, time), lookUp(motion.course.t, motion.course.v, time)];
    const [s, v] = at(t);
    nodes.hand.setAttribute("transform", `translate(${axes.x(s)} 0)`);
    nodes.spot.setAttribute("cx", axes.x(s));
    nodes.spot.setAttribute("cy", axes.y(v));
    const { top, height, bottom } = axes.box;
    nodes.ghost.setAttribute("d", ghost === null ? "" : `M${axes.x(at(ghost)[0])} ${top}V${height - bottom}`);
    const [place, speed] = ghost === null ? [s, v] : at(ghost);
    const one = motion.stretches.find((stretch) => place >= stretch.from && place <= stretch.to);
    const why = one && one.name ? [", held back by ", make("b", {}, holdName(motion, one))] : [];
    out.replaceChildren(make("b", {}, `${show(speed)} rad/s`), ` at ${show(place)} rad`, ...why);
  };

  /** Shows one trial on top; null for none. */
  const point = (number) => {
    mark = number;
    if (!nodes || !axes) return;
    const trial = axes.runs.find((one) => one.number === number);
    nodes.marked.setAttribute("d", trial ? joined(trial.profile.s, trial.profile.v, axes.x, axes.y) : "");
  };

  onWidth(area, paint);
  return { build, move, point };
}

const LANES = ["speed", "acceleration", "deceleration", "jerk", "torque", "torque rate", "tip speed", "tip acceleration"];
