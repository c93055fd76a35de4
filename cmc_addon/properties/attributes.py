"""The mesh attributes that store the measures of a result."""

from __future__ import annotations

from ...solver.shells.vertex_measures import DIRECTION, MEASURES

DEVIATION = "deviation"


ATTRIBUTES = {name: f"cmc_{name}" for name in (*MEASURES, DEVIATION, DIRECTION)}
"""Name of a measure -> its attribute."""


USUAL = (*MEASURES, DEVIATION)
"""The measures of every solve."""
