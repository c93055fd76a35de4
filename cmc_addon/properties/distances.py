"""How near an approximation is, as text: the names of its distances in the panel, and their units."""

from __future__ import annotations

from ...solver.fitting.targets import Closed, GaussMap, NearSurface, RimOnCurve, SmoothRim
from ...solver.measure.summary import NOISE
from .units import length_text

NAMES = {
    RimOnCurve.label: "Off Rim",
    NearSurface.label: "Off Surface",
    GaussMap.label: "Off Normals",
    SmoothRim.label: "Rim Roughness",
    Closed.label: "Gap",
}
"""The solver's name of a distance -> the panel's."""

_LENGTHS = {target.label for target in (RimOnCurve, NearSurface, Closed)}


def goal_text(label: str, off: float, size: float) -> str:
    """A distance with its unit, or "None" where it is noise on a shell of this size."""
    if off <= NOISE * (size if label in _LENGTHS else 1.0):
        return "None"
    return length_text(off, digits=2) if label in _LENGTHS else f"{off:.2g}"
