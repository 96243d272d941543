"""A mobile base in a room, simulated by MuJoCo (needs ``pip install 'guideway[mujoco]'``)."""

from __future__ import annotations

import importlib
import math
import os
from collections.abc import Mapping
from typing import Any
from xml.etree.ElementTree import Element, tostring

import numpy as np

from guideway import _core
from guideway.errors import BadParameter
from guideway.plants import base, room
from guideway.plants.measures import Gauge
from guideway.plants.movers import Stage, position
from guideway.plants.settings import Settings
from guideway.records import Limits

FRAMES = 25.0
"""States kept for pictures, per second of the run."""
RUNAWAY = 1e6
"""Speed of a joint that no base ever has, m/s or rad/s."""
TURN_RATE, TURN_ACCELERATION = 2.0, 6.0
"""Of a robot without limits of its own, rad/s and rad/s2."""


def simulator() -> Any:
    """The module ``mujoco``. Raises ``ImportError`` with what to install."""
    try:
        return importlib.import_module("mujoco")
    except Exception as error:
        asked = os.environ.get("MUJOCO_GL")
        if asked in (None, "disabled"):
            raise ImportError(f"the plant 'mujoco' needs the MuJoCo simulator: pip install 'guideway[mujoco]' ({error})") from error
    os.environ["MUJOCO_GL"] = "disabled"  # a graphics library that is not there is no reason not to drive
    try:
        return simulator()
    finally:
        os.environ["MUJOCO_GL"] = asked


class MobileBase:
    """A differential base on springs that drives a motion of :func:`guideway.drive` in a room made from the query's world.

    Discs are cylinders, polygons prisms, blocked cells boxes, movers bodies that follow their motion whatever they meet. The border of the world is a
    line on the floor. ``query`` gives world, footprint and start heading, ``trajectory`` the start and, unless ``limits`` does, what the servos may
    do.
    """

    name = "mujoco"
    error = 0.04
    """How far the body, which leans on its springs, may be from the model that controllers have of it, m."""

    def __init__(
        self,
        query: _core.Query,
        trajectory: _core.Trajectory,
        *,
        seed: int = 0,
        settings: Settings | None = None,
        limits: Limits | None = None,
    ) -> None:
        self.settings = settings or Settings()
        self.simulator = self._mj = simulator()
        self._shape = base.Shape.of(query.footprint, self.settings.point)
        self._layout = base.Layout.of(self._shape, self.settings)
        asked: dict[str, Any] = trajectory.limits if limits is None else limits.to_dict()
        self.limits = self._layout.holds(self._shape, self.settings, asked["speed"]) if self.settings.margin > 0 else {}
        """What it can hold, by the names of :class:`guideway.Limits`; empty where the settings have no margin."""
        self._limits = asked | {"turn_rate": asked["turn_rate"] or TURN_RATE, "turn_acceleration": asked["turn_acceleration"] or TURN_ACCELERATION}
        self._limits |= {name: min(self._limits[name], most) for name, most in self.limits.items()}
        self.footprint = {"disc": self._shape.radius} if self._shape.radius else query.footprint
        """The body on the floor: of a point, the disc that stands for it."""
        self.bounds = tuple(query.world.bounds)
        self._stage = Stage(query.world.movers)
        self.model = self._build(query, trajectory)
        self.data = self._mj.MjData(self.model)
        self._noise = np.random.Generator(np.random.PCG64(seed))
        self._time, self._wanted, self.gauge = 0.0, [0.0, 0.0], Gauge()
        self.frames: list[tuple[float, np.ndarray, np.ndarray]] = []
        self._find()
        pose = trajectory.at(0.0)["pose"]
        self._settle(pose[0], pose[1], pose[2] if query.start_yaw is None else query.start_yaw)

    def _build(self, query: _core.Query, trajectory: _core.Trajectory) -> Any:
        root = Element("mujoco", model="room")
        room.add(root, "compiler", angle="radian", autolimits="true")
        step = {"timestep": room.texts(self.settings.timestep), "integrator": "implicitfast", "cone": "elliptic", "impratio": "10"}
        room.add(root, "option", **step)
        visual = room.add(root, "visual")
        room.add(visual, "global", offwidth="1920", offheight="1200")
        room.add(visual, "quality", shadowsize="2048")
        room.add(visual, "headlight", ambient="0.42 0.42 0.42", diffuse="0.28 0.28 0.28", specular="0.05 0.05 0.05")
        self._movers = room.furnish(root, query.world)
        base.build(root, self._shape, self._layout, self.settings)
        stage = root.find("worldbody")
        assert stage is not None
        room.line(stage, _thinned(_core.polyline(trajectory.path, query).tolist()), "0.15 0.55 0.35 1", 0.012)
        goal = {"pos": room.texts(*query.goal, 0.002), "size": room.texts(0.12, 0.002), "rgba": "0.15 0.65 0.35 1"}
        room.add(stage, "geom", type="cylinder", contype="0", conaffinity="0", **goal)
        try:
            return self._mj.MjModel.from_xml_string(tostring(root, encoding="unicode"))
        except ValueError as error:
            raise BadParameter(f"the simulator refuses this room: {error}") from error

    def _find(self) -> None:
        """Looks up what is read in every step."""
        model, number = self.model, self._mj.mj_name2id
        kinds = self._mj.mjtObj
        self._hubs = [number(model, kinds.mjOBJ_BODY, name) for name in ("left", "right")]
        self._body = number(model, kinds.mjOBJ_BODY, "base")
        joints = [number(model, kinds.mjOBJ_JOINT, f"{name} wheel") for name in ("left", "right")]
        self._spin = [int(model.jnt_dofadr[joint]) for joint in joints]
        names = [self._mj.mj_id2name(model, kinds.mjOBJ_GEOM, geom) or "" for geom in range(model.ngeom)]
        obstacle = ("static", "cells", "mover")
        self._obstacles = {geom: name for geom, name in enumerate(names) if name.startswith(obstacle)}
        mocap = [int(model.body_mocapid[number(model, kinds.mjOBJ_BODY, name)]) for name in self._movers]
        self._mocap = mocap

    def _settle(self, x: float, y: float, yaw: float) -> None:
        """Lets the springs take the weight out of the way of everything, then puts the base where it starts."""
        model, data = self.model, self.data
        data.qpos[0:2] = x, y
        data.qpos[3:7] = math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)
        contacts = model.geom_contype.copy()
        for geom in self._obstacles:
            model.geom_contype[geom] = model.geom_conaffinity[geom] = 0
        for _ in range(round(1.0 / self.settings.timestep)):
            self._advance()
        for geom in self._obstacles:
            model.geom_contype[geom], model.geom_conaffinity[geom] = contacts[geom], 1
        data.qpos[0:2] = x, y
        data.qvel[:] = 0
        data.time = 0.0
        self._place_movers(x, y)
        self._mj.mj_forward(model, data)
        self._read()
        self._keep()

    def _place_movers(self, x: float, y: float) -> None:
        self._stage.trigger(self._time, x, y)
        for number, (mover, present) in enumerate(zip(self._stage.movers, self._stage.present, strict=True)):
            at = position(mover, self._time)
            self.data.mocap_pos[self._mocap[number]] = (*at, 0.0 if present else room.HIDDEN)

    def _read(self) -> None:
        """The true state: the middle between the wheels, its speed ahead, the turn rate."""
        data, turn = self.data, self.data.xmat[self._body].reshape(3, 3)
        yaw = math.atan2(turn[1, 0], turn[0, 0])
        ahead, aside = np.array([math.cos(yaw), math.sin(yaw)]), np.array([-math.sin(yaw), math.cos(yaw)])
        hubs = np.array([self._velocity(hub) for hub in self._hubs])
        middle = data.xpos[self._hubs].mean(axis=0)
        spin = data.qvel[self._spin] * self._layout.wheel
        self._pose = (float(middle[0]), float(middle[1]), yaw)
        self._v, self._w = float(hubs.mean(axis=0) @ ahead), float((turn @ data.qvel[3:6])[2])
        self._odometry = (float(spin.mean()), float((spin[1] - spin[0]) / self._layout.track))
        along, across = spin - hubs @ ahead, hubs @ aside
        self._slip = (float(np.abs(along).max()), float(np.abs(across).max()))
        pitch, roll = math.asin(max(-1.0, min(1.0, -turn[2, 0]))), math.atan2(turn[2, 1], turn[2, 2])
        self._tilt = (math.degrees(pitch), math.degrees(roll))

    def _velocity(self, body: int) -> np.ndarray:
        """Of a body's centre, over the floor, m/s."""
        both = np.zeros(6)
        self._mj.mj_objectVelocity(self.model, self.data, self._mj.mjtObj.mjOBJ_BODY, body, both, 0)
        return both[3:5]

    def observe(self) -> dict[str, Any]:
        """Pose with noise, speeds as the wheels turn with the scale error."""
        s = self.settings
        noise = self._noise.normal(size=3) * (s.noise_position, s.noise_position, s.noise_heading)
        scale = 1.0 + s.odometry_scale
        pose = tuple(float(value) for value in np.asarray(self._pose) + noise)
        return {"time": self._time, "pose": pose, "v": self._odometry[0] * scale, "w": self._odometry[1] * scale}

    def step(self, v: float, w: float, dt: float) -> None:
        """Runs the simulator for ``dt`` s; the wheel servos follow the commands with the lags and within the limits of the robot."""
        count = max(1, round(dt / self.settings.timestep))
        h = dt / count
        self.model.opt.timestep = h
        for _ in range(count):
            self._servo(v, w, h)
            self._place_movers(*self._pose[:2])
            self._advance()
            self._time += h
            self.gauge.drive(float(self.data.actuator_force @ self.data.qvel[self._spin]), h)
        self._read()
        self._gauge()

    def _servo(self, v: float, w: float, h: float) -> None:
        """Moves the wanted speeds by one step and tells the wheels."""
        limits, s = self._limits, self.settings
        turn = limits["turn_acceleration"]
        rates = ((limits["acceleration"], limits["deceleration"]), (turn, turn))
        targets = (_within(v, limits["speed"]), _within(w, limits["turn_rate"]))
        for k, lag in enumerate((s.lag_speed, s.lag_turn)):
            self._wanted[k] = lagged(self._wanted[k], targets[k], lag, rates[k], h)
        v, w = self._wanted
        half, wheel = self._layout.track / 2, self._layout.wheel
        self.data.ctrl[:] = (v - w * half) / wheel, (v + w * half) / wheel

    def _advance(self) -> None:
        """One step of the simulator. Where numbers run away it would start over by itself; that is no run."""
        kinds = self._mj.mjtWarning
        runaway = not np.abs(self.data.qvel).max() < RUNAWAY
        if not runaway:
            self._mj.mj_step(self.model, self.data)
            runaway = any(self.data.warning[kind].number for kind in (kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC))
        if runaway:
            raise BadParameter(f"the simulation came apart after {self._time:.3f} s: take a smaller timestep, or more ordinary settings of the plant")

    def _gauge(self) -> None:
        self.gauge.rows.append((self._time, *self._tilt))
        self.gauge.slips.append(self._slip)
        if abs(self._v) > 0.01 or abs(self._w) > 0.01:
            self.gauge.move(self._time)
        pairs = self.data.contact.geom
        if len(pairs):
            self.gauge.touch(self._time, {self._obstacles[geom] for geom in pairs.ravel().tolist() if geom in self._obstacles})
        if self._time >= len(self.frames) / FRAMES - 1e-9:
            self._keep()

    def _keep(self) -> None:
        self.frames.append((self._time, self.data.qpos.copy(), self.data.mocap_pos.copy()))

    def motion(self) -> dict[str, Any]:
        """The true state."""
        return {"pose": self._pose, "v": self._v, "w": self._w}

    def extras(self) -> dict[str, Any]:
        """What was measured so far, for ``run.json``; :mod:`guideway.plants.measures` says how."""
        body: Mapping[str, Any] = {"polygon": [list(point) for point in self._shape.corners]} if self._shape.corners else {"disc": self._shape.radius}
        about = {"simulator": f"MuJoCo {self._mj.__version__}", "mass": self.settings.mass, "height": self.settings.height, "body": body}
        return about | self.gauge.record()


def _within(value: float, top: float | None) -> float:
    """A command inside its limits; what is no number is 0."""
    top = math.inf if top is None else top
    return max(-top, min(top, value)) if math.isfinite(value) else 0.0


def lagged(value: float, target: float, lag: float, rates: tuple[float, float], h: float) -> float:
    """The next value of a servo that follows its target with a time constant (s) and rate limits [away from zero, towards zero]."""
    wanted = (target - value) * (1 - math.exp(-h / lag)) if lag > 0 else target - value
    limit = rates[value * wanted < 0] * h
    return value + max(-limit, min(limit, wanted))


def _thinned(points: list[list[float]]) -> list[list[float]]:
    """At most a few hundred points of a line, for the floor."""
    every = max(1, len(points) // 300)
    return [*points[:-1:every], points[-1]] if points else []
