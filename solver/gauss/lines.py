"""Conditions on the rim itself: it lies on a line, or stays over one and leans there. Such surfaces are spanned."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..domain.shape import DomainLike, as_domain
from ..errors import ConditionError, plural
from ..limits import NUMBERS, check_number
from ..linalg import as_numbers
from .boundary_data import Conditions
from .frames import boundary_edges

# Angles at which a surface may meet the wall over a line, radians.
_STEEPEST = np.radians(8.0)
_FLATTEST = np.radians(160.0)


def line(domain: DomainLike, edges: ArrayLike, curve: ArrayLike | None = None) -> Conditions:
    """The rim lies on these boundary edges as they are drawn, with their heights, or on a closed curve (m, 3).

    A curve takes the place of whole boundary loops: starting anywhere, either way round, see `span_outline`. The
    normals along the rim are free. Where lines meet a mirror their common vertex stays where it was drawn. Raises
    `ConditionError` on edges inside, and on a curve for a part of a loop.
    """
    chosen = boundary_edges(domain, edges)
    if curve is None:
        return Conditions(lines=chosen)
    points = as_numbers(curve, "The points of the curve", ConditionError)
    if points.ndim != 2 or points.shape[1] not in (2, 3) or len(points) < 3:
        raise ConditionError(f"A curve is three or more points (m, 3) in order, not an array {points.shape}.")
    for loop in as_domain(domain).boundary_loop_edges:
        missing = np.setdiff1d(loop, chosen)
        if 0 < missing.size < len(loop):
            raise ConditionError(
                f"A curve takes the place of a whole boundary loop, but {plural('edge', missing)} of this one are not "
                "on it; choose the whole loop, or leave the curve out.",
                edges=missing,
            )
    return Conditions(lines=chosen, curves=((chosen, points),))


def lean(domain: DomainLike, edges: ArrayLike, angle: float) -> Conditions:
    """The rim stays over these boundary edges, rises and falls there, and the surface meets the upright wall over them.

    angle: between the surface and the wall, radians: N · ν = cos(angle), ν the wall's normal out of the plan; 0 is
    upright, ½ π at right angles, as across a mirror: the natural condition of D(f) - 2H V(f) with the wetted part of
    the wall (Finn 1986). Raises `ConditionError` on edges inside, and on angles under 8° and over 160°.
    """
    chosen = boundary_edges(domain, edges)
    return Conditions(leans=chosen, lean_angles=np.full(len(chosen), checked_lean(angle)))


def checked_lean(angle: float) -> float:
    """The angle; raises `ConditionError` where it is no number, or too steep or too flat for a wall."""
    check_number(angle, "lean", NUMBERS)
    if not _STEEPEST <= angle <= _FLATTEST:
        if angle > np.pi:
            raise ConditionError(f"A lean of {angle:g} radians is more than a half turn; for degrees use np.radians.")
        raise ConditionError(
            f"A lean of {np.degrees(angle):.3g}° is out of range: a surface meets a wall at "
            f"{np.degrees(_STEEPEST):.0f}° to {np.degrees(_FLATTEST):.0f}°. Hold the normals instead."
        )
    return float(angle)
