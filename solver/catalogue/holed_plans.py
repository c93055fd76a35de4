"""Plans with a hole to start from: a ring around a court, and a tube as an endless strip; the type of start plans."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..errors import CmcError
from . import shapes

Array = NDArray[np.float64]

# Least distance between court and rim, as a part of the radius.
_NARROWEST = 0.05


@dataclass(frozen=True, eq=False)
class StartPlan:
    """A plan to start from, as arrays.

    points (V, 3): of a domain. uvs: (F, 3, 2) of its corners; seams: (n,) edges where these jump. sides: name → edges,
    with the kind of condition on each and its parameters. settings: of `Object.cmc`. remesh: whether Mesh Plan refines
    it in place, from its own rim. own_lengths: whether the domain's edge lengths differ from those of the points.
    initial: (V, 3) the map to start from.
    """

    name: str
    domain: Domain
    points: Array
    uvs: Array
    sides: dict[str, NDArray[np.integer]]
    kinds: Mapping[str, tuple[str, Mapping[str, object]]]
    seams: NDArray[np.integer] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    settings: Mapping[str, object] = field(default_factory=dict)
    remesh: bool = False
    own_lengths: bool = False
    initial: Array | None = None

    def __repr__(self) -> str:
        return f"StartPlan({self.name!r}, {self.domain!r}, sides: {', '.join(self.sides) or 'none'})"


def annulus(size: float, hole: float, offset: float, columns: int) -> StartPlan:
    """A round plan with a round court, off the middle by `offset`; hole and offset are parts of the outer radius.

    columns: edges along the outer rim. Raises `CmcError` if the court is too near to the rim.
    """
    if hole + offset > 1.0 - _NARROWEST:
        raise CmcError("The hole is too near to the outer rim; make it smaller, or move it towards the middle.")
    edge = 2.0 * np.pi / columns
    shape = shapes.annulus(hole, 1.0, max(18, round(np.pi * (1.0 - hole**2) / np.sqrt(0.75) / edge**2)))
    flat = shape.positions.copy()
    flat[:, 0] += offset * (1.0 - np.linalg.norm(flat, axis=1)) / (1.0 - hole)
    flat *= 0.5 * size
    points = np.column_stack([flat, np.zeros(len(flat))])
    sides = {"Outer": shape.sides["outer"], "Inner": shape.sides["inner"]}
    tilts = {"Outer": np.radians(50.0), "Inner": np.radians(35.0)}
    kinds = {name: ("binormal", {"tilt": float(tilt)}) for name, tilt in tilts.items()}
    return StartPlan("Annulus", shape.domain, points, flat[shape.domain.faces], sides, kinds)


def cylinder(size: float, height: float, columns: int) -> StartPlan:
    """A tube, `size` wide and `height` diameters high, whose normals wind once along both ends (paper, Fig. 12)."""
    around = np.pi * size
    shape = shapes.cylinder(around, height * size, columns)
    domain, (x, y) = shape.domain, shape.positions.T
    turn = 2.0 * x / size
    points = np.column_stack([0.5 * size * np.cos(turn), 0.5 * size * np.sin(turn), y])
    uvs = shape.positions[domain.faces].copy()
    across = np.ptp(uvs[:, :, 0], axis=1) > 0.5 * around
    uvs[across, :, 0] += np.where(uvs[across, :, 0] < 0.5 * around, around, 0.0)
    sides = {"Bottom": shape.sides["bottom"], "Top": shape.sides["top"]}
    kinds = {name: ("twisted", {"m": 1.0}) for name in sides}
    settings = {"size": "SPAN", "span": 2.0 * size}  # its ends are no outline to match
    settings["keep_closed"] = False  # it is a strip along its axis
    return StartPlan("Cylinder Strip", domain, points, uvs, sides, kinds, seams_of(domain, uvs), settings)


def seams_of(domain: Domain, uvs: Array) -> NDArray[np.integer]:
    """Edges whose two faces have them at different places in the texture."""
    inside = domain.interior_edges
    left, right = domain.half_edges[inside].T
    middles = 0.5 * (np.roll(uvs, -1, axis=1) + np.roll(uvs, 1, axis=1)).reshape(-1, 2)  # opposite each corner
    apart = np.linalg.norm(middles[left] - middles[right], axis=1)
    return inside[apart > 1e-6 * np.ptp(uvs[..., 0])]
