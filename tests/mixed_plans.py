"""Plans with a condition of its own for each side, solved by tests in Python, as job files and in Blender."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

HALL = ((0.0, 0.0), (18.0, 0.0), (18.0, 12.0), (0.0, 12.0))
ROUND = tuple((9.0 + 2.2 * np.cos(t), 6.0 + 2.2 * np.sin(t)) for t in np.linspace(0, 2 * np.pi, 40, endpoint=False))

LINE_OFF, ANGLE_OFF, NORMAL_OFF = 3e-3, 0.5, 1e-5
"""How far a fitted line may be off by the span, a lean and a given normal in degrees."""


@dataclass(frozen=True)
class MixedPlan:
    """A hall of 18 × 12 metres whose sides are on their lines but for those in `sides`: kind and parameters, degrees.

    Sides are "side0" (the street) to "side3", counter-clockwise, and "hole0". heights: of a point (n, 2). radius: of
    its corners. is_fitted: whether normals are given beside lines, else the shell is spanned.
    """

    name: str
    sides: dict[str, tuple[str, dict[str, Any]]]
    rise: float = 0.35
    radius: float = 1.5
    holes: tuple[Any, ...] = ()
    heights: Callable[[np.ndarray], np.ndarray] | None = field(default=None, repr=False)
    is_fitted: bool = False

    def mesh(self, shapes: Any, max_edge: float = 0.28) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
        """Positions (V, 3), triangles, and the vertex pairs (K, 2) of each side in `sides`. shapes: the module."""
        outline, holes = np.array(HALL), [np.array(hole) for hole in self.holes]
        shape = shapes.polygon(outline, holes, max_edge=max_edge, corner_radius=self.radius)
        flat = shape.positions[:, :2]
        z = np.zeros(len(flat)) if self.heights is None else self.heights(flat)
        pairs = {name: shape.domain.edges[shape.sides[name]] for name in self.sides}
        return np.column_stack([flat, z]), shape.domain.faces, pairs

    def turned(self, degrees: float) -> MixedPlan:
        """The same with the first side, a lean or a touched plane, farther from the upright."""
        name, (kind, parameters) = next(iter(self.sides.items()))
        more = {key: value + degrees for key, value in parameters.items() if key != "normal"}
        if kind == "plane":
            _, y, z = parameters["normal"]
            tilt = np.arctan2(z, -y) + np.radians(degrees)
            more = {"normal": (0.0, -np.cos(tilt), np.sin(tilt))}
        return replace(self, sides={**self.sides, name: (kind, more or parameters)})

    def off_line(self, points: np.ndarray, drawn: np.ndarray, triangles: np.ndarray, pairs: dict) -> float:
        """The largest distance of a shell (V, 3) from its drawn line, where that is asked for, by the span."""
        rim = _boundary(triangles)
        given = np.unique(np.concatenate(list(pairs.values())))
        on_line = np.setdiff1d(rim, given)
        a, b = drawn[rim[:, 0]], drawn[rim[:, 1]]
        way = b - a
        part = np.einsum("kij,ij->ki", points[on_line, None] - a, way) / np.einsum("ij,ij->i", way, way)
        nearest = a + np.clip(part, 0.0, 1.0)[..., None] * way
        off = np.linalg.norm(points[on_line, None] - nearest, axis=2).min(axis=1).max()
        return float(off / np.linalg.norm(np.ptp(drawn[:, :2], axis=0)))


def _boundary(triangles: np.ndarray) -> np.ndarray:
    """The vertex pairs (B, 2) of edges with one triangle."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    found, count = np.unique(edges, axis=0, return_counts=True)
    return found[count == 1]


def misses(report: dict[str, Any], codes: set[str]) -> list[str]:
    """What a report and its warnings' codes leave untold: sides off by more than they may be, without a word."""
    found = []
    for side in report.get("sides", ()):
        if side["kind"] == "held" and side["angle"] > NORMAL_OFF:
            found.append(f"{side['name']} turned by {side['angle']}")
        if side["kind"] == "lean" and side["angle"] > ANGLE_OFF and "goal-missed" not in codes:
            found.append(f"{side['name']} leans {side['angle']}° off")
    for lean in (report.get("span") or {}).get("leans", ()):
        if abs(lean["measured"] - lean["asked"]) > ANGLE_OFF:
            found.append(f"leans by {lean['measured']} instead of {lean['asked']}")
        if lean["off"] > ANGLE_OFF and "lean-missed" not in codes:
            found.append(f"leans up to {lean['off']}° off")
    return found


def _raised(points: np.ndarray) -> np.ndarray:
    """A back line 1.5 higher than the street, smoothly along the ends."""
    part = np.clip((points[:, 1] - 1.5) / 9.0, 0.0, 1.0)
    return 1.5 * part**2 * (3.0 - 2.0 * part)


_TOUCHED = {"normal": (0.0, -np.cos(np.radians(50)), np.sin(np.radians(50)))}
_WALL = ("mirror", {"normal": (-1.0, 0.0, 0.0)})

MIXED_PLANS = [
    MixedPlan("a street side leans 35° over its line", {"side0": ("lean", {"angle": 35.0})}),
    MixedPlan("a wall as mirror and three lines", {"side3": _WALL}, radius=0.0),
    MixedPlan("a plane touched along one side", {"side0": ("plane", _TOUCHED)}, is_fitted=True),
    MixedPlan("a raised line opposite a lean", {"side0": ("lean", {"angle": 50.0})}, rise=0.5, heights=_raised),
    MixedPlan("a courtyard leans 70°", {"hole0": ("lean", {"angle": 70.0})}, holes=(ROUND,)),
    MixedPlan("a street side leans 60°, rim free", {"side0": ("binormal", {"tilt": 60.0})}, is_fitted=True),
    MixedPlan(
        "rim free, opposite a lean",
        {"side0": ("binormal", {"tilt": 60.0}), "side2": ("lean", {"angle": 70.0})},
        is_fitted=True,
    ),
    MixedPlan(
        "a plane touched beside a wall as mirror",
        {"side0": ("plane", _TOUCHED), "side3": _WALL},
        radius=0.0,
        is_fitted=True,
    ),
]
