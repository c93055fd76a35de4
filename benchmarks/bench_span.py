"""The time of a surface through a line, as a multiple of one cold solve of the same plan in the same run.

`make bench` prints the ratios; rounds are interleaved and the median is quoted, as in bench_solve.py.
"""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.bench_fit import OUTLINES, VERTICES
from benchmarks.bench_solve import ratios
from solver import CmcSolver, Domain, conditions, shapes, span_outline

# By the number that chooses the surface; volumes in those of half a sphere over a circle of the plan's area.
CHOICES = [("mean_curvature", 0.0), ("mean_curvature", 0.6), ("volume", 0.5), ("volume", 1.5), ("rise", 0.45)]


@pytest.mark.parametrize("corners", ["round", "sharp"])
@pytest.mark.parametrize("name", OUTLINES)
def test_a_surface_through_a_line(name, corners, capsys):
    outline, radius, area = OUTLINES[name]
    edge = np.sqrt(area / VERTICES * 2 / np.sqrt(3))
    shape = shapes.polygon(outline, max_edge=edge, corner_radius=radius if corners == "round" else 0.0)
    points, faces = shape.positions, shape.domain.faces
    half_sphere = 2 / 3 * np.pi * (area / np.pi) ** 1.5

    def cold() -> None:
        domain = Domain.from_positions(points, faces)
        CmcSolver(domain).solve(conditions.binormal(domain, points, domain.boundary_edges, 0.6))

    def span(number: str, value: float) -> None:
        wanted = {number: value * half_sphere if number == "volume" else value}
        assert span_outline(Domain.from_positions(points, faces), points, **wanted).ok

    before = span_outline(shape.domain, points, mean_curvature=0.5)
    works = {f"{number} {value:g}": lambda choice=(number, value): span(*choice) for number, value in CHOICES}
    works["H 0.5 to 0.55, from the last one"] = lambda: span_outline(
        shape.domain, points, mean_curvature=0.55, initial=before
    )
    unit, measured = ratios(works, cold)
    with capsys.disabled():
        print(f"\n{name}, {corners} corners, {len(points)} vertices; one cold solve {unit:.3f} s")
        for label, ratio in measured.items():
            print(f"  {label:<34s} {ratio:5.1f} x")
