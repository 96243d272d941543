"""``guideway demo``: the main job on a real map that ships with the package."""

from __future__ import annotations

import argparse
import os
import shutil
from importlib.resources import as_file, files

from guideway import driving, jobs
from guideway.commands import drive as drive_verb
from guideway.commands import options
from guideway.commands import plan as plan_verb

EXAMPLES = """examples:
  guideway demo
  guideway demo --out tour --seed 3"""

FILES = ("demo.toml", "warehouse.yaml", "warehouse.png")


def declare(parser: argparse.ArgumentParser) -> None:
    """Names the options."""
    parser.epilog = EXAMPLES
    parser.add_argument("--out", metavar="DIR", default="guideway-demo", help="folder for the results (default guideway-demo)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the noise (default 0)")
    parser.set_defaults(handler=handle)


def handle(arguments: argparse.Namespace) -> int:
    """Runs the verb."""
    from guideway.io import load_scene
    from guideway.view import report

    options.count("--seed", arguments.seed)
    folder = arguments.out
    unpack(folder)
    job = plan_verb.job_of_scene(load_scene(os.path.join(folder, FILES[0])))
    outcome = jobs.run(job, folder)
    options.write(os.path.join(folder, "plan.json"), options.sealed_json(outcome.record))
    print(f"A transfer robot in a warehouse of {_size(outcome)}, among fork lifts and people.\n")
    print(plan_verb.summary(outcome.record))
    assert outcome.trajectory is not None
    drive = driving.Drive(outcome.query, outcome.trajectory, job.limits, seed=arguments.seed, arrival=0.2)
    run = driving.run(drive, folder)
    options.write(os.path.join(folder, "run.json"), options.sealed_json(run))
    print(drive_verb.summary(run))
    target = os.path.join(folder, "report.html")
    report([outcome.record, run], target, worlds=[outcome.query.world] * 2, title="Guideway demo: a warehouse that moves")
    print(f"\nOpen {target} in a browser.")
    return 130 if run["cancelled"] else 0 if run["outcome"] == "arrived" else 3


def unpack(folder: str) -> None:
    """Copies the demo's map and scene, so that the folder stands on its own."""
    from guideway.errors import BadFile

    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        raise BadFile(folder, f"the folder cannot be made ({error.strerror})", "", "Choose another place with --out") from None
    for name in FILES:
        with as_file(files("guideway").joinpath("data").joinpath(name)) as path:
            shutil.copyfile(path, os.path.join(folder, name))


def _size(outcome: jobs.Outcome) -> str:
    world = outcome.query.world
    return f"{world.width * world.resolution:.0f} x {world.height * world.resolution:.0f} m"
