"""Files of a timed motion: the record (traj.json), joint CSV, URScript, ROS JointTrajectory."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from guideway import _core
from guideway.arm.limits import JointLimits
from guideway.arm.measures import measures
from guideway.arm.motion import RATE, ArmMotion, pieces_of
from guideway.arm.paths import JointPath
from guideway.arm.skeleton import chain
from guideway.errors import BadParameter

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from guideway.arm.model import Arm

    Floats = NDArray[np.float64]

LOOKAHEAD, GAIN = 0.1, 300
"""Look-ahead time (s, 0.03 to 0.2) and gain (100 to 2000) of ``servoj``."""

OTHERS = ("abb_irb6700_235_265", "abb_irb120_3_58")
"""Arms that ship with the package and do not understand URScript."""

PIECE = ("t", "s", "speed", "acceleration", "jerk", "duration")


def record(motion: ArmMotion, rate: float = RATE) -> dict[str, Any]:
    """The record of ``traj.json``: the sampled motion ``t, q, qd, qdd`` at a rate (Hz), and everything that led to it.

    ``tau_model`` is what the arm's model asks for, where torques counted; ``tau`` is kept for measured ones. Infinite values are None.
    """
    sample, limits = motion.sample(rate), motion.limits.to_dict(len(motion.names))
    found: dict[str, Any] = {
        "guideway": _core.__version__,
        "schema": 1,
        "kind": "arm",
        "robot": robot_record(motion),
        "joints": list(motion.names),
        "duration": motion.duration,
        "limits": limits,
        "t": _rounded(sample["t"]),
        **{key: _rounded(sample[key]) for key in ("q", "qd", "qdd")},
    }
    if motion.arm is not None and "torque" in limits:
        found["tau_model"] = _rounded(motion.torques(sample))
    path = motion.path.path
    found["path"] = {
        "degree": path.degree,
        "knots": path.knots.tolist(),
        "control_points": path.control_points.tolist(),
        "length": path.length,
        "source": motion.path.source,
    }
    found["pieces"] = [dict(zip(PIECE, row, strict=True)) for row in motion.pieces.tolist()]
    found["grid"] = {"s": [], "x": [], "mvc": [], "active": [], **motion.grid}
    found["report"] = {**{key: value for key, value in motion.report.items() if key != "certificate"}, "path": motion.path.report}
    found["report"]["measures"] = measures(motion)
    found["certificate"] = motion.report.get("certificate")
    return plain(found)


def robot_record(motion: ArmMotion) -> dict[str, Any] | None:
    """Which arm it is, and what was assumed of it."""
    arm = motion.arm
    if arm is None:
        return None
    viscous, coulomb = arm.friction.arrays(arm.joints)
    return {
        "name": arm.name,
        "source": arm.source,
        "tip": arm.tip,
        "frame": arm.base,
        "inertials": arm.inertials,
        "payload": {"mass": arm.payload.mass, "at": list(arm.payload.at), "inertia": arm.payload.matrix().tolist()},
        "friction": {"viscous": viscous.tolist(), "coulomb": coulomb.tolist()},
        "range": {"lower": arm.lower.tolist(), "upper": arm.upper.tolist()},
        "chain": chain(arm),
    }


def _rounded(values: Floats) -> Any:
    return np.round(values, 9).tolist()


def plain(value: Any) -> Any:
    """Data as JSON has them: lists and numbers; what is not finite becomes None."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def csv_text(motion: ArmMotion, rate: float = RATE) -> str:
    """The motion as CSV: ``t``, then for every joint its position, and ``_velocity``, ``_acceleration`` behind its name; rad, s."""
    sample = motion.sample(rate)
    heads = ["t", *(f"{name}{end}" for end in ("", "_velocity", "_acceleration") for name in motion.names)]
    table = np.column_stack([sample["t"], sample["q"], sample["qd"], sample["qdd"]])
    return "\n".join([",".join(heads), *(",".join(f"{v:.10g}" for v in row) for row in table.tolist())]) + "\n"


def urscript(motion: ArmMotion, rate: float = RATE, lookahead: float = LOOKAHEAD, gain: int = GAIN) -> str:
    """A URScript program: a slow move to the start, then one ``servoj`` per step of 1/``rate`` s, then a stop.

    Raises ``BadParameter`` for arms that do not have six joints, arms of the package that are not of Universal Robots, and settings that ``servoj``
    refuses. An arm whose name does not begin with "ur" gets a warning as a comment: it may be one of Universal Robots under another name.
    """
    name = motion.arm.name if motion.arm is not None else ""
    if name in OTHERS:
        raise BadParameter(f"URScript is for arms of Universal Robots, not for {name}: use --csv or --ros (csv_text, ros_yaml)")
    if len(motion.names) != 6:
        raise BadParameter(f"URScript is for arms of six joints, this motion has {len(motion.names)}")
    if not (0.03 <= lookahead <= 0.2 and 100 <= gain <= 2000 and 10 <= rate <= 500):
        raise BadParameter("servoj takes a look-ahead of 0.03 to 0.2 s and a gain of 100 to 2000, at 10 to 500 Hz")
    count = math.ceil(motion.duration * rate - 1e-9)
    rows = motion.sample(times=np.arange(count + 1) / rate)["q"].tolist()
    step = f"{1 / rate:.9g}"
    lines = [
        f"# Guideway {_core.__version__}: {motion.duration:.6f} s along {motion.path.path.length:.6f} rad, a step of {step} s each",
        "# Joints: " + ", ".join(motion.names),
        *(
            []
            if name.lower().startswith("ur")
            else [f"# WARNING: this motion is for {name or 'an arm without a name'}; only arms of Universal Robots run it."]
        ),
        "# Check the way to the start, the payload and the safety settings of the controller before running it.",
        "def guideway_motion():",
        f"  movej({_vector(rows[0])}, a=0.5, v=0.25)",
        *(f"  servoj({_vector(row)}, 0, 0, {step}, {lookahead:g}, {gain})" for row in rows[1:]),
        "  stopj(2.0)",
        "end",
        "guideway_motion()",
    ]
    return "\n".join(lines) + "\n"


def ros_yaml(motion: ArmMotion, rate: float = 100.0) -> str:
    """The motion as a ROS ``trajectory_msgs/JointTrajectory`` in YAML, with positions, velocities and accelerations of every point."""
    sample = motion.sample(rate)
    lines = ["header:", "  stamp: {sec: 0, nanosec: 0}", "  frame_id: ''", "joint_names:", *(f"- {name}" for name in motion.names), "points:"]
    before = -1
    for t, q, qd, qdd in zip(*(sample[key].tolist() for key in ("t", "q", "qd", "qdd")), strict=True):
        moment = round(t * 1e9)
        if moment <= before:
            continue
        before = moment
        lines += [
            f"- positions: {_vector(q)}",
            f"  velocities: {_vector(qd)}",
            f"  accelerations: {_vector(qdd)}",
            "  effort: []",
            f"  time_from_start: {{sec: {moment // 10**9}, nanosec: {moment % 10**9}}}",
        ]
    return "\n".join(lines) + "\n"


def _vector(values: list[float]) -> str:
    return "[" + ", ".join(f"{value:.9f}" for value in values) + "]"


def load_motion(given: dict[str, Any], arm: Arm | None = None) -> ArmMotion:
    """The motion that a record holds; ``arm`` is the arm it is for, where torques or collisions are asked for later.

    Raises ``BadParameter`` where the record holds no motion of an arm, or one of other joints.
    """
    try:
        shape, rows = given["path"], given["pieces"]
        path = _core.Path(shape["degree"], shape["knots"], shape["control_points"])
        names, limits = tuple(given["joints"]), JointLimits.of(given["limits"])
        pieces, grid, report = pieces_of(rows), dict(given.get("grid") or {}), dict(given.get("report") or {})
    except (KeyError, TypeError, ValueError) as error:
        raise BadParameter(
            f"the record holds no motion of an arm ({type(error).__name__}: {error}): use a traj.json that guideway arm wrote"
        ) from None
    if arm is not None and arm.names != names:
        raise BadParameter(f"the motion's joints {', '.join(names)} are not those of {arm.name}: {', '.join(arm.names)}")
    return ArmMotion(JointPath(path, names, report.pop("path", None), shape.get("source")), pieces, limits, arm, grid, report)
