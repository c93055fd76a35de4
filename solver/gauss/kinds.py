"""The kinds of boundary condition by name, as user interfaces and job files offer them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..domain.shape import DomainLike
from ..errors import ConditionError, check_choice
from ..limits import NUMBERS, Range
from .boundary_data import Conditions
from .held import TURNS, fixed, free, mirror
from .lines import lean, line
from .rim_normals import binormal, gauss_map, placed, twisted


@dataclass(frozen=True)
class Parameter:
    """A number or vector that a kind of condition takes, as a user interface shows it."""

    name: str
    label: str
    description: str
    default: float | tuple[float, ...]
    unit: str = ""
    within: Range = NUMBERS


@dataclass(frozen=True)
class Kind:
    """A kind of boundary condition, as a user interface offers it.

    leans: whether `make` takes `against` and `up`; curve: whether it takes a closed `curve` (m, 3).
    """

    label: str
    description: str
    parameters: tuple[Parameter, ...]
    make: Callable[..., Conditions] = field(repr=False)
    leans: bool = False
    curve: bool = False


_HALF_WAY = 0.25 * np.pi

KINDS: dict[str, Kind] = {
    "line": Kind(
        "On the line",
        "The rim lies on the drawn edges, with their heights, or on a chosen curve",
        (),
        lambda domain, positions, edges, curve=None: line(domain, edges, curve),
        curve=True,
    ),
    "lean": Kind(
        "Leans over its line",
        "The rim stays over the drawn edges, rises and falls there, and the shell meets the upright at an angle",
        (
            Parameter(
                "angle",
                "Angle",
                "Between the shell and the upright over the line; 0° stands upright, 90° lies flat",
                _HALF_WAY,
                "radians",
            ),
        ),
        lambda domain, positions, edges, angle=_HALF_WAY: lean(domain, edges, angle),
    ),
    "binormal": Kind(
        "Leans, rim free",
        "The rim leans by an angle: 0° stands upright, 90° lies flat",
        (Parameter("tilt", "Lean", "The rim leans by this angle; 0° stands upright, 90° lies flat", 0.0, "radians"),),
        lambda domain, positions, edges, tilt=0.0, **how: binormal(domain, positions, edges, tilt, **how),
        leans=True,
    ),
    "plane": Kind(
        "Constant plane",
        "The shell touches one plane along these edges",
        (Parameter("normal", "Normal", "Normal of the plane, pointing out of the shell", (0.0, 0.0, 1.0)),),
        lambda domain, positions, edges, normal=(0.0, 0.0, 1.0): fixed(domain, edges, normal),
    ),
    "twisted": Kind(
        "Twisted",
        "The tangent plane turns about the rim, along the rim",
        (Parameter("m", "Turns", "Full turns of the tangent plane on the way around the loop", 1.0, within=TURNS),),
        lambda domain, positions, edges, m=1.0: twisted(domain, positions, edges, m),
    ),
    "gauss_map": Kind(
        "As drawn",
        "The shell keeps the tangent planes of the drawn mesh along these edges",
        (),
        lambda domain, positions, edges: gauss_map(domain, positions, edges),
    ),
    "mirror": Kind(
        "Mirror",
        "The shell meets a plane at a right angle and continues as its own reflection",
        (
            Parameter("normal", "Normal", "Normal of the plane, pointing out of the shell", (0.0, 0.0, 1.0)),
            Parameter("winding", "Extra Turns", "Extra full turns of the tangent plane along a mirror", 0.0, "", TURNS),
        ),
        lambda domain, positions, edges, normal=(0.0, 0.0, 1.0), winding=0: mirror(domain, edges, normal, winding),
    ),
    "free": Kind(
        "Free",
        "Nothing is prescribed; the rim finds its own tangent planes",
        (),
        lambda domain, positions, edges: free(domain, edges),
    ),
}


def build(
    kind: str,
    domain: DomainLike,
    positions: ArrayLike | None = None,
    edges: ArrayLike | None = None,
    *,
    against: str = "horizon",
    up: ArrayLike | None = None,
    **parameters: object,
) -> Conditions:
    """The condition named `kind` in `KINDS`, with that kind's parameters (angles in radians).

    against, up: what a lean is measured against (see `binormal`); kinds that do not lean pass over them.
    """
    check_choice(kind, KINDS, "boundary condition")
    known = {parameter.name for parameter in KINDS[kind].parameters} | ({"curve"} if KINDS[kind].curve else set())
    unknown = sorted(set(parameters) - known)
    if unknown:
        raise ConditionError(
            f"The boundary condition {kind!r} has no parameter {', '.join(unknown)}; "
            f"it has {', '.join(sorted(known)) or 'none'}."
        )
    _, positions, edges, _ = placed(domain, positions, edges)
    how = {"against": against, "up": up} if KINDS[kind].leans else {}
    return KINDS[kind].make(domain, positions, edges, **parameters | how)
