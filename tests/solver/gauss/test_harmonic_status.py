"""How a solve for normals ends: progress, statuses, refusals, factors that are kept."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import ConditionError, HarmonicSolver, Status, conditions, linalg, shapes
from tests.solver.exact_surfaces import disc
from tests.solver.rim_conditions import rim


def test_progress_is_reported_and_can_cancel():
    domain, points = disc(1500)
    seen = []

    def progress(iteration, residual):
        seen.append((iteration, residual))
        return iteration < 2

    result = HarmonicSolver(domain).solve(rim(domain, points), progress=progress)
    assert result.status is Status.CANCELLED and result.iterations == 2
    assert [k for k, _ in seen] == [0, 1, 2]
    assert_allclose(seen[-1][1], result.residual, rtol=1e-12, atol=0)


def test_the_iteration_limit_is_a_status():
    domain, points = disc(1500)
    result = HarmonicSolver(domain).solve(rim(domain, points), max_iterations=1)
    assert result.status is Status.ITERATION_LIMIT and result.iterations == 1


def test_a_tolerance_out_of_reach_is_stalled_or_met_never_endless():
    domain, points = disc(800)
    result = HarmonicSolver(domain).solve(rim(domain, points), tolerance=1e-15)
    assert result.status in (Status.STALLED, Status.ITERATION_LIMIT)
    assert result.residual < 1e-9


def test_constant_data_collapse():
    domain, _ = disc(300)
    result = HarmonicSolver(domain).solve(conditions.fixed(domain, domain.boundary_edges, [0, 0, 1]))
    assert result.status is Status.COLLAPSED


def test_a_mesh_too_coarse_for_its_map_is_under_resolved():
    shape = shapes.disc(19)
    edges = shape.domain.boundary_edges
    result = HarmonicSolver(shape.domain).solve(conditions.twisted(shape.domain, shape.positions, edges, 4))
    assert result.status is Status.UNDER_RESOLVED


def test_an_initial_map_is_taken():
    domain, points = disc(1500)
    solver = HarmonicSolver(domain)
    condition = rim(domain, points, 0.2)
    once = solver.solve(condition)
    again = solver.solve(condition, once.normals)
    assert again.iterations == 0
    assert_allclose(again.normals, once.normals, rtol=0, atol=1e-15)


def test_factors_are_kept_and_results_do_not_depend_on_them():
    domain, points = disc(800)
    solver = HarmonicSolver(domain)
    first = solver.solve(rim(domain, points, 0.2))
    solver.solve(rim(domain, points, 0.5))
    again = solver.solve(rim(domain, points, 0.2))
    assert_array_equal(first.normals, again.normals)
    assert len(solver._factors) == 1
    half = conditions.binormal(domain, points, domain.boundary_edges[:10])
    solver.solve(half)
    assert len(solver._factors) == 2


def test_superlu_and_cholespy_agree(monkeypatch):
    pytest.importorskip("cholespy")
    domain, points = disc(1500)
    fast = HarmonicSolver(domain).solve(rim(domain, points, 0.2))
    monkeypatch.setattr("solver.gauss.dirichlet.factorize", linalg._SuperLU)
    slow = HarmonicSolver(domain).solve(rim(domain, points, 0.2))
    assert_allclose(slow.normals, fast.normals, rtol=0, atol=1e-8)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda d, p: conditions.free(d, d.boundary_edges), "Nothing fixes the normals"),
        (lambda d, p: conditions.fixed_at(d, np.arange(d.vertex_count), [0, 0, 1]), "are fixed"),
    ],
)
def test_too_little_and_too_much_is_refused(make, words):
    domain, points = disc(60)
    with pytest.raises(ConditionError, match=words):
        HarmonicSolver(domain).solve(make(domain, points))


def test_a_closed_domain_has_nothing_to_prescribe():
    with pytest.raises(ConditionError, match="closed"):
        HarmonicSolver(shapes.sphere(100).domain).solve(conditions.Conditions())


@pytest.mark.parametrize(
    "arguments",
    [{"side": 0}, {"method": "nosuch"}, {"initial": np.zeros((3, 3))}, {"initial": "zeros"}],
)
def test_bad_arguments_are_condition_errors(arguments):
    domain, points = disc(60)
    if isinstance(arguments.get("initial"), str):
        arguments = {"initial": np.zeros((domain.vertex_count, 3))}
    with pytest.raises(ConditionError):
        HarmonicSolver(domain).solve(rim(domain, points), **arguments)


@pytest.mark.parametrize("arguments", [{"sites": "nosuch"}, {"energy": "nosuch"}])
def test_unknown_names_list_the_known_ones(arguments):
    with pytest.raises(ConditionError, match=r"known are|did you mean"):
        HarmonicSolver(disc(60)[0], **arguments)


@pytest.mark.parametrize(("angle", "status"), [(89.0, Status.ITERATION_LIMIT), (91.0, Status.UNDER_RESOLVED)])
def test_a_map_is_torn_where_neighbouring_normals_are_more_than_90_degrees_apart(angle, status):
    shape = shapes.disc(61)
    centre = int(np.linalg.norm(shape.positions, axis=1).argmin())
    initial = np.tile([0.0, 0.0, 1.0], (shape.domain.vertex_count, 1))
    initial[centre] = [np.sin(np.radians(angle)), 0.0, np.cos(np.radians(angle))]
    up = conditions.fixed(shape.domain, shape.domain.boundary_edges, [0, 0, 1])
    result = HarmonicSolver(shape.domain).solve(up, initial, max_iterations=0)
    assert_allclose(result.normals, initial, rtol=0, atol=1e-12)
    assert result.status is status


@pytest.mark.parametrize(("part", "status"), [(0.99, Status.COLLAPSED), (1.01, Status.ITERATION_LIMIT)])
def test_a_map_of_hardly_any_energy_counts_as_collapsed(part, status):
    """Below 10⁻¹² of the 4π of the whole sphere."""
    shape = shapes.disc(61)
    solver = HarmonicSolver(shape.domain)
    up = conditions.fixed(shape.domain, shape.domain.boundary_edges, [0, 0, 1])
    centre = int(np.linalg.norm(shape.positions, axis=1).argmin())

    def solved(angle):
        initial = np.tile([0.0, 0.0, 1.0], (shape.domain.vertex_count, 1))
        initial[centre] = [np.sin(angle), 0.0, np.cos(angle)]
        return solver.solve(up, initial, max_iterations=0, tolerance=1e-15)

    limit = 4.0 * np.pi * 1e-12
    # the energy is quadratic in small angles
    found = solved(1e-3 * np.sqrt(part * limit / solved(1e-3).energy))
    assert found.energy == pytest.approx(part * limit, rel=1e-3)
    assert found.status is status
