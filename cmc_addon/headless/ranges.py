"""Numbers that are given to properties without a window: out of their range Blender would move them without a word."""

from __future__ import annotations

import math
from typing import Any

import bpy

from ...solver.errors import JobError

# What single precision may move an end of a range by.
_SLACK = 1e-6


def check_range(rna: bpy.types.Property, value: Any) -> None:
    """Raise `JobError` on a number, or one of several, that the property does not take."""
    if rna.type not in ("FLOAT", "INT"):
        return
    low, high = rna.hard_min, rna.hard_max
    for number in value if isinstance(value, (list, tuple)) else [value]:
        if not low - _SLACK * abs(low) <= number <= high + _SLACK * abs(high):
            turn = math.degrees if rna.unit == "ROTATION" else float
            ends = f"from {turn(low):.6g} to {turn(high):.6g}"
            name = rna.identifier.replace("_", " ")
            raise JobError(f"The {name} is a number {ends} in Blender, not {turn(number):.6g}.")
