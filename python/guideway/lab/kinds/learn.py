"""Runs of learning: how fast an arm may go along a path whose torques are not known, trial by trial, beside the optimum of the true plant."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from guideway.errors import BadParameter, GuidewayError, Infeasible
from guideway.lab.experiment import Experiment, Metric, Run
from guideway.lab.extra import needed
from guideway.lab.kinds import Outcome

if TYPE_CHECKING:
    from guideway.arm.learning import Task
    from guideway.arm.learning.loop import Learned
    from guideway.plants.arm import IdealArm
    from guideway.plants.arm_mujoco import MujocoArm

FIELDS = ("learner", "trials")
"""``learner`` (:data:`guideway.arm.learning.LEARNERS`) with ``set`` as its settings, and how many ``trials`` it may have (6)."""
WORLD_FIELDS = ("make", "robot", "path", "acceleration", "torque", "plant", "payload", "payload_at", "friction", "noise", "random")
"""``make`` is ``arm``: a ``robot`` (ur5e) along a ``path`` (star) with limits of ``acceleration`` (rad/s2) and ``torque`` (N m, per joint), on a
``plant`` (ideal or mujoco) with ``payload`` (kg) ``payload_at`` (m), ``friction``, ``noise`` (N m); ``random``: a plant drawn from the seed."""
QUERY_FIELDS: tuple[str, ...] = ()
WORLD: Mapping[str, Any] = {
    "make": "arm",
    "robot": "ur5e",
    "path": "star",
    "acceleration": 10.0,
    "plant": "ideal",
    "payload": 0.0,
    "payload_at": (0.0, 0.0, 0.08),
    "friction": "reference",
    "noise": 0.5,
    "random": False,
}
NEAR, CLOSE = 1.01, 0.01
"""T/T* that counts as reached; share of a torque limit that a violation may have."""
ROUNDING = 1e-9
SOON, LATE = 1.05, 1.03
"""T/T* that trials four and six are to have."""

METRICS = {
    metric.name: metric
    for metric in (
        Metric("ratio", "", "lower", 4),
        Metric("trials", "", "lower", 1),
        Metric("to_feasible", "trials", "lower", 1),
        Metric("to_measured", "trials", "lower", 1),
        Metric("to_near", "trials", "lower", 1),
        Metric("first_ratio", "", "lower", 4),
        Metric("last_ratio", "", "lower", 4),
        Metric("soon", "", "higher", 3),
        Metric("late", "", "higher", 3),
        Metric("bound_ratio", "", None, 4),
        Metric("violation", "%", "lower", 2),
        Metric("worst", "%", "lower", 2),
        Metric("time_over", "s", "lower", 3),
        Metric("feasible", "", "higher", 3),
        Metric("close", "", "higher", 3),
        Metric("use", "", None, 4),
        Metric("within", "", "higher", 3),
        Metric("duration", "s", "lower", 4),
        Metric("optimum", "s", None, 4),
    )
}
"""``ratio``: T/T* of the fastest trial without a true violation (None: there is none). ``to_feasible``, ``to_measured``: the first trial without a
true and without a measured violation; ``to_near``: the first without a true one at T/T* of at most 1.01. ``first_ratio``, ``last_ratio``; ``soon``:
at most 1.05 in the fourth trial, ``late``: at most 1.03 in the sixth. Of the last trial: the true ``violation`` (below 0: inside), ``time_over``,
whether it is ``feasible``. ``worst``: largest violation from the third trial on, ``close``: it is at most 1 %. ``bound_ratio``: the largest lower
bound that the learner stated over T*. ``use``: how much of the limits of speed and acceleration the last motion takes, ``within``: at most all."""


def run(run: Run) -> Outcome:
    """Learns and judges. Raises ``Infeasible`` where standing still is already too much, and what a learner raises."""
    from guideway.arm.learning import make_learner
    from guideway.arm.learning.loop import run as tried

    world = {**WORLD, **run.world}
    task = _task(world["robot"], world["path"], float(world["acceleration"]), _torque(world))
    # first: a plant that cannot stand still is refused before any method is tried, in the same words for all
    best = _optimum(task, world, run.seed if world["random"] else None)
    plant = plant_of(task, world, run.seed)
    settings = dict(run.method.get("set", {}))
    if run.method["learner"] == "rl":
        settings.setdefault("seed", run.seed)
    found = tried(task, make_learner(run.method["learner"], task, settings), plant, int(run.method.get("trials", 6)))
    if not found.trials:
        raise Infeasible("the learner made no motion to try")
    measures, curve = judged(found, task, best)
    finite = all(value is None or math.isfinite(value) for value in measures.values())
    return Outcome(measures=measures, curve=curve, certified=finite)


def judged(found: Learned, task: Task, best: float) -> tuple[dict[str, Any], list[list[float]]]:
    """Measures, and the curve: T/T* of the best trial so far without a true violation, over trials."""
    trials = found.trials
    true = [math.nan if trial.true is None else trial.true for trial in trials]
    ratios = [trial.duration / best for trial in trials]
    good = [k for k, value in enumerate(true) if value <= 0]
    curve: list[list[float]] = []
    for k in good:
        if not curve or ratios[k] < curve[-1][1]:
            curve.append([k + 1, ratios[k]])
    late = max(true[2:], default=None)
    bounds = [trial.lower_bound / best for trial in trials if trial.lower_bound is not None]
    last, use = trials[-1], task.kinematic_ratio(found.motions[-1].dense())
    return {
        "ratio": curve[-1][1] if curve else None,
        "trials": len(trials),
        "to_feasible": good[0] + 1 if good else None,
        "to_measured": next((k + 1 for k, trial in enumerate(trials) if trial.clean), None),
        "to_near": next((k + 1 for k in good if ratios[k] <= NEAR), None),
        "first_ratio": ratios[0],
        "last_ratio": ratios[-1],
        "soon": None if len(ratios) < 4 else ratios[3] <= SOON,
        "late": None if len(ratios) < 6 else ratios[5] <= LATE,
        "bound_ratio": max(bounds, default=None),
        "violation": 100 * true[-1],
        "worst": None if late is None else 100 * late,
        "time_over": last.time_over,
        "feasible": true[-1] <= 0,
        "close": None if late is None else late <= CLOSE,
        "use": use,
        "within": use <= 1 + ROUNDING,
        "duration": last.duration,
        "optimum": best,
    }, curve


def plant_of(task: Task, world: Mapping[str, Any], seed: int) -> IdealArm | MujocoArm:
    """The plant of a world, its noise drawn from the seed."""
    from guideway.plants.arm import make_arm

    if world["random"]:
        return random_plant(task, seed)
    words = {name: world[name] for name in ("friction", "noise")}
    return make_arm(world["plant"], task, payload=float(world["payload"]), payload_at=tuple(world["payload_at"]), seed=seed, **words)


def random_plant(task: Task, number: int) -> IdealArm:
    """Payload 0 to 5 kg with a random centre within 0.1 m of (0, 0, 0.08) and random inertia, friction of each joint scaled by 0.5 to 1.5, half of
    the plants with all effects of friction, noise 0.1 to 1 N m. Raises ``Infeasible`` where standing still is already too much."""
    import guideway as gw
    from guideway.plants.arm import IdealArm, Sensors, usual_friction
    from guideway.plants.arm_friction import JointFriction

    joints = task.arm.joints
    draw = np.random.default_rng([20, number])
    mass, centre = draw.uniform(0, 5), np.array([0, 0, 0.08]) + draw.uniform(-1, 1, 3) * 0.1 / math.sqrt(3)
    viscous, coulomb = (np.asarray(part) * draw.uniform(0.5, 1.5, joints) for part in usual_friction(task))
    arm = task.arm.with_payload(gw.arm.Payload(mass, tuple(centre.tolist()), float(mass * draw.uniform(0.0005, 0.005))))
    friction = JointFriction.of(draw.choice(["reference", "full"]), tuple(viscous), tuple(coulomb))
    plant = IdealArm(arm, friction, Sensors.usual(float(draw.uniform(0.1, 1.0)), joints), task.torque, seed=number)
    still = plant.rows(task, np.full(len(task.s), 1e-4)).c
    if not (np.abs(still) < 0.98 * task.torque).all():
        raise Infeasible(f"random plant {number} cannot stand still on the path within its torques")
    return plant


def _torque(world: Mapping[str, Any]) -> tuple[float, ...]:
    from guideway.arm import STAR_TORQUE

    given: Sequence[float] = world.get("torque", STAR_TORQUE)
    return tuple(float(value) for value in given)


@lru_cache(maxsize=8)
def _task(robot: str, path: str, acceleration: float, torque: tuple[float, ...]) -> Task:
    import guideway as gw
    from guideway.arm.learning import Task

    arm = gw.arm.robot(robot)
    limits = gw.arm.JointLimits(speed=arm.speed_limits(), acceleration=acceleration, torque=torque)
    curve = gw.arm.star() if path == "star" else gw.arm.load_nurbs(path)
    return Task(gw.arm.joint_path(arm, curve).path, arm, limits)


_OPTIMA: dict[tuple[Any, ...], float] = {}


def _optimum(task: Task, world: Mapping[str, Any], number: int | None) -> float:
    """Duration of the optimum of the true plant, s, kept per process; ``number`` of a random plant."""
    from guideway.arm.learning.oracle import optimum

    named = (world["plant"], world["payload"], tuple(world["payload_at"]), world["friction"]) if number is None else (number,)
    key = (world["robot"], world["path"], world["acceleration"], _torque(world), *named)
    if key not in _OPTIMA:
        _OPTIMA[key] = optimum(task, plant_of(task, world, number or 0).rows).duration
    return _OPTIMA[key]


def check(experiment: Experiment) -> None:
    """Raises :class:`guideway.BadParameter` for what is not known, ``MissingExtra`` where arms do not work, before any run."""
    from guideway.arm.learning import LEARNERS
    from guideway.plants.arm import PLANTS
    from guideway.plants.arm_friction import KINDS

    for world in experiment.worlds:
        where = f"world {world['name']!r}"
        for name, allowed in (("make", ("arm",)), ("plant", PLANTS), ("friction", KINDS), ("random", (True, False))):
            value = world.get(name, None if name == "make" else WORLD[name])
            if value not in allowed or (name == "random" and not isinstance(value, bool)):
                raise BadParameter(f"{where}: {name} {value!r} is not known: one of {', '.join(map(str, allowed))}")
        for name in ("payload", "noise", "acceleration"):
            _number(where, name, world.get(name, 1.0))
        for name in ("torque", "payload_at"):
            if not isinstance(world.get(name, []), (list, tuple)):
                raise BadParameter(f"{where}: {name} {world[name]!r} is not a list of numbers")
    for method in experiment.methods:
        where, trials = f"method {method['name']!r}", method.get("trials", 6)
        if method.get("learner") not in LEARNERS:
            raise BadParameter(f"{where}: learner {method.get('learner')!r} is not known: one of {', '.join(LEARNERS)}")
        if isinstance(trials, bool) or not isinstance(trials, int) or not 1 <= trials <= 100_000:
            raise BadParameter(f"{where}: trials {trials!r} is not a whole number from 1 to 100000")
    needed("pinocchio", "arm", "runs of learning need Pinocchio")
    if any(world.get("plant", WORLD["plant"]) == "mujoco" for world in experiment.worlds):
        needed("mujoco", "mujoco", "the plant 'mujoco' needs MuJoCo")
    _check_tasks(experiment)


def _number(where: str, name: str, value: object) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 <= value < 1e6:
        raise BadParameter(f"{where}: {name} {value!r} is not a number from 0")


def _check_tasks(experiment: Experiment) -> None:
    """The task of each world and the learner of each method, made."""
    from guideway.arm.learning import make_learner

    task = None
    for given in experiment.worlds:
        world = {**WORLD, **given}
        try:
            task = _task(world["robot"], world["path"], float(world["acceleration"]), _torque(world))
            plant_of(task, world | {"random": False}, 0)
        except (GuidewayError, TypeError, ValueError) as error:
            raise BadParameter(f"world {world['name']!r}: {error}") from None
    for method in experiment.methods:
        assert task is not None  # an experiment has a world
        try:
            make_learner(method["learner"], task, method.get("set", {}))
        except (GuidewayError, TypeError, ValueError) as error:
            raise BadParameter(f"method {method['name']!r}: set: {error}") from None
