"""Distances of a fitted shell from its goals as text: their names in the panel, and their units."""

from __future__ import annotations

import math

from ...solver.fitting.targets import (
    Anchors,
    Area,
    Closed,
    Crown,
    GaussMap,
    MinimalChange,
    NearSurface,
    RimOnCurve,
    SmoothRim,
    TiltBounds,
    Volume,
)
from ...solver.measure.summary import NOISE
from .units import length_text

NAMES = {
    RimOnCurve.label: "Off Line",
    Crown.label: "Off Height",
    Volume.label: "Off Volume",
    Area.label: "Off Area",
    Anchors.label: "Off Anchors",
    NearSurface.label: "Off Surface",
    GaussMap.label: "Off Normals",
    MinimalChange.label: "Turn of Normals",
    SmoothRim.label: "Rim Roughness",
    TiltBounds.label: "Off Lean",
    Closed.label: "Gap",
}
"""The solver's name of a distance -> the panel's."""

_POWERS = {target.label: 1 for target in (RimOnCurve, Crown, Anchors, NearSurface, Closed)}
_POWERS |= {Area.label: 2, Volume.label: 3}


def goal_text(label: str, off: float, size: float) -> str:
    """A distance with its unit, or "None" where it is noise on a shell of this size."""
    power = _POWERS.get(label, 0)
    if off <= NOISE * size**power:
        return "None"
    if label == TiltBounds.label:
        return f"{math.degrees(off):.2g}°"
    return length_text(off, power, digits=2) if power else f"{off:.2g}"
