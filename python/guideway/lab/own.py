"""Planners of users: any Python object with ``plan(query, ...)``, named in an experiment or given to :func:`guideway.lab.compare`."""

from __future__ import annotations

import importlib
import importlib.util
import pickle
from pathlib import Path
from types import ModuleType
from typing import Any

from guideway.errors import BadFile, BadParameter
from guideway.io.files import show

PICKLED = "pickle:"
"""Before the file of a pickled object, as :func:`guideway.lab.compare` writes it."""


def is_own(planner: str) -> bool:
    """Is it ``file.py:Name``, ``package.module:Name`` or ``pickle:FILE``, rather than a registered planner or a peer?"""
    return ":" in planner and not planner.startswith("peer:")


def load(planner: str, folder: str, settings: dict[str, Any] | None = None) -> Any:
    """A new object for every call, so that no run sees what another left behind. ``folder`` is where relative files are.

    ``file.py:Name`` and ``package.module:Name`` name a class, a function that returns a planner (both called with ``settings``), or an object with
    ``plan``. Raises :class:`guideway.GuidewayError`.
    """
    if planner.startswith(PICKLED):
        return _with_plan(planner, _unpickled(Path(folder) / planner.removeprefix(PICKLED)))
    place, _, name = planner.rpartition(":")
    found = getattr(_module(planner, place, folder), name, None)
    if found is None:
        raise BadParameter(f"planner {show(planner)}: there is no {name} in {place}")
    if isinstance(found, type) or not hasattr(found, "plan"):
        if not callable(found):
            raise BadParameter(f"planner {show(planner)}: {name} has no method plan(query) and cannot be called")
        found = found(**(settings or {}))
    return _with_plan(planner, found)


def _unpickled(path: Path) -> Any:
    try:
        return pickle.loads(path.read_bytes())
    except Exception as error:  # whatever the object does when it is made again
        raise BadFile(str(path), f"the planner in it cannot be made again ({type(error).__name__}: {error})") from error


def _with_plan(planner: str, found: Any) -> Any:
    if not callable(getattr(found, "plan", None)):
        raise BadParameter(f"planner {show(planner)}: it has no method plan(query)")
    return found


_LOADED: dict[str, ModuleType] = {}


def _module(planner: str, place: str, folder: str) -> ModuleType:
    if not place.endswith(".py"):
        try:
            return importlib.import_module(place)
        except ImportError as error:
            raise BadParameter(
                f"planner {show(planner)}: its module cannot be loaded ({error}); write file.py:Name or package.module:Name"
            ) from error
    path = str((Path(folder) / place).absolute())
    if path not in _LOADED:
        spec = importlib.util.spec_from_file_location(Path(path).stem, path)
        if not Path(path).is_file() or spec is None or spec.loader is None:
            raise BadFile(path, "there is no such file", "file.py:Name, relative to the experiment's file", "Correct planner")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        _LOADED[path] = module
    return _LOADED[path]
