"""The kinds of boundary condition by name, as user interfaces and job files offer them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from numpy.typing import ArrayLike

from ..domain.shape import DomainLike
from ..errors import ConditionError
from .boundary_data import Conditions
from .held import fixed, free, mirror
from .rim_normals import binormal, gauss_map, placed, twisted


@dataclass(frozen=True)
class Parameter:
    """A number or vector that a kind of condition takes, as a user interface shows it."""

    name: str
    label: str
    description: str
    default: float | tuple[float, ...]
    unit: str = ""


@dataclass(frozen=True)
class Kind:
    """A kind of boundary condition, as a user interface offers it. leans: whether `make` takes `against` and `up`."""

    label: str
    description: str
    parameters: tuple[Parameter, ...]
    make: Callable[..., Conditions] = field(repr=False)
    leans: bool = False


KINDS: dict[str, Kind] = {
    "binormal": Kind(
        "Outward, leaning",
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
        (Parameter("m", "Turns", "Full turns of the tangent plane on the way around the loop", 1.0),),
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
            Parameter("winding", "Extra Turns", "Extra full turns of the tangent plane along the mirror", 0.0),
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
    if not isinstance(kind, str) or kind not in KINDS:
        raise ConditionError(f"There is no boundary condition {kind!r}; choose one of {', '.join(KINDS)}.")
    known = {parameter.name for parameter in KINDS[kind].parameters}
    unknown = sorted(set(parameters) - known)
    if unknown:
        raise ConditionError(
            f"The boundary condition {kind!r} has no parameter {', '.join(unknown)}; "
            f"it has {', '.join(sorted(known)) or 'none'}."
        )
    _, positions, edges, _ = placed(domain, positions, edges)
    how = {"against": against, "up": up} if KINDS[kind].leans else {}
    return KINDS[kind].make(domain, positions, edges, **parameters | how)
