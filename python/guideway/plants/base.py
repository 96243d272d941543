"""A differential base as bodies of the simulator: an MJCF document."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from guideway.plants.room import add, prism, texts
from guideway.plants.settings import Settings

GROUND = 0.05
"""Between the floor and the bottom of the body, m."""
ON_WHEELS = 0.6
"""Share of the weight on the driven wheels."""
WHEEL, CASTER, ARM = 0.025, 0.0075, 0.00125
"""Shares of the mass that are not on springs: a wheel, a caster, what carries either."""
GRAVITY = 9.81
TOUCHES = {"contype": "1", "conaffinity": "2"}
"""The body touches the room; its parts do not touch each other."""
ROLLS = {"contype": "4", "conaffinity": "0"}
"""Wheels and casters touch the floor alone: the balls that stand for wheels reach out of the body."""


@dataclass(frozen=True)
class Shape:
    """A body: its outline (m, robot frame; a disc has none), how far it reaches forward, back and sideways, and where it touches the floor."""

    radius: float
    corners: tuple[tuple[float, float], ...]
    front: float
    back: float
    side: float

    @classmethod
    def of(cls, footprint: Mapping[str, Any], point: float) -> Shape:
        """The body of a footprint; one of radius 0 becomes a disc of ``point`` m."""
        if "disc" in footprint:
            radius = float(footprint["disc"]) or point
            return cls(radius, (), radius, radius, radius)
        if "box" in footprint:
            length, width = (float(value) / 2 for value in footprint["box"])
            corners = ((-length, -width), (length, -width), (length, width), (-length, width))
        else:
            corners = tuple((float(x), float(y)) for x, y in footprint["polygon"])
        xs, ys = [x for x, _ in corners], [y for _, y in corners]
        return cls(0.0, corners, max(xs), -min(xs), min(max(ys), -min(ys)))


@dataclass(frozen=True)
class Layout:
    """Where the base stands on the floor, m: wheels at ``track``/2 to the left and right, casters ``front`` and ``back`` of the reference point."""

    wheel: float
    track: float
    front: float
    back: float

    @classmethod
    def of(cls, shape: Shape, settings: Settings) -> Layout:
        """Four fifths of the way to the edge, wheels no larger than a third of the body."""
        wheel = min(settings.wheel, 0.6 * min(shape.front, shape.back, shape.side))
        return cls(wheel, 1.6 * shape.side, 0.8 * shape.front, 0.8 * shape.back)

    def holds(self, shape: Shape, settings: Settings, speed: float) -> dict[str, float]:
        """The limits that the base can keep at up to ``speed`` m/s, with the margin of the settings: nothing lifts off, no wheel slips.

        A caster is free of load where the springs have given way by all that the weight had pressed them, a wheel likewise in bends. Friction is
        shared by braking and bends, and half of it is left for turning in place.
        """
        lever = settings.margin * GRAVITY / settings.height
        grip = settings.margin * settings.friction * ON_WHEELS * GRAVITY
        ahead, back = ((1 - ON_WHEELS) * lever * arm for arm in (self.back, self.front))
        ahead, back = min(ahead, grip / math.sqrt(2)), min(back, grip / math.sqrt(2))
        aside = min(ON_WHEELS * lever * self.track / 2, math.sqrt(grip**2 - max(ahead, back) ** 2))
        spin = 0.5 * grip * (self.track / 2) * 12 / ((shape.front + shape.back) ** 2 + (2 * shape.side) ** 2)
        return {"acceleration": ahead, "deceleration": back, "turn_rate": aside / speed, "turn_acceleration": spin}

    def loads(self, weight: float) -> tuple[float, float, float]:
        """Weight on each wheel, the front and the back caster, N; the centre of gravity is above the axle."""
        casters = (1 - ON_WHEELS) * weight
        return ON_WHEELS * weight / 2, casters * self.back / (self.front + self.back), casters * self.front / (self.front + self.back)


def build(root: Element, shape: Shape, layout: Layout, settings: Settings) -> None:
    """Adds the base, standing at the origin, and its two servos."""
    stage, assets = root.find("worldbody"), root.find("asset")
    assert stage is not None
    assert assets is not None
    axle = layout.wheel
    body = add(stage, "body", name="base", pos=texts(0, 0, axle))
    add(body, "freejoint", name="free")
    _hull(assets, body, shape, settings, axle)
    weight = settings.mass * GRAVITY
    wheel_load, front, back = layout.loads(weight)
    for name, y in (("left", layout.track / 2), ("right", -layout.track / 2)):
        arm = _sprung(body, name, (0.0, y), wheel_load - (WHEEL + ARM) * weight, settings)
        _wheel(arm, name, layout.wheel, settings)
    ball = min(0.03, 0.5 * axle)
    for name, x, load in (("front", layout.front, front), ("back", -layout.back, back)):
        arm = _sprung(body, name, (x, 0.0), load - (CASTER + ARM) * weight, settings)
        place = {"pos": texts(0, 0, ball - axle), "size": texts(ball), "mass": texts(CASTER * settings.mass)}
        # its low friction must win over the floor's, or the caster holds the base
        add(
            arm,
            "geom",
            name=f"{name} caster",
            type="sphere",
            friction="0.005",
            priority="1",
            solref="0.004 1",
            rgba="0.2 0.2 0.22 1",
            **place,
            **ROLLS,
        )
    actuators = add(root, "actuator")
    for name in ("left", "right"):
        add(actuators, "velocity", name=name, joint=f"{name} wheel", kv="30")


def _hull(assets: Element, body: Element, shape: Shape, settings: Settings, axle: float) -> None:
    """The body from the ground clearance to as far above the centre of gravity, and its inertia: that of a solid block."""
    top = max(2 * settings.height - GROUND, GROUND + 0.05)
    sprung = settings.mass * (1 - 2 * (WHEEL + CASTER + 2 * ARM))
    length, width, height = shape.front + shape.back, 2 * shape.side, top - GROUND
    inertia = [sprung / 12 * (a * a + b * b) for a, b in ((width, height), (length, height), (length, width))]
    add(body, "inertial", pos=texts(0, 0, settings.height - axle), mass=texts(sprung), diaginertia=texts(*inertia))
    look = {"rgba": "0.13 0.45 0.78 1", "friction": "0.3"} | TOUCHES
    middle, half = (top + GROUND) / 2 - axle, height / 2
    if shape.corners:
        prism(assets, body, "hull", shape.corners, (GROUND - axle, top - axle), look)
    else:
        add(body, "geom", name="hull", type="cylinder", pos=texts(0, 0, middle), size=texts(shape.radius, half), mass="0", **look)
    nose = {"size": texts(0.12 * shape.front, 0.3 * shape.side, 0.004), "pos": texts(0.7 * shape.front, 0, top - axle + 0.003)}
    add(body, "geom", name="nose", type="box", rgba="0.98 0.85 0.25 1", mass="0", contype="0", conaffinity="0", **nose)


def _sprung(body: Element, name: str, at: Sequence[float], load: float, settings: Settings) -> Element:
    """A body on a spring that carries ``load`` (N) in the middle of its way."""
    sag = GRAVITY / (2 * math.pi * settings.frequency) ** 2
    stiffness = load / sag
    damping = 2 * settings.damping * math.sqrt(stiffness * load / GRAVITY)
    arm = add(body, "body", name=f"{name} arm", pos=texts(*at, 0))
    spring = {"stiffness": texts(stiffness), "damping": texts(damping), "springref": texts(-sag), "range": texts(-2 * sag, 2 * sag)}
    add(arm, "joint", name=f"{name} spring", type="slide", axis="0 0 1", limited="true", **spring)
    add(arm, "inertial", pos="0 0 0", mass=texts(ARM * settings.mass), diaginertia="1e-4 1e-4 1e-4")
    return arm


def _wheel(arm: Element, name: str, radius: float, settings: Settings) -> None:
    """A driven wheel: it touches the floor as a ball does, in one point, and looks like a wheel."""
    body = add(arm, "body", name=name)
    drag = settings.rolling * settings.mass * GRAVITY * radius / 2  # all of it: the casters roll freely
    add(body, "joint", name=f"{name} wheel", type="hinge", axis="0 1 0", frictionloss=texts(drag))
    contact = {"friction": texts(settings.friction), "priority": "1", "solref": "0.004 1", "rgba": "0 0 0 0"}
    add(body, "geom", name=f"{name} tread", type="sphere", size=texts(radius), mass=texts(WHEEL * settings.mass), **contact, **ROLLS)
    quarter = texts(np.pi / 2, 0, 0)
    add(
        body,
        "geom",
        type="cylinder",
        size=texts(radius, 0.2 * radius),
        euler=quarter,
        mass="0",
        rgba="0.12 0.12 0.14 1",
        contype="0",
        conaffinity="0",
    )
