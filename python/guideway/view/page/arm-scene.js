// The arm on its path: camera, floor, ghosts, the tool's path coloured by its speed, and what the pointer does.

const FIELD = (32 * Math.PI) / 180;

/** A colour of the style sheet as numbers from 0 to 1. */
function inkOf(name, alpha = 1) {
  const hex = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  return [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16) / 255).concat(alpha);
}
const blend = (a, b, part) => a.map((value, i) => value + (b[i] - value) * part);
const cssOf = ([r, g, b], alpha = 1) => `rgb(${[r, g, b].map((value) => Math.round(255 * value)).join(" ")} / ${alpha})`;

/** A camera that goes around a point. */
function makeCamera() {
  const camera = { yaw: -0.9, pitch: 0.42, far: 3, target: [0, 0, 0.4], width: 1, height: 1, eye: new Float32Array(16), from: [0, 0, 0], key: [0, 0, 1], axes: [] };
  camera.update = () => {
    const [cy, sy, cp, sp] = [Math.cos(camera.yaw), Math.sin(camera.yaw), Math.cos(camera.pitch), Math.sin(camera.pitch)];
    const [right, back] = [[-sy, cy, 0], [cy * cp, sy * cp, sp]];
    const up = [-cy * sp, -sy * sp, cp];
    camera.axes = [right, up, back];
    camera.from = camera.target.map((value, c) => value + camera.far * back[c]);
    const dot = (axis) => -axis.reduce((sum, value, c) => sum + value * camera.from[c], 0);
    const look = [right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0, dot(right), dot(up), dot(back), 1];
    const [near, end, f] = [camera.far / 40, camera.far * 12, 1 / Math.tan(FIELD / 2)];
    const wide = camera.width / camera.height;
    const lens = [f / wide, 0, 0, 0, 0, f, 0, 0, 0, 0, (end + near) / (near - end), -1, 0, 0, (2 * end * near) / (near - end), 0];
    camera.eye = glTimes(lens, look);
    const key = right.map((value, c) => 0.35 * value + 0.75 * up[c] + 0.6 * back[c]);
    camera.key = key.map((value) => value / Math.hypot(...key));
  };
  /** Pixel of a point, and its distance; null behind the camera. */
  camera.pixel = ([x, y, z]) => {
    const m = camera.eye;
    const w = m[3] * x + m[7] * y + m[11] * z + m[15];
    if (w <= 0) return null;
    return [((m[0] * x + m[4] * y + m[8] * z + m[12]) / w + 1) * 0.5 * camera.width, (1 - (m[1] * x + m[5] * y + m[9] * z + m[13]) / w) * 0.5 * camera.height, w];
  };
  /** Moves so that all points are within the picture. */
  camera.fit = (points) => {
    if (!points.length) return;
    const [low, high] = [Math.min, Math.max].map((pick) => [0, 1, 2].map((c) => pick(...points.map((point) => point[c]))));
    camera.target = low.map((value, c) => (value + high[c]) / 2);
    for (let round = 0; round < 3; round += 1) {
      camera.update();
      const [right, up, back] = camera.axes;
      const along = (axis, point) => axis.reduce((sum, value, c) => sum + value * (point[c] - camera.target[c]), 0);
      const [tall, wide] = [Math.tan(FIELD / 2) * 0.8, Math.tan(FIELD / 2) * 0.84 * (camera.width / camera.height)];
      const spans = [right, up].map((axis) => points.map((point) => along(axis, point)));
      const shift = spans.map((values) => (Math.min(...values) + Math.max(...values)) / 2);
      camera.target = camera.target.map((value, c) => value + shift[0] * right[c] + shift[1] * up[c]);
      camera.far = Math.max(0.02, ...points.map((point) => along(back, point) + Math.max(Math.abs(along(right, point)) / wide, Math.abs(along(up, point)) / tall)));
    }
    camera.update();
  };
  camera.turn = (dx, dy) => {
    camera.yaw -= dx;
    camera.pitch = clamp(camera.pitch + dy, -1.45, 1.5);
  };
  camera.zoom = (factor) => { camera.far = clamp(camera.far / factor, 0.02, 400); };
  camera.shift = (dx, dy) => {
    const scale = (2 * camera.far * Math.tan(FIELD / 2)) / camera.height;
    const [right, up] = camera.axes;
    camera.target = camera.target.map((value, c) => value - scale * (dx * right[c] - dy * up[c]));
  };
  return camera;
}

/** The picture of the arm. `link`: hover(t | null), tap(t), and `scene()` for what to draw. */
function makeScene(host, solid, over, scene, link) {
  const [renderer, camera] = [makeRenderer(solid), makeCamera()];
  const pen = over.getContext("2d");
  let [motion, dirty, made, touched, shape] = [null, false, null, false, []];

  const resize = () => {
    const ratio = clamp(window.devicePixelRatio || 1, 1, 2);
    const size = [Math.max(1, host.clientWidth), Math.max(1, host.clientHeight), ratio];
    if (size.every((value, i) => value === shape[i])) return;
    shape = size;
    [camera.width, camera.height] = size;
    for (const canvas of [solid, over]) [canvas.width, canvas.height] = [Math.round(camera.width * ratio), Math.round(camera.height * ratio)];
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    if (!touched) home();
    draw(); // at once: a canvas that changes its size is empty
  };

  const pointsOfArm = () => motion.hull;
  const home = () => motion && camera.fit(pointsOfArm());
  const focus = () => motion && camera.fit(motion.tool.map((row) => row.at));

  /** Everything of a motion that stays the same while it plays. */
  const load = (next) => {
    motion = next;
    touched = false;
    [camera.yaw, camera.pitch] = next ? [next.yaw, 0.4] : [-0.9, 0.4];
    restyle();
    resize();
    home();
    draw();
  };

  const restyle = () => {
    if (made) [made.floor, made.path, ...made.meshes].forEach(renderer.drop);
    made = null;
    if (!renderer || !motion) return draw();
    made = { meshes: motion.parts.map(renderer.mesh), floor: renderer.lines(floorLines()), path: renderer.lines(pathLines()) };
    return draw(); // at once: printing does not wait for a frame
  };

  const floorLines = () => {
    const { span, step, low } = motion.floor;
    const ink = inkOf("--rule");
    const fade = (x, y) => [...ink.slice(0, 3), 0.75 * Math.max(0, 1 - (x * x + y * y) / (span * span))];
    const out = [];
    for (let i = -Math.floor(span / step); i <= span / step; i += 1) {
      for (let k = -Math.floor(span / step); k < Math.floor(span / step); k += 1) {
        const [c, a, b] = [i * step, k * step, (k + 1) * step];
        if (Math.hypot(c, Math.min(Math.abs(a), Math.abs(b))) > span) continue;
        out.push([[c, a, low], [c, b, low], fade(c, a), fade(c, b)], [[a, c, low], [b, c, low], fade(a, c), fade(b, c)]);
      }
    }
    return out;
  };

  const paceInk = (part) => (part < 0.5 ? blend(inkOf("--slow"), inkOf("--middle"), 2 * part) : blend(inkOf("--middle"), inkOf("--fast"), 2 * part - 1));
  const pathLines = () => {
    const ramp = Array.from({ length: 33 }, (_, i) => paceInk(i / 32));
    const ink = (row) => ramp[Math.round(32 * clamp(row.pace / (motion.fastest || 1), 0, 1))];
    return motion.tool.slice(1).map((row, i) => [motion.tool[i].at, row.at, ink(motion.tool[i]), ink(row)]);
  };

  const ask = () => {
    if (dirty) return;
    dirty = true;
    requestAnimationFrame(() => {
      dirty = false;
      draw();
    });
  };

  const colourOf = (t) => {
    const [body, worst] = [inkOf("--body"), motion.useAt(t)];
    const inks = worst.map((share, j) => blend(body, inkOf(`--joint-${j % 8}`), 0.8 * clamp((share - 0.8) / 0.19, 0, 1) ** 2));
    const [wall, tool, bad] = ["--obstacle", "--load", "--bad"].map((name) => inkOf(name));
    return ({ joint, part, name }) => {
      if (part === "scene") return name && motion.hits.includes(name) ? bad : wall;
      if (part && part !== "arm") return tool;
      const driver = motion.chain.driver(joint);
      return driver === null || !inks[driver] ? body : inks[driver];
    };
  };

  const draw = () => {
    pen.clearRect(0, 0, camera.width, camera.height);
    if (!motion) return;
    camera.update();
    const now = scene();
    const poses = motion.posesAt(now.t);
    if (renderer && made) drawSolid(now, poses);
    else drawFlat(now, poses);
    drawMarks(now, poses);
  };

  const drawSolid = (now, poses) => {
    const scale = solid.width / camera.width;
    renderer.begin(camera);
    renderer.stroke(made.floor, 0.55 * scale);
    const { low } = motion.floor;
    const [right, , back] = camera.axes;
    const [slopeX, slopeY] = [0, 1].map((c) => -0.28 * right[c] + 0.22 * back[c]); // the light is behind the viewer's left shoulder
    const flat = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, -slopeX, -slopeY, 0, 0, slopeX * low, slopeY * low, low, 1]);
    renderer.shadow(made.meshes, poses, inkOf("--shade", document.documentElement.dataset.theme === "dark" ? 0.5 : 0.16), flat);
    renderer.stroke(made.path, 2.3 * scale, 0.3, true);
    renderer.stroke(made.path, 2.3 * scale);
    renderer.bodies(made.meshes, poses, colourOf(now.t));
    const body = inkOf("--body");
    const moving = made.meshes.filter((part) => part.part !== "scene" && part.joint > 0);
    if (now.ghosts) for (const ghost of motion.ghosts) renderer.bodies(moving, ghost, () => body, 0.3);
    if (now.ghost !== null) renderer.bodies(moving, motion.posesAt(now.ghost), () => inkOf("--accent"), 0.4);
  };

  /** Without WebGL: the chain as thick lines, the far ones first. */
  const drawFlat = (now, poses) => {
    const line = (a, b, width, ink) => {
      const [p, q] = [camera.pixel(a), camera.pixel(b)];
      if (!p || !q) return;
      pen.strokeStyle = ink;
      pen.lineWidth = width;
      pen.lineCap = "round";
      pen.beginPath();
      lineTo2(pen, p, q);
      pen.stroke();
    };
    for (const [a, b, ink] of floorLines()) line(a, b, 0.7, cssOf(ink, ink[3]));
    for (const [a, b, ink] of pathLines()) line(a, b, 2.4, cssOf(ink));
    const bones = (all) => motion.chain.joints.map((joint, k) => [all[joint.parent], all[k + 1], k]).concat([[all[motion.chain.tip.joint], motion.chain.tipOf(all), motion.chain.tip.joint - 1]]);
    const unit = camera.height / (2 * Math.tan(FIELD / 2));
    const limbs = (all, colour, alpha) => bones(all).map(([from, to, k]) => [originOf(from), originOf(to), k]).sort((one, two) => (camera.pixel(two[1]) || [0, 0, 0])[2] - (camera.pixel(one[1]) || [0, 0, 0])[2])
      .forEach(([from, to, k]) => line(from, to, Math.max(3, (motion.thick * unit) / camera.far), cssOf(colour({ joint: k + 1 }), alpha)));
    if (now.ghosts) for (const ghost of motion.ghosts) limbs(ghost, () => inkOf("--body"), 0.2);
    const colour = colourOf(now.t);
    limbs(poses, (one) => colour(one).map((value, c) => (c < 3 ? value * (0.82 + 0.06 * (one.joint % 3)) : value)), 1);
  };
  const lineTo2 = (path, p, q) => {
    path.moveTo(p[0], p[1]);
    path.lineTo(q[0], q[1]);
  };

  const dot = (at, radius, fill, rim) => {
    const spot = at && camera.pixel(at);
    if (!spot) return;
    pen.beginPath();
    pen.arc(spot[0], spot[1], radius, 0, 7);
    [pen.fillStyle, pen.strokeStyle, pen.lineWidth] = [fill, rim, 2];
    pen.fill();
    pen.stroke();
  };

  const drawMarks = (now, poses) => {
    const [ink, paper, accent] = ["--ink", "--surface", "--accent"].map((name) => cssOf(inkOf(name)));
    const [first, last] = [motion.tool[0], motion.tool[motion.tool.length - 1]];
    const apart = first && Math.hypot(...first.at.map((value, c) => value - last.at[c])) > 1e-4;
    if (first) dot(first.at, 4.5, paper, ink);
    if (apart) dot(last.at, 4.5, ink, paper);
    const tip = motion.chain.tipOf(poses);
    const from = camera.pixel(originOf(tip));
    [["#d6453d", 0], ["#2f9e54", 1], ["#3a74e0", 2]].forEach(([colour, c]) => {
      const to = camera.pixel(moved(tip, [0, 1, 2].map((k) => (k === c ? motion.triad : 0))));
      if (!from || !to) return;
      [pen.strokeStyle, pen.lineWidth, pen.lineCap] = [colour, 2, "round"];
      pen.beginPath();
      lineTo2(pen, from, to);
      pen.stroke();
    });
    dot(originOf(tip), 4, accent, paper);
    if (now.ghost !== null) dot(originOf(motion.chain.tipOf(motion.posesAt(now.ghost))), 5, paper, accent);
  };

  // ---- pointers ----

  const held = new Map();
  let [travel, pinch] = [0, null];
  const place = (event) => {
    const box = over.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  /** The sample of the tool's path nearest to a pixel, if it is near. */
  const nearest = ([px, py]) => {
    let [best, found] = [16, null];
    for (const row of motion ? motion.tool : []) {
      const spot = camera.pixel(row.at);
      const d = spot ? Math.hypot(spot[0] - px, spot[1] - py) : Infinity;
      if (d < best) [best, found] = [d, row];
    }
    return found;
  };
  const spread = () => {
    const [a, b] = [...held.values()];
    return { size: Math.hypot(a[0] - b[0], a[1] - b[1]), middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2] };
  };
  over.addEventListener("pointerdown", (event) => {
    held.set(event.pointerId, place(event));
    over.setPointerCapture(event.pointerId);
    travel = held.size > 1 ? 99 : 0;
    pinch = held.size === 2 ? spread() : null;
  });
  over.addEventListener("pointermove", (event) => {
    const at = place(event);
    const before = held.get(event.pointerId);
    if (!before) return link.hover(nearest(at), at);
    held.set(event.pointerId, at);
    const [dx, dy] = [at[0] - before[0], at[1] - before[1]];
    travel += Math.abs(dx) + Math.abs(dy);
    if (travel < 4) return undefined;
    touched = true;
    over.classList.add("dragging");
    link.hover(null, at);
    if (held.size === 2 && pinch) {
      const next = spread();
      camera.zoom(next.size / Math.max(1, pinch.size));
      camera.shift(next.middle[0] - pinch.middle[0], next.middle[1] - pinch.middle[1]);
      pinch = next;
    } else if (event.shiftKey || event.buttons > 1) camera.shift(dx, dy);
    else camera.turn(0.008 * dx, 0.008 * dy);
    return ask();
  });
  const release = (event) => {
    if (held.delete(event.pointerId) && travel < 4 && event.type === "pointerup") {
      const row = nearest(place(event));
      if (row) link.tap(row.t);
    }
    pinch = null;
    over.classList.remove("dragging");
  };
  over.addEventListener("pointerup", release);
  over.addEventListener("pointercancel", release);
  over.addEventListener("pointerleave", () => link.hover(null, [0, 0]));
  over.addEventListener("contextmenu", (event) => event.preventDefault());
  over.addEventListener("wheel", (event) => {
    event.preventDefault();
    touched = true;
    camera.zoom(Math.exp(-clamp(event.deltaY * (event.deltaMode ? 20 : 1), -240, 240) * 0.0016));
    ask();
  }, { passive: false });
  solid.addEventListener("webglcontextlost", (event) => event.preventDefault());
  solid.addEventListener("webglcontextrestored", () => location.reload());
  new ResizeObserver(resize).observe(host);

  const act = (change) => {
    touched = true;
    change();
    ask();
  };
  return { load, restyle, ask, home: () => act(home), focus: () => act(focus), zoom: (factor) => act(() => camera.zoom(factor)), turn: (dx, dy) => act(() => camera.turn(dx, dy)) };
}
