"""Plans with lines along some sides and given normals along others, for docs/measured/fitting.md."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver import conditions, shapes

Array = NDArray[np.float64]

EDGE = 0.42
HALL = np.array([[0.0, 0.0], [18.0, 0.0], [18.0, 12.0], [0.0, 12.0]])
L_SHAPE = np.array([[0, 0], [18, 0], [18, 8], [9, 8], [9, 16], [0, 16]])


@dataclass(frozen=True)
class MixedPlan:
    """A plan with positions (V, 3), and the options of `fit_outline` by the angle of its lean in degrees."""

    name: str
    shape: shapes.Shape
    goals: Callable[[float], dict[str, Any]] = field(repr=False)
    angle: float
    positions: Array = field(repr=False)


def mixed_plans() -> list[MixedPlan]:
    """In metres, about 1,500 vertices each."""
    hall, sharp, ell, ellipse, court = _hall(), _hall(0.0), _ell(), _ellipse(), _courtyard()
    raised = _flat(hall)
    part = np.clip((raised[:, 1] - 1.5) / 9.0, 0.0, 1.0)
    raised[:, 2] = 1.5 * part**2 * (3.0 - 2.0 * part)

    def lean(shape: shapes.Shape, side: str, rise: float = 0.35) -> Callable[[float], dict[str, Any]]:
        return lambda angle: {"rise": rise, "held": _binormal(shape, side, angle)}

    def with_lean(angle: float) -> dict[str, Any]:
        over = conditions.lean(hall, "back", np.radians(70))
        return {"rise": 0.35, "held": _binormal(hall, "street", angle) + over}

    def beside_mirror(angle: float) -> dict[str, Any]:
        mirror = conditions.mirror(sharp, "left", [1, 0, 0])
        return {"rise": 0.35, "held": _binormal(sharp, "street", angle) + mirror}

    def touching(angle: float) -> dict[str, Any]:
        normal = [0.0, -np.cos(np.radians(angle)), np.sin(np.radians(angle))]
        return {"rise": 0.35, "held": conditions.fixed(hall, "street", normal)}

    def two(angle: float) -> dict[str, Any]:
        return {"rise": 0.35, "held": _binormal(hall, "street", angle) + _binormal(hall, "back", 70)}

    def wall(_: float) -> dict[str, Any]:
        return {"rise": 0.35, "held": conditions.mirror(sharp, "left", [1, 0, 0])}

    plans = [
        ("street side leans 35°, rim free", hall, lean(hall, "street"), 35),
        ("the same, 60°", hall, lean(hall, "street"), 60),
        ("the same, 85°", hall, lean(hall, "street"), 85),
        ("L, street side 45°", ell, lean(ell, "street"), 45),
        ("a third of an ellipse, 70°", ellipse, lean(ellipse, "third"), 70),
        ("touches a plane of 50°", hall, touching, 50),
        ("opposite sides, 60° and 70°", hall, two, 60),
        ("60°, opposite one 70° over its line", hall, with_lean, 60),
        ("60°, a wall as mirror", sharp, beside_mirror, 60),
        ("three lines, a wall as mirror", sharp, wall, 0),
        ("courtyard leans 70°", court, lean(court, "hole0"), 70),
    ]
    found = [MixedPlan(name, shape, goals, angle, _flat(shape)) for name, shape, goals, angle in plans]
    return [*found, MixedPlan("50°, opposite line raised by 1.5", hall, lean(hall, "street", rise=0.5), 50, raised)]


def _hall(corner_radius: float = 1.5, **how: Any) -> shapes.Shape:
    shape = shapes.polygon(HALL, max_edge=EDGE, corner_radius=corner_radius, **how)
    for name, axis, place in (("street", 1, 0.0), ("back", 1, 12.0), ("left", 0, 0.0)):
        shape.sides[name] = _straight(shape, axis, place)
    return shape


def _courtyard() -> shapes.Shape:
    t = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    return _hall(holes=[np.column_stack([9 + 2.2 * np.cos(t), 6 + 2.2 * np.sin(t)])])


def _ell() -> shapes.Shape:
    shape = shapes.polygon(L_SHAPE, max_edge=EDGE, corner_radius=1.5)
    shape.sides["street"] = _straight(shape, 1, 0.0)
    return shape


def _ellipse() -> shapes.Shape:
    t = np.linspace(0, 2 * np.pi, 120, endpoint=False)
    shape = shapes.polygon(np.column_stack([10 * np.cos(t), 6.5 * np.sin(t)]), max_edge=EDGE)
    rim = shape.domain.boundary_edges
    x, y = shape.positions[shape.domain.edges[rim]].mean(axis=1).T
    shape.sides["third"] = rim[np.abs(np.arctan2(y / 6.5, x / 10) + np.pi / 2) < np.pi / 3]
    return shape


def _straight(shape: shapes.Shape, axis: int, place: float) -> NDArray[np.integer]:
    """The boundary edges at one coordinate."""
    rim = shape.domain.boundary_edges
    ends = shape.positions[shape.domain.edges[rim]]
    return rim[(np.abs(ends[:, :, axis] - place) < 1e-6).all(axis=1)]


def _binormal(shape: shapes.Shape, side: str, degrees: float) -> conditions.Conditions:
    return conditions.binormal(shape, side, tilt=np.radians(degrees))


def _flat(shape: shapes.Shape) -> Array:
    return np.column_stack([shape.positions, np.zeros(len(shape.positions))])
