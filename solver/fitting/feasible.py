"""Given normals beside lines that no surface can have, found before the search.

Along a side the rim is normal to N. Where N has a large part along the side, the rim turns away from the side and does
not come back to its ends on lines; where N points down, or into the plan, the surface folds under or over itself
there. Measured on a hall of 18 × 12 m, rise 35 %, ends of the side on lines: a normal out of the direction across the
side by 37° misses the lines by 0.6 % of the span, by 53° by 1.3 %, by 64° by 13 %; 20° below the horizon by 5 %; 10°
into the plan by 28 %.
"""

from __future__ import annotations

import numpy as np

from ..errors import ConditionError, plural
from .sides import HELD, LEAN, LINE, Sides, walls

# The farthest that given normals may turn along their side, under the horizon and into the plan, degrees.
_ALONG, _DOWN, _INTO = 50.0, 15.0, 5.0


def check_held(sides: Sides, sign: float) -> None:
    """Raise `ConditionError` on a side with given normals, its ends on lines, that is farther off than surfaces go.

    By the median along the side outside its blend zones, so that normals may run out of these bounds on a part of it.
    sign: -1 for f-, whose normals are -N. A closed loop has no ends, and is not refused.
    """
    stays = np.concatenate([[-1], *(side.vertices for side in sides.of_kind(LINE, LEAN))])
    for side in sides.of_kind(HELD):
        if side.closed or not np.isin(side.vertices[[0, -1]], stays).all():
            continue
        outward = walls(sides.drawn, side)
        full = (side.parts == 1.0) & outward.any(axis=1)
        if not full.any():
            continue
        N, out = sign * side.normals[full], outward[full]
        along = np.column_stack([-out[:, 1], out[:, 0], np.zeros(len(out))])
        parts = np.array([np.median(np.sum(N * each, axis=1)) for each in (along, -out)])
        turned, into = np.degrees(np.arcsin(np.clip(parts, -1.0, 1.0)))
        down = -float(np.degrees(np.arcsin(np.clip(np.median(N[:, 2]), -1.0, 1.0))))
        where = f"The normals given at {plural('vertex', side.vertices[[0, -1]]).replace(', ', ' to ')}"
        vertices = side.vertices.tolist()
        if down > _DOWN:
            raise ConditionError(
                f"{where} point down by {down:.0f}°, so beside lines the shell folds under itself. Turn them up.",
                vertices=vertices,
            )
        if abs(turned) > _ALONG:
            raise ConditionError(
                f"{where} turn by {abs(turned):.0f}° along their side, so the rim leaves it and cannot reach the lines "
                "at its ends. Turn them across the side, or take the lines off its neighbours.",
                vertices=vertices,
            )
        if into > _INTO:
            raise ConditionError(
                f"{where} lean by {into:.0f}° into the plan, so the shell rises towards that side and cannot reach "
                "the lines at its ends. Turn them outwards, or lean the side over its line, which may be steeper.",
                vertices=vertices,
            )
