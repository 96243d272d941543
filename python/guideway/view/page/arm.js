// The page of an arm's motion: what time it is, and the wires between the arm, time bar, phase plane, curves and facts.

const GHOSTS = 5; // poses along the way

const byId = (id) => document.getElementById(id);
const bundle = record(JSON.parse(byId("data").textContent));
const motions = list(bundle.motions).map(makeMotion);
const state = { t: 0, ghost: null, playing: false, rate: 1, active: 0, joint: null, ghosts: true };
const current = () => motions[state.active] || null;

/** One number per joint, whatever the file says. */
function perJoint(value, count) {
  if (finite(value)) return Array.from({ length: count }, () => value);
  return Array.isArray(value) && value.length === count ? value : null;
}

/** What the page needs of one motion, ready to draw. */
function makeMotion(source, index) {
  const data = record(source);
  const joints = list(data.joints).map(String);
  const course = { t: [], ...record(data.course) };
  course.t = list(course.t);
  const given = record(data.limits);
  const limits = {};
  for (const kind of ["speed", "acceleration", "deceleration", "jerk", "torque", "torque_rate"]) limits[kind] = perJoint(given[kind], joints.length);
  for (const kind of ["tip_speed", "tip_acceleration"]) limits[kind] = finite(given[kind]) ? given[kind] : null;
  const range = record(record(data.robot).range);
  const motion = {
    index, label: String(data.label || `motion ${index + 1}`), joints, course, limits, learner: data.learner, plant: data.plant, robot: data.robot, best: data.best, points: data.points,
    range: Array.isArray(range.lower) && Array.isArray(range.upper) ? range : null, certificate: data.certificate ? record(data.certificate) : null,
    duration: finite(data.duration) ? data.duration : number(course.t[course.t.length - 1]), path: record(data.path), report: record(data.report), phase: { s: [], v: [], ...record(data.phase) },
    stretches: list(data.stretches).map(record), trials: list(data.trials).map(record).map((trial, k) => ({ ...trial, number: finite(trial.number) ? trial.number : k + 1 })),
    oracle: data.oracle && list(record(data.oracle).s).length ? data.oracle : null, oracleDuration: data.oracle_duration, chain: makeChain(data.chain), tool: [], fastest: 0, parts: null,
  };
  motion.postureAt = (t) => joints.map((_, j) => number(lookUp(course.t, list(list(course.q)[j]), t)));
  motion.posesAt = (t) => motion.chain.place(motion.postureAt(t));
  motion.useAt = useOf(motion);
  const hit = record(record(record(motion.certificate).collision).hit);
  motion.hits = hit.pair ? String(hit.pair).split(" and ") : [];
  if (motion.chain && list(course.q).length === joints.length && course.t.length > 1) addTool(motion, data);
  else motion.chain = null;
  return motion;
}

/** The largest share of its limits that each joint uses over time. */
function useOf(motion) {
  let rows = null;
  return (t) => {
    if (!rows) rows = motion.joints.map((_, j) => motion.course.t.map((_time, i) => Math.max(0, ...["qd", "qdd", ...(motion.course.jerky ? [] : ["qddd"]), "tau"].map((id) => Math.abs(shareOf(motion, id, j, i) || 0)))));
    return rows.map((row) => number(lookUp(motion.course.t, row, t)));
  };
}

/** The tool's path and speed, poses along the way, what the first view shows. */
function addTool(motion, { bodies, around }) {
  const { chain, course } = motion;
  const places = course.t.map((t) => chain.place(motion.postureAt(t)));
  motion.tool = places.map((poses, i) => ({ t: course.t[i], at: originOf(chain.tipOf(poses)), pace: 0 }));
  const last = motion.tool.length - 1;
  motion.tool.forEach((row, i) => {
    const [a, b] = [motion.tool[Math.max(0, i - 1)], motion.tool[Math.min(last, i + 1)]];
    row.pace = b.t > a.t ? Math.hypot(...a.at.map((value, c) => b.at[c] - value)) / (b.t - a.t) : 0;
  });
  if (last > 1 && finite(list(course.v)[0])) for (const [i, next] of [[0, 1], [last, last - 1]]) motion.tool[i].pace = course.v[i] < 1e-9 ? 0 : motion.tool[next].pace;
  motion.fastest = Math.max(...motion.tool.map((row) => row.pace));
  motion.ghosts = Array.from({ length: GHOSTS }, (_, k) => motion.posesAt((motion.duration * (k + 0.5)) / GHOSTS));
  const surfaces = list(list(bundle.surfaces)[bodies]).map(record).map(unpack).filter(Boolean);
  motion.parts = [...(surfaces.length ? surfaces : capsulesOf(chain)), ...list(around).map(record).map(unpack).filter(Boolean), ...loadOf(motion)];
  const hull = [motion.tool.map((row) => row.at)];
  for (const part of motion.parts.filter((one) => one.part !== "scene")) {
    const step = 9 * Math.max(1, Math.ceil(part.corners.length / 9 / 60));
    for (const poses of [places[0], ...motion.ghosts]) {
      const some = [];
      for (let i = 0; i < part.corners.length; i += step) some.push(moved(poses[part.joint] || STILL, part.corners.slice(i, i + 3)));
      hull.push(some);
    }
  }
  motion.hull = hull.flat();
  const low = Math.min(...motion.hull.map((point) => point[2]));
  const size = Math.max(...motion.hull.map((point) => Math.hypot(point[0], point[1])));
  const step = roundStep(size / 5);
  motion.floor = { low: Math.min(low, 0) - 1e-3, span: Math.ceil((1.25 * size) / step) * step, step };
  motion.triad = 0.1 * size;
  motion.thick = 0.09 * size;
  const middle = [0, 1].map((c) => motion.tool.reduce((sum, row) => sum + row.at[c], 0) / motion.tool.length);
  motion.yaw = Math.atan2(middle[1], middle[0]) + 0.85;
}

/** The payload as a ball of steel of its mass, at its centre. */
function loadOf(motion) {
  const { mass, at } = record(record(motion.robot).payload);
  if (!(mass > 0) || list(at).length !== 3 || !at.every(finite)) return [];
  const center = moved(motion.chain.tip.pose, at);
  return [{ ...capsule(center, center, Math.cbrt((3 * mass) / (4 * Math.PI * 7800)), motion.chain.tip.joint), part: "load" }];
}

/** When a motion is first shown: where something went wrong, else some way along. */
function firstTime(motion) {
  const failed = list(record(motion.certificate).checks).map(record).find((check) => check.ok === false && finite(check.t));
  const hit = record(record(record(motion.certificate).collision).hit);
  if (finite(hit.s) && list(motion.course.s).length) return number(motion.course.t[Math.min(motion.course.t.length - 1, floorIndex(motion.course.s, hit.s) + 1)]);
  return failed ? failed.t : 0.3 * motion.duration;
}

// ---- pictures ----

const link = { hover: (t) => setGhost(t), seek: (t) => seek(t), joint: (j) => setJoint(j) };
const scene = makeScene(byId("scene"), byId("solid"), byId("over"), () => ({ t: state.t, ghost: state.ghost, ghosts: state.ghosts && !state.playing }), {
  hover: (row, at) => {
    byId("over").classList.toggle("pointing", Boolean(row));
    showTip(row, at);
    setGhost(row ? row.t : null);
  },
  tap: (t) => seek(t),
});
const phase = makePhase(byId("phase"), link);
const curves = makeCurves(byId("curves"), link);
const fillTrials = makeTrials(byId("trials"), (trial) => phase.point(trial));

function showTip(row, [px, py]) {
  const tip = byId("tip");
  tip.hidden = !row;
  if (!row) return;
  const lines = [["at", `${show(row.t)} s`], ["tool", `${show(row.pace)} m/s`], ["place", `(${row.at.map((value) => value.toFixed(3).replace("-", "\u2212")).join(", ")}) m`]];
  tip.replaceChildren(...lines.map(([name, text]) => make("div", {}, make("span", {}, `${name} `), make("b", {}, text))));
  const box = byId("scene").getBoundingClientRect();
  const left = px + 18 + tip.offsetWidth > box.width ? px - 18 - tip.offsetWidth : px + 18;
  tip.style.transform = `translate(${Math.max(4, left)}px, ${clamp(py - 20, 4, box.height - tip.offsetHeight - 4)}px)`;
}

function setGhost(t) {
  if (t === state.ghost) return;
  state.ghost = t;
  phase.move(state.t, t);
  curves.move(state.t, t);
  scene.ask();
}

function setJoint(joint) {
  state.joint = joint;
  if (current()) curves.build(current(), joint);
  curves.move(state.t, state.ghost);
}

// ---- time ----

const duration = () => (current() ? current().duration : 0);

function setTime(t) {
  const end = duration();
  state.t = clamp(t, 0, end);
  const slider = byId("slider");
  slider.value = String(state.t);
  slider.setAttribute("aria-valuetext", `${show(state.t)} s`);
  slider.style.setProperty("--done", `${end > 0 ? (100 * state.t) / end : 0}%`);
  byId("clock").replaceChildren(make("b", {}, state.t.toFixed(2)), ` / ${end.toFixed(2)} s`);
  phase.move(state.t, state.ghost);
  curves.move(state.t, state.ghost);
  scene.ask();
}

function play(on) {
  if (on === state.playing) return;
  state.playing = on;
  byId("play").classList.toggle("playing", on);
  byId("play").setAttribute("aria-label", on ? "Pause" : "Play");
  if (!on) return scene.ask();
  if (state.t >= duration() - 1e-9) setTime(0);
  let before = performance.now();
  const step = (now) => {
    if (!state.playing) return;
    setTime(state.t + (state.rate * (now - before)) / 1000);
    before = now;
    if (state.t >= duration()) play(false);
    else requestAnimationFrame(step);
  };
  return requestAnimationFrame(step);
}

function seek(t) {
  play(false);
  setTime(t);
}

/** Over the time bar: which joint holds the motion back. */
function fillBound(motion) {
  byId("bound").replaceChildren(...motion.stretches.filter((one) => finite(one.begins)).map((one) => {
    const bar = make("i", {});
    bar.style.left = `${(100 * one.begins) / motion.duration}%`;
    bar.style.width = `${(100 * (one.ends - one.begins)) / motion.duration}%`;
    bar.style.background = jointInk(one.joint);
    return bar;
  }));
}

function refresh() {
  const motion = current();
  byId("slider").max = String(duration());
  fillVerdict(byId("verdict"), motion);
  fillCompare(byId("compare"), motions, state.active, choose);
  fillTrials(motion);
  fillDetails(byId("details"), motion, seek);
  fillBound(motion);
  phase.build(motion, motions.filter((one) => one !== motion && list(one.phase.s).length > 1));
  curves.build(motion, state.joint);
  scene.load(motion.chain ? motion : null);
  byId("noscene").hidden = Boolean(motion.chain);
  byId("noscene").textContent = motion.chain ? "" : "This file does not say how the arm is built: no picture of it.";
  byId("scenekey").replaceChildren(...sceneKeys(motion));
  setTime(state.t);
}

function sceneKeys(motion) {
  if (!motion.chain) return [];
  const lit = motion.stretches.length || motion.limits.speed ? [make("div", { class: "wide" }, "Coloured links: their joint is near a limit.")] : [];
  const load = number(record(record(motion.robot).payload).mass);
  if (load > 0) lit.unshift(make("div", { class: "wide" }, `Ball: ${trimmed(load)} kg of payload, as steel.`));
  return [make("div", { class: "ramp" }, "Tool 0", make("i", {}), `${show(motion.fastest)} m/s`), make("div", {}, `Floor: squares of ${trimmed(motion.floor.step)} m.`), ...lit];
}

function choose(i) {
  state.active = i;
  state.joint = null;
  state.t = firstTime(current());
  refresh();
}

// ---- theme, keys ----

function watchTheme() {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  let chosen = (/theme=(dark|light)/.exec(location.hash) || [])[1] || null;
  const set = (theme) => {
    document.documentElement.dataset.theme = theme;
    scene.restyle();
  };
  const apply = () => set(chosen || (dark.matches ? "dark" : "light"));
  dark.addEventListener("change", apply);
  byId("theme").addEventListener("click", () => {
    chosen = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    apply();
  });
  addEventListener("beforeprint", () => set("light"));
  addEventListener("afterprint", apply);
  apply();
}

function toggleGhosts() {
  state.ghosts = !state.ghosts;
  byId("ghosts").setAttribute("aria-pressed", String(state.ghosts));
  scene.ask();
}

function watchKeys() {
  const nudge = (event) => ((event.shiftKey ? 0.05 : 0.005) * duration());
  const onArm = () => document.activeElement === byId("over");
  const arrow = (dx, dy) => (event) => (onArm() ? scene.turn(0.1 * dx, 0.1 * dy) : dx ? seek(state.t + dx * nudge(event)) : null);
  const keys = {
    " ": () => play(!state.playing), ArrowRight: arrow(1, 0), ArrowLeft: arrow(-1, 0), ArrowUp: arrow(0, 1), ArrowDown: arrow(0, -1), Home: () => seek(0), End: () => seek(duration()),
    "+": () => scene.zoom(1.25), "=": () => scene.zoom(1.25), "-": () => scene.zoom(0.8), 0: () => scene.home(), f: () => scene.focus(), g: toggleGhosts, a: () => setJoint(null),
  };
  addEventListener("keydown", (event) => {
    const field = event.target instanceof HTMLElement ? event.target.closest("select, summary, button") : null;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (field && [" ", "ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End"].includes(event.key)) return;
    if (!onArm() && ["ArrowUp", "ArrowDown"].includes(event.key)) return;
    const joint = Number(event.key) - 1;
    if (current() && joint >= 0 && joint < current().joints.length) return setJoint(joint);
    const act = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act || !current()) return;
    event.preventDefault();
    act(event);
  });
}

function subtitle() {
  const motion = current();
  if (!motion) return "No motion in this report.";
  const robot = record(motion.robot);
  const load = number(record(robot.payload).mass);
  const parts = [motions.length > 1 ? `${motions.length} motions` : motion.label, `${motion.joints.length} joints`, finite(motion.path.length) ? `${show(motion.path.length)} rad of path` : null, load ? `payload ${trimmed(load)} kg` : null];
  return parts.filter(Boolean).join("  \u00b7  ");
}

function start() {
  byId("title").textContent = String(bundle.title);
  byId("subtitle").textContent = subtitle();
  watchTheme();
  if (!current()) {
    for (const id of ["verdict", "trials", "curves", "details", "time", "phase"]) byId(id).hidden = true;
    byId("noscene").hidden = false;
    byId("noscene").textContent = "There is no motion in this report.";
    return;
  }
  for (const rate of [0.1, 0.25, 0.5, 1, 2]) byId("rate").append(make("option", { value: rate, selected: rate === 1 }, `${rate}\u00d7`));
  byId("rate").addEventListener("change", (event) => { state.rate = Number(event.target.value); });
  byId("play").addEventListener("click", () => play(!state.playing));
  byId("slider").addEventListener("input", (event) => seek(Number(event.target.value)));
  byId("in").addEventListener("click", () => scene.zoom(1.25));
  byId("out").addEventListener("click", () => scene.zoom(0.8));
  byId("fit").addEventListener("click", () => scene.home());
  byId("focus").addEventListener("click", () => scene.focus());
  byId("ghosts").addEventListener("click", toggleGhosts);
  watchKeys();
  const asked = Number((/\bt=([\d.]+)/.exec(location.hash) || [])[1]);
  state.t = finite(asked) ? asked : firstTime(current());
  const joint = Number((/\bjoint=(\d+)/.exec(location.hash) || [])[1]) - 1;
  if (joint >= 0 && joint < current().joints.length) state.joint = joint;
  refresh();
}

start();
