"""Lengths, areas and curvatures as text, in the units of the scene."""

from __future__ import annotations

import bpy


def length_text(value: float, power: int = 1, digits: int = 4) -> str:
    """A length or area in the units of the scene."""
    units = bpy.context.scene.unit_settings
    if units.system == "NONE":
        return f"{value:.{digits}g}" if abs(value) >= 1e-6 else "0"
    kind = {1: "LENGTH", 2: "AREA"}[power]
    value *= units.scale_length**power
    return bpy.utils.units.to_string(units.system, kind, value, precision=digits, split_unit=False)


def per_length() -> str:
    """The unit of H: one over a Blender unit, which is a metre in a metric scene of scale 1."""
    units = bpy.context.scene.unit_settings
    return "1/m" if units.system == "METRIC" and units.scale_length == 1.0 else "per unit"
