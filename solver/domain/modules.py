"""Plans of pieces between mirrors whose copies make columns, tubes and lattices, with the corner angles of the surface.

Where two mirrors meet at an angle of π/k a surface has a corner of π/k; a plan that has another angle there converges
slowly. Where a curved side meets a straight one the polygon of the curve leaves at a right angle exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError
from .domain import Domain
from .mesher import mesh_plan
from .shapes import Shape

Array = NDArray[np.float64]

# An edge is on a straight side when both its ends are nearer than this part of the plan.
_NEAR = 1e-9


@dataclass(frozen=True, eq=False)
class Module:
    """A shape between mirrors.

    shape: every boundary edge is on one of its sides. normals: of the planes of the sides, out of f+, so that the two
    of a corner have the normal of the surface there for their product, in the order of the boundary.
    """

    shape: Shape
    normals: dict[str, Array]


def node(tubes: int, length: float, *, depth: float = 1.0, bend: float = 1.0, max_edge: float) -> Module:
    """A quarter of half a tube from a node of `tubes` equal ones in a plane: 3 make honeycombs, 4 and 6 other grids.

    Sides: "axis", the vertical plane of the tube; "end", half-way to the next node; "floor", the horizontal plane of
    all axes; "bisector", between this tube and the next. The plan is the quadrilateral of `length` along the axis and
    `depth` along the end, with the angle π/tubes at the node and right angles elsewhere: the floor is an arc of radius
    `bend`, then straight. Two tubes are one (an unduloid) and have a rectangular plan.

    Longer plans, relative to their depth, have thinner necks. Raises `MeshError` where the arc leaves no straight part.
    """
    if tubes < 2:
        raise MeshError(f"A node needs two tubes or more, not {tubes}.")
    half = np.pi / tubes
    across = np.array([-np.sin(half), np.cos(half), 0.0])
    turn = 0.5 * np.pi - half
    start = bend * np.sin(turn) + (depth + bend * (1.0 - np.cos(turn))) / np.tan(half) if tubes > 2 else 0.0
    if not (min(length, depth, bend, max_edge) > 0.0 and np.isfinite([length, depth, bend, max_edge]).all()):
        raise MeshError("The length, depth, bend and largest edge of a node must be positive numbers.")
    if not length > start:
        raise MeshError(f"This node must be longer than {start:.4g}, where its arc begins, not {length:g} long.")
    arc = _arc(bend, turn, max_edge) * [-1.0, 1.0] + [start, depth] if tubes > 2 else np.array([[0.0, depth]])
    outline = np.concatenate([[[0.0, 0.0], [length, 0.0], [length, depth]], arc])
    straight = {
        "axis": lambda p: p[:, 1],
        "end": lambda p: p[:, 0] - length,
        "bisector": lambda p: p @ across[:2],
    }
    normals = {
        "axis": np.array([0.0, -1.0, 0.0]),
        "end": np.array([1.0, 0.0, 0.0]),
        "floor": np.array([0.0, 0.0, -1.0]),
        "bisector": across,
    }
    return Module(_shape(outline, max_edge, straight, "floor"), normals)


def capital(radius: float, *, bay: float = 1.0, max_edge: float) -> Module:
    """A quarter of a bay of a grid of columns: half a bay square, less the quarter of a disc from which a column comes.

    Sides: "front", "right", "back", "left", the vertical planes through the axes and half-way between them, and
    "column", an arc. All corners are right angles. `radius` is a part of half the `bay` in the plan, not in space:
    thinner plans make slenderer columns. The column's side may be a mirror, in the floor, or touch the floor.
    """
    a = 0.5 * bay
    if not (0.0 < radius < 1.0 and a > 0.0 and max_edge > 0.0 and np.isfinite([bay, max_edge]).all()):
        raise MeshError("A capital needs a positive bay and largest edge, and a radius between 0 and 1.")
    r = radius * a
    arc = _arc(r, 0.5 * np.pi, max_edge)[:-1]
    outline = np.concatenate([[[r, 0.0], [a, 0.0], [a, a], [0.0, a], [0.0, r]], arc * [1.0, -1.0] + [0.0, r]])
    straight = {
        "front": lambda p: p[:, 1],
        "right": lambda p: p[:, 0] - a,
        "back": lambda p: p[:, 1] - a,
        "left": lambda p: p[:, 0],
    }
    normals = {
        "front": np.array([0.0, -1.0, 0.0]),
        "right": np.array([1.0, 0.0, 0.0]),
        "back": np.array([0.0, 1.0, 0.0]),
        "left": np.array([-1.0, 0.0, 0.0]),
        "column": np.array([0.0, 0.0, -1.0]),
    }
    return Module(_shape(outline, max_edge, straight, "column"), normals)


def _arc(radius: float, turn: float, max_edge: float) -> Array:
    """Points (k + 1, 2) of the polygon about an arc that starts at the origin along x and turns left, the start left
    out: corners where tangents meet, and the end, so that its first and last segments are tangent."""
    count = max(2, int(np.ceil(2.0 * radius * turn / max_edge)))
    angles = (np.arange(count) + 0.5) * turn / count
    outer = radius / np.cos(0.5 * turn / count)
    corners = np.column_stack([outer * np.sin(angles), radius - outer * np.cos(angles)])
    return np.vstack([corners, [radius * np.sin(turn), radius * (1.0 - np.cos(turn))]])


def _shape(outline: Array, max_edge: float, straight: dict, curved: str) -> Shape:
    """The meshed plan; edges that are on no straight side are on the curved one."""
    plan = mesh_plan(outline, max_edge=max_edge)
    domain = Domain.from_positions(plan.positions, plan.triangles)
    rim = domain.boundary_edges
    ends = plan.positions[domain.edges[rim]]
    near = _NEAR * float(np.abs(outline).max())
    sides = {
        name: rim[(np.abs([far(ends[:, 0]), far(ends[:, 1])]) < near).all(axis=0)] for name, far in straight.items()
    }
    sides[curved] = np.setdiff1d(rim, np.concatenate(list(sides.values())))
    return Shape(domain, plan.positions, sides)
