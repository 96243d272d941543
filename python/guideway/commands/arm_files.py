"""What the sub-verbs of ``guideway arm`` share: options of safety and output, refusals of a certificate, files."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from guideway.commands import options

if TYPE_CHECKING:
    from guideway.arm import ArmMotion


def add_safety(parser: argparse.ArgumentParser) -> None:
    """What stands around the arm."""
    safe = parser.add_argument_group("safety")
    safe.add_argument(
        "--scene", metavar="FILE.toml", help="what stands around the arm: [[box]], [[sphere]], [[cylinder]], [[mesh]], [[tool]], clearance"
    )
    safe.add_argument("--clearance", type=float, metavar="M", help="distance to keep from all that, and of the arm from itself, m (default 0)")
    safe.add_argument("--no-collisions", action="store_true", help="do not check collisions")


def add_output(parser: argparse.ArgumentParser) -> None:
    """Which files are written."""
    out = parser.add_argument_group("output")
    out.add_argument("--out", metavar="FILE", help="the record as JSON")
    out.add_argument("--csv", metavar="FILE", help="the motion of the joints as a table")
    out.add_argument("--urscript", metavar="FILE", help="a program of servoj steps for arms of Universal Robots")
    out.add_argument("--ros", metavar="FILE", help="a ROS JointTrajectory as YAML")
    out.add_argument("--report", metavar="FILE", help="a self-contained HTML report")
    out.add_argument("--rate", type=float, default=500.0, metavar="HZ", help="samples per second in files (default 500; ROS 100 at most)")
    out.add_argument("--json", action="store_true", help="the record on stdout, and nothing else there")


def places(arguments: argparse.Namespace) -> tuple[str | None, ...]:
    """Files that are asked for."""
    return (arguments.out, arguments.csv, arguments.urscript, arguments.ros, arguments.report)


def failure(motion: ArmMotion, certificate: dict[str, Any]) -> str:
    """What the certificate refuses, in one paragraph."""
    collision = certificate["collision"]
    if collision is not None and not collision["ok"]:
        return collided(collision, f", t = {motion.time_at(collision['hit']['s']):.4g} s")
    worst = next(check for check in certificate["checks"] if not check["ok"])
    if "ratio" in worst:
        return f"certificate: {worst['name']} reaches {worst['ratio']:.9f} of its limit at t = {worst['t']:.4g} s"
    return f"certificate: {worst['name']}: {worst.get('margin', worst.get('gap'))!r}"


def collided(collision: dict[str, Any], when: str = "") -> str:
    """Which shapes come too near each other, and what to do."""
    hit = collision["hit"]
    near = f"come as near as {hit['distance']:.3g} m, less than the clearance, or too near to be proved apart"
    what = "overlap" if hit["distance"] <= 0 else near
    return (
        f"collision: {hit['pair']} {what} at s = {hit['s']:.4g} rad{when}; "
        f"clearance {collision['clearance']:g} m. Move the path, take another posture, or correct the shapes; "
        "--no-collisions leaves this check out"
    )


def near(collision: dict[str, Any]) -> str:
    """What came nearest to what."""
    closest = collision["closest"]
    if closest is None:
        return "nothing to collide with"
    return f"no collision ({collision['pairs']} pairs): {closest['pair']} come as near as {closest['distance']:.3f} m"


def write(arguments: argparse.Namespace, motion: ArmMotion, record: dict[str, Any], shown: Any) -> list[str]:
    """Writes the files that are asked for, none where one of them cannot be made; ``shown`` is what the report shows. Returns their names."""
    from guideway.arm import outputs

    rate = arguments.rate
    makers = (
        (arguments.out, lambda: json.dumps(record, allow_nan=False) + "\n"),
        (arguments.csv, lambda: outputs.csv_text(motion, rate)),
        (arguments.urscript, lambda: outputs.urscript(motion, min(rate, 500.0))),
        (arguments.ros, lambda: outputs.ros_yaml(motion, min(rate, 100.0))),
    )
    made = [(place, make()) for place, make in makers if place]
    for place, text in made:
        options.write(place, text)
    if arguments.report:
        from guideway.view import arm_report

        arm_report(shown, arguments.report)
    return [place for place in places(arguments) if place]
