"""What makes no sense in a design is refused with a sentence, whatever it is."""

import numpy as np
import pytest

from solver import CmcError, Side, close_periods, complete, conditions, fit_gauss_map, fit_outline, shapes, solve_cmc
from solver.closing.holes import hole
from solver.closing.moduli import tube

DISC = shapes.disc(80)
RING = shapes.annulus(0.4, 1.0, 200)
RIM = conditions.binormal(RING.domain, RING.positions, RING.domain.boundary_edges, 0.4)
BALL = shapes.sphere(60)
BOWL = np.column_stack([DISC.positions, 0.2 * DISC.positions[:, 0] ** 2])


def outline(**options):
    return lambda: fit_outline(DISC.domain, DISC.positions, **options)


def piece():
    held = conditions.binormal(DISC.domain, DISC.positions, DISC.domain.boundary_edges, 0.4)
    return complete(solve_cmc(DISC.domain, held), Side("rim", DISC.domain.boundary_edges))


def moved(**options):
    moduli = hole(RING.domain, RING.positions, 1)
    return lambda: close_periods(RING.domain, RIM, by="both", moduli=moduli, **options)


WRONG = {
    "no curve": (outline(curve=[]), "three or more points"),
    "ragged curve": (outline(curve=[[0, 0], [1, 0], [1]]), "regular array"),
    "ragged curves": (outline(curve=[[[0, 0], [1, 0], [1]]]), "regular array"),
    "height in words": (outline(height="high"), "height must be a positive number"),
    "hardly a height": (outline(height=1e-20), r"height 1e-20 does not .* measures 2\.82; .* between 2\.82e-06"),
    "a high rise": (outline(rise=1e9), r"height 9\.95e\+08 does not go with .* and 2\.82e\+06"),
    "hardly a volume": (outline(volume=1e-20), "volume 1e-20 does not go with"),
    "hardly bent": (outline(mean_curvature=1e-9), "mean curvature 1e-09 does not go with"),
    "a curve in one place": (outline(curve=np.ones((4, 3))), "All points of the curve are in one place"),
    "three bounds": (outline(tilt=(0.1, 0.2, 0.3)), "two angles"),
    "a bound that is no number": (outline(tilt=(np.nan, 0.3)), "least below the most"),
    "anchors in words": (outline(anchors=(["a"], [[0, 0, 0]], [1])), "must be numbers"),
    "half a vertex": (outline(anchors=([1.5], [[0, 0, 0]], [1])), "no vertex 1.5"),
    "anchors that push": (outline(anchors=([1], [[0, 0, 0]], [-1])), "weights positive"),
    "rough on purpose": (outline(smooth=-1.0), "smooth boundary normals must be a number from 0 to 1e"),
    "no evaluations": (outline(max_evaluations=0), "evaluations must be a whole number from 1 to 100,000"),
    "regularisation in words": (lambda: fit_gauss_map(DISC.domain, BOWL, "some"), "regularisation must be"),
    "a closed surface": (lambda: fit_gauss_map(BALL.domain, BALL.positions), "no rim whose normals"),
    "moduli for nothing": (moved(weight=0.0), "weight of moduli must be a positive number"),
    "tolerance in words": (moved(tolerance="small"), "tolerance must be"),
    "steps back": (moved(max_steps=-1), "steps must be a whole number from 0"),
    "one side": (piece, "sides must be a list"),
    "a hole by name": (lambda: hole(RING.domain, RING.positions, "x"), "loop must be a whole number"),
    "flat corners": (lambda: tube(RING.domain, np.zeros((3, 2)), [0], [0, 1]), "Corners must have shape"),
}


@pytest.mark.parametrize("what", WRONG)
def test_it_is_refused_with_a_sentence(what):
    work, message = WRONG[what]
    with pytest.raises(CmcError, match=message):
        work()
