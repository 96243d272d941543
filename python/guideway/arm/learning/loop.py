"""The loop of learning against a plant, and what a judge says of each trial."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning import Learner, make_learner
from guideway.arm.learning.log import Log
from guideway.arm.learning.motion import Motion
from guideway.arm.learning.task import Task
from guideway.arm.limits import JointLimits
from guideway.errors import BadParameter, Infeasible

if TYPE_CHECKING:
    from guideway._core import Path
    from guideway.arm.model import Arm
    from guideway.arm.paths import JointPath
    from guideway.plants.arm import ArmPlant

Floats = NDArray[np.float64]


PROFILES = 60
"""Trials whose profile is in the record."""


@dataclass(frozen=True)
class Trial:
    """A trial: its ``number`` from 1, ``duration`` (s), the ``lower_bound`` (s) its learner then knew, ``measured``: largest filtered torque over its
    limit less 1 (below 0: inside) and the ``samples`` beyond what noise explains, ``stopped`` early. ``excess``: by how much longer averages are
    beyond (:meth:`guideway.arm.learning.log.Log.excess`), ``accepted``: what the learner itself says of the torques, None where it has no measure of
    its own. Of a simulated plant also ``true`` (as ``measured``, of the true torque) and ``time_over`` (s with any joint over its limit)."""

    number: int
    duration: float
    lower_bound: float | None
    measured: float
    samples: int
    stopped: bool
    true: float | None = None
    time_over: float | None = None
    excess: float = 0.0
    accepted: bool | None = None

    @property
    def clean(self) -> bool:
        """Was no violation measured?"""
        return not self.samples and not self.stopped

    @property
    def good(self) -> bool:
        """Was no violation measured, by the measure of its learner where it has one?"""
        return self.clean if self.accepted is None else self.accepted


def best_of(trials: Sequence[Trial]) -> int | None:
    """Index of the fastest trial without a measured violation, None where there is none. Those without an excess in longer averages come first: what
    hides in the noise of single samples does not hide there."""
    good = [k for k, trial in enumerate(trials) if trial.good]
    found = [k for k in good if trials[k].excess <= 0] or good
    return min(found, key=lambda k: trials[k].duration) if found else None


@dataclass
class Learned:
    """What came out: the ``trials`` with their ``motions`` and ``logs``; ``best`` is the index of the fastest one without a measured violation, None
    where there is none. ``oracle``: the optimum of the simulated plant's true torques."""

    task: Task
    learner: str
    trials: list[Trial] = field(default_factory=list)
    motions: list[Motion] = field(default_factory=list)
    logs: list[Log] = field(default_factory=list)
    oracle: Motion | None = None
    finished: bool = False
    true: list[tuple[Floats, Floats]] = field(default_factory=list)
    """Per trial, instants (s) and true torques (N m) of a simulated plant."""

    @property
    def best(self) -> int | None:
        """Index of the fastest trial without a measured violation: :func:`best_of`."""
        return best_of(self.trials)

    @property
    def motion(self) -> Motion:
        """The best motion; raises :class:`guideway.errors.Infeasible` where no trial was without a measured violation."""
        if self.best is None:
            raise Infeasible(f"none of {len(self.trials)} trials was without a measured violation: allow more trials, or take another learner")
        return self.motions[self.best]

    def rows(self) -> list[dict[str, Any]]:
        """The trials as records, with the ratio to the oracle where there is one, and the profile of some of them (:func:`with_profiles`)."""
        known = {"ratio": None} if self.oracle is None else {}
        rows = [
            asdict(trial) | {"clean": trial.clean} | (known or {"ratio": trial.duration / self.oracle.duration if self.oracle else None})
            for trial in self.trials
        ]
        return with_profiles(rows, self.motions, self.best)


def with_profiles(rows: list[dict[str, Any]], motions: Sequence[Motion], best: int | None) -> list[dict[str, Any]]:
    """Records of trials with the ``profile`` of their motions, of more than :data:`PROFILES` trials only that of the best one, the last one and some
    in between."""
    step = max(1, -(-len(rows) // PROFILES))
    kept = {*range(0, len(rows), step), len(rows) - 1, best}
    return [row | ({"profile": motion.profile()} if k in kept else {}) for k, (row, motion) in enumerate(zip(rows, motions, strict=True))]


def judged(task: Task, number: int, log: Log, learner: Learner, true: tuple[Floats, Floats] | None) -> Trial:
    """What can be said of a trial."""
    lower, accepts = getattr(learner, "lower_bound", None), getattr(learner, "accepts", None)
    measured = float((np.abs(log.filtered) / task.torque).max() - 1)
    samples = int(log.violations(task.torque).any(1).sum())
    found = (number, log.motion.duration, lower, measured, samples, log.stopped)
    own = {"excess": log.excess(task.torque), "accepted": None if accepts is None else bool(accepts(log))}
    if true is None:
        return Trial(*found, **own)
    t, tau = true
    share = (np.abs(tau) / task.torque).max(1)
    over = share > 1
    return Trial(*found, float(share.max() - 1), float((np.diff(t) * (over[1:] & over[:-1])).sum()), **own)


class Interrupted(KeyboardInterrupt):
    """Ctrl-C while learning; ``found`` holds the trials that were complete."""

    def __init__(self, found: Learned) -> None:
        super().__init__("interrupted while learning")
        self.found = found


def run(task: Task, learner: Learner, plant: ArmPlant, trials: int, observe: Callable[[Trial], object] | None = None) -> Learned:
    """Up to ``trials`` trials of a learner against a plant; ``observe`` sees each. Raises :class:`Interrupted` on Ctrl-C."""
    found = Learned(task, type(learner).__name__)
    try:
        _tried(found, learner, plant, trials, observe)
    except KeyboardInterrupt as stop:
        raise Interrupted(found) from stop
    finally:
        count = len(found.trials)
        found.true = list(getattr(plant, "true", []))[:count]
        del found.motions[count:], found.logs[count:]
    return found


def _tried(found: Learned, learner: Learner, plant: ArmPlant, trials: int, observe: Callable[[Trial], object] | None) -> None:
    for number in range(1, trials + 1):
        motion = learner.next(found.logs)
        if motion is None:
            found.finished = True
            break
        log = plant.run(motion)
        if log.motion is not motion:
            raise BadParameter("the plant returned the log of another motion: run(motion) must return Log(motion, ...)")
        true = getattr(plant, "true", None)
        trial = judged(found.task, number, log, learner, true[-1] if true else None)
        found.motions.append(motion)
        found.logs.append(log)
        found.trials.append(trial)
        if observe:
            observe(trial)


def learn_task(
    task: Task,
    plant: ArmPlant,
    learner: str | Learner = "structured",
    *,
    trials: int = 6,
    settings: Mapping[str, Any] | None = None,
    observe: Callable[[Trial], object] | None = None,
) -> Learned:
    """Learns the fastest motion of a task on a plant: any object with ``run(motion) -> Log``.

    ``learner`` is a name (``settings``: its fields) or an object with ``next(logs)``; ``observe`` sees each trial. On simulated plants the result
    also has the oracle. Raises :class:`guideway.errors.Infeasible` for a static overload and ``BadParameter`` for unknown names.
    """
    if trials < 1:
        raise BadParameter(f"trials {trials!r} is out of range: a whole number from 1")
    made = make_learner(learner, task, settings) if isinstance(learner, str) else learner
    rows = getattr(plant, "rows", None)
    named = learner if isinstance(learner, str) else type(learner).__name__
    try:
        found = run(task, made, plant, trials, observe)
    except Interrupted as stop:
        stop.found.learner = named
        raise
    found.learner = named
    if rows is not None:
        from guideway.arm.learning.oracle import optimum

        found.oracle = optimum(task, rows)
    return found


def learn(
    path: JointPath | Path,
    limits: JointLimits | Mapping[str, Any],
    arm: Arm,
    plant: str | ArmPlant = "ideal",
    learner: str | Learner = "structured",
    *,
    trials: int = 6,
    settings: Mapping[str, Any] | None = None,
    simulated: Mapping[str, Any] | None = None,
    observe: Callable[[Trial], object] | None = None,
) -> Learned:
    """Learns the fastest motion of an arm along a joint path, trial by trial, from measured torques.

    ``arm`` is what is known: its payload and friction are not. ``limits`` need acceleration and torque, or the robot's own torques are taken.
    ``plant`` is what the trials are run on: an object with ``run(motion) -> Log``, or ``ideal`` or ``mujoco`` with the fields of
    :func:`guideway.plants.arm.make_arm` in ``simulated`` (payload, payload_at, friction, noise, seed). The rest is as in :func:`learn_task`.

    >>> import guideway as gw
    >>> arm = gw.arm.robot("ur5e")
    >>> limits = gw.arm.JointLimits(acceleration=10.0, torque=gw.arm.STAR_TORQUE)
    >>> found = gw.arm.learn(gw.arm.joint_path(arm, gw.arm.star()), limits, arm, simulated={"payload": 5.0})
    >>> found.motion.duration < 1.05 * found.oracle.duration
    True
    """
    from guideway.arm.timing import complete
    from guideway.plants.arm import make_arm

    task = Task(getattr(path, "path", path), arm, complete(JointLimits.of(limits), arm, True))
    if simulated and not isinstance(plant, str):
        raise BadParameter("settings of a simulated plant were given, but the plant is an object of its own")
    tried = make_arm(plant, task, **(simulated or {})) if isinstance(plant, str) else plant
    return learn_task(task, tried, learner, trials=trials, settings=settings, observe=observe)


def replay(learner: Learner, logs: Sequence[Log]) -> Motion | None:
    """The motion a learner asks for after logs that were measured on its motions, one after the other."""
    seen: list[Log] = []
    motion = learner.next(seen)
    for log in logs:
        seen.append(log)
        motion = learner.next(seen)
    return motion
