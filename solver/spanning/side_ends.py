"""Ends of leaning sides: where the rim would slide past them, it stands upright there.

A rim vertex of a leaning side has 0 <= s <= length along its line. Next to a line a steep side does not keep to that:
the angle would have to change at once, and the rim slides back below the line. With the constraint it falls, or rises,
upright at the end of its side and then goes on. Vertices that passed an end are made to stand there, half of them at a
time; the innermost is let go again where the energy pulls it inwards,

    g = <φ, γ'> + ½ cos t (z_before - z_behind) < 0 at the start, > 0 at the end.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .descent import Descent
from .linearised import Linearised
from .rim import OverCurve

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# A pull below this part of the force on the vertex is none.
_NO_PULL = 1e-3


def upright_vertices(descent: Descent) -> tuple[int, ...]:
    """The rim vertices to be stood at the ends of their sides, given those that stand in the last surface."""
    problem, state = descent.problem, descent.state
    stands: list[int] = []
    here = None
    for track, part in zip(problem.rim.tracks, problem.rim.parts(state.x), strict=True):
        if not isinstance(track, OverCurve) or track.ends is None or not len(part):
            continue
        start, end = track.ends
        now = {True: start[1:], False: end[:-1][::-1]}  # from the end of the side inwards
        for first, chain in now.items():
            vertices = track.vertices if first else track.vertices[::-1]
            s = part[:, 0] if first else track.curve.length - part[::-1, 0]
            past = int(np.sum(s[: len(s) // 2] <= 0.0))
            if past:
                stands += [*chain, *vertices[: max(1, past // 2)]]
            elif len(chain):
                here = here or Linearised(problem, state, descent.mean_curvature)
                stands += list(chain[:-1] if _pulled(here, track, first, chain, vertices) else chain)
    return tuple(sorted(int(vertex) for vertex in stands))


def _pulled(here: Linearised, track: OverCurve, first: bool, chain: Int, vertices: Int) -> bool:
    """Whether the energy falls as the innermost vertex of a chain moves inwards along the line."""
    joint = track.ends[0][0] if first else track.ends[1][-1]  # pyright: ignore[reportOptionalSubscript]
    outer = chain[-2] if len(chain) > 1 else joint
    force = here.force[chain[-1]]
    tangent = track.curve.at(np.array([0.0 if first else track.curve.length]))[1][0]
    z = here.rim.points[:, 2]
    before, behind = (outer, vertices[0]) if first else (vertices[0], outer)
    pull = float(force @ tangent) + 0.5 * np.cos(track.angle) * float(z[before] - z[behind])
    inwards = -pull if first else pull
    return inwards > _NO_PULL * float(np.linalg.norm(force))
