// Surfaces of links as triangles with normals: unpacked from the report, or capsules along the chain.

const CREASE = 0.8; // cosine between faces that are shaded as one smooth surface

function bytesOf(text) {
  const raw = atob(String(text));
  return Uint8Array.from(raw, (letter) => letter.charCodeAt(0)).buffer;
}

/** A body of the report: { joint, part, name, corners, normals }, nine numbers a triangle; null where it cannot be read. */
function unpack(part) {
  try {
    const steps = new Int16Array(bytesOf(part.corners));
    const faces = new Uint16Array(bytesOf(part.faces));
    const points = Float32Array.from(steps, (step, i) => step * part.scale + part.origin[i % 3]);
    return { joint: part.joint, part: part.part || "arm", name: part.name, ...shaded(points, faces) };
  } catch {
    return null;
  }
}

/** Triangles and their normals, smooth across gentle edges. */
function shaded(points, faces) {
  const count = faces.length / 3;
  const flat = new Float32Array(3 * count);
  const around = Array.from({ length: points.length / 3 }, () => []);
  for (let f = 0; f < count; f += 1) {
    const [a, b, c] = [0, 1, 2].map((k) => 3 * faces[3 * f + k]);
    const [ux, uy, uz, vx, vy, vz] = [points[b] - points[a], points[b + 1] - points[a + 1], points[b + 2] - points[a + 2], points[c] - points[a], points[c + 1] - points[a + 1], points[c + 2] - points[a + 2]];
    flat.set([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx], 3 * f);
    for (let k = 0; k < 3; k += 1) around[faces[3 * f + k]].push(f);
  }
  const size = (f) => Math.hypot(flat[3 * f], flat[3 * f + 1], flat[3 * f + 2]) || 1;
  const [corners, normals] = [new Float32Array(9 * count), new Float32Array(9 * count)];
  for (let f = 0; f < count; f += 1) {
    for (let k = 0; k < 3; k += 1) {
      const corner = faces[3 * f + k];
      const sum = [0, 0, 0];
      for (const other of around[corner]) {
        const dot = (flat[3 * f] * flat[3 * other] + flat[3 * f + 1] * flat[3 * other + 1] + flat[3 * f + 2] * flat[3 * other + 2]) / (size(f) * size(other));
        if (dot > CREASE) for (let c = 0; c < 3; c += 1) sum[c] += flat[3 * other + c];
      }
      const length = Math.hypot(...sum) || 1;
      for (let c = 0; c < 3; c += 1) {
        corners[9 * f + 3 * k + c] = points[3 * corner + c];
        normals[9 * f + 3 * k + c] = sum[c] / length;
      }
    }
  }
  return { corners, normals };
}

/** Unit vectors across a direction. */
function across([x, y, z]) {
  const length = Math.hypot(x, y, z);
  const d = length > 0 ? [x / length, y / length, z / length] : [0, 0, 1];
  const helper = Math.abs(d[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
  const u = [d[1] * helper[2] - d[2] * helper[1], d[2] * helper[0] - d[0] * helper[2], d[0] * helper[1] - d[1] * helper[0]];
  const size = Math.hypot(...u) || 1;
  const unit = u.map((value) => value / size);
  return [d, unit, [d[1] * unit[2] - d[2] * unit[1], d[2] * unit[0] - d[0] * unit[2], d[0] * unit[1] - d[1] * unit[0]]];
}

/** A capsule from one point to another, a ball where they are one. */
function capsule(from, to, radius, joint) {
  const [d, u, v] = across(to.map((value, c) => value - from[c]));
  const [sides, rings] = [20, 6];
  const points = [];
  const ring = (center, angle) => {
    for (let i = 0; i < sides; i += 1) {
      const turn = (2 * Math.PI * i) / sides;
      for (let c = 0; c < 3; c += 1) points.push(center[c] + radius * (Math.sin(angle) * d[c] + Math.cos(angle) * (Math.cos(turn) * u[c] + Math.sin(turn) * v[c])));
    }
  };
  for (let k = 0; k <= rings; k += 1) ring(from, (-Math.PI / 2) * (1 - k / rings));
  for (let k = 0; k <= rings; k += 1) ring(to, (Math.PI / 2) * (k / rings));
  const faces = [];
  for (let k = 0; k <= 2 * rings; k += 1) {
    for (let i = 0; i < sides; i += 1) {
      const [a, b] = [k * sides + i, k * sides + ((i + 1) % sides)];
      faces.push(a, b, b + sides, a, b + sides, a + sides);
    }
  }
  return { joint, part: "arm", ...shaded(Float32Array.from(points), Uint32Array.from(faces)) };
}

/** Capsules from each joint to the joints that it carries and to the tip. */
function capsulesOf(chain) {
  const ends = chain.joints.map((joint, k) => [joint.parent, originOf(joint.pose), k + 1]).concat([[chain.tip.joint, originOf(chain.tip.pose), 0]]);
  const reach = ends.reduce((sum, [, at]) => sum + Math.hypot(...at), 0) || 1;
  return ends.flatMap(([parent, at, k]) => {
    const radius = reach * (0.042 - 0.02 * (parent / (chain.joints.length || 1)));
    const parts = Math.hypot(...at) > 1e-6 ? [capsule([0, 0, 0], at, radius, parent)] : [];
    return k ? [...parts, capsule([0, 0, 0], [0, 0, 0], radius * 1.25, k)] : parts;
  });
}
