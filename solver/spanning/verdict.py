"""How a span ended: its status, and the sentence that says what to do about it."""

from __future__ import annotations

from enum import Enum

import numpy as np
from numpy.typing import NDArray

from ..measure.arrays import face_areas_in_space
from .descent import Descent

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# D / area - 1 is the mean of ½ (Q + 1/Q) - 1 with the distortion Q; 0 where the map is conformal. Surfaces reach 1e-3
# on coarse meshes.
CONFORMAL = 5e-3
# The same on a plan with holes: there a neck that closes stays open on a coarse mesh, at this price.
_CONFORMAL_RING = 4e-3
# Least and greatest stretch of a gap between neighbours on a line against the plan.
_CROWDED = 0.1
_SPREAD = 8.0


class SpanStatus(Enum):
    """How a span ended; `sentence` says it to a person."""

    CONVERGED = "converged"
    NO_SURFACE = "no surface"
    NOT_CONFORMAL = "not conformal"
    UNLIKE = "unlike"
    STALLED = "stalled"
    ITERATION_LIMIT = "iteration limit"
    CANCELLED = "cancelled"

    @property
    def sentence(self) -> str:
        """What happened, and the way out."""
        return _SENTENCES[self]


_SENTENCES = {
    SpanStatus.CONVERGED: "The surface spans its lines.",
    SpanStatus.NO_SURFACE: "No surface of this size spans these lines.",
    SpanStatus.NOT_CONFORMAL: "What was found is not the surface: the map to it distorts. Refine the mesh, round "
    "narrow corners, or choose a flatter shell.",
    SpanStatus.UNLIKE: "The vertices of the plan crowd on one part of the lines: the plan is too unlike them. Mesh a "
    "new plan from the lines seen from above.",
    SpanStatus.STALLED: "No step comes nearer to a surface; refine or improve the mesh.",
    SpanStatus.ITERATION_LIMIT: "The limit of steps was reached before the tolerance; several surfaces may be near, or "
    "none. Choose a flatter shell, or allow more steps.",
    SpanStatus.CANCELLED: "The search was cancelled; this is the last surface reached.",
}
_CROWDED_RIM = "The vertices of the plan crowd on one part of its boundary. Choose a flatter shell, or refine the mesh."
NECK = "No surface joins these lines: the neck between them closes. Bring the lines nearer to each other."

_ENDS = {
    "converged": SpanStatus.CONVERGED,
    "stalled": SpanStatus.STALLED,
    "iteration limit": SpanStatus.ITERATION_LIMIT,
    "cancelled": SpanStatus.CANCELLED,
    "runaway": SpanStatus.NO_SURFACE,
    "neck": SpanStatus.NO_SURFACE,
    "crowded": SpanStatus.UNLIKE,
}


def judged(descent: Descent, is_drawn: bool) -> tuple[SpanStatus, str]:
    """The status of a search that ended, and its sentence. is_drawn: whether the lines are the plan's own boundary."""
    status = _ENDS[descent.end]
    sentence = NECK if descent.end == "neck" else status.sentence
    if status is SpanStatus.CONVERGED:
        status, sentence = _if_conformal(descent)
    if is_drawn and status is SpanStatus.UNLIKE:
        sentence = _CROWDED_RIM
    if not is_drawn and status not in (SpanStatus.CONVERGED, SpanStatus.CANCELLED) and _crowding(descent):
        status, sentence = SpanStatus.UNLIKE, SpanStatus.UNLIKE.sentence
    return status, sentence


def _if_conformal(descent: Descent) -> tuple[SpanStatus, str]:
    state, problem = descent.state, descent.problem
    ring = len(problem.loops) > 1
    if ring and not problem.moving_holes:  # what that costs is told with the checks
        return SpanStatus.CONVERGED, SpanStatus.CONVERGED.sentence
    off = distortion(state.D, state.f, problem.domain.faces)
    if ring and off > _CONFORMAL_RING:
        return SpanStatus.NO_SURFACE, NECK
    status = SpanStatus.NOT_CONFORMAL if off > CONFORMAL else SpanStatus.CONVERGED
    return status, status.sentence


def distortion(energy: float, f: Array, faces: Int) -> float:
    """D / area - 1, the mean over the surface f (V, 3) of ½ (Q + 1/Q) - 1; energy: D."""
    return energy / float(face_areas_in_space(f, faces).sum()) - 1.0


def _crowding(descent: Descent) -> bool:
    """Whether gaps along a curve have changed beyond what the mesh can resolve."""
    least, most = descent.problem.rim.stretches(descent.state.x)
    return least < _CROWDED or most > _SPREAD


def largest_sentence(wanted: float, largest: float) -> str:
    """What to say where H is too large."""
    return (
        f"No surface of mean curvature {wanted:.4g} spans these lines: the largest is about {largest:.4g}, shown here. "
        "Choose a smaller one, or choose by height or volume."
    )


