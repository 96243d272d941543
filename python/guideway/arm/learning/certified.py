"""The certificate of a learned motion: everything but its torques, which no model at hand can certify."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from guideway.arm.collisions import Surroundings
    from guideway.arm.learning.loop import Trial
    from guideway.arm.learning.motion import Motion
    from guideway.arm.learning.task import Task
    from guideway.arm.motion import ArmMotion
    from guideway.arm.paths import JointPath

STEP = 1e-6
"""Speeds along the path at its ends from which on they are no rest, rad/s."""


def collisions_of(path: JointPath, around: Surroundings, clearance: float | None = None) -> dict[str, Any]:
    """Does the arm keep clear of itself and of what is ``around`` it, all along the path? Every motion along it then does, however fast it is."""
    from guideway.arm.collisions import check

    return check(around, path.path, clearance)


def certified(task: Task, path: JointPath, motion: Motion, collision: dict[str, Any] | None = None, trial: Trial | None = None) -> ArmMotion:
    """The motion as :func:`guideway.arm.time` makes them, with a certificate of speeds, accelerations, the tip, joint ranges, continuity and (where
    :func:`collisions_of` was asked) collisions in ``report["certificate"]``.

    Torques depend on what nobody states, so they are told, not certified: what the learned model expects, else what the motion's own ``trial``
    measured. A step of speed at start and stop is in ``report["speed_step"]``, rad/s along the path.
    """
    timed = motion.timed(path, task.limits, task.arm)
    certificate = replace(timed, limits=replace(task.limits, torque=None)).certify(collisions=False)
    certificate["checks"].append(_torque(task, motion, trial))
    certificate["collision"] = collision
    certificate["ok"] = certificate["ok"] and (collision is None or collision["ok"])
    ends = np.sqrt(motion.x[[0, -1]])
    if ends.max() > STEP:
        timed.report["speed_step"] = ends.round(9).tolist()
    timed.report["certificate"] = certificate
    return timed


def _torque(task: Task, motion: Motion, trial: Trial | None) -> dict[str, Any]:
    """What is known of the motion's torques; ``ok`` says that nothing was found against it, ``certified`` that this is no proof."""
    entry: dict[str, Any] = {"name": "torque", "limit": "torque", "ok": True, "certified": False}
    if motion.expected is not None:
        seen = motion.dense()
        share = np.abs(motion.expected(seen)) / task.torque
        at, joint = np.unravel_index(int(np.argmax(share)), share.shape)
        name = task.arm.names[joint]
        entry |= {"name": f"torque of {name}", "joint": name, "t": float(seen.t[at]), "s": float(seen.s[at]), "ratio": float(share[at, joint])}
        return entry | {"note": f"learned: expected {100 * entry['ratio']:.1f} % of the limit by the learned model"}
    if trial is not None:
        return entry | {
            "ratio": 1 + trial.measured,
            "note": f"learned: {100 * (1 + trial.measured):.1f} % of the limit measured in this motion's trial",
        }
    return entry | {"note": "learned: this motion was not measured yet, and the learner has no model of its torques"}
