// Motions: a path by arc length, a trajectory of pieces, a drive as it was measured. Units: m, s, rad.

/** A polyline with its arc length; points that repeat are dropped. */
function makeLine(rows) {
  const kept = [];
  for (const point of pointsOf(rows)) {
    const last = kept[kept.length - 1];
    if (!last || Math.hypot(point[0] - last[0], point[1] - last[1]) > 1e-9) kept.push(point);
  }
  const n = kept.length;
  const line = { n, x: new Float64Array(n), y: new Float64Array(n), s: new Float64Array(n), length: 0 };
  for (let i = 0; i < n; i += 1) {
    line.x[i] = kept[i][0];
    line.y[i] = kept[i][1];
    if (i) line.s[i] = line.s[i - 1] + Math.hypot(line.x[i] - line.x[i - 1], line.y[i] - line.y[i - 1]);
  }
  line.length = n ? line.s[n - 1] : 0;
  return line;
}

const segmentYaw = (line, i) => Math.atan2(line.y[i + 1] - line.y[i], line.x[i + 1] - line.x[i]);

/** Place and heading at arc length s; headings of gently bent lines are blended so that a robot turns without steps. */
function placeAt(line, s) {
  if (!line.n) return null;
  if (line.n === 1) return { x: line.x[0], y: line.y[0], yaw: 0 };
  const i = Math.min(floorIndex(line.s, s), line.n - 2);
  const part = clamp((s - line.s[i]) / (line.s[i + 1] - line.s[i]), 0, 1);
  const own = segmentYaw(line, i);
  const other = part < 0.5 ? (i > 0 ? segmentYaw(line, i - 1) : own) : i + 2 < line.n ? segmentYaw(line, i + 1) : own;
  const bend = wrap(other - own);
  const yaw = Math.abs(bend) < 0.3 ? own + bend * Math.abs(part - 0.5) : own;
  return { x: line.x[i] + part * (line.x[i + 1] - line.x[i]), y: line.y[i] + part * (line.y[i + 1] - line.y[i]), yaw };
}

/** Trajectory pieces in order of time, complete with what the file may leave out; null if there are none. */
function makePieces(rows) {
  const pieces = [];
  let s = 0;
  for (const row of list(rows).map(record)) {
    const duration = Math.max(0, number(row.duration));
    const last = pieces[pieces.length - 1];
    const t = number(row.t, last ? last.t + last.duration : 0);
    if (finite(row.turn)) {
      pieces.push({ t, duration, turn: row.turn, s: number(row.s, s), from: finite(row.from) ? row.from : null });
      s = number(row.s, s);
    } else {
      const piece = { t, duration, s: number(row.s, s), v: number(row.speed), a: number(row.acceleration), j: number(row.jerk) };
      pieces.push(piece);
      s = piece.s + duration * (piece.v + duration * (piece.a / 2 + (duration * piece.j) / 6));
    }
  }
  return pieces.length ? pieces : null;
}

/** The motion of a plan: by its trajectory, or, without one, along the path at one metre per unit. */
function makeMotion(plan) {
  const line = makeLine(plan.polyline);
  const pieces = makePieces(record(plan.trajectory).pieces);
  const timed = pieces !== null;
  const used = pieces || [{ t: 0, duration: line.length, s: 0, v: 1, a: 0, j: 0 }];
  const starts = Float64Array.from(used, (piece) => piece.t);
  const last = used[used.length - 1];
  const duration = last.t + last.duration;
  const travelled = along(last, last.duration).s;
  const ratio = timed && travelled > 0 && line.length > 0 && Math.abs(line.length / travelled - 1) < 0.02 ? line.length / travelled : 1;
  const at = (t) => {
    const piece = used[floorIndex(starts, t)];
    const state = along(piece, clamp(t - piece.t, 0, piece.duration));
    const place = placeAt(line, state.s * ratio);
    if (!place) return null;
    const yaw = state.turned === undefined ? place.yaw : (piece.from === null ? place.yaw - piece.turn : piece.from) + state.turned;
    return { t, s: state.s, x: place.x, y: place.y, yaw, v: state.v, a: state.a, j: state.j, moving: state.turned === undefined };
  };
  return { timed, duration, line, pieces: used, at, samples: null };
}

/** State of one piece after dt: along the path, or turned so far in place (rest to rest, symmetric). */
function along(piece, dt) {
  if (piece.turn !== undefined) {
    const p = piece.duration > 0 ? dt / piece.duration : 1;
    return { s: piece.s, v: 0, a: 0, j: 0, turned: piece.turn * p * p * p * (10 + p * (6 * p - 15)) };
  }
  return {
    s: piece.s + dt * (piece.v + dt * (piece.a / 2 + (dt * piece.j) / 6)),
    v: piece.v + dt * (piece.a + (dt * piece.j) / 2),
    a: piece.a + dt * piece.j,
    j: piece.j,
  };
}

/** The motion of a drive: rows [t, x, y, yaw, v, w]. */
function makeDrive(run) {
  const rows = list(run.driven).filter((row) => Array.isArray(row) && finite(row[0]) && finite(row[1]) && finite(row[2]));
  const t = Float64Array.from(rows, (row) => row[0]);
  const line = makeLine(rows.map((row) => [row[1], row[2]]));
  const s = new Float64Array(rows.length);
  for (let i = 1; i < rows.length; i += 1) s[i] = s[i - 1] + Math.hypot(rows[i][1] - rows[i - 1][1], rows[i][2] - rows[i - 1][2]);
  const duration = rows.length ? t[rows.length - 1] : number(run.time);
  const at = (time) => {
    if (!rows.length) return null;
    const i = Math.min(floorIndex(t, time), Math.max(0, rows.length - 2));
    const a = rows[i];
    const b = rows[Math.min(i + 1, rows.length - 1)];
    const part = b[0] > a[0] ? clamp((time - a[0]) / (b[0] - a[0]), 0, 1) : 0;
    const mix = (k) => number(a[k]) + part * (number(b[k]) - number(a[k]));
    return { t: time, s: s[i] + part * (s[Math.min(i + 1, rows.length - 1)] - s[i]), x: mix(1), y: mix(2), yaw: number(a[3]) + part * wrap(number(b[3]) - number(a[3])), v: mix(4), w: mix(5), moving: true };
  };
  return { timed: true, duration, line, rows, t, s, at, samples: null };
}

/** Evenly spaced states for looking up the place nearest to a pointer. */
function samplesOf(motion) {
  if (!motion.samples) {
    const count = 2000;
    motion.samples = [];
    for (let i = 0; i <= count; i += 1) {
      const state = motion.at((motion.duration * i) / count);
      if (state) motion.samples.push(state);
    }
  }
  return motion.samples;
}

/** A mover's place over time, or null while it is not there. */
function makeMover(mover) {
  const rows = list(mover.states).filter((row) => Array.isArray(row) && finite(row[0]) && finite(row[1]) && finite(row[2]));
  const t = Float64Array.from(rows, (row) => row[0]);
  const at = (time) => {
    if (!rows.length) return null;
    const i = floorIndex(t, time);
    const a = rows[i];
    if (a.length > 3 && !a[3]) return null;
    const b = rows[Math.min(i + 1, rows.length - 1)];
    const part = b[0] > a[0] ? clamp((time - a[0]) / (b[0] - a[0]), 0, 1) : 0;
    return { x: a[1] + part * (b[1] - a[1]), y: a[2] + part * (b[2] - a[2]), yaw: finite(a[4]) ? a[4] : 0 };
  };
  return { shape: record(mover.shape), rows, at };
}

/** Corners of a box or polygon footprint (also as an outline { points, radius }), null for a disc. */
function cornersOf(shape) {
  if (Array.isArray(shape.box)) {
    const [l, w] = [number(shape.box[0]) / 2, number(shape.box[1]) / 2];
    return [[-l, -w], [l, -w], [l, w], [-l, w]];
  }
  const polygon = [shape.polygon, record(shape.polygon).points, shape.points].find(Array.isArray);
  return polygon && polygon.length > 1 ? pointsOf(polygon) : null;
}

const radiusOf = (shape) => {
  const corners = cornersOf(shape);
  return (corners ? Math.max(0, ...corners.map((p) => Math.hypot(p[0], p[1]))) : number(shape.disc)) + number(shape.radius);
};

/** Curves of a plan over time, each { x, y } as arrays; jumps are two samples at one time. */
function planCurves(motion, profile) {
  const out = { speed: curve(), acceleration: curve(), jerk: curve(), curvature: curve(), clearance: curve() };
  const bent = columns(profile.curvature);
  const free = columns(profile.clearance);
  const travelled = motion.pieces.length ? along(motion.pieces[motion.pieces.length - 1], motion.pieces[motion.pieces.length - 1].duration).s : 0;
  const scale = (table) => (table.x.length && travelled > 0 ? table.x[table.x.length - 1] / travelled : 1);
  const [bentScale, freeScale] = [scale(bent), scale(free)];
  for (const piece of motion.pieces) {
    const count = Math.max(2, Math.ceil((1400 * piece.duration) / (motion.duration || 1)));
    for (let i = 0; i <= count; i += 1) {
      const dt = (piece.duration * i) / count;
      const state = along(piece, dt);
      if (motion.timed) {
        push(out.speed, piece.t + dt, state.v);
        push(out.acceleration, piece.t + dt, state.a);
        push(out.jerk, piece.t + dt, state.j);
      }
      if (bent.x.length) push(out.curvature, piece.t + dt, lookUp(bent.x, bent.y, state.s * bentScale));
      if (free.x.length) push(out.clearance, piece.t + dt, lookUp(free.x, free.y, state.s * freeScale));
    }
  }
  return out;
}

/** The speed ceiling over time: rows [s, v] looked up where the motion is. */
function ceilingCurve(motion, rows) {
  const table = columns(rows);
  const out = curve();
  if (table.x.length && motion.timed) for (const state of samplesOf(motion)) push(out, state.t, lookUp(table.x, table.y, state.s));
  return out;
}

/** Curves of a drive: measured speed, acceleration over 0.2 s, turn rate, distances. */
function driveCurves(motion, profile) {
  const out = { speed: curve(), acceleration: curve(), turnRate: curve(), clearance: columns(profile.clearance), separation: columns(profile.separation) };
  const step = Math.max(1, Math.floor(motion.rows.length / 3000));
  for (let i = 0; i < motion.rows.length; i += step) {
    const row = motion.rows[i];
    if (finite(row[4])) push(out.speed, row[0], row[4]);
    if (finite(row[5])) push(out.turnRate, row[0], row[5]);
    const [before, after] = [motion.at(Math.max(0, row[0] - 0.1)), motion.at(Math.min(motion.duration, row[0] + 0.1))];
    if (finite(row[4]) && after.t > before.t) push(out.acceleration, row[0], (after.v - before.v) / (after.t - before.t));
  }
  return out;
}

const curve = () => ({ x: [], y: [] });
const push = (to, x, y) => {
  to.x.push(x);
  to.y.push(y);
};
const columns = (rows) => {
  const kept = pointsOf(rows);
  return { x: kept.map((row) => row[0]), y: kept.map((row) => row[1]) };
};
