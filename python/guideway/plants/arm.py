"""Simulated arms for learning: ``run(motion) -> Log``. The ideal plant follows its reference exactly; its torque is that of the true arm.

What only a judge may ask of a plant is in ``true`` and :meth:`IdealArm.rows`: learners get the log and nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.dynamics import Dynamics, Rows
from guideway.arm.learning.log import Log
from guideway.arm.learning.motion import Motion, Sampled
from guideway.arm.learning.task import Task
from guideway.arm.model import REFERENCE_FRICTION, Arm, direction
from guideway.errors import BadParameter
from guideway.plants.arm_friction import JointFriction

if TYPE_CHECKING:
    from guideway.plants.arm_mujoco import MujocoArm

Floats = NDArray[np.float64]


class ArmPlant(Protocol):
    """What motions are tried on: a simulator, a robot, a stack of logs."""

    def run(self, motion: Motion) -> Log:
        """Carries out one trial and returns what was measured."""
        ...


@dataclass(frozen=True)
class Sensors:
    """What torques and angles look like to the outside: ``noise`` (standard deviation, N m, a number per joint), ``quantum`` (N m), ``delay``
    (samples) of torques, ``rate`` (1/s)."""

    noise: tuple[float, ...]
    quantum: float = 0.05
    delay: int = 1
    rate: float = 500.0

    @staticmethod
    def usual(noise: float, joints: int) -> Sensors:
        """``noise`` in the first three joints, 0.3 of it in the others."""
        if not (np.isfinite(noise) and noise >= 0):
            raise BadParameter(f"noise {noise!r} cannot be used: a number of N m from 0")
        return Sensors(tuple(noise if joint < 3 else 0.3 * noise for joint in range(joints)))

    def seen(self, tau: Floats, random: np.random.Generator) -> Floats:
        """True torques (n, joints) as they are reported."""
        late = np.concatenate([np.repeat(tau[:1], self.delay, 0), tau])[: len(tau)]
        noisy = late + random.normal(size=tau.shape) * np.asarray(self.noise)
        return np.round(noisy / self.quantum) * self.quantum if self.quantum > 0 else noisy


@dataclass
class IdealArm:
    """An arm that follows its reference exactly: ``arm`` carries the true payload (its own friction is not used), ``friction`` is the true friction.

    ``stop`` = (ratio, s): a trial ends where a joint's torque stays beyond ``ratio`` times ``torque`` (N m) that long.
    """

    arm: Arm
    friction: JointFriction
    sensors: Sensors
    torque: Floats
    seed: int = 0
    stop: tuple[float, float] = (1.3, 0.02)
    trials: int = field(default=0, init=False)
    true: list[tuple[Floats, Floats]] = field(default_factory=list, init=False)
    """For judging: per trial, instants and true torques, both sides of every step of the acceleration among them."""

    def run(self, motion: Motion) -> Log:
        """One trial; the torque is that of the reference."""
        seen = motion.sample(self.sensors.rate)
        tau = self.truth(seen)
        random = np.random.default_rng([self.seed, self.trials])
        end = safety_stop(seen.t, tau, self.torque, self.stop)
        dense = motion.dense(2)
        self.true.append((dense.t, self.truth(dense)))
        self.trials += 1
        return Log(motion, seen.t[:end], seen.q[:end].copy(), self.sensors.seen(tau, random)[:end], stopped=end < len(seen.t))

    def truth(self, seen: Sampled) -> Floats:
        """True torques (n, joints) along a sampled motion, in the next trial."""
        rubs = self.friction.torque(seen.qd, direction(seen.q1), self.trials)
        return self.friction.gain(seen.q) * (self.arm.rnea(seen.q, seen.qd, seen.qdd) + rubs)

    def rows(self, task: Task, x: Floats) -> Rows:
        """True torques on a task's grid as rows, friction beyond the viscous part as it is at squared speeds ``x``."""
        q, q1, q2 = task.q, task.q1, task.q2
        rigid, ways = Dynamics(self.arm.with_friction(None)).nominal(q, q1, q2), direction(q1)
        speed = np.sqrt(x)[:, None]
        gain, slope = self.friction.gain(q), self.friction.slope(ways, self.trials)
        rest = self.friction.torque(q1 * speed, ways, self.trials) - slope * q1 * speed
        return Rows(gain * rigid.a, gain * rigid.b, gain * slope * q1, gain * (rigid.c + rest))

    def report(self) -> dict[str, Any]:
        """What it was, for ``traj.json``."""
        load = self.arm.payload
        return {"name": "ideal", "payload": load.mass, "payload_at": list(load.at), "friction": asdict(self.friction)}


def safety_stop(t: Floats, tau: Floats, torque: Floats, stop: tuple[float, float]) -> int:
    """How many samples are run before the safety stop ends the trial."""
    beyond = np.asarray((np.abs(tau) > stop[0] * torque).any(1))
    since = 0.0
    for k in range(1, len(t)):
        since = since + t[k] - t[k - 1] if beyond[k] else 0.0
        if since >= stop[1] - 1e-9:
            return k + 1
    return len(t)


SPARE = 1.5
"""Where the description states no torques, motors have so many times the limit."""

PLANTS = {
    "ideal": "follows its reference exactly; torques are those of the true arm along it (the default)",
    "mujoco": "an arm in the MuJoCo simulator with a tracking controller that knows the nominal arm, and the torques that come with a motion",
}
"""The plants that :func:`make_arm` makes, with a line each."""

FEEDFORWARD = ("learned", "nominal")


def make_arm(
    plant: str,
    task: Task,
    *,
    payload: float = 0.0,
    payload_at: Sequence[float] = (0.0, 0.0, 0.08),
    friction: str = "reference",
    noise: float = 0.5,
    seed: int = 0,
    feedforward: str = "learned",
) -> IdealArm | MujocoArm:
    """The simulated plant of that name for the arm of a task.

    ``payload`` (kg) sits at ``payload_at`` (m, in the tip's frame); ``friction`` is ``none``, ``reference`` or ``full``; ``noise`` (N m) is that of
    torques in the first three joints, 0.3 of it in the others. The controller of ``mujoco`` feeds forward the torques that a motion's learner
    expects where it says any (``feedforward`` = ``learned``), or those of the nominal arm always (``nominal``). Raises ``BadParameter``, and
    ``ImportError`` where MuJoCo is missing.
    """
    if feedforward not in FEEDFORWARD:
        raise BadParameter(f"feedforward {feedforward!r} is not known: one of {', '.join(FEEDFORWARD)}")
    if plant not in PLANTS:
        raise BadParameter(f"plant {plant!r} is not known: one of {', '.join(PLANTS)}, or an object with run(motion)")
    arm, sensors = task.arm.with_payload(payload, payload_at), Sensors.usual(noise, task.arm.joints)
    rubs = JointFriction.of(friction, *usual_friction(task))
    if plant == "ideal":
        return IdealArm(arm, rubs, sensors, task.torque, seed)
    from guideway.plants.arm_mujoco import MujocoArm

    given = task.arm.effort
    rated = np.array([max(limit, own or SPARE * limit) for limit, own in zip(task.torque, given, strict=True)])
    return MujocoArm(arm, task.arm, rubs, sensors, task.torque, rated, seed, feedforward=feedforward)


def usual_friction(task: Task) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Viscous (N m s/rad) and Coulomb (N m) friction of the reference: as stated for arms like the UR5e; for others a tenth of each joint's torque
    limit, and as much again at full speed."""
    if task.arm.name == "ur5e":
        viscous, coulomb = REFERENCE_FRICTION.arrays(task.arm.joints)
    else:
        viscous, coulomb = 0.1 * task.torque / task.speed, 0.1 * task.torque
    return tuple(viscous.tolist()), tuple(coulomb.tolist())
