// The map: view, layers in order, pointer, wheel and pinch.

const colours = () => {
  const style = getComputedStyle(document.documentElement);
  const named = (name) => style.getPropertyValue(`--${name}`).trim();
  const names = ["ink", "soft", "faint", "line", "hair", "surface", "void", "unknown", "wall", "forbidden", "near", "far", "mover", "grid", "halo", "accent", "good", "bad", "scent-0", "scent-1", "scent-2", "scent-3", "scent-4"];
  return Object.fromEntries(names.map((name) => [name, named(name)]));
};

const entryColour = (index) => getComputedStyle(document.documentElement).getPropertyValue(`--entry-${index % 6}`).trim();

/** Creates the map on a canvas; `scene()` gives { entries, world, layers, t, ghost }, `events` is told what the pointer does. */
function makeMap(canvas, scene, events) {
  const pen = canvas.getContext("2d");
  const still = document.createElement("canvas");
  const view = makeView();
  const pictures = new Map();
  let [stale, asked, colour] = [true, false, colours()];

  const ask = (again) => {
    stale = stale || Boolean(again);
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      draw();
    });
  };

  const resize = () => {
    const box = canvas.getBoundingClientRect();
    if (!box.width || !box.height) return;
    const first = !view.width;
    view.ratio = Math.max(1, window.devicePixelRatio || 1);
    view.width = box.width;
    view.height = box.height;
    for (const sheet of [canvas, still]) {
      sheet.width = Math.round(box.width * view.ratio);
      sheet.height = Math.round(box.height * view.ratio);
    }
    if (first) view.fit(scene().home, events.covered());
    stale = true;
    draw();
  };

  const restyle = () => {
    colour = colours();
    pictures.clear();
    ask(true);
  };

  const load = (world) => {
    if (!pictures.has(world)) {
      pictures.set(world, null);
      const palette = colour;
      loadWorld(world, palette).then((levels) => {
        if (palette !== colour) return;
        pictures.set(world, levels);
        ask(true);
      }, () => events.trouble("The map image could not be decoded; paths are drawn without it."));
    }
    return pictures.get(world);
  };

  const draw = () => {
    if (!view.width) return;
    const now = scene();
    if (stale) drawStill(now);
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.drawImage(still, 0, 0);
    pen.setTransform(view.ratio, 0, 0, view.ratio, 0, 0);
    const { layers } = now;
    if (layers.movers) for (const entry of now.entries) drawMovers(pen, view, entry.movers, Math.min(now.t, entry.motion.duration), colour.mover);
    for (const entry of now.entries.filter((e) => e.active && e.replay)) drawReplay(pen, view, entry, clamp(now.ghost === null ? now.t : now.ghost, 0, entry.motion.duration), layers, colour);
    if (now.alternative) drawPath(pen, view, now.alternative, STYLE.alternative, colour.mover, colour.halo);
    if (now.ghost !== null) drawGhost(now);
    if (layers.robot) {
      for (const entry of [...now.entries].sort((a, b) => a.active - b.active)) {
        const state = entry.motion.at(Math.min(now.t, entry.motion.duration));
        if (state) drawRobot(pen, view, entry, state, entryColour(entry.index), colour.halo);
      }
    }
    if (layers.stops) for (const entry of now.entries.filter((e) => e.active)) entry.stops.forEach(([point, letter]) => drawPin(pen, view, point, letter, colour));
  };

  const drawGhost = (now) => {
    for (const entry of now.entries.filter((e) => e.active)) {
      const state = entry.motion.at(clamp(now.ghost, 0, entry.motion.duration));
      if (!state) continue;
      pen.save();
      pen.lineWidth = 1.6;
      pen.setLineDash([3, 3]);
      pen.strokeStyle = entryColour(entry.index);
      pen.beginPath();
      if (radiusOf(entry.footprint) * view.scale > 6) traceFootprint(pen, view, entry.footprint, state);
      pen.stroke();
      pen.setLineDash([]);
      pen.beginPath();
      pen.arc(view.x(state.x), view.y(state.y), 5, 0, 2 * Math.PI);
      pen.fillStyle = colour.halo;
      pen.fill();
      pen.lineWidth = 2.5;
      pen.stroke();
      pen.restore();
    }
  };

  const drawStill = (now) => {
    const ink = still.getContext("2d");
    ink.setTransform(view.ratio, 0, 0, view.ratio, 0, 0);
    const { world, layers } = now;
    ink.fillStyle = world ? colour.void : colour.far;
    ink.fillRect(0, 0, view.width, view.height);
    if (world) drawWorld(ink, world, layers);
    const lead = now.entries.find((e) => e.leading);
    if (lead && lead.scent && layers.scent) drawScent(ink, view, lead.scent, colour);
    if (layers.swept) for (const entry of now.entries.filter((e) => e.active)) drawSwept(ink, view, entry, entryColour(entry.index));
    if (lead && layers.tree && lead.tree.length) drawTree(ink, view, lead.tree, colour.soft);
    if (lead && layers.crowd) drawCrowd(ink, view, crowdAt(lead, now.generation), colour.ink);
    if (lead && layers.classes) drawClasses(ink, view, lead.classes, colour);
    const ordered = [...now.entries].sort((a, b) => a.active - b.active);
    for (const entry of ordered) drawPaths(ink, entry, layers);
    drawAxes(ink, view, colour, layers.grid);
    stale = false;
  };

  const drawWorld = (ink, world, layers) => {
    const levels = load(world);
    const [x0, y0, x1, y1] = world.bounds;
    ink.fillStyle = colour.far;
    if (!world.walls) ink.fillRect(view.x(x0), view.y(y1), (x1 - x0) * view.scale, (y1 - y0) * view.scale);
    if (levels && levels.wallLevels && !(layers.shade && levels.shadeLevels)) fillGround(ink, world);
    if (levels && levels.shadeLevels && layers.shade) drawRaster(ink, view, world, world.shade, levels.shadeLevels, false);
    if (levels && levels.wallLevels) drawRaster(ink, view, world, world.walls, levels.wallLevels, true);
    drawShapes(ink, view, world.shapes, colour);
    if (!world.walls) {
      ink.strokeStyle = colour.wall;
      ink.lineWidth = 1.5;
      ink.strokeRect(view.x(x0), view.y(y1), (x1 - x0) * view.scale, (y1 - y0) * view.scale);
    }
  };

  const fillGround = (ink, world) => {
    ink.save();
    ink.translate(view.x(world.origin[0]), view.y(world.origin[1]));
    ink.rotate(-world.origin[2]);
    ink.fillRect(0, -world.walls.top * view.scale, world.walls.span * view.scale, world.walls.top * view.scale);
    ink.restore();
  };

  const drawPaths = (ink, entry, layers) => {
    const own = entryColour(entry.index);
    if (entry.leading && layers.raw) drawPath(ink, view, entry.raw, STYLE.raw, colour.soft, colour.halo);
    if (entry.kind === "plan" && layers.final) drawPath(ink, view, entry.rows, { ...STYLE.final, width: entry.active ? 2.8 : 2 }, own, colour.halo);
    if (entry.leading && layers.optimum) drawPath(ink, view, entry.optimum, STYLE.optimum, colour.ink, null);
    if (entry.kind === "run" && entry.leading && layers.final) drawPath(ink, view, entry.planned, STYLE.planned, colour.soft, colour.halo);
    if (entry.kind === "run" && layers.driven) drawPath(ink, view, entry.rows, STYLE.driven, own, colour.halo);
    if (entry.active && layers.points) drawPoints(ink, entry.rows, own);
  };

  const drawPoints = (ink, rows, own) => {
    ink.fillStyle = own;
    let [px, py] = [NaN, NaN];
    for (const row of rows) {
      const [x, y] = [view.x(row[0]), view.y(row[1])];
      if (Math.abs(x - px) + Math.abs(y - py) < 5) continue;
      ink.fillRect(x - 2, y - 2, 4, 4);
      [px, py] = [x, y];
    }
  };

  watchPointer(canvas, view, events, ask);
  new ResizeObserver(resize).observe(canvas);
  return { view, ask, restyle, resize };
}

/** The mapping between the map frame (m, y up) and the canvas (CSS pixels, y down). */
function makeView() {
  const view = { scale: 1, cx: 0, cy: 0, width: 0, height: 0, ratio: 1 };
  view.x = (x) => view.width / 2 + (x - view.cx) * view.scale;
  view.y = (y) => view.height / 2 - (y - view.cy) * view.scale;
  view.worldX = (px) => view.cx + (px - view.width / 2) / view.scale;
  view.worldY = (py) => view.cy - (py - view.height / 2) / view.scale;
  view.fit = ([x0, y0, x1, y1], covered = 0) => {
    const [right, upper, lower] = [view.width > 700 ? 60 : 24, 24, 40];
    const [w, h] = [Math.max(x1 - x0, 1e-3), Math.max(y1 - y0, 1e-3)];
    const scaleWith = (margin) => Math.min((view.width - margin - right) / w, (view.height - upper - lower) / h);
    const left = covered > 44 && scaleWith(covered) > 0.7 * scaleWith(44) ? covered : 44;
    view.scale = Math.max(1e-6, scaleWith(left));
    view.cx = (x0 + x1) / 2 - (left - right) / 2 / view.scale;
    view.cy = (y0 + y1) / 2 - (lower - upper) / 2 / view.scale;
    view.least = Math.min(view.least || Infinity, view.scale / 4);
  };
  view.zoom = (factor, px = view.width / 2, py = view.height / 2) => {
    const [x, y] = [view.worldX(px), view.worldY(py)];
    view.scale = clamp(view.scale * factor, view.least || 1e-3, 4000);
    view.cx = x - (px - view.width / 2) / view.scale;
    view.cy = y + (py - view.height / 2) / view.scale;
  };
  view.pan = (dx, dy) => {
    view.cx -= dx / view.scale;
    view.cy += dy / view.scale;
  };
  return view;
}

/** Drag, pinch, wheel, hover and tap. */
function watchPointer(canvas, view, events, ask) {
  const down = new Map();
  let travelled = 0;
  const local = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const spread = () => {
    const [a, b] = [...down.values()];
    return { d: Math.hypot(a[0] - b[0], a[1] - b[1]), x: (a[0] + b[0]) / 2, y: (a[1] + b[1]) / 2 };
  };
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button > 0) return;
    canvas.setPointerCapture(event.pointerId);
    if (!down.size) travelled = 0;
    down.set(event.pointerId, local(event));
  });
  canvas.addEventListener("pointermove", (event) => {
    const at = local(event);
    if (!down.has(event.pointerId)) {
      events.hover(...at);
      return;
    }
    const before = down.get(event.pointerId);
    const pinch = down.size === 2 ? spread() : null;
    down.set(event.pointerId, at);
    travelled += Math.hypot(at[0] - before[0], at[1] - before[1]);
    if (pinch) {
      const now = spread();
      view.pan(now.x - pinch.x, now.y - pinch.y);
      view.zoom(now.d / Math.max(1, pinch.d), now.x, now.y);
      travelled += 10;
    } else if (down.size === 1 && travelled > 3) {
      view.pan(at[0] - before[0], at[1] - before[1]);
      canvas.classList.add("dragging");
    }
    events.leave();
    ask(true);
  });
  const lift = (event) => {
    const held = down.delete(event.pointerId);
    canvas.classList.remove("dragging");
    if (held && event.type === "pointerup" && travelled <= 3) events.tap(...local(event));
  };
  canvas.addEventListener("pointerup", lift);
  canvas.addEventListener("pointercancel", lift);
  canvas.addEventListener("pointerleave", () => events.leave());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 16 : event.deltaMode === 2 ? 240 : 1;
    view.zoom(Math.exp(-clamp(event.deltaY * lines, -240, 240) * (event.ctrlKey ? 0.01 : 0.0022)), ...local(event));
    ask(true);
  }, { passive: false });
  canvas.addEventListener("dblclick", (event) => {
    view.zoom(event.shiftKey ? 0.5 : 2, ...local(event));
    ask(true);
  });
}
