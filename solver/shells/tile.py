"""The shell over a plan with holes, repeated by its periods: across every cut goes on a copy of itself."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..errors import JobError
from ..symmetry.complete import MOST_COPIES, complete
from .complete import Completed
from .gaps import period_vectors
from .shell import Shell


def tile_plan(shell: Shell, repeat: Sequence[int], sheet: str = "f+") -> Completed:
    """The copies k₁ p₁ + k₂ p₂ + …, 0 ≤ kᵢ < repeatᵢ, of a placed shell that is cut open, pᵢ as in `hole_gaps`.

    Holes beyond those that `repeat` names count once. Counts and transforms are cheap; the welded mesh is made where it
    is asked for. Raises `JobError` on a shell that closes and on too many copies.
    """
    surface = shell.surface
    if not surface.is_open:
        raise JobError("The shell closes around the holes of its plan: it has no periods to be repeated by.")
    vectors = period_vectors(surface)
    times = tile_times(len(vectors), repeat)
    moving = np.linalg.norm(vectors, axis=1) > 0.0
    # around nothing is the shell alone; what generates the copies are the translations
    chosen = [n for n, moves in zip(times, moving.tolist(), strict=True) if moves]
    found = complete(surface, around=[()], translations=vectors[moving], repeat=chosen, sheet=sheet)
    return Completed(shell, found)


def tile_times(holes: int, repeat: Sequence[int]) -> list[int]:
    """How often along the period of each hole. Raises `JobError` where that makes too many copies."""
    times = [*repeat, *[1] * holes][:holes]
    if min(times, default=1) < 1 or math.prod(times) > MOST_COPIES:
        raise JobError(
            f"There would be {math.prod(times)} copies; repeat the shell at least once along each period, and in all "
            f"at most {MOST_COPIES} times."
        )
    return times
