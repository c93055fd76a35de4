"""Lengths, areas and curvatures as text, in the units of the scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeVar

import bpy

from ...solver.measure.summary import NOISE, percent
from ...solver.notes import Note, Sentence

_FOOT = 0.3048
_IMPERIAL = {2: "sq ft", 3: "cu ft"}


def metres(value: float) -> float:
    """A length in metres as Blender units of the scene, as the defaults of Blender's own primitives are."""
    units = bpy.context.scene.unit_settings
    return value if units.system == "NONE" else value / units.scale_length


def length_text(value: float, power: int = 1, digits: int = 4) -> str:
    """A length, area or volume in the units of the scene."""
    units = bpy.context.scene.unit_settings
    if units.system == "NONE":
        return f"{value:.{digits}g}" if abs(value) >= 1e-6 else "0"
    value *= units.scale_length**power
    if power > 1 and units.system == "IMPERIAL":  # Blender would give square yards beside feet
        return f"{value / _FOOT**power:.{digits}g} {_IMPERIAL[power]}"
    kind = {1: "LENGTH", 2: "AREA", 3: "VOLUME"}[power]
    return bpy.utils.units.to_string(units.system, kind, value, precision=digits, split_unit=False)


S = TypeVar("S", bound=str)


def in_scene_units(text: S) -> S:
    """A sentence or a warning of the solver with its lengths in the units of the scene."""
    return text.written(length_text) if isinstance(text, (Sentence, Note)) else text  # type: ignore[return-value]


def part_text(length: float, part: float, words: str = "") -> str:
    """A length with the part of the shell's size that it is, or "None" where it is noise; words: after the length."""
    return "None" if part < NOISE else f"{length_text(length, digits=2)}{words} ({percent(part)})"


def vector_text(vector: Sequence[float]) -> str:
    """A vector in metres or feet, with the decimals that give its length three digits."""
    units = bpy.context.scene.unit_settings
    size, unit = {"METRIC": (1.0, " m"), "IMPERIAL": (_FOOT, " ft")}.get(units.system, (units.scale_length, ""))
    numbers = [x * units.scale_length / size for x in vector]
    length = math.hypot(*numbers)
    decimals = max(0, 2 - math.floor(math.log10(length))) if length > 0.0 else 0
    return "({}, {}, {}){}".format(*(f"{round(x, decimals) + 0.0:.{decimals}f}" for x in numbers), unit)


def per_length() -> str:
    """The unit in which `in_units` gives H."""
    return {"METRIC": "1/m", "IMPERIAL": "1/ft"}.get(bpy.context.scene.unit_settings.system, "per unit")


def in_units(curvature: float, power: int = 1) -> float:
    """A curvature of a surface in Blender units, H or with power 2 K, in the units of the scene (see `per_length`)."""
    units = bpy.context.scene.unit_settings
    length = {"METRIC": 1.0, "IMPERIAL": _FOOT}.get(units.system, units.scale_length)
    return curvature * (length / units.scale_length) ** power
