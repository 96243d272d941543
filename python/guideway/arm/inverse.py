"""Inverse kinematics: one posture for a pose, all branches of a pose, and one branch along a whole path with its singularities and joint limits."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from guideway.arm.extra import pinocchio
from guideway.arm.model import Arm, frame_of
from guideway.errors import BadParameter, NoPath

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

SINGULAR = 0.005
"""A path that comes nearer to a singular posture than this smallest singular value of the tip's Jacobian (m, rad) is refused."""

JUMP = 0.3
"""Largest step of a joint (rad) from one point of a path to the next that counts as one branch; points are added between others before."""

_STEP, _ROUNDS, _DEPTH, _EVERY = 1e-10, 30, 12, 16


@dataclass(frozen=True)
class Branch:
    """A branch of the inverse kinematics along a path: postures ``q`` (n, joints) at parameters ``w`` (n,), the smallest singular value of the
    tip's Jacobian there ``singular`` (n,), and the distance to the nearest joint limit ``margin`` (n,), rad."""

    w: Floats
    q: Floats
    singular: Floats
    margin: Floats

    @property
    def report(self) -> dict[str, Any]:
        """The worst of it: values and where (parameter 0 ... 1)."""
        near, tight = int(np.argmin(self.singular)), int(np.argmin(self.margin))
        return {
            "smallest_singular_value": float(self.singular[near]),
            "singular_at": float(self.w[near]),
            "joint_limit_margin": float(self.margin[tight]),
            "joint_limit_at": float(self.w[tight]),
            "points": len(self.w),
        }


class Solver:
    """Damped Newton steps to a pose of the tip of one arm."""

    def __init__(self, arm: Arm) -> None:
        self.arm, self.pin, self.model, self.data = arm, pinocchio(), arm.model, arm._data
        self.index = frame_of(arm.model, arm.tip)
        base = arm.model.frames[frame_of(arm.model, arm.base)]
        if base.parentJoint != 0:
            raise BadParameter(f"link {arm.base!r} moves with the arm: name a link that stands still as the frame of the poses")
        self.base = base.placement

    def target(self, pose: Floats) -> Any:
        """A pose (4, 4) in the base's frame as the model's own kind, in the frame of the root."""
        return self.base * self.pin.SE3(np.ascontiguousarray(pose[:3, :3]), np.ascontiguousarray(pose[:3, 3]))

    def residual(self, q: Floats, target: Any) -> Floats:
        """What is missing to the pose, as a twist (6,) in the tip's frame; the Jacobian is that of the same posture."""
        self.pin.computeJointJacobians(self.model, self.data, self.arm.coupling @ q + self.arm.offset)
        self.jacobian = self.pin.getFrameJacobian(self.model, self.data, self.index, self.pin.LOCAL) @ self.arm.coupling
        return self.pin.log6(self.pin.updateFramePlacement(self.model, self.data, self.index).actInv(target)).vector

    def solve(self, target: Any, q: Floats, rounds: int = _ROUNDS) -> tuple[Floats, bool]:
        """The posture next to ``q`` that reaches the pose, and whether it does."""
        missing = self.residual(q, target)
        for _ in range(rounds):
            step = self._step(missing)
            size = float(np.max(np.abs(step)))
            q = q + step * min(1.0, 0.5 / max(size, 1e-300))
            missing = self.residual(q, target)
            if size < _STEP:
                return q, bool(np.max(np.abs(missing)) < 1e-9)
            if size > 1e6:
                break
        return q, False

    def _step(self, missing: Floats) -> Floats:
        """A Newton step; where the Jacobian is nearly singular or not square, a damped one of least squares."""
        jacobian = self.jacobian
        if jacobian.shape[0] == jacobian.shape[1]:
            try:
                step = np.linalg.solve(jacobian, missing)
            except np.linalg.LinAlgError:
                step = np.full(len(missing), math.inf)
            if np.max(np.abs(step)) < 1.0:
                return step
        damping = 1e-4 * float(missing @ missing) + 1e-12
        return jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + damping * np.eye(6), missing)


def solve(arm: Arm, pose: ArrayLike, q: ArrayLike) -> Floats:
    """The posture next to ``q`` (joints,) with the tip at ``pose`` (4, 4) in the base's frame; raises ``NoPath`` where there is none in reach."""
    solver = Solver(arm)
    target = np.asarray(pose, float)
    found, reached = solver.solve(solver.target(target), np.asarray(q, float))
    if not reached:
        raise _unreachable(solver, target, found, "")
    return found


def branches(arm: Arm, pose: ArrayLike, *, draws: int = 400, seed: int = 0) -> Floats:
    """All postures (m, joints) of an arm of six joints with the tip at ``pose`` (4, 4), angles from -pi to pi, within the joint limits.

    They are found by Newton steps from ``draws`` random postures (the same for the same seed) and sorted; a branch with a very small basin may be
    missed. Raises ``NoPath`` where there is none, ``BadParameter`` for other arms than those of six joints, whose postures cannot be counted.
    """
    if arm.joints != 6:
        raise BadParameter(f"branches are counted for arms of six joints only, {arm.name} has {arm.joints}: choose a posture by hand")
    solver, target, found = Solver(arm), np.asarray(pose, float), []
    place = solver.target(target)
    for guess in np.random.default_rng(seed).uniform(-math.pi, math.pi, (draws, arm.joints)):
        q, reached = solver.solve(place, guess)
        q = math.pi - np.mod(math.pi - q, 2 * math.pi)
        if reached and all(np.max(np.abs(np.sin((q - other) / 2))) > 1e-6 for other in found):
            found.append(q)
    kept = [q for q in found if _fits(arm, q)]
    if not kept:
        raise _unreachable(solver, target, solver.solve(place, np.zeros(arm.joints))[0], "")
    return np.array(sorted(kept, key=lambda q: tuple(np.round(q, 6))))


def _fits(arm: Arm, q: Floats) -> bool:
    return bool((q >= arm.lower).all() and (q <= arm.upper).all())


def follow(arm: Arm, pose_at: Callable[[Floats], Floats], w: Floats, posture: ArrayLike | None = None) -> Branch:
    """The postures along a path of poses in one branch.

    ``pose_at`` gives poses (n, 4, 4) in the base's frame for parameters (n,); ``w`` increases. The first posture is the one next to ``posture``
    (default: the middle of the joint ranges); each further one continues the one before. Raises ``NoPath`` with the place where a point is out of
    reach, where the path runs into a singular posture, and where it leaves the joint limits.
    """
    solver = Solver(arm)
    start = np.asarray(posture if posture is not None else middle(arm), float)
    if start.shape != (arm.joints,) or not np.isfinite(start).all():
        raise BadParameter(f"posture of shape {start.shape} cannot be used: {arm.joints} finite joint values, rad")
    poses = pose_at(w)
    coarse = np.unique(np.append(np.arange(0, len(w), _EVERY), len(w) - 1)) if arm.joints == 6 else np.arange(len(w))
    q = _walk(solver, pose_at, w[coarse], poses[coarse], start)
    if len(coarse) < len(w):
        guess = np.column_stack([np.interp(w, w[coarse], column) for column in q.T])
        filled = _polished(arm, poses, guess)
        q = filled if filled is not None else _walk(solver, pose_at, w, poses, start)
    return _checked(arm, w, q, poses)


def _walk(solver: Solver, pose_at: Callable[[Floats], Floats], w: Floats, poses: Floats, start: Floats) -> Floats:
    """One posture after the other."""
    q = np.empty((len(w), len(start)))
    q[0], reached = solver.solve(solver.target(poses[0]), start, 200)
    if not reached:
        raise _unreachable(solver, poses[0], q[0], " at the start of the path")
    for k in range(1, len(w)):
        guess = 2 * q[k - 1] - q[k - 2] if k > 1 else q[0]
        q[k], reached = solver.solve(solver.target(poses[k]), guess, 8)
        if not reached or np.max(np.abs(q[k] - q[k - 1])) > JUMP:
            q[k] = _creep(solver, pose_at, (w[k - 1], w[k]), q[k - 1])
    return q


def _polished(arm: Arm, poses: Floats, q: Floats) -> Floats | None:
    """All postures at once by Newton steps from good guesses; None where one of them does not settle near its guess."""
    guess = q
    for _ in range(8):
        found, jacobians = arm.kinematics(q)
        turn = np.einsum("kij,klj->kil", poses[:, :3, :3], found[:, :3, :3])
        spin = np.stack([turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]], axis=1) / 2
        missing = np.concatenate([poses[:, :3, 3] - found[:, :3, 3], spin], axis=1)
        try:
            step = np.linalg.solve(jacobians, missing[..., None])[..., 0]
        except np.linalg.LinAlgError:
            return None
        q = q + step
        if np.max(np.abs(q - guess)) > JUMP / 2:
            return None
        if np.max(np.abs(step)) < _STEP:
            return q
    return None


def middle(arm: Arm) -> Floats:
    """The middle of the joint ranges, 0 where there is none."""
    inside = np.isfinite(arm.lower) & np.isfinite(arm.upper)
    return np.where(inside, (np.where(inside, arm.lower, 0) + np.where(inside, arm.upper, 0)) / 2, 0.0)


def _creep(solver: Solver, pose_at: Callable[[Floats], Floats], span: tuple[float, float], q: Floats) -> Floats:
    """From one point of the path to the next by steps as small as it takes."""
    at, end, step = span[0], span[1], (span[1] - span[0]) / 2
    least = (span[1] - span[0]) / 2**_DEPTH
    while at < end:
        to = min(at + step, end)
        pose = pose_at(np.array([to]))[0]
        found, reached = solver.solve(solver.target(pose), q, 12)
        if reached and np.max(np.abs(found - q)) <= JUMP:
            at, q, step = to, found, 2 * step
        elif step > least:
            step /= 2
        elif reached or _reachable(solver, pose_at(np.array([end]))[0]):
            raise _singular(solver.arm, pose, to, _smallest(solver.arm, q))
        else:
            pose = pose_at(np.array([end]))[0]  # the last one that is reached is as good as there
            raise _unreachable(solver, pose, solver.solve(solver.target(pose), q, 200)[0], f" at {100 * end:.4g} % of the path")
    return q


def _reachable(solver: Solver, pose: Floats, draws: int = 60) -> bool:
    """Does any posture reach the pose? Then it was a singular posture that stood in the way, not the end of the arm."""
    guesses = np.random.default_rng(0).uniform(-math.pi, math.pi, (draws, solver.arm.joints))
    return any(solver.solve(solver.target(pose), guess)[1] for guess in guesses)


def _smallest(arm: Arm, q: Floats) -> float:
    return float(np.linalg.svd(arm.jacobian(q), compute_uv=False)[-1])


def _checked(arm: Arm, w: Floats, q: Floats, poses: Floats) -> Branch:
    jacobians = arm.jacobian(q)
    smallest = np.asarray(np.linalg.svd(jacobians, compute_uv=False)[:, -1], float)
    near = int(np.argmin(smallest))
    if smallest[near] < SINGULAR:
        raise _singular(arm, poses[near], float(w[near]), float(smallest[near]))
    if arm.joints == 6:
        sides = np.sign(np.linalg.det(jacobians))
        flips = np.flatnonzero(np.diff(sides))
        if len(flips):
            raise _singular(arm, poses[flips[0]], float(w[flips[0]]), 0.0)
    margin = np.minimum(q - arm.lower, arm.upper - q)
    worst = np.unravel_index(np.argmin(margin), margin.shape)
    if margin[worst] < 0:
        name, value = arm.names[worst[1]], q[worst]
        raise NoPath(
            f"the path leaves the range of {name} at {100 * w[worst[0]]:.4g} % of the way: {value:.4f} rad, allowed: "
            f"{arm.lower[worst[1]]:.4f} to {arm.upper[worst[1]]:.4f} rad. Start from another posture, or move the path"
        )
    return Branch(w, q, smallest, np.asarray(margin.min(axis=1), float))


def _singular(arm: Arm, pose: Floats, w: float, value: float) -> NoPath:
    x, y, z = pose[:3, 3]
    return NoPath(
        f"the path runs into a singular posture of {arm.name} at {100 * w:.4g} % of the way, point ({x:.4f}, {y:.4f}, {z:.4f}) m: smallest singular "
        f"value of the Jacobian {value:.2g}, at least {SINGULAR:g} is asked for. Turn the tool, move the path, or choose another posture"
    )


def _unreachable(solver: Solver, pose: Floats, q: Floats, where: str) -> NoPath:
    x, y, z = pose[:3, 3]
    missing = solver.residual(q, solver.target(pose))
    off = f"the nearest that was found is {np.linalg.norm(missing[:3]):.3g} m and {np.linalg.norm(missing[3:]):.3g} rad away"
    return NoPath(
        f"point ({x:.4f}, {y:.4f}, {z:.4f}) m{where} cannot be reached by {solver.arm.name} with this orientation of {solver.arm.tip}: {off}. "
        "Move the path, turn the tool, or start from another posture"
    )
