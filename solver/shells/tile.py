"""The shell over a plan with holes, repeated by its periods: a copy continues it across every cut."""

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
    """The copies of an open shell at k₁ p₁ + k₂ p₂ + …, 0 ≤ kᵢ < repeatᵢ, with the periods pᵢ of `hole_gaps`.

    Further holes than `repeat` has numbers count once. Counts and transforms are cheap; the welded mesh is made on
    first use. Raises `JobError` on a shell that closes and on too many copies.
    """
    surface = shell.surface
    if not surface.is_open:
        raise JobError("The shell closes around the holes of its plan, so it has no periods to repeat by.")
    vectors = period_vectors(surface)
    times = tile_times(len(vectors), repeat)
    moving = np.linalg.norm(vectors, axis=1) > 0.0
    # around=[()] is the shell alone; the translations generate the copies
    chosen = [n for n, moves in zip(times, moving.tolist(), strict=True) if moves]
    completion = complete(surface, around=[()], translations=vectors[moving], repeat=chosen, sheet=sheet)
    return Completed(shell, completion)


def tile_times(holes: int, repeat: Sequence[int]) -> list[int]:
    """The number of copies along the period of each hole. Raises `JobError` on too many copies."""
    times = [*repeat, *[1] * holes][:holes]
    if min(times, default=1) < 1 or math.prod(times) > MOST_COPIES:
        raise JobError(
            f"That makes {math.prod(times)} copies; repeat the shell at least once along each period, and in all at "
            f"most {MOST_COPIES} times."
        )
    return times
