"""JSON Schemas (draft 2020-12) of the files that Guideway promises: ``plan`` (plan.json), ``run`` (run.json), ``arm`` (traj.json), ``row`` (a line
of ``--scen``), ``scene`` (scene and job TOML, read as plain data), ``record`` (a line of the
lab's records), ``summary`` (summary.json of the lab).

They name every promised field with its unit and allow further ones.
"""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

NAMES = ("arm", "plan", "record", "row", "run", "scene", "summary")


def load(name: str) -> dict[str, Any]:
    """The schema called ``name``, one of ``NAMES``, as plain data; raises ``KeyError`` for another name."""
    if name not in NAMES:
        raise KeyError(f"no schema is called {name!r}: one of {', '.join(NAMES)}")
    return json.loads(files(__name__).joinpath(f"{name}.schema.json").read_text("utf-8"))
