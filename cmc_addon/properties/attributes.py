"""The mesh attributes that measures are stored in, and what each is called in the panel."""

from __future__ import annotations

from ...solver.shells.vertex_measures import DIRECTION, MEASURES

DEVIATION = "deviation"


ATTRIBUTES = {name: f"cmc_{name}" for name in (*MEASURES, DEVIATION, DIRECTION)}
"""Name of a measure -> the attribute that it is stored in."""


USUAL = (*MEASURES, DEVIATION)
"""Names of what every solve measures."""
