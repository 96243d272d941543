"""Pictures of results: one self-contained HTML report, figures for papers, map images.

Reads results (the dictionaries of ``plan.json``, ``run.json`` and ``traj.json``) and a picture of the world; never plans anything itself.
"""

from .alternatives import alternatives_figure
from .arm import is_arm
from .arm import page as arm_page
from .arm import report as arm_report
from .arm_figure import arm_figure
from .course import search_figure
from .figure import figure, map_png
from .report import page, report
from .scenery import Scenery

__all__ = [
    "Scenery",
    "alternatives_figure",
    "arm_figure",
    "arm_page",
    "arm_report",
    "figure",
    "is_arm",
    "map_png",
    "page",
    "report",
    "search_figure",
]
