// Forward kinematics. Poses are 3 x 4 matrices, row by row, of 12 numbers; lengths in m, angles in rad.

const STILL = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];

function after(a, b) {
  const out = new Array(12);
  for (let r = 0; r < 12; r += 4) {
    for (let c = 0; c < 4; c += 1) out[r + c] = a[r] * b[c] + a[r + 1] * b[4 + c] + a[r + 2] * b[8 + c] + (c === 3 ? a[r + 3] : 0);
  }
  return out;
}

const moved = (pose, [x, y, z]) => [0, 4, 8].map((r) => pose[r] * x + pose[r + 1] * y + pose[r + 2] * z + pose[r + 3]);
const originOf = (pose) => [pose[3], pose[7], pose[11]];

/** The pose that a joint makes with its value: a turn about its axis, or a slide along it. */
function jointPose({ axis: [x, y, z], slides }, value) {
  if (slides) return [1, 0, 0, x * value, 0, 1, 0, y * value, 0, 0, 1, z * value];
  const [c, s] = [Math.cos(value), Math.sin(value)];
  const k = 1 - c;
  return [c + x * x * k, x * y * k - z * s, x * z * k + y * s, 0, y * x * k + z * s, c + y * y * k, y * z * k - x * s, 0, z * x * k - y * s, z * y * k + x * s, c + z * z * k, 0];
}

const isPose = (value) => Array.isArray(value) && value.length === 12 && value.every(finite);

/** The chain of a record's robot, or null where it has none that can be used. */
function makeChain(data) {
  const given = record(data);
  const joints = list(given.joints).map(record);
  const sound = joints.length && joints.every((joint, k) => isPose(joint.pose) && list(joint.axis).length === 3 && joint.axis.every(finite) && Number.isInteger(joint.parent) && joint.parent >= 0 && joint.parent <= k);
  if (!sound) return null;
  const links = list(given.links).map(record).filter((link) => isPose(link.pose) && Number.isInteger(link.joint) && link.joint >= 0 && link.joint <= joints.length);
  const tip = links.find((link) => link.name === given.tip) || { joint: joints.length, pose: STILL };
  const drivers = joints.map((joint) => list(joint.factors).reduce((best, factor, i, all) => (Math.abs(factor) > Math.abs(all[best] || 0) ? i : best), 0));
  /** Poses of the root and of all joints for the driven joints' values. */
  const place = (q) => {
    const poses = [STILL];
    for (const joint of joints) {
      const value = list(joint.factors).reduce((sum, factor, i) => sum + number(factor) * number(q[i]), number(joint.offset));
      poses.push(after(after(poses[joint.parent], joint.pose), jointPose(joint, value)));
    }
    return poses;
  };
  /** Driven joint that moves a joint of the chain. */
  const driver = (k) => (k > 0 ? drivers[k - 1] : null);
  return { joints, links, tip, place, driver, tipOf: (poses) => after(poses[tip.joint], tip.pose) };
}
