"""Plans of pieces between mirrors whose copies form columns, tubes and lattices.

Where two mirrors meet at an angle of π/k the surface has a corner of π/k; a plan with another angle there converges
slowly. Where a curved side meets a straight one the polygon of the curve leaves at exactly a right angle.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..domain.shape import Shape
from ..errors import MeshError
from ..limits import COUNT, POSITIVE, Range, check_number
from ..meshing.mesher import mesh_plan
from ..signatures import checked

Array = NDArray[np.float64]

__all__ = [
    "Module",
    "capital",
    "node",
    "pentagon",
    "vault",
]


def __dir__() -> list[str]:
    """The public names only."""
    return list(__all__)


# An edge is on a straight side when both its ends are nearer than this part of the plan.
_NEAR = 1e-9
_OPENINGS = Range(3, 1000, whole=True)


@dataclass(frozen=True, eq=False)
class Module:
    """A shape between mirrors.

    shape: every boundary edge is on one of its sides. normals: of the planes of the sides, pointing out of f+; the
    cross product of the two at a corner, in the order of the boundary, is the normal of the surface there.
    """

    shape: Shape
    normals: dict[str, Array]

    def __repr__(self) -> str:
        return f"Module({self.shape!r})"


@checked
def node(tubes: int, length: float, *, depth: float = 1.0, bend: float = 1.0, max_edge: float) -> Module:
    """A quarter of half a tube from a node of `tubes` equal ones in a plane: 3 make honeycombs, 4 and 6 other grids.

    Sides: "axis", the vertical plane of the tube; "end", half-way to the next node; "floor", the horizontal plane of
    all axes; "bisector", between this tube and the next. The plan is the quadrilateral of `length` along the axis and
    `depth` along the end, with the angle π/tubes at the node and right angles elsewhere: the floor is an arc of radius
    `bend`, then straight. Two tubes are one (an unduloid) and have a rectangular plan.

    Longer plans, relative to their depth, have thinner necks. Raises `MeshError` if the arc leaves no straight part.
    """
    if tubes < 2:
        raise MeshError(f"A node needs two tubes or more, not {tubes}.")
    half = np.pi / tubes
    across = np.array([-np.sin(half), np.cos(half), 0.0])
    outline = _quadrilateral(length, tubes, depth, bend, max_edge)
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


@checked
def pentagon(length: float, spoke: float, *, depth: float = 1.0, bend: float = 1.0, max_edge: float) -> Module:
    """Half the upper half of a node of a ring: half a tube of the ring, and a quarter of the spoke that leaves it.

    Three quadrilaterals of `node(3)`, without the mirrors between them (paper, Fig. 16, inset). Sides: "middle", the
    vertical plane of the spoke, straight through the top of the node; "inner", the floor inside the ring; "ring",
    half-way to the ring's next node; "outer", the floor outside; "spoke", its end. `length` is that of the ring's tube
    and `spoke` the other one's, each as in `node`; the floors are at one height for certain lengths only.

    The harmonic map between these mirrors is no minimiser. Raises `MeshError` as `node` does.
    """
    across = np.array([-np.sqrt(0.75), 0.5, 0.0])
    turned = np.eye(3) - 2.0 * np.outer(across, across)
    ring, outer = (_quadrilateral(end, 3, depth, bend, max_edge) for end in (length, spoke))
    beside = (outer @ turned[:2, :2])[-2:0:-1]  # its ends are corners; where quadrilaterals meet there is no corner
    outline = np.concatenate([(ring * [1.0, -1.0])[:1:-1], ring[2:], beside])
    normals = {
        "middle": turned @ [0.0, -1.0, 0.0],
        "inner": np.array([0.0, 0.0, -1.0]),
        "ring": np.array([1.0, 0.0, 0.0]),
        "outer": np.array([0.0, 0.0, -1.0]),
        "spoke": turned @ [1.0, 0.0, 0.0],
    }
    places = {"middle": 0.0, "ring": length, "spoke": spoke}
    straight = {name: lambda p, n=normals[name][:2], d=d: p @ n - d for name, d in places.items()}

    def floor_of(middles: Array) -> list[str]:
        return ["inner" if below else "outer" for below in middles[:, 1] < 0.0]

    return Module(_shape(outline, max_edge, straight, floor_of), normals)


@checked
def capital(radius: float, *, oculus: float = 0.0, eighth: bool = False, bay: float = 1.0, max_edge: float) -> Module:
    """A quarter of a bay of a grid of columns: half a bay square, without the quarter disc of a column.

    Sides: "front", "right", "back", "left", the vertical planes through the axes and half-way between them, "column",
    an arc, and with an `oculus` another one of that name, about the middle of the bay. An `eighth` ends at a "diagonal"
    in place of back and left. All corners but that at a middle without oculus are right angles (there an eighth has
    45°). The radii are parts of half the `bay` in the plan, not in space: thinner plans make slenderer columns.

    The column's side takes a mirror in the floor: a ring that touched the floor would enclose the area of a whole bay.
    The oculus takes a tangent side, with the normal of a flat ceiling, or a free one.
    """
    a = 0.5 * bay
    if not (0.0 < radius < 1.0 and a > 0.0 and max_edge > 0.0 and np.isfinite([bay, max_edge]).all()):
        raise MeshError("A capital needs a positive bay and largest edge, and a radius between 0 and 1.")
    if not (0.0 <= oculus < 1.0 and radius + oculus < np.sqrt(2.0)):
        raise MeshError("The oculus of a capital must be smaller than half a bay, and must not reach its column.")
    x, y = np.eye(2)
    last = (x + y) / np.sqrt(2.0) if eighth else y
    away = -last if eighth else -x
    middle = _cut_out(a * (x + y), -y, away, oculus * a, max_edge) if oculus else (a * (x + y))[None]
    column = _cut_out(0.0 * x, last, x, radius * a, max_edge)
    outline = np.concatenate([column, [a * x], middle, *([] if eighth else [[a * y]])])
    lines = {"front": (-y, 0.0), "right": (x, a)}
    lines |= {"diagonal": ((y - x) / np.sqrt(2.0), 0.0)} if eighth else {"back": (y, a), "left": (-x, 0.0)}
    straight = {name: lambda p, n=n, d=d: p @ n - d for name, (n, d) in lines.items()}
    normals = {name: np.append(n, 0.0) for name, (n, _) in lines.items()} | {"column": np.array([0.0, 0.0, -1.0])}
    if oculus:
        normals["oculus"] = np.array([0.0, 0.0, 1.0])

    def arc_of(middles: Array) -> list[str]:
        from_column, from_middle = (np.linalg.norm(middles - at, axis=1) / a for at in (0.0 * x, a * (x + y)))
        in_column = (from_column - radius < from_middle - oculus) | (oculus == 0.0)
        return ["column" if here else "oculus" for here in in_column]

    return Module(_shape(outline, max_edge, straight, arc_of), normals)


@checked
def vault(openings: int, foot: float | Sequence[float], *, length: float = 1.0, max_edge: float) -> Module:
    """A shell that touches walls and stands on a floor (paper, Fig. 9): a polygon whose corners are cut out by arcs.

    Sides: "wall0", "wall1", …, straight, with the outward normal of each, for surfaces that touch a vertical plane
    there; "foot0", …, the arc before each wall, for mirrors in the floor. The polygon is regular with two units between
    opposite sides, and `length` times as long along the first wall. Arcs are about the corners, so that all corners of
    the plan are right angles; their radius is `foot`, one for all or one each, as a part of half a regular side.

    Feet of different radii end at different heights. Raises `MeshError` if an arc leaves nothing of a wall.
    """
    count = openings if openings in _OPENINGS else 0
    radii = np.full(count, foot, dtype=np.float64) if np.ndim(foot) == 0 else np.asarray(foot, dtype=np.float64)
    if not (count and radii.shape == (count,) and ((radii > 0.0) & (radii < 1.0)).all()):
        raise MeshError(f"A vault needs {_OPENINGS} of openings, and a foot between 0 and 1, or one for each of them.")
    if not (length >= 1.0 and max_edge > 0.0 and np.isfinite([length, max_edge]).all()):
        raise MeshError("The length of a vault must be 1 or more, its largest edge positive.")
    half = np.pi / openings
    angles = 2.0 * half * np.arange(openings) - 0.5 * np.pi - half
    corners = np.column_stack([length * np.cos(angles), np.sin(angles)]) / np.cos(half)
    along = np.roll(corners, -1, axis=0) - corners
    along /= np.linalg.norm(along, axis=1)[:, None]
    radii = radii * np.tan(half)
    outline, straight, normals = [], {}, {}
    for k, (corner, wall, radius) in enumerate(zip(corners, along, radii, strict=True)):
        outline.append(_cut_out(corner, -along[k - 1], wall, radius, max_edge))
        out = np.array([wall[1], -wall[0]])
        straight[f"wall{k}"] = lambda p, corner=corner, out=out: (p - corner) @ out
        normals |= {f"wall{k}": np.append(out, 0.0), f"foot{k}": np.array([0.0, 0.0, -1.0])}

    def foot_of(middles: Array) -> list[str]:
        nearest = np.linalg.norm(middles[:, None] - corners, axis=2).argmin(axis=1)
        return [f"foot{k}" for k in nearest]

    return Module(_shape(np.concatenate(outline), max_edge, straight, foot_of), normals)


def _quadrilateral(length: float, tubes: int, depth: float, bend: float, max_edge: float) -> Array:
    """The outline of a node: from the node along the axis, the end and the floor to the bisector."""
    if any(number not in POSITIVE for number in (length, depth, bend, max_edge)):
        raise MeshError("The length, depth, bend and largest edge of a node must be positive numbers.")
    corners = np.array([[0.0, 0.0], [length, 0.0], [length, depth]])
    if tubes == 2:
        return np.concatenate([corners, [[0.0, depth]]])
    half = np.pi / tubes
    turn = 0.5 * np.pi - half
    start = bend * np.sin(turn) + (depth + bend * (1.0 - np.cos(turn))) / np.tan(half)
    if not length > start:
        raise MeshError(f"This node must be longer than {start:.4g}, where its arc begins, not {length:g} long.")
    return np.concatenate([corners, _arc(bend, turn, max_edge) * [-1.0, 1.0] + [start, depth]])


def _cut_out(corner: Array, back: Array, ahead: Array, radius: float, max_edge: float) -> Array:
    """The polygon about an arc around a corner, from the ray along `back` to that along `ahead`, both unit vectors."""
    turn = float(np.arccos(np.clip(back @ ahead, -1.0, 1.0)))
    arc = np.vstack([[0.0, 0.0], _arc(radius, turn, max_edge)])
    inwards = (ahead - (back @ ahead) * back) / np.sin(turn)
    return corner + radius * back + arc[:, :1] * inwards - arc[:, 1:] * back


def _arc(radius: float, turn: float, max_edge: float) -> Array:
    """Points (k + 1, 2) of the polygon about an arc from the origin along x, turning left, without the origin.

    They are the corners where tangents meet, and the end, so that the first and last segments are tangent.
    """
    edges = np.ceil(radius * turn / max_edge)
    check_number(edges, "number of edges of an arc", Range(0, COUNT.most), MeshError)
    count = max(2, int(edges))
    angles = (np.arange(count) + 0.5) * turn / count
    outer = radius / np.cos(0.5 * turn / count)
    corners = np.column_stack([outer * np.sin(angles), radius - outer * np.cos(angles)])
    return np.vstack([corners, [radius * np.sin(turn), radius * (1.0 - np.cos(turn))]])


def _shape(outline: Array, max_edge: float, straight: dict, curved: str | Callable[[Array], Sequence[str]]) -> Shape:
    """The meshed plan; edges on no straight side are on the `curved` one, or on those it names for their midpoints."""
    plan = mesh_plan(outline, max_edge=max_edge, keep=[np.arange(len(outline)).tolist()])
    domain = Domain.from_positions(plan.positions, plan.triangles)
    rim = domain.boundary_edges
    ends = plan.positions[domain.edges[rim]]
    near = _NEAR * float(np.abs(outline).max())
    sides = {
        name: rim[(np.abs([far(ends[:, 0]), far(ends[:, 1])]) < near).all(axis=0)] for name, far in straight.items()
    }
    rest = np.setdiff1d(rim, np.concatenate(list(sides.values())))
    if isinstance(curved, str):
        sides[curved] = rest
    else:
        names = np.array(curved(plan.positions[domain.edges[rest]].mean(axis=1)))
        sides |= {name: rest[names == name] for name in np.unique(names)}
    return Shape(domain, plan.positions, sides)
