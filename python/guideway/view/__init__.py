"""Pictures of results: one self-contained HTML report, figures for papers, map images.

Reads results (the dictionaries of ``plan.json`` and ``run.json``) and a picture of the world; never plans anything itself.
"""

from .alternatives import alternatives_figure
from .course import search_figure
from .figure import figure, map_png
from .report import page, report
from .scenery import Scenery

__all__ = ["Scenery", "alternatives_figure", "figure", "map_png", "page", "report", "search_figure"]
