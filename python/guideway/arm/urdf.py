"""Robot descriptions (URDF), read and checked before they are built: every complaint names the file, the joint and the value."""

from __future__ import annotations

import math
import os
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field

from guideway.errors import BadFile
from guideway.io.files import load, name, show

MOVING = ("revolute", "continuous", "prismatic")
"""Kinds of joints that are driven."""

NUMERIC = {
    "origin": ("xyz", "rpy"),
    "axis": ("xyz",),
    "limit": ("lower", "upper", "velocity", "effort"),
    "mass": ("value",),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    "mimic": ("multiplier", "offset"),
}
"""Attributes that hold numbers, by element."""

TURNS = 1e4
"""Joint range that stands for "no limit" in the model of a continuous joint, rad."""


@dataclass(frozen=True)
class Joint:
    """A joint: its ``kind``, ``parent`` and ``child`` link, its limits (rad, rad/s, N m; m for prismatic ones; None: not given)."""

    name: str
    kind: str
    parent: str
    child: str
    lower: float = -math.inf
    upper: float = math.inf
    speed: float | None = None
    effort: float | None = None
    mimic: tuple[str, float, float] | None = None

    @property
    def moves(self) -> bool:
        """Is it driven, or does it follow another joint?"""
        return self.kind in MOVING


@dataclass(frozen=True)
class Description:
    """A checked URDF: ``text`` for the model (no pictures, no continuous or mimic joints), ``path`` of the file, its ``joints`` and link names."""

    path: str
    name: str
    text: str
    joints: dict[str, Joint]
    links: dict[str, ElementTree.Element] = field(repr=False)
    root: str

    def chain(self, tip: str) -> list[Joint]:
        """The joints from the root to a link, in that order."""
        above = {joint.child: joint for joint in self.joints.values()}
        found: list[Joint] = []
        while tip in above:
            found.append(above[tip])
            tip = above[tip].parent
        return found[::-1]

    def tip(self) -> str:
        """The link that is moved where nobody says otherwise: ``tool0``, else the end of the chain with the most driven joints."""
        if "tool0" in self.links:
            return "tool0"
        ends = [link for link in self.links if all(joint.parent != link for joint in self.joints.values())]
        return max(ends, key=lambda link: (sum(joint.moves and not joint.mimic for joint in self.chain(link)), len(self.chain(link))))


def read(path: str | os.PathLike[str]) -> Description:
    """Reads and checks a URDF file; raises :class:`guideway.errors.BadFile`."""
    where = name(path)
    try:
        robot = ElementTree.fromstring(load(path).text())
    except ElementTree.ParseError as error:
        raise BadFile(where, f"this is not valid XML ({error})", "a URDF file (expand xacro files first)", "Check the file") from None
    if robot.tag != "robot":
        raise BadFile(where, f"the document is a <{show(robot.tag)[1:-1]}>", "a <robot>, as URDF has it", "Name the URDF file of the robot")
    _finite(where, robot)
    links = {_named(where, link): link for link in robot.findall("link")}
    joints = {_named(where, element): _joint(where, element) for element in robot.findall("joint")}
    _one_tree(where, links, joints)
    root = next(link for link in links if all(joint.child != link for joint in joints.values()))
    title = robot.get("name") or "robot"
    return Description(os.fspath(path), title, _model_text(robot), joints, links, root)


def _named(where: str, element: ElementTree.Element) -> str:
    found = element.get("name")
    if not found:
        raise BadFile(where, f"a <{element.tag}> has no name", "a name for every link and joint", "Add it")
    return found


def _finite(where: str, robot: ElementTree.Element) -> None:
    """Refuses numbers that are no finite numbers, wherever they stand; elements that others have added are theirs."""
    for owner in (*robot.findall("link"), *robot.findall("joint")):
        for element in owner.iter():
            for key in NUMERIC.get(element.tag, ()):
                text = element.get(key, "")
                if not all(_is_number(part) for part in text.split()):
                    at = f"{where}, {owner.tag} {owner.get('name')}, {element.tag} {key}"
                    raise BadFile(at, f"{show(text)} cannot be used", "finite numbers", "Correct the file")


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _joint(where: str, element: ElementTree.Element) -> Joint:
    title, kind = str(element.get("name")), element.get("type", "")
    at = f"{where}, joint {title}"
    if kind not in (*MOVING, "fixed"):
        raise BadFile(at, f"a joint of type {kind or 'none'} cannot be planned", ", ".join((*MOVING, "fixed")), "Take it out of the file")
    ends = [part.get("link", "") if (part := element.find(tag)) is not None else "" for tag in ("parent", "child")]
    if not all(ends):
        raise BadFile(at, "it has no parent or no child link", "<parent link=.../> and <child link=.../>", "Correct the file")
    limit, mimic = element.find("limit"), element.find("mimic")
    if limit is None and kind in ("revolute", "prismatic"):
        raise BadFile(at, "it has no limits", "<limit lower=... upper=... velocity=... effort=.../>", "Add them")
    bounds = (-math.inf, math.inf)
    if limit is not None and kind != "continuous":
        bounds = (float(limit.get("lower", "0")), float(limit.get("upper", "0")))
        if bounds[0] > bounds[1]:
            raise BadFile(at, f"its lower limit {bounds[0]:g} is above its upper limit {bounds[1]:g}", "lower <= upper", "Correct the file")
    speed, effort = (float(limit.get(key, "0")) if limit is not None else 0.0 for key in ("velocity", "effort"))
    for key, value in (("velocity", speed), ("effort", effort)):
        if value < 0:
            raise BadFile(f"{at}, limit {key}", f"{value:g} is below 0", "a number above 0; 0 means not given", "Correct the file")
    follows = None
    if mimic is not None:
        follows = (mimic.get("joint", ""), float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0")))
    return Joint(title, kind, ends[0], ends[1], *bounds, speed if speed > 0 else None, effort if effort > 0 else None, follows)


def _one_tree(where: str, links: dict[str, ElementTree.Element], joints: dict[str, Joint]) -> None:
    children: set[str] = set()
    for joint in joints.values():
        for link in (joint.parent, joint.child):
            if link not in links:
                raise BadFile(f"{where}, joint {joint.name}", f"there is no link {show(link)}", "links of this file", "Correct the name")
        if joint.child in children:
            raise BadFile(f"{where}, joint {joint.name}", f"link {joint.child} hangs on two joints", "a tree", "Correct the file")
        children.add(joint.child)
        if joint.mimic and (joint.mimic[0] not in joints or joints[joint.mimic[0]].mimic):
            raise BadFile(f"{where}, joint {joint.name}", f"it follows {show(joint.mimic[0])}", "a driven joint of this file", "Correct the name")
    if not links:
        raise BadFile(where, "there is no link", "a robot with links and joints", "Expand xacro files first, with the macros they call")
    if len(links) - len(children) != 1:
        raise BadFile(
            where, f"{len(links) - len(children)} links hang on no joint", "one root", "Join the parts, or take those away that are not needed"
        )
    reached, front = set[str](), [link for link in links if link not in children]
    while front:
        link = front.pop()
        reached.add(link)
        front += [joint.child for joint in joints.values() if joint.parent == link]
    if len(reached) != len(links):
        raise BadFile(where, "some joints form a ring", "a tree of links", "Cut the ring open")
    if not any(joint.moves and not joint.mimic for joint in joints.values()):
        raise BadFile(where, "no joint moves", "at least one revolute, continuous or prismatic joint", "Name the URDF file of a robot")


def _model_text(robot: ElementTree.Element) -> str:
    """The file as the model builder needs it: geometry gone, continuous joints as revolute ones, mimic joints free (they are coupled later)."""
    copy = ElementTree.fromstring(ElementTree.tostring(robot))
    for child in list(copy):
        if child.tag not in ("link", "joint"):
            copy.remove(child)
    for link in copy.findall("link"):
        for tag in ("visual", "collision"):
            for part in link.findall(tag):
                link.remove(part)
    for joint in copy.findall("joint"):
        for part in joint.findall("mimic"):
            joint.remove(part)
        if joint.get("type") == "continuous":
            joint.set("type", "revolute")
            for part in joint.findall("limit"):
                joint.remove(part)
            ElementTree.SubElement(joint, "limit", lower=str(-TURNS), upper=str(TURNS), velocity="1", effort="1")
    return ElementTree.tostring(copy, encoding="unicode")
