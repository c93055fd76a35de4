"""Which of several surfaces of one mean curvature through the same lines was found.

The surfaces of one rim, ordered by their volume V, have H = H(V). With the tangent t along them, K t = 2 H' V' and
<V', t> = 1, the Hessian K of D - 2H V has <t, K t> = 2 H'. Where H' > 0 the surface is a minimum, the flatter of two;
past the largest H it is the fuller one, K has one negative direction, and only a given volume holds it. Small and large
surfaces of one H exist on every closed line (Brezis and Coron 1984; Struwe 1985).
"""

from __future__ import annotations

from enum import Enum

import numpy as np

from .descent import keeper, tangent_at
from .knobs import HeldVolume
from .linearised import Linearised

# A surface of less mean curvature, in units of one over its size, has no flatter one beside it.
_MINIMAL = 1e-3


class Branch(Enum):
    """flatter: H grows with the volume, so the surface is stable. fuller: H falls. saddle: it is unstable though its
    volume is held, or at H = 0."""

    FLATTER = "flatter"
    FULLER = "fuller"
    SADDLE = "saddle"


def branch(here: Linearised) -> Branch:
    """The branch of a critical surface, linearised with H as the multiplier; some 20 back-solves."""
    ahead, bent = tangent_at(here, keeper(here, HeldVolume()), None)
    falls = ahead.rest(here.along) < 0.0
    if bent or (falls and abs(here.H) * float(np.ptp(here.state.f, axis=0).max()) < _MINIMAL):
        return Branch.SADDLE
    return Branch.FULLER if falls else Branch.FLATTER
