"""Boundary conditions by their names in architecture: a wall, 45°, a flat rim, mirrors, the floor."""

from __future__ import annotations

import math
from dataclasses import dataclass, field


@dataclass(frozen=True)
class GroupPreset:
    """kind: of `CmcGroup`. values: of its parameters. axis: of a mirror, whose normal points out of the plan along it,
    in either direction."""

    label: str
    description: str
    icon: str
    kind: str
    values: dict[str, object] = field(default_factory=dict)
    axis: tuple[float, float, float] | None = None


PRESETS = {
    "LINE": GroupPreset(
        "On the Line", "The rim lies on these edges, with their heights", "CURVE_PATH", "LINE"),
    "LEAN": GroupPreset(
        "Leans over its Line", "The rim stays over these edges, rises and falls there, and leans by 45°",
        "MOD_SIMPLEDEFORM", "LEAN", {"angle": math.radians(45.0)}),
    "WALL": GroupPreset(
        "Vertical Wall", "The shell stands upright along these edges: lean 0°", "ALIGN_TOP",
        "BINORMAL", {"tilt": 0.0}),
    "HALF": GroupPreset(
        "45°", "The shell leans in by 45° along these edges", "IPO_LINEAR", "BINORMAL",
        {"tilt": math.radians(45.0)}),
    "FLAT": GroupPreset(
        "Flat Rim", "The shell lies flat along these edges: lean 90°", "IPO_CONSTANT", "BINORMAL",
        {"tilt": math.radians(90.0)}),
    "MIRROR_X": GroupPreset(
        "Mirror X", "The shell meets a wall across the X axis at right angles and continues behind it as its mirror "
        "image", "MOD_MIRROR", "MIRROR", axis=(1.0, 0.0, 0.0)),
    "MIRROR_Y": GroupPreset(
        "Mirror Y", "The shell meets a wall across the Y axis at right angles and continues behind it as its mirror "
        "image", "MOD_MIRROR", "MIRROR", axis=(0.0, 1.0, 0.0)),
    "FLOOR": GroupPreset(
        "Mirror Floor", "The shell meets the level floor at right angles and continues below it as its mirror image",
        "MOD_MIRROR", "MIRROR", {"normal": (0.0, 0.0, -1.0)}),
}
"""Identifier → preset, in the order of the menus."""


def preset_items() -> list[tuple[str, str, str, str, int]]:
    """For an EnumProperty."""
    return [(name, p.label, p.description, p.icon, k) for k, (name, p) in enumerate(PRESETS.items())]
