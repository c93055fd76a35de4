"""Design by target: the adjoint, the gradient of every target, and fits whose answers are known."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ConditionError, Domain, HarmonicSolver, conditions, mean_curvature_of, shapes, solve_cmc
from solver.design import FitStatus, fit_gauss_map, fit_outline
from solver.design.adjoint import Extension
from solver.design.curves import Curve
from solver.design.targets import (
    Anchors,
    Area,
    Crown,
    GaussMap,
    MinimalChange,
    NearSurface,
    RimOnCurve,
    Shape,
    SmoothRim,
    Volume,
)
from solver.gauss import sphere
from tests.solver.exact import rates

PLANS = {
    "disc": lambda: shapes.disc(250),
    "rectangle": lambda: shapes.polygon([[0, 0], [2, 0], [2, 1], [0, 1]], max_edge=0.15, corner_radius=0.2),
    "L": lambda: shapes.polygon([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], max_edge=0.2, corner_radius=0.2),
}


@pytest.fixture(params=PLANS)
def extension(request):
    shape = PLANS[request.param]()
    rim = conditions.binormal(shape.domain, shape.positions, shape.domain.boundary_edges, 0.4)
    fixed, normals = rim.resolve()
    return Extension(HarmonicSolver(shape.domain), fixed, rim.up), normals


def test_the_conjugate_is_that_of_the_solver_at_second_order():
    misses = []
    for n in (300, 1200, 4800):
        shape = shapes.disc(n)
        rim = conditions.twisted(shape.domain, shape.positions, shape.domain.boundary_edges, 1)
        fixed, normals = rim.resolve()
        state = Extension(HarmonicSolver(shape.domain), fixed, rim.up)(normals)
        misses.append(np.abs(state.g - solve_cmc(shape.domain, rim).g).max())
    assert rates(misses).min() > 1.5


def test_the_differential_against_finite_differences_and_the_adjoint(extension):
    extend, normals = extension
    random = np.random.default_rng(0)
    turn = sphere.project(normals, random.normal(size=normals.shape))
    state = extend(normals, tolerance=1e-12)
    moved, shifted = extend.differential(state, turn)
    h = 1e-4
    plus, minus = (extend(sphere.exp(normals, s * h * turn), state.N, tolerance=1e-12) for s in (1, -1))
    assert_allclose((plus.N - minus.N) / (2 * h), moved, rtol=0, atol=2e-5 * np.abs(moved).max())
    assert_allclose((plus.g - minus.g) / (2 * h), shifted, rtol=0, atol=2e-5 * np.abs(shifted).max())
    a, b = random.normal(size=(2, *state.N.shape))
    pulled = extend.pull_back(state, a, b)
    assert_allclose(np.sum(pulled * state.N[extend.fixed], axis=1), 0, rtol=0, atol=1e-9)
    assert_allclose(sphere.inner(pulled, turn), sphere.inner(a, moved) + sphere.inner(b, shifted), rtol=1e-6, atol=0)


def test_the_adjoint_at_a_saddle():
    """There the Hessian is indefinite; MINRES takes over, and the two linear solves still agree."""
    shape = shapes.disc(250)
    rim = conditions.binormal(shape.domain, shape.positions, shape.domain.boundary_edges)
    fixed, normals = rim.resolve()
    extend = Extension(HarmonicSolver(shape.domain), fixed, rim.up)
    flat = np.column_stack([shape.positions[:, :2] + [0.013, 0.007], np.zeros(len(shape.positions))])
    saddle = extend.solver.solve(rim, initial=flat, method="lagrange", tolerance=1e-11)
    state = extend.at(saddle)
    random = np.random.default_rng(1)
    turn = sphere.project(normals, random.normal(size=normals.shape))
    a, b = random.normal(size=(2, *state.N.shape))
    moved, shifted = extend.differential(state, turn)
    pulled = extend.pull_back(state, a, b)
    assert_allclose(sphere.inner(pulled, turn), sphere.inner(a, moved) + sphere.inner(b, shifted), rtol=1e-5, atol=0)


def all_targets(extend, points):
    domain = extend.domain
    random = np.random.default_rng(3)
    line = 1.1 * points[domain.boundary_loops[0]][::3]
    line[:, 2] += 0.1 * np.cos(np.linspace(0, 6, len(line)))
    towards = sphere.normalize(random.normal(size=(domain.vertex_count, 3)))
    inside = np.setdiff1d(np.arange(domain.vertex_count), domain.boundary_vertices)[:3]
    loop = domain.boundary_loops[0]
    return [
        GaussMap(towards),
        SmoothRim(),
        MinimalChange(towards[extend.fixed]),
        RimOnCurve(Curve(line, closed=True), loop),
        RimOnCurve(Curve(line, closed=True), loop, True),
        Anchors(inside, random.normal(size=(3, 3))),
        Anchors(inside, random.normal(size=(3, 3)), axes=(0.0, 0.0, 1.0)),
        Crown(0.7),
        Volume(1.3),
        Area(2.0),
        NearSurface(lambda points: points / np.linalg.norm(points, axis=1, keepdims=True)),
    ]


@pytest.mark.parametrize("number", range(11))
def test_taylor_remainders_of_every_target_fall_at_second_order(extension, number):
    """Through the harmonic map, the conjugate and the offset: F(t) - F(0) - t <grad F, turn> ~ t²."""
    extend, normals = extension
    random = np.random.default_rng(4)
    turn = sphere.project(normals, random.normal(size=normals.shape))
    turn = sphere.project(normals, smooth_along(extend, turn))
    state = extend(normals, tolerance=1e-12)

    def placed(state):
        points = 0.8 * (state.g + state.N) + [0.1, -0.2, 0.3]
        return Shape(extend.domain, extend.fixed, points, state.N, 2.5)

    target = all_targets(extend, placed(state).points)[number]
    here = target.partials(placed(state))
    by_conjugate = 0.8 * here.by_points
    slope = sphere.inner(extend.pull_back(state, here.by_normals + by_conjugate, by_conjugate), turn)
    remainders = []
    for t in (0.02, 0.01, 0.005):
        there = extend(sphere.exp(normals, t * turn), state.N, tolerance=1e-12)
        remainders.append(abs(target.partials(placed(there)).value - here.value - t * slope))
    # where a closest point jumps from one side of a corner to another the squared distance has a kink
    order = 1.5 if isinstance(target, RimOnCurve) else 1.9
    assert rates(remainders).mean() > order or max(remainders) < 1e-12
    assert abs(slope) > 1e-4
    assert target.distance(placed(state)) > 0


def smooth_along(extend, turn):
    """Averages along the boundary, so that closest points do not jump."""
    loop = extend.domain.boundary_loops[0]
    place = np.searchsorted(extend.fixed, loop)
    for _ in range(20):
        turn[place] = (np.roll(turn[place], 1, axis=0) + turn[place] + np.roll(turn[place], -1, axis=0)) / 3
    return turn


def test_closest_points_of_a_curve():
    square = Curve(np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0.0]]), closed=True)
    found = square.closest(np.array([[1, -1, 0], [3, 3, 1], [0.2, 1, 0.0]]))
    assert_allclose(found.points, [[1, 0, 0], [2, 2, 0], [0, 1, 0]], rtol=0, atol=1e-12)
    assert_allclose(square.length, 8)
    assert_allclose(square.at(np.array([0.0, 0.125, 0.5])), [[0, 0, 0], [1, 0, 0], [2, 2, 0]], rtol=0, atol=1e-12)
    assert_allclose(square.shares, 0.25)


@pytest.mark.parametrize("rise", [0.1, 0.45, 0.8])
def test_a_circle_gives_the_exact_cap(rise):
    shape = shapes.disc(800)
    found = fit_outline(shape.domain, shape.positions, rise=rise, max_evaluations=90)
    points = found.points()
    radius = (1 + rise**2) / (2 * rise)
    miss = np.linalg.norm(points - [0, 0, rise - radius], axis=1) - radius
    assert found.met, found.message
    assert_allclose(points[:, 2].max(), rise, rtol=1e-3, atol=0)
    assert_allclose(1 / found.surface.mean_curvature, radius, rtol=3e-3, atol=0)
    assert np.abs(miss).max() < 2e-3


@pytest.mark.parametrize("rise", [0.05, 0.25, 0.45])
def test_a_square_keeps_its_outline(rise):
    shape = shapes.polygon([[-1, -1], [1, -1], [1, 1], [-1, 1]], max_edge=0.07, corner_radius=0.2)
    found = fit_outline(shape.domain, shape.positions, rise=rise)
    size = np.linalg.norm(np.ptp(shape.positions[:, :2], axis=0))
    assert found.met, found.message
    assert found.distances["rim on curve"] < 2e-3 * size
    H = mean_curvature_of(found.points(), found.surface.faces, found.surface.normals)
    assert np.median(np.abs(H / found.surface.mean_curvature - 1)) < 0.03


def test_volume_and_mean_curvature_as_knobs():
    shape = shapes.disc(800)
    h = 0.4
    volume = np.pi * h * (3 + h**2) / 6
    found = fit_outline(shape.domain, shape.positions, volume=volume, max_evaluations=90)
    assert found.distances["volume"] < 1e-3 * volume
    assert_allclose(found.points()[:, 2].max(), h, rtol=0.01, atol=0)
    found = fit_outline(shape.domain, shape.positions, mean_curvature=0.5, max_evaluations=90)
    assert_allclose(found.surface.mean_curvature, 0.5, rtol=1e-12, atol=0)
    assert_allclose(found.points()[:, 2].max(), 2 - np.sqrt(3), rtol=0.01, atol=0)


def test_wishes_that_cannot_be_met_end_with_the_nearest_surface_and_a_sentence():
    shape = shapes.disc(400)
    found = fit_outline(shape.domain, shape.positions, mean_curvature=2.0, max_evaluations=60)
    assert not found.met and "smaller mean curvature" in found.message
    assert found.distances["rim on curve"] > 0.1
    assert np.isfinite(found.points()).all()


def test_fits_can_be_cancelled_and_continued():
    shape = shapes.disc(400)
    seen = []

    def progress(evaluation, value):
        seen.append((evaluation, value))
        return len(seen) < 4

    first = fit_outline(shape.domain, shape.positions, rise=0.4, progress=progress)
    assert first.status is FitStatus.CANCELLED and len(seen) == 4
    second = fit_outline(shape.domain, shape.positions, rise=0.4, initial=first)
    assert second.value < first.value and second.met


def test_a_cmc_surface_comes_back():
    """A cap of the sphere is CMC: its Gauss map is kept and it lies over itself, better the finer the mesh."""
    misses = []
    for n in (300, 1200, 4800):
        shape = shapes.disc(n)
        points = np.column_stack([shape.positions[:, :2], np.sqrt(2 - np.sum(shape.positions[:, :2] ** 2, axis=1))])
        found = fit_gauss_map(Domain.from_positions(points, shape.domain.faces), points, 0.0, max_evaluations=60)
        misses.append(np.sqrt(np.mean((found.points() - points) ** 2)))
        assert found.sheet == "f+" and found.sign == 1.0
    assert rates(misses).min() > 1.5
    bowl = fit_gauss_map(Domain.from_positions(points * [1, 1, -1], shape.domain.faces), points * [1, 1, -1], 0.0)
    assert bowl.sign == -1.0 and np.abs(bowl.points() - points * [1, 1, -1]).max() < 0.01


def test_boundary_normals_vary_less_the_larger_the_regularisation():
    shape = shapes.disc(800)
    x, y = shape.positions[:, :2].T
    points = np.column_stack([x, y, 0.25 * (1 - x**2 - y**2) + 0.06 * (x**4 - 6 * x**2 * y**2 + y**4)])
    domain = Domain.from_positions(points, shape.domain.faces)
    fits = [fit_gauss_map(domain, points, weight) for weight in (1e-4, 1e-3, 1e-2)]
    variation = [f.distances["smooth rim"] for f in fits]
    deviation = [f.distances["Gauss map"] for f in fits]
    assert variation == sorted(variation, reverse=True) and deviation == sorted(deviation)


def test_wrong_wishes_are_refused():
    shape = shapes.disc(100)
    domain, points = shape.domain, shape.positions
    for arguments, message in (
        ({"rise": 0.3, "volume": 1.0}, "one of"),
        ({"rise": -1.0}, "positive"),
        ({"curve": [[0, 0], [1, 1]]}, "three or more"),
        ({"on_curve": False}, "nothing to fit"),
        ({"sheet": "g"}, "sheet"),
        ({"anchors": ([999], [[0, 0, 0]], [1.0])}, "999"),
    ):
        with pytest.raises(ConditionError, match=message):
            fit_outline(domain, points, **arguments)
    with pytest.raises(ConditionError, match="regularisation"):
        fit_gauss_map(domain, np.column_stack([points[:, :2], points[:, 0] ** 2]), -1.0)
    with pytest.raises(ConditionError, match="one boundary loop"):
        ring = shapes.annulus(0.4, 1.0, 200)
        fit_outline(ring.domain, ring.positions)
