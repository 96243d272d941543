"""Everything that can go wrong, as exceptions.

The classes below :class:`PlanningError` are raised by the compute core; their names are those of the Rust enum. Attributes carry the values
(``point``, ``clearance``, ``needed``, ``widest`` ...); the message is one short paragraph that says what is wrong, the allowed range and what to do.
"""

from __future__ import annotations


class GuidewayError(Exception):
    """Base of all errors of this package. ``exit_code`` is what the command line returns."""

    exit_code = 2


class BadFile(GuidewayError):
    """A file cannot be used: ``where`` (file, field or line), ``what`` is wrong, what is ``allowed``, what ``todo``."""

    def __init__(self, where: str, what: str, allowed: str = "", todo: str = "") -> None:
        self.where, self.what, self.allowed, self.todo = where, what, allowed, todo
        parts = [f"{where}: {what}"] + [f"allowed: {allowed}"] * bool(allowed) + [todo] * bool(todo)
        text = ". ".join(part.rstrip(".") for part in parts)
        super().__init__(text if text.endswith("?") else text + ".")


class PlanningError(GuidewayError):
    """Raised by the compute core."""


class BadParameter(PlanningError, ValueError):
    """A parameter is outside its allowed range: ``name``, ``value``, ``allowed``."""


class OutsideMap(PlanningError):
    """A point lies outside the world: ``point`` (m), ``bounds`` (m)."""


class NoResult(PlanningError):
    """The input is fine, but there is no result."""

    exit_code = 3


class StartBlocked(NoResult):
    """The robot does not fit at the start: ``point`` (m), ``clearance`` (m), ``needed`` (m)."""


class GoalBlocked(NoResult):
    """The robot does not fit at the goal: ``point`` (m), ``clearance`` (m), ``needed`` (m)."""


class NoPath(NoResult):
    """No path: ``proved``, ``needed`` (m), ``widest`` (m or None), ``narrowest`` (point or None), ``reason``."""


class Infeasible(NoResult):
    """The motion cannot be timed under the limits: ``reason``, ``best_end_speed`` (m/s or None)."""


class CertificateFailed(NoResult):
    """A result failed the independent checker: ``stage``, ``detail``."""


class Cancelled(PlanningError):
    """Cancelled before a result was found."""

    exit_code = 130
