// Joints over time: position, speed, acceleration, jerk, torque, and the tool's speed; as shares of their limits, or one joint in its units.

const QUANTITIES = [
  { id: "q", title: "Position", unit: "rad", limit: null },
  { id: "qd", title: "Speed", unit: "rad/s", limit: "speed" },
  { id: "qdd", title: "Acceleration", unit: "rad/s\u00b2", limit: "acceleration" },
  { id: "qddd", title: "Jerk", unit: "rad/s\u00b3", limit: "jerk" },
  { id: "tau", title: "Torque", unit: "N m", limit: "torque" },
];

const MOST_SHARE = 260; // % of a limit that a strip shows; what is beyond is cut off, the table of limits has it

/** Bounds of a quantity of one joint at a sample: [low, high], null where it has none. Acceleration may differ from deceleration. */
function boundsOf(motion, id, joint, i) {
  const { limits, range } = motion;
  if (id === "q") return range && finite(range.lower[joint]) && finite(range.upper[joint]) ? [range.lower[joint], range.upper[joint]] : null;
  const most = limits[QUANTITIES.find((one) => one.id === id).limit];
  if (!most || !finite(most[joint])) return null;
  if (id !== "qdd") return [-most[joint], most[joint]];
  const brake = limits.deceleration ? limits.deceleration[joint] : most[joint];
  return number(list(motion.course.qd[joint])[i]) >= 0 ? [-brake, most[joint]] : [-most[joint], brake];
}

/** Share of its limit that a joint uses at a sample, signed; null where there is no limit. */
function shareOf(motion, id, joint, i) {
  const bounds = boundsOf(motion, id, joint, i);
  const value = list(list(motion.course[id])[joint])[i];
  if (!bounds || !finite(value)) return null;
  return value >= 0 ? value / bounds[1] : -value / bounds[0];
}

/** Builds the curves into `host`; `link` as of the phase plane, `link.joint(j | null)` when another joint is asked for. */
function makeCurves(host, link) {
  let [motion, chosen, strips, last] = [null, null, [], [0, null]];
  const chips = make("div", { class: "chips", role: "group", "aria-label": "Joint" });
  const body = make("div", {});
  host.replaceChildren(make("div", { class: "caption" }, make("h2", {}, "Joints over time")), chips, body);

  const build = (next, joint) => {
    [motion, chosen] = [next, joint];
    host.hidden = !(motion && motion.course.t.length > 1 && list(motion.course.q).length);
    if (host.hidden) return;
    const chip = (name, j) => {
      const node = make("button", { type: "button", "aria-pressed": String(j === chosen), onclick: () => link.joint(j) }, j === null ? null : make("i", {}), name);
      node.style.setProperty("--who", jointInk(j));
      return node;
    };
    chips.replaceChildren(chip("all joints", null), ...motion.joints.map((_, j) => chip(jointName(motion, j), j)));
    strips = specs().map(stripOf);
    body.replaceChildren(...strips.map((strip) => strip.node), make("p", { class: "hint" }, "Tinted: beyond the limit. Point at a curve to see the arm there; press to go there."));
    paint();
  };

  const specs = () => {
    const { course } = motion;
    const kept = QUANTITIES.filter(({ id }) => list(course[id]).length && !(id === "qddd" && course.jerky));
    return [...kept, ...(motion.tool.length ? [{ id: "pace", title: "Speed of the tool", unit: "m/s", limit: "tip_speed" }] : [])];
  };

  const stripOf = (spec) => {
    const shares = chosen === null && spec.limit && spec.id !== "pace" && Boolean(motion.limits[spec.limit]);
    const out = make("output", {});
    const area = make("div", {});
    const measured = spec.id === "tau" ? (motion.course.measured ? ", of the plant" : ", of the model") : "";
    const name = shares ? "% of the limit" : `${spec.unit}${limitWords(spec)}`;
    const node = make("div", { class: "curve" }, make("div", { class: "head" }, make("h3", {}, spec.title), make("span", { class: "key" }, name + measured), out), area);
    return { spec, shares, out, area, node };
  };

  /** The limit of the chosen joint, or of the tool, in words: it may be far outside of what is drawn. */
  const limitWords = (spec) => {
    if (spec.id === "pace") return finite(motion.limits.tip_speed) ? `, limit ${trimmed(motion.limits.tip_speed)}` : "";
    if (chosen === null) return "";
    const bounds = boundsOf(motion, spec.id, chosen, 0);
    if (!bounds) return "";
    if (spec.id === "q") return `, range ${trimmed(bounds[0])} to ${trimmed(bounds[1])}`;
    const brake = spec.id === "qdd" && motion.limits.deceleration ? ` and ${trimmed(motion.limits.deceleration[chosen])} braking` : "";
    return `, limit ${trimmed(motion.limits[spec.limit][chosen])}${brake}`;
  };

  /** Values of a strip for a joint. */
  const valuesOf = ({ spec, shares }, joint) => {
    if (spec.id === "pace") return motion.tool.map((row) => row.pace);
    const row = list(motion.course[spec.id][joint]);
    return shares ? row.map((_, i) => shareOf(motion, spec.id, joint, i)).map((value) => (value === null ? null : 100 * value)) : row;
  };
  const jointsOf = ({ spec }) => (spec.id === "pace" ? [null] : chosen === null ? motion.joints.map((_, j) => j) : [chosen]);

  /** Limit lines: [low or high per sample] of a strip. */
  const limitsOf = (strip) => {
    const { spec, shares } = strip;
    const { t } = motion.course;
    if (spec.id === "pace") return finite(motion.limits.tip_speed) ? [t.map(() => motion.limits.tip_speed)] : [];
    if (shares) return [t.map(() => 100), t.map(() => -100)];
    if (chosen === null || !boundsOf(motion, spec.id, chosen, 0)) return [];
    const rows = t.map((_, i) => boundsOf(motion, spec.id, chosen, i));
    return [rows.map((row) => row[1]), rows.map((row) => row[0])];
  };

  const extent = (strip, series, limits) => {
    const values = series.flatMap((one) => one.values).filter(finite);
    let [low, high] = [Math.min(0, ...values), Math.max(0, ...values)];
    if (strip.shares) [low, high] = [clamp(low, -MOST_SHARE, -100), clamp(high, 100, MOST_SHARE)];
    else for (const row of limits) {
      const far = row.reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a), 0);
      if (Math.abs(far) < 2.2 * Math.max(Math.abs(low), Math.abs(high), 1e-9)) [low, high] = [Math.min(low, far), Math.max(high, far)];
    }
    if (high - low < 1e-9) high = low + 1;
    const air = 0.1 * (high - low);
    return [low < 0 ? low - air : low, high + air];
  };

  const paint = () => strips.forEach((strip, k) => {
    const width = strip.area.clientWidth;
    if (!width) return;
    const lastOne = k === strips.length - 1;
    const [left, right, top, bottom] = [42, 8, 4, lastOne ? 20 : 4];
    const height = 84 + bottom;
    const { t } = motion.course;
    const end = Math.max(motion.duration, 1e-9);
    const series = jointsOf(strip).map((joint) => ({ joint, values: valuesOf(strip, joint) }));
    const limits = limitsOf(strip);
    const [low, high] = extent(strip, series, limits);
    const x = (time) => left + ((width - left - right) * time) / end;
    const y = (v) => height - bottom - ((height - bottom - top) * (v - low)) / (high - low);
    const [xs, ys] = [ticksOf(0, end, (width - left - right) / 70), strip.shares ? { step: 100, ticks: [-200, -100, 0, 100, 200] } : ticksOf(low, high, 4)];
    const svg = drawing("svg", { viewBox: `0 0 ${width} ${height}`, class: "chart", role: "img", "aria-label": `${strip.spec.title} over time` });
    const frame = frameOf({ width, height, left, right, top, bottom, x, y, xs: lastOne ? xs : { ...xs, ticks: [] }, ys });
    svg.append(...frame, ...(lastOne ? [label(left - 16, height - 5, "s", { "text-anchor": "end", class: "name" })] : xs.ticks.map((v) => stroked(`M${Math.round(x(v)) + 0.5} ${top}V${height - bottom}`, "rule"))));
    for (const row of limits.filter((one) => one.some((value) => value >= low && value <= high))) {
      const side = row[0] > 0 ? top : height - bottom;
      const shape = t.map((time, i) => `${i ? "L" : "M"}${x(time).toFixed(1)} ${clamp(y(row[i]), top, height - bottom).toFixed(1)}`).join("");
      svg.append(stroked(`${shape}V${side}H${left}Z`, "over"), stroked(shape, "limit"));
    }
    series.forEach((one) => svg.append(stroked(joined(t, one.values, x, (v) => y(clamp(v, low, high))), "line", { stroke: one.joint === null ? "var(--accent)" : jointInk(one.joint), "stroke-width": series.length === 1 ? 1.8 : 1.4 })));
    strip.hand = stroked(`M0.5 ${top}V${height - bottom}`, "hand");
    strip.ghost = stroked(`M0.5 ${top}V${height - bottom}`, "ghost", { visibility: "hidden" });
    svg.append(strip.ghost, strip.hand);
    Object.assign(strip, { x, series, width, left, right, end });
    watch(strip, svg);
    strip.area.replaceChildren(svg);
    moveStrip(strip);
  });

  const watch = (strip, svg) => {
    const at = (event) => clamp(((event.clientX - svg.getBoundingClientRect().left - strip.left) / (strip.width - strip.left - strip.right)) * strip.end, 0, strip.end);
    svg.addEventListener("pointerdown", (event) => {
      if (event.button === 0) link.seek(at(event));
    });
    svg.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) link.seek(at(event));
      link.hover(at(event));
    });
    svg.addEventListener("pointerleave", () => link.hover(null));
  };

  const moveStrip = (strip) => {
    if (!strip.x) return;
    const [t, ghost] = last;
    strip.hand.setAttribute("transform", `translate(${strip.x(clamp(t, 0, strip.end))} 0)`);
    strip.ghost.setAttribute("visibility", ghost === null ? "hidden" : "visible");
    if (ghost !== null) strip.ghost.setAttribute("transform", `translate(${strip.x(ghost)} 0)`);
    const shown = strip.series.map((one) => [one.joint, lookUp(motion.course.t, one.values, ghost === null ? t : ghost)]).filter(([, value]) => finite(value));
    if (!shown.length || (!strip.shares && shown.length > 1)) return strip.out.replaceChildren();
    const [joint, value] = shown.reduce((best, one) => (Math.abs(one[1]) > Math.abs(best[1]) ? one : best));
    const text = strip.shares ? `${jointName(motion, joint)} ${value.toFixed(0).replace("-", "\u2212")} %` : `${show(value)} ${strip.spec.unit}`;
    const node = make("span", {}, text);
    node.style.color = joint === null ? "var(--accent)" : jointInk(joint);
    return strip.out.replaceChildren(node);
  };

  const move = (t, ghost) => {
    last = [t, ghost];
    if (motion && !host.hidden) strips.forEach(moveStrip);
  };

  onWidth(body, paint);
  return { build, move };
}
