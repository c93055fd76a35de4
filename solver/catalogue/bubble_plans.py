"""Bubbles to start from: a quarter of a Wente cylinder, a whole torus, a honeycomb ring (paper, Sec. 5.3.3).

Their maps are no minimisers on the whole surface. The quarter is one between its mirrors; torus and ring are whole,
with edge lengths of their own and an initial map (paper, Figures 13, 15 and 16).
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ..errors import ConditionError
from ..symmetry.complete import complete
from ..symmetry.completion import Completion
from ..symmetry.glued_map import whole
from . import modules
from .holed_plans import StartPlan, seams_of
from .honeycomb_ring import ring
from .wente import Bubble, cover_count, wente
from .wente_heights import check_angle, discrete_height

Array = NDArray[np.float64]

# These shells intersect themselves by nature, so they are not tested for it.
_QUIET = {"intersections": False}
# Largest denominator of a simple part of a half turn, and how near an angle must be to count as that part.
_MOST_PARTS, _SINGLE = 100, 1e-6
# A ring's plan lies by this part of 1/(2H) inside the shell, so that the two do not coincide.
_INSIDE = 0.15
# Radius 1/H of a Wente torus, as a part of its diameter.
_RADIUS = 0.3


def wente_plan(size: float, angle: float, height: float, columns: int) -> StartPlan:
    """A quarter of a Wente cylinder whose ends have normals `angle` apart; `size` is about that of the torus.

    height: as a part of the one at which the cylinder closes; 1 finds that height exactly. columns: of the quarter,
    which is halved at a mirror where copies of the whole would cover the torus twice. The shell continues across the
    sides that make it a torus if that closes, a cylinder if it does not, and a strip of bubbles if the cylinder is open
    (paper, Fig. 13). Raises `ConditionError` where there is no bubble.
    """
    bubble = _bubble(angle, columns, height)
    flat = bubble.positions * (0.5 * size / float(np.ptp(bubble.positions, axis=0).max()))
    sides = {title: next(side for side in bubble.sides if side.name == name) for name, title in _TITLES.items()}
    halved = sides["Top"].kind == "mirror"
    kinds: dict[str, tuple[str, Mapping[str, object]]] = {
        "Mirror": ("mirror", {"normal": (0.0, 0.0, 1.0), "winding": 0.0 if halved else 1.0}),
        "Free": ("free", {"across": "ON"}),
    }
    is_torus = bubble.closed and bubble.cylinders is not None
    for title in ("Bottom", "Top"):
        normal = tuple(np.asarray(sides[title].normal, dtype=np.float64).tolist())
        kind = "mirror" if sides[title].kind == "mirror" else "plane"
        kinds[title] = (kind, {"normal": normal, "across": "AUTO" if is_torus else "OFF"})
    repeat = (1, 1, 1) if bubble.closed else (3, 1, 1)
    return StartPlan(
        "Wente Cylinder",
        bubble.domain,
        np.column_stack([flat, np.zeros(len(flat))]),
        flat[bubble.domain.faces],
        {title: np.asarray(side.edges) for title, side in sides.items()},
        kinds,
        settings={"size": "RADIUS", "radius": _RADIUS * size, "complete_repeat": repeat} | _QUIET,
        initial=bubble.surface.normals if halved else None,  # where two mirrors meet the long way is not determined
    )


_TITLES = {"left": "Mirror", "right": "Free", "bottom": "Bottom", "top": "Top"}


def torus_plan(size: float, angle: float, columns: int) -> StartPlan:
    """The flat torus of Wente's torus, drawn as a torus of revolution, with its lengths and its map.

    The drawing is conformal where the flat torus is a rectangle; at 120° it is a parallelogram.
    Raises `ConditionError` where there is no bubble, or the torus of that angle never closes.
    """
    bubble = _bubble(angle, columns, 1.0)
    if bubble.cylinders is None:
        raise ConditionError(
            f"A torus with ends {np.degrees(angle):.5g}° apart never closes; choose an angle that is a simple part of "
            "180°, like 60°, 90° or 120°."
        )
    completion = complete(bubble.surface, bubble.sides)
    glued = whole(completion)
    width, length = 2.0 * np.pi, bubble.cylinders / bubble.covers * bubble.height
    shift = np.pi if bubble.covers == 2 else 0.0  # around, once along
    corners = _unrolled(completion, bubble.positions, np.array([[width, 0.0], [shift, length]]))
    at = np.zeros((glued.domain.vertex_count, 2))
    at[glued.domain.faces] = corners @ np.linalg.inv([[width, 0.0], [shift, length]])
    points = _revolution(at, length / width, size)
    return StartPlan(
        "Wente Torus",
        glued.domain,
        points,
        corners * (np.pi * size / max(width, length)),
        {},
        {},
        seams_of(glued.domain, corners),
        {"method": "CRITICAL", "ground": "RIM", "size": "SPAN", "span": size} | _QUIET,
        own_lengths=True,
        initial=glued.normals,
    )


def ring_plan(size: float, slenderness: float, columns: int) -> StartPlan:
    """A hexagon of tubes and the half tubes that leave it, drawn slightly smaller, with its lengths and its map.

    slenderness: from 0, stocky, to 1, thin necks. columns: edges along half a tube, about.
    """
    length = 1.3 + 1.8 * slenderness
    honeycomb = ring(length, max_edge=length / columns)
    domain = honeycomb.domain
    scale = size / float(np.ptp(honeycomb.positions, axis=0).max())
    middle = honeycomb.positions.mean(axis=0)
    sides: dict[str, NDArray[np.integer]] = {}
    kinds: dict[str, tuple[str, Mapping[str, object]]] = {}
    for number, loop in enumerate(domain.boundary_loop_edges, start=1):
        rim = np.unique(domain.edges[loop])
        normal = np.linalg.svd(honeycomb.normals[rim])[2][-1]
        out = normal * np.sign(normal @ (honeycomb.positions[rim].mean(axis=0) - middle))
        name = f"Tube {number}"
        sides[name] = np.asarray(loop)
        kinds[name] = ("mirror", {"normal": tuple(np.round(out, 12).tolist())})
    points = scale * (honeycomb.positions - _INSIDE * honeycomb.normals - middle)
    flat = modules.node(3, length, max_edge=length / columns).shape.positions
    corners = np.concatenate([flat[faces] for faces in _faces(honeycomb.completion)])
    return StartPlan(
        "Honeycomb Ring",
        domain,
        points,
        corners * (0.5 * scale * honeycomb.spacing / length),
        sides,
        kinds,
        settings={"method": "CRITICAL", "size": "RADIUS", "radius": 2.0 * scale, "ground": "RIM"}
        | {"complete_repeat": (3, 3, 1)}
        | _QUIET,
        own_lengths=True,
        initial=honeycomb.normals,
    )


def _bubble(angle: float, columns: int, height: float) -> Bubble:
    """Closed if the height is 1, else at that part of the closing height. The angle has single precision."""
    part = Fraction(angle / np.pi).limit_denominator(_MOST_PARTS)
    angle = float(part) * np.pi if abs(float(part) * np.pi - angle) < _SINGLE else angle
    if height == 1.0:
        bubble = wente(angle, columns, halved=cover_count(angle) == 2)
    else:
        check_angle(angle)
        bubble = wente(angle, columns, height=height * discrete_height(angle, columns), closed=False)
    if bubble.collapsed or (height == 1.0 and not bubble.closed):
        raise ConditionError(bubble.message)
    return bubble


def _faces(completion: Completion) -> list[NDArray[np.integer]]:
    """The faces of each copy of a completion, as vertices of the piece, oriented as in the mesh of all copies."""
    faces = completion.surface.faces
    return [faces[:, ::-1] if copy.flipped else faces for copy in completion.copies]


def _unrolled(completion: Completion, flat: Array, lattice: Array) -> Array:
    """(K F, 3, 2) corners of the copies of a rectangle, flat (V, 2), unrolled: across a side lies its mirror image.

    Copies lie within the parallelogram of the rows of `lattice` (2, 2), up to half of one.
    """
    low, high = flat.min(axis=0), flat.max(axis=0)
    mirrors = {"left": (0, low[0]), "right": (0, high[0]), "bottom": (1, low[1]), "top": (1, high[1])}
    signs, shifts = {0: np.ones(2)}, {0: np.zeros(2)}
    waiting = [0]
    for k in waiting:
        for seam, other in zip(completion.seams, completion.neighbours[k].tolist(), strict=True):
            if other < 0 or other in signs:
                continue
            axis, at = mirrors[seam.name]
            turned, moved = signs[k].copy(), shifts[k].copy()
            moved[axis] += 2.0 * at * turned[axis]
            turned[axis] = -turned[axis]
            signs[other], shifts[other] = turned, moved
            waiting.append(other)
    corners = []
    for k, faces in enumerate(_faces(completion)):
        placed = signs[k] * flat + shifts[k]
        cell = np.floor(placed.mean(axis=0) @ np.linalg.inv(lattice))
        corners.append((placed - cell @ lattice)[faces])
    return np.concatenate(corners)


def _revolution(at: Array, ratio: float, size: float) -> Array:
    """Points (V, 3) of the torus of revolution, `size` wide, that is conformal to the flat one of this ratio of length
    to width, at (V, 2), parts of the width and of the length.

    Its meridians are circles of radius r about one of radius R with √(R² - r²) = ratio · r, the ratio being at least 1;
    on them tan(α/2) = √((R + r)/(R - r)) tan(v/2) for a conformal angle v.
    """
    around, along = (at[:, 1], at[:, 0]) if ratio >= 1.0 else (at[:, 0], at[:, 1])
    ratio = max(ratio, 1.0 / ratio)
    r = 0.5 * size / (1.0 + np.sqrt(1.0 + ratio**2))
    centre = r * np.sqrt(1.0 + ratio**2)
    v = np.pi * (2.0 * (along % 1.0) - 1.0)
    alpha = 2.0 * np.arctan(np.sqrt((centre + r) / (centre - r)) * np.tan(0.5 * v))
    theta, reach = 2.0 * np.pi * around, centre + r * np.cos(alpha)
    return np.column_stack([reach * np.cos(theta), reach * np.sin(theta), r * np.sin(alpha)])
