"""Normals on faces against normals on vertices: the Möbius energy on a disc with 25k vertices and 50k faces, as a
multiple of the cotangent solve on a disc with 50k vertices, in the same run. Both have equally many unknowns.

`make bench` prints the ratios; rounds are interleaved and the median is quoted, as in bench_solve.py.
"""

from __future__ import annotations

import pytest

from benchmarks.bench_solve import from_scratch, plan, ratios
from solver import CmcSolver, Domain, conditions

VERTICES = 50_000


def on_faces(points, faces, m: int, delaunay: bool) -> CmcSolver:
    """The whole solve, from arrays to f±."""
    domain = Domain.from_positions(points, faces)
    solver = CmcSolver(domain, sites="faces", energy="mobius", delaunay=delaunay)
    solver.solve(conditions.twisted(domain, points, domain.boundary_edges, m))
    return solver


@pytest.mark.parametrize("m", [1, 2, 3])
def test_mobius_on_as_many_faces(m, capsys):
    coarse, fine = plan(VERTICES // 2), plan(VERTICES)
    unit, measured = ratios(
        {
            f"Möbius on {len(coarse[1])} faces": lambda: on_faces(*coarse, m, delaunay=False),
            "the same on their Delaunay triangulation": lambda: on_faces(*coarse, m, delaunay=True),
        },
        lambda: from_scratch(*fine, m),
    )
    with capsys.disabled():
        print(f"\nm = {m}; cotangents on {len(fine[0])} vertices, from positions to f±: {unit:.3f} s")
        for name, ratio in measured.items():
            print(f"  {name:<44s} {ratio:5.2f} x")
