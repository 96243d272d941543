// Plots over time, one strip per quantity, linked by a common hand.

const LEFT = 40;
const RIGHT = 10;

/** Range of the curves and lines of a strip, with zero where it belongs and a little air. */
function rangeOf(strip, end) {
  let [low, high] = strip.signed ? [0, 0] : [0, -Infinity];
  for (const series of strip.series) {
    for (let i = 0; i < series.y.length; i += 1) {
      if (!finite(series.y[i]) || series.x[i] > end + 1e-9) continue;
      low = Math.min(low, series.y[i]);
      high = Math.max(high, series.y[i]);
    }
  }
  if (!Number.isFinite(high)) high = 1;
  for (const line of strip.lines) if (line.y <= Math.max(high, 1e-9) * 2.5 && line.y >= Math.min(low, -1e-9) * 2.5) [low, high] = [Math.min(low, line.y), Math.max(high, line.y)];
  if (high - low < 1e-9) high = low + 1;
  const air = 0.1 * (high - low);
  return [low < 0 ? low - air : low, high + air];
}

/** Builds the strips into `host`; `link.hover(t | null)` and `link.seek(t)` are told what the pointer does. */
function makePlots(host, link) {
  let strips = [];
  let span = { end: 1, unit: "s" };
  const observer = new ResizeObserver(() => strips.forEach(paint));

  const build = (specs, nextSpan) => {
    observer.disconnect();
    host.replaceChildren();
    span = nextSpan;
    host.hidden = !specs.length;
    strips = specs.map((spec, i) => {
      const strip = { ...spec, last: i === specs.length - 1 };
      strip.canvas = make("canvas", { "aria-hidden": "true" });
      strip.hand = make("div", { class: "hand" });
      strip.ghost = make("div", { class: "ghost", hidden: true });
      strip.out = make("output", {});
      strip.area = make("div", { class: "area", role: "img", "aria-label": describe(strip) }, strip.canvas, strip.ghost, strip.hand);
      const keys = strip.lines.length ? [make("span", { class: "key" }, strip.lines.map((line) => line.name).filter((name, k, all) => all.indexOf(name) === k).join(", "))] : [];
      host.append(make("div", { class: "strip" }, make("div", { class: "head" }, make("h3", {}, strip.title), ...keys, strip.out), strip.area));
      watch(strip);
      observer.observe(strip.area);
      return strip;
    });
    if (strips.length) host.append(make("p", { class: "hint" }, "Point at a curve to see the place on the map; press to go there."));
    strips.forEach(paint);
  };

  const describe = (strip) => {
    const [low, high] = rangeOf({ ...strip, lines: [] }, span.end);
    return `${strip.title} from ${show(low)} to ${show(high)} ${strip.unit}`;
  };

  const xOf = (strip, t) => LEFT + (t / span.end) * (strip.width - LEFT - RIGHT);
  const tOf = (strip, x) => clamp(((x - LEFT) / (strip.width - LEFT - RIGHT)) * span.end, 0, span.end);

  const watch = (strip) => {
    let held = false;
    const at = (event) => tOf(strip, event.clientX - strip.area.getBoundingClientRect().left);
    strip.area.addEventListener("pointerdown", (event) => {
      if (event.button > 0) return;
      held = true;
      if (event.pointerType === "mouse") strip.area.setPointerCapture(event.pointerId);
      link.seek(at(event));
    });
    strip.area.addEventListener("pointermove", (event) => {
      if (held) link.seek(at(event));
      link.hover(at(event));
    });
    for (const name of ["pointerup", "pointercancel"]) strip.area.addEventListener(name, () => { held = false; });
    strip.area.addEventListener("pointerleave", () => link.hover(null));
  };

  const paint = (strip) => {
    const [width, height] = [strip.area.clientWidth, strip.area.clientHeight];
    if (!width) return;
    strip.width = width;
    const ratio = Math.max(1, window.devicePixelRatio || 1);
    strip.canvas.width = Math.round(width * ratio);
    strip.canvas.height = Math.round(height * ratio);
    const pen = strip.canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    const colour = colours();
    const floor = height - (strip.last ? 24 : 6);
    const [low, high] = rangeOf(strip, span.end);
    const y = (v) => floor - ((v - low) / (high - low)) * (floor - 6);
    const x = (t) => xOf(strip, t);
    strip.digits = clamp(2 - Math.floor(Math.log10(high - low)), 1, 4);
    paintFrame(pen, strip, { x, y, low, high, floor, width, colour });
    pen.save();
    pen.beginPath();
    pen.rect(LEFT, 2, width - LEFT - RIGHT + 1, floor - 1);
    pen.clip();
    for (const line of strip.lines) paintLevel(pen, line, { x, y, end: span.end, colour });
    for (const series of strip.series) paintSeries(pen, series, { x, y, colour, width, floor });
    pen.restore();
    strip.hand.style.height = strip.ghost.style.height = `${floor}px`;
    moveHands(strip);
  };

  const paintFrame = (pen, strip, { x, y, low, high, floor, width, colour }) => {
    pen.font = "10.5px system-ui, sans-serif";
    pen.fillStyle = colour.faint;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    const vertical = ticksOf(low, high, (floor - 6) / 16);
    for (const v of vertical.ticks.filter((tick) => y(tick) > 4 && y(tick) <= floor + 0.5)) {
      pen.strokeStyle = v === 0 ? colour.line : colour.hair;
      pen.beginPath();
      lineBetween(pen, LEFT, Math.round(y(v)) + 0.5, width - RIGHT, Math.round(y(v)) + 0.5);
      pen.stroke();
      pen.fillText(metres(v, vertical.step), LEFT - 6, clamp(y(v), 7, floor - 3));
    }
    const across = ticksOf(0, span.end, (width - LEFT - RIGHT) / 70);
    pen.textAlign = "center";
    for (const t of across.ticks) {
      pen.strokeStyle = colour.hair;
      pen.beginPath();
      lineBetween(pen, Math.round(x(t)) + 0.5, 4, Math.round(x(t)) + 0.5, floor);
      pen.stroke();
      if (strip.last) pen.fillText(`${metres(t, across.step)}${t === 0 ? ` ${span.unit}` : ""}`, x(t), floor + 12);
    }
  };

  const paintLevel = (pen, line, { x, y, end, colour }) => {
    pen.strokeStyle = colour.bad;
    pen.globalAlpha = 0.75;
    pen.lineWidth = 1;
    pen.setLineDash([4, 4]);
    pen.beginPath();
    lineBetween(pen, x(0), Math.round(y(line.y)) + 0.5, x(end), Math.round(y(line.y)) + 0.5);
    pen.stroke();
    pen.setLineDash([]);
    pen.globalAlpha = 1;
  };

  const paintSeries = (pen, series, { x, y, colour, floor }) => {
    if (!series.x.length) return;
    pen.beginPath();
    let open = false;
    for (let i = 0; i < series.x.length; i += 1) {
      if (!finite(series.y[i]) || (series.breaks && i && series.x[i] - series.x[i - 1] > series.breaks)) open = false;
      if (!finite(series.y[i])) continue;
      if (open) pen.lineTo(x(series.x[i]), y(series.y[i]));
      else pen.moveTo(x(series.x[i]), y(series.y[i]));
      open = true;
    }
    if (series.ceiling) {
      pen.lineTo(x(series.x[series.x.length - 1]), 0);
      pen.lineTo(x(series.x[0]), 0);
      pen.fillStyle = colour.bad;
      pen.globalAlpha = 0.08;
      pen.fill();
      pen.globalAlpha = 1;
      return;
    }
    pen.lineJoin = "round";
    pen.lineWidth = series.bold ? 1.9 : 1.3;
    pen.globalAlpha = series.bold ? 1 : 0.8;
    pen.setLineDash(series.dash || []);
    pen.strokeStyle = series.colour();
    pen.stroke();
    pen.setLineDash([]);
    if (series.bold && series.fill) {
      pen.lineTo(x(series.x[series.x.length - 1]), floor);
      pen.lineTo(x(series.x[0]), floor);
      pen.globalAlpha = 0.07;
      pen.fillStyle = series.colour();
      pen.fill();
    }
    pen.globalAlpha = 1;
  };

  let [time, ghostTime] = [0, null];
  const moveHands = (strip) => {
    if (!strip.width) return;
    strip.hand.style.transform = `translateX(${xOf(strip, Math.min(time, span.end))}px)`;
    strip.ghost.hidden = ghostTime === null;
    if (ghostTime !== null) strip.ghost.style.transform = `translateX(${xOf(strip, Math.min(ghostTime, span.end))}px)`;
    const shown = ghostTime === null ? time : ghostTime;
    const parts = strip.series.filter((series) => series.bold || (series.lead && !strip.series.some((other) => other.bold))).map((series) => {
      const outside = !series.x.length || shown > series.x[series.x.length - 1] + 1e-6;
      const value = outside ? null : lookUp(series.x, series.y, shown);
      const part = make("span", {}, value === null ? "\u2013" : `${value.toFixed(strip.digits).replace("-", "\u2212")} ${strip.unit}`);
      part.style.color = series.colour();
      return part;
    });
    strip.out.replaceChildren(...parts);
  };

  const move = (t, ghost) => {
    [time, ghostTime] = [t, ghost];
    strips.forEach(moveHands);
  };

  return { build, move, repaint: () => strips.forEach(paint) };
}
