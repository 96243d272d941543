"""Arms from robot descriptions, from Denavit-Hartenberg rows, and the ones that ship with the package."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any

import numpy as np

from guideway.arm import urdf
from guideway.arm.extra import pinocchio
from guideway.arm.model import Arm, Friction, Payload
from guideway.errors import BadFile, BadParameter

ROBOTS = {
    "ur5e": "UR5e of Universal Robots, with inertials and torques",
    "irb6700": "IRB 6700-235/2.65 of ABB; its description states neither inertials nor torques",
    "irb120": "IRB 120-3/0.58 of ABB, with inertials; torques are not given",
}
"""The arms that :func:`robot` knows, with a line each."""

LINK = " (link)"
"""What tells a link from a joint of the same name while a model is reduced."""


def robot(name: str, *, estimated: bool = False, **options: Any) -> Arm:
    """An arm that ships with the package, one of :data:`ROBOTS`; ``options`` as in :meth:`guideway.arm.Arm.load`.

    ``estimated`` fills in inertials where the description has none (IRB 6700): the stated mass of the robot spread evenly over the volumes of its
    links. They are good for studies, not for a real robot; ``inertials`` of the arm then reads "estimated".
    """
    if name not in ROBOTS:
        raise BadParameter(f"robot {name!r} is not known; allowed: {', '.join(ROBOTS)}, or a URDF file by Arm.load")
    folder = files("guideway").joinpath("data").joinpath("arms").joinpath(name)
    arm = Arm.load(str(folder.joinpath(f"{name}.urdf")), **options)
    if not estimated or arm.inertials == "given":
        return arm
    stated = json.loads(folder.joinpath("estimated_inertials.json").read_text("utf-8"))
    return _estimated(arm, stated["links"])


def from_description(found: urdf.Description, tip: str | None, base: str | None) -> Arm:
    """The chain to ``tip`` of a checked description, poses in the frame of ``base``."""
    pin = pinocchio()
    for title in (tip, base):
        if title is not None and title not in found.links:
            raise BadParameter(f"link {title!r} is not in {found.path}; allowed: {', '.join(found.links)}")
    tip = tip or found.tip()
    driven = [joint for joint in found.chain(tip) if joint.moves and not joint.mimic]
    if not driven:
        raise BadParameter(f"no driven joint lies between the root and link {tip!r} of {found.path}: name the link that is moved")
    try:
        whole = pin.buildModelFromXML(found.text)
    except (ValueError, RuntimeError) as error:
        raise BadFile(found.path, f"the model cannot be built ({error})", "a URDF file", "Check the file") from None
    model = _reduced(whole, found, [joint.name for joint in driven])
    coupling, offset = _coupling(model, found, [joint.name for joint in driven])
    massive = all(model.inertias[model.getJointId(joint.name)].mass > 0 for joint in driven)
    return Arm(
        name=found.name,
        names=tuple(joint.name for joint in driven),
        lower=np.array([joint.lower for joint in driven]),
        upper=np.array([joint.upper for joint in driven]),
        speed=tuple(joint.speed for joint in driven),
        effort=tuple(joint.effort for joint in driven),
        tip=tip,
        base=base or found.root,
        inertials="given" if massive else "none",
        payload=Payload(),
        friction=Friction(),
        model=model,
        coupling=coupling,
        offset=offset,
        source=found.path,
        _bare=model,
        _data=model.createData(),
    )


def _reduced(whole: Any, found: urdf.Description, driven: list[str]) -> Any:
    """The model with every joint locked that is neither driven nor follows a driven one."""
    pin = pinocchio()
    kept = {joint.name for joint in found.joints.values() if joint.name in driven or (joint.mimic and joint.mimic[0] in driven)}
    locked = [name for name in list(whole.names)[1:] if name not in kept]
    if not locked:
        return whole
    still = pin.neutral(whole)
    for name in locked:
        joint = found.joints[name]
        still[whole.joints[whole.getJointId(name)].idx_q] = min(max(0.0, joint.lower), joint.upper)
    # Pinocchio looks frames up by name alone here, and a joint may be called as a link is.
    for frame in whole.frames:
        if frame.type == pin.BODY:
            frame.name += LINK
    model = pin.buildReducedModel(whole, [whole.getJointId(name) for name in locked], still)
    for frame in model.frames:
        frame.name = frame.name.removesuffix(LINK)
    return model


def _coupling(model: Any, found: urdf.Description, driven: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """How the model's joints follow the driven ones: ``full = coupling @ q + offset``."""
    coupling, offset = np.zeros((model.nq, len(driven))), np.zeros(model.nq)
    for name in list(model.names)[1:]:
        row, follows = model.joints[model.getJointId(name)].idx_q, found.joints[name].mimic
        leader, factor, shift = follows or (name, 1.0, 0.0)
        coupling[row, driven.index(leader)], offset[row] = factor, shift
    return coupling, offset


def retipped(arm: Arm, tip: str, base: str) -> Arm:
    """The same arm with another moved link and another frame for poses; the payload stays where it is."""
    from dataclasses import replace

    if (tip, base) == (arm.tip, arm.base):
        return arm
    for link in (tip, base):
        arm._index(link)
    return replace(arm, tip=tip, base=base)


def _estimated(arm: Arm, links: Mapping[str, Mapping[str, Any]]) -> Arm:
    from dataclasses import replace

    pin, model = pinocchio(), arm._bare.copy()
    for link, body in links.items():
        frame = model.frames[model.getFrameId(link, pin.BODY)]
        inertia = pin.Inertia(body["mass"], np.array(body["center"], float), np.array(body["inertia"], float))
        model.appendBodyToJoint(frame.parentJoint, inertia, frame.placement)
    return replace(arm, inertials="estimated", _bare=model).with_payload(arm.payload)


def from_rows(
    rows: Sequence[Mapping[str, Any]],
    *,
    name: str = "dh",
    lower: float | Sequence[float] = -2 * math.pi,
    upper: float | Sequence[float] = 2 * math.pi,
    speed: Sequence[float] | None = None,
    torque: Sequence[float] | None = None,
    names: Sequence[str] | None = None,
) -> Arm:
    """An arm of revolute joints from standard Denavit-Hartenberg rows, base to tip.

    A row: ``a``, ``d`` (m), ``alpha`` (rad; a, alpha along and about x_i, d and the joint's angle along and about z_(i-1)), optional ``theta``
    (added to the angle, rad), ``mass`` (kg), ``center`` (m, in frame i), ``inertia`` (three principal moments about the centre, kg m2).
    The base is the link ``base``, the tip ``tool0`` is the last frame. Raises ``BadParameter``.
    """
    pin = pinocchio()
    count = len(rows)
    titles = tuple(names or (f"joint_{i + 1}" for i in range(count)))
    model = pin.Model()
    model.addFrame(pin.Frame("base", 0, 0, pin.SE3.Identity(), pin.BODY))
    before, parent = pin.SE3.Identity(), 0
    for row, title in zip(rows, titles, strict=True):
        a, alpha, d, theta = (_number(row, key) for key in ("a", "alpha", "d", "theta"))
        turn = pin.SE3(pin.utils.rotate("z", theta), np.zeros(3))
        parent = model.addJoint(parent, pin.JointModelRZ(), before * turn, title)
        before = pin.SE3(pin.utils.rotate("x", alpha), np.array([a, 0.0, d]))
        if row.get("mass"):
            inertia = pin.Inertia(float(row["mass"]), np.asarray(row["center"], float), np.diag(np.asarray(row["inertia"], float)))
            model.appendBodyToJoint(parent, inertia, before)
    model.addFrame(pin.Frame("tool0", parent, 0, before, pin.BODY))
    massive = bool(rows) and all(row.get("mass") for row in rows)
    bounds = [np.broadcast_to(np.asarray(bound, float), (count,)).copy() for bound in (lower, upper)]
    return Arm(
        name=name,
        names=titles,
        lower=bounds[0],
        upper=bounds[1],
        speed=tuple(speed or [None] * count),
        effort=tuple(torque or [None] * count),
        tip="tool0",
        base="base",
        inertials="given" if massive else "none",
        payload=Payload(),
        friction=Friction(),
        model=model,
        coupling=np.eye(count),
        offset=np.zeros(count),
        _bare=model,
        _data=model.createData(),
    )


def _number(row: Mapping[str, Any], key: str) -> float:
    value = row.get(key, 0.0 if key == "theta" else None)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise BadParameter(f"{key} {value!r} of a Denavit-Hartenberg row cannot be used: a finite number, m or rad")
    return float(value)


_TABLES = {"manufacturer": (-0.3922, 0.1625, 0.1333, 0.0997, 0.0996), "printed": (-0.39225, 0.0, 0.10915, 0.09465, 0.0823)}
_MASSES = (3.761, 8.058, 2.846, 1.37, 1.3, 0.365)
_CENTERS = ((0, -0.02561, 0.00193), (0.2125, 0, 0.11336), (0.15, 0, 0.0265), (0, -0.0018, 0.01634), (0, 0.0018, 0.01634), (0, 0, -0.001159))
_MOMENTS = (
    (0.0070, 0.0065, 0.0066),
    (0.0151, 0.3339, 0.3325),
    (0.0040, 0.0788, 0.0785),
    (0.0017, 0.0014, 0.0013),
    (0.0014, 0.0013, 0.0010),
    (0.0002, 0.0002, 0.0003),
)


def ur5e_rows(table: str = "manufacturer") -> list[dict[str, Any]]:
    """Denavit-Hartenberg rows of the UR5e: ``manufacturer``, or ``printed`` as the source of velocity self-learning has them.

    The printed ones are those of the older UR5 without the height of its first joint; masses and centres are the manufacturer's, moments rounded.
    """
    if table not in _TABLES:
        raise BadParameter(f"table {table!r} is not known; allowed: {', '.join(_TABLES)}")
    a3, d1, d4, d5, d6 = _TABLES[table]
    quarter = math.pi / 2
    shape = ((0.0, quarter, d1), (-0.425, 0.0, 0.0), (a3, 0.0, 0.0), (0.0, quarter, d4), (0.0, -quarter, d5), (0.0, 0.0, d6))
    bodies = zip(_MASSES, _CENTERS, _MOMENTS, strict=True)
    return [
        {"a": a, "alpha": alpha, "d": d, "mass": mass, "center": center, "inertia": moments}
        for (a, alpha, d), (mass, center, moments) in zip(shape, bodies, strict=True)
    ]


def ur5e_from_dh(table: str = "manufacturer") -> Arm:
    """The UR5e from its Denavit-Hartenberg rows (see :func:`ur5e_rows`), with the manufacturer's speeds and torques."""
    names = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint")
    return from_rows(ur5e_rows(table), name="ur5e", speed=(math.pi,) * 6, torque=(150.0, 150.0, 150.0, 28.0, 28.0, 28.0), names=names)
