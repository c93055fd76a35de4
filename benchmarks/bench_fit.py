"""The time of a fit to an outline, as a multiple of one cold solve of the same plan in the same run.

Lines alone are spanned; bounds that the span does not keep start a search from it.

`make bench` prints the ratios; rounds are interleaved and the median is quoted, as in bench_solve.py.
"""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.bench_solve import ratios
from solver import CmcSolver, Domain, conditions, fit_outline, shapes

VERTICES = 5_000
# outline, radius of its corners, area
OUTLINES = {
    "square": ([[0, 0], [2, 0], [2, 2], [0, 2]], 0.2, 4.0),
    "rectangle 3 : 1": ([[0, 0], [3, 0], [3, 1], [0, 1]], 0.3, 3.0),
    "L": ([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], 0.3, 3.0),
}


@pytest.mark.parametrize("name", OUTLINES)
def test_fit_to_an_outline(name, capsys):
    outline, radius, area = OUTLINES[name]
    edge = np.sqrt(area / VERTICES * 2 / np.sqrt(3))
    shape = shapes.polygon(outline, max_edge=edge, corner_radius=radius)
    points, faces = shape.positions, shape.domain.faces

    def cold() -> None:
        domain = Domain.from_positions(points, faces)
        CmcSolver(domain).solve(conditions.binormal(domain, points, domain.boundary_edges, 0.6))

    def fit(rise: float) -> None:
        fit_outline(Domain.from_positions(points, faces), points, rise=rise)

    solver = CmcSolver(shape.domain)
    before = fit_outline(shape.domain, points, rise=0.25, solver=solver)
    works = {f"rise {rise:g}, from positions": lambda rise=rise: fit(rise) for rise in (0.05, 0.25, 0.45)}
    on = {"initial": before, "solver": solver}
    bounds = {"rise": 0.25, "tilt": np.radians([60, 90]), "free_heights": True}
    works["rise 0.25, tilts from 60°"] = lambda: fit_outline(Domain.from_positions(points, faces), points, **bounds)
    works["rise 0.25 to 0.3, from the last fit"] = lambda: fit_outline(shape.domain, points, rise=0.3, **on)
    unit, measured = ratios(works, cold)
    with capsys.disabled():
        print(f"\n{name}, {len(points)} vertices; one cold solve {unit:.3f} s")
        for label, ratio in measured.items():
            print(f"  {label:<34s} {ratio:5.1f} x")
