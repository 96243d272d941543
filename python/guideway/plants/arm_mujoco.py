"""An arm in the MuJoCo simulator that tracks its reference with a controller.

Motors turn the joints through gears: rotor inertia, friction and ripple as :mod:`guideway.plants.arm_friction` has them. The controller is computed
torque along the reference, proportional and differential feedback, and an integrator that settles before the motion starts and then holds; torques
saturate at ``rated``. The torque that is computed is that of the nominal arm, or the one that comes with the motion: what its learner expects.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
from numpy.typing import NDArray

from guideway.arm.extra import pinocchio
from guideway.arm.learning.dynamics import Rows
from guideway.arm.learning.log import Log
from guideway.arm.learning.motion import Motion, Sampled
from guideway.arm.learning.task import Task
from guideway.arm.model import Arm, direction
from guideway.errors import GuidewayError
from guideway.plants.arm import IdealArm, Sensors, safety_stop
from guideway.plants.arm_friction import JointFriction

Floats = NDArray[np.float64]

STEP = 0.0005
"""Of the simulator, s."""
PER_CONTROL = 2
"""Steps of the simulator in one step of the controller."""
WITHIN = 4
"""Instants of a step of the controller that the torque fed forward is the mean of."""
SETTLE = 0.6
"""At rest before a motion starts, s."""
ROTOR = 0.1
"""Inertia of each motor on its joint's side, kg m2."""
STIFFNESS = 60.0
"""Natural frequency of the tracking controller, rad/s."""


@dataclass
class MujocoArm:
    """``arm`` carries the true payload, ``nominal`` is what the controller knows; ``torque`` (N m) are the limits that the safety stop watches,
    ``rated`` where motors saturate; ``feedforward`` is ``learned`` (the torques that come with a motion, where it has any) or ``nominal``."""

    arm: Arm
    nominal: Arm
    friction: JointFriction
    sensors: Sensors
    torque: Floats
    rated: Floats
    seed: int = 0
    stop: tuple[float, float] = (1.3, 0.02)
    feedforward: str = "learned"
    trials: int = field(default=0, init=False)
    true: list[tuple[Floats, Floats]] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        self._mj: Any = importlib.import_module("mujoco")
        self.model = self._mj.MjModel.from_xml_string(document(self.arm))
        self._ideal = IdealArm(self.arm, self.friction, self.sensors, self.torque)

    def run(self, motion: Motion) -> Log:
        """One trial, from rest at the start of the path."""
        every = STEP * PER_CONTROL
        seen = motion.sample(1.0 / every)
        expected = motion.expected if self.feedforward == "learned" else None
        expected = expected or self._nominal
        within = motion.sample(times=(seen.t[:, None] + every * (np.arange(WITHIN) + 0.5) / WITHIN).ravel())
        forward = expected(within).reshape(len(seen.t), WITHIN, -1).mean(1)
        q, tau = self._tracked(seen, forward, expected(motion.at_rest())[0])
        stride = max(1, round(1.0 / (self.sensors.rate * every)))
        t, q, tau = seen.t[::stride], q[::stride], tau[::stride]
        end = safety_stop(t, tau, self.torque, self.stop)
        random = np.random.default_rng([self.seed, self.trials])
        self.trials += 1
        self._ideal.trials = self.trials
        self.true.append((t[:end], tau[:end]))
        return Log(motion, t[:end], q[:end], self.sensors.seen(tau, random)[:end], stopped=end < len(t))

    def rows(self, task: Task, x: Floats) -> Rows:
        """True torques on a task's grid, as if the reference were followed exactly."""
        rows = self._ideal.rows(task, x)
        gain = ROTOR * self.friction.gain(task.q)
        return Rows(rows.a + gain * task.q1, rows.b + gain * task.q2, rows.d, rows.c)

    def report(self) -> dict[str, Any]:
        """What it was, for ``traj.json``."""
        load = self.arm.payload
        about = {
            "payload": load.mass,
            "payload_at": list(load.at),
            "friction": asdict(self.friction),
            "rotor": ROTOR,
            "inertials": self.arm.inertials,
            "feedforward": self.feedforward,
        }
        return {"name": "mujoco", "simulator": f"MuJoCo {self._mj.__version__}"} | about

    def _nominal(self, seen: Sampled) -> Floats:
        """What the controller knows by itself: the nominal arm and its motors."""
        return self.nominal.torques(seen.q, seen.qd, seen.qdd) + ROTOR * seen.qdd

    def _gains(self, q: Floats) -> Floats:
        """Inertia (joints,) that the feedback is tuned for: the largest of each joint on the path."""
        pin, arm = pinocchio(), self.nominal
        data = arm.model.createData()
        full = q[:: max(1, len(q) // 50)] @ arm.coupling.T + arm.offset
        inertia = [np.diag(arm.coupling.T @ pin.crba(arm.model, data, row) @ arm.coupling) for row in full]
        return np.max(inertia, 0) + ROTOR

    def _tracked(self, seen: Sampled, forward: Floats, hold: Floats) -> tuple[Floats, Floats]:
        """Joint angles and motor torques at every step of the controller, once settled; torques ``forward`` (n, joints) are fed forward, at rest
        before the motion ``hold`` (joints,)."""
        mj, model, q, qd, inertia = self._mj, self.model, seen.q, seen.qd, self._gains(seen.q)
        data = mj.MjData(model)
        still = np.zeros(q.shape[1])
        data.qpos[:], bias = q[0], still
        stiff, damp = inertia * STIFFNESS**2, 2 * inertia * STIFFNESS
        settle = round(SETTLE / (STEP * PER_CONTROL))
        found, torques = np.empty_like(q), np.empty_like(q)
        for k in range(-settle, len(q)):
            at = max(k, 0)
            wanted, ahead = (qd[at], forward[at]) if k >= 0 else (still, hold)
            error = q[at] - data.qpos
            if k < 0:
                bias = bias + 10.0 * stiff * error * STEP * PER_CONTROL
            tau = np.clip(ahead + bias + stiff * error + damp * (wanted - data.qvel), -self.rated, self.rated)
            if k >= 0:
                found[k], torques[k] = data.qpos, tau
            self._drive(data, tau)
            mj.mj_step(model, data, PER_CONTROL)
        if not np.isfinite(found).all():
            raise GuidewayError("the simulation of the arm came apart: take a smaller payload or gentler limits")
        return found, torques

    def _drive(self, data: Any, tau: Floats) -> None:
        """Motor torques reach the joint through a gear that ripples; friction of the moment acts. A sharp sign is left to the simulator; a soft
        one is damping about the speed of the moment, which is stable however steep it is."""
        speed, rub = data.qvel, self.friction
        ways = direction(speed)
        grip, slope = rub.grip(speed, ways, self.trials), rub.slope(ways, self.trials)
        driving = tau / rub.gain(data.qpos)
        if rub.smooth > 0:
            soft = np.tanh(speed / rub.smooth)
            steep = grip * (1 - soft * soft) / rub.smooth
            driving, slope, grip = driving - grip * soft + steep * speed, slope + steep, np.zeros_like(grip)
        data.qfrc_applied[:] = driving
        self.model.dof_damping[:] = slope
        self.model.dof_frictionloss[:] = grip


def document(arm: Arm) -> str:
    """The arm as an MJCF document: bodies, inertias and driven joints; joints that follow others stand still."""
    pin, model = pinocchio(), arm.model
    root = Element("mujoco", model="arm")
    SubElement(root, "compiler", angle="radian", inertiafromgeom="false", balanceinertia="true")
    SubElement(root, "option", timestep=str(STEP), gravity=_text(model.gravity.linear), integrator="implicitfast")
    bodies: dict[int, Element] = {0: SubElement(root, "worldbody")}
    for index in range(1, model.njoints):
        place, inertia = model.jointPlacements[index], model.inertias[index]
        turn = pin.Quaternion(place.rotation)
        body = SubElement(
            bodies[model.parents[index]], "body", name=model.names[index], pos=_text(place.translation), quat=_text([turn.w, turn.x, turn.y, turn.z])
        )
        m = inertia.inertia
        full = _text([m[0, 0], m[1, 1], m[2, 2], m[0, 1], m[0, 2], m[1, 2]])
        if inertia.mass > 0:
            SubElement(body, "inertial", pos=_text(inertia.lever), mass=_text([inertia.mass]), fullinertia=full)
        if model.names[index] in arm.names:
            joint, data = model.joints[index], model.joints[index].createData()
            joint.calc(data, pin.neutral(model)[joint.idx_q : joint.idx_q + joint.nq])
            along = np.asarray(data.S).ravel()
            slides = np.abs(along[:3]).sum() > 0
            about = {"type": "slide" if slides else "hinge", "axis": _text(along[:3] if slides else along[3:]), "armature": str(ROTOR)}
            SubElement(body, "joint", {"name": str(model.names[index]), **about})
        bodies[index] = body
    return tostring(root, encoding="unicode")


def _text(values: Sequence[float] | Floats) -> str:
    return " ".join(f"{float(value):.12g}" for value in values)
