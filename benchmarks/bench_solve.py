"""The time of a solve, as a multiple of one sparse factorisation of the same Laplacian in the same run.

`make bench` prints the ratios; `pytest benchmarks -k size` adds the table over mesh sizes. Rounds are
interleaved, so that a machine whose speed drifts slows both sides of a ratio, and the median over the rounds
is quoted.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from solver import CmcSolver, Domain, conditions, report, shapes

VERTICES = 50_000
ROUNDS = 5
TILT = np.radians(5.0)


def plan(vertices: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions and faces of a disc with jittered inner vertices."""
    shape = shapes.disc(vertices)
    inside = np.linalg.norm(shape.positions, axis=1) < 1 - 1e-9
    move = 0.15 * shape.domain.edge_lengths.mean() * np.random.default_rng(1).uniform(-1, 1, shape.positions.shape)
    return shape.positions + move * inside[:, None], shape.domain.faces


def interior_laplacian(points: np.ndarray, faces: np.ndarray) -> sp.csc_matrix:
    domain = Domain.from_positions(points, faces)
    inside = np.setdiff1d(np.arange(domain.vertex_count), domain.boundary_vertices)
    return sp.csc_matrix(domain.laplacian[inside][:, inside])


def factorise(A: sp.csc_matrix) -> None:
    splu(A, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def from_scratch(points: np.ndarray, faces: np.ndarray, m: int) -> CmcSolver:
    """The whole solve, from arrays to f±, without the report."""
    domain = Domain.from_positions(points, faces)
    solver = CmcSolver(domain)
    solver.solve(conditions.twisted(domain, points, domain.boundary_edges, m))
    return solver


def tilted(domain: Domain, points: np.ndarray, m: int, tilt: float) -> conditions.Conditions:
    """Normals of Figure 3 (paper), all turned by a further angle around the boundary tangent."""
    data = conditions.twisted(domain, points, domain.boundary_edges, m)
    radial = np.column_stack([points[data.vertices], np.zeros(len(data.vertices))])
    around = np.cross(radial, [0.0, 0.0, 1.0])
    turned = np.cos(tilt) * data.vertex_normals + np.sin(tilt) * np.cross(data.vertex_normals, around) * -1.0
    return conditions.fixed_at(domain, data.vertices, turned)


def seconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def ratios(works: dict[str, Callable[[], object]], unit: Callable[[], object]) -> tuple[float, dict[str, float]]:
    """Median seconds of the unit, and the median ratio of each work to it, round by round."""
    units, rows = [], {name: [] for name in works}
    for _ in range(ROUNDS):
        units.append(seconds(unit))
        for name, work in works.items():
            rows[name].append(seconds(work) / units[-1])
    return float(np.median(units)), {name: float(np.median(values)) for name, values in rows.items()}


def show(capsys: pytest.CaptureFixture[str], title: str, unit: float, measured: dict[str, float]) -> None:
    with capsys.disabled():
        print(f"\n{title}; one factorisation {unit:.3f} s")
        for name, ratio in measured.items():
            print(f"  {name:<44s} {ratio:5.2f} x")


@pytest.mark.parametrize("m", [1, 2, 3])
def test_full_solve_and_edit(m, capsys):
    points, faces = plan(VERTICES)
    A = interior_laplacian(points, faces)
    solver = from_scratch(points, faces, m)
    before = solver.solve(tilted(solver.domain, points, m, 0.0)).normals
    edit = tilted(solver.domain, points, m, TILT)
    measured = ratios(
        {
            f"m = {m}, from positions to f±": lambda: from_scratch(points, faces, m),
            f"m = {m}, tilted by 5°, cached, from the old map": lambda: solver.solve(edit, before),
            f"m = {m}, tilted by 5°, cached, from scratch": lambda: solver.solve(edit),
        },
        lambda: factorise(A),
    )
    show(capsys, f"{len(points)} vertices", *measured)


def test_dome_with_report(capsys):
    points, faces = plan(VERTICES)
    A = interior_laplacian(points, faces)

    def dome() -> CmcSolver:
        domain = Domain.from_positions(points, faces)
        solver = CmcSolver(domain)
        solver.solve(conditions.binormal(domain, points, domain.boundary_edges))
        return solver

    solver = dome()
    leaning = conditions.binormal(solver.domain, points, solver.domain.boundary_edges, tilt=TILT)
    surface = solver.solve(leaning)
    measured = ratios(
        {
            "dome, from positions to f±": dome,
            "dome, tilted by 5°, cached": lambda: solver.solve(leaning),
            "report": lambda: report(surface),
        },
        lambda: factorise(A),
    )
    show(capsys, f"{len(points)} vertices", *measured)


@pytest.mark.parametrize("vertices", [5_000, 50_000, 200_000])
def test_sizes(vertices, capsys):
    points, faces = plan(vertices)
    A = interior_laplacian(points, faces)
    measured = ratios({"m = 1, from positions to f±": lambda: from_scratch(points, faces, 1)}, lambda: factorise(A))
    show(capsys, f"{len(points)} vertices", *measured)
