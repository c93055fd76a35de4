"""The surface as a function of its boundary normals: its differential, and the gradient of every target."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import CmcSolver, HarmonicSolver, conditions, shapes, solve_cmc
from solver.fitting.curves import Curve
from solver.fitting.response import Response, hats
from solver.fitting.target import Shape
from solver.fitting.targets import (
    Anchors,
    Area,
    Closed,
    Crown,
    GaussMap,
    MinimalChange,
    NearSurface,
    RimOnCurve,
    SmoothRim,
    TiltBounds,
    Volume,
)
from solver.gauss import sphere
from solver.surface.adjoint import AdjointSolver
from tests.solver.exact_surfaces import rates

PLANS = {
    "disc": lambda: shapes.disc(250),
    "rectangle": lambda: shapes.polygon([[0, 0], [2, 0], [2, 1], [0, 1]], max_edge=0.15, corner_radius=0.2),
    "L": lambda: shapes.polygon([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], max_edge=0.2, corner_radius=0.2),
    "courtyard": lambda: shapes.polygon(ring(1.0), holes=[ring(0.4) + [0.1, 0.05]], max_edge=0.17),
}


def ring(radius):
    angle = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


@pytest.fixture(params=PLANS)
def extension(request):
    shape = PLANS[request.param]()
    rim = conditions.binormal(shape.domain, shape.positions, shape.domain.boundary_edges, 0.4)
    _, normals = rim.resolve()
    return AdjointSolver(HarmonicSolver(shape.domain), rim), normals


def test_the_conjugate_is_that_of_the_solver_at_second_order():
    misses = []
    for n in (300, 1200, 4800):
        shape = shapes.disc(n)
        rim = conditions.twisted(shape.domain, shape.positions, shape.domain.boundary_edges, 1)
        _, normals = rim.resolve()
        state = AdjointSolver(HarmonicSolver(shape.domain), rim)(normals)
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


def test_periods_are_the_sums_along_the_loops():
    holes = [ring(0.2) + centre for centre in ([0.4, 0.3], [-0.4, 0.2], [0.0, -0.5])]
    shape = shapes.polygon(ring(1.0), holes=holes, max_edge=0.12)
    a, b, c, d = (conditions.binormal(shape, name, tilt=0.2 * k) for k, name in enumerate(list(shape.sides)[:4]))
    rim = a + b + c + d
    _, normals = rim.resolve()
    state = AdjointSolver(HarmonicSolver(shape.domain), rim)(normals, tolerance=1e-12)
    surface = CmcSolver(shape.domain).solve(rim, tolerance=1e-12)
    assert state.periods.shape == (3, 3) and np.abs(state.periods).max() > 0.5
    assert_allclose(state.periods, surface.conjugate.periods, rtol=0, atol=1e-10)


def test_the_adjoint_at_a_saddle():
    """There the Hessian is indefinite; MINRES takes over, and the two linear solves still agree."""
    shape = shapes.disc(250)
    rim = conditions.binormal(shape.domain, shape.positions, shape.domain.boundary_edges)
    _, normals = rim.resolve()
    extend = AdjointSolver(HarmonicSolver(shape.domain), rim)
    flat = np.column_stack([shape.positions[:, :2] + [0.013, 0.007], np.zeros(len(shape.positions))])
    saddle = extend.solver.solve(rim, initial=flat, method="lagrange", tolerance=1e-11)
    state = extend.at(saddle)
    random = np.random.default_rng(1)
    turn = sphere.project(normals, random.normal(size=normals.shape))
    a, b = random.normal(size=(2, *state.N.shape))
    moved, shifted = extend.differential(state, turn)
    pulled = extend.pull_back(state, a, b)
    assert_allclose(sphere.inner(pulled, turn), sphere.inner(a, moved) + sphere.inner(b, shifted), rtol=1e-5, atol=0)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_quick_response_is_nearly_the_differential(extension, side):
    """It leaves |dN|² out, a term of lower order: of rough turns nearly all the change is there, of others most."""
    extend, normals = extension
    random = np.random.default_rng(2)
    rough = sphere.project(normals, random.normal(size=normals.shape))
    state = extend(normals, tolerance=1e-12)
    rim = extend.fixed
    response = Response(extend)
    matrix = response.of_points(state, rim, side)
    for turn, least in ((rough, 0.97), (smooth_along(extend, rough.copy()), 0.88)):
        turn = sphere.project(normals, turn)
        moved, shifted = extend.differential(state, turn)
        exact = (shifted + side * moved)[rim]
        quick = np.einsum("kamb,mb->ka", matrix, turn)
        assert sphere.inner(exact, quick) > least * np.sqrt(sphere.inner(exact, exact) * sphere.inner(quick, quick))
        assert abs(np.log(sphere.inner(quick, quick) / sphere.inner(exact, exact))) < 0.8


def test_hat_functions_along_the_boundary_sum_up_to_one(extension):
    extend, _ = extension
    for knots in (4, 20, 1000):
        functions = hats(extend.domain, extend.fixed, knots)
        assert_allclose(functions.sum(axis=1), 1.0, rtol=0, atol=1e-12)
        assert functions.shape[1] <= max(knots, 3 * len(extend.domain.boundary_loops))
    assert_allclose(functions.toarray(), functions.toarray().round(), rtol=0, atol=0)


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
        TiltBounds(np.radians(25), np.radians(40)),
        Closed(),
    ]


@pytest.mark.parametrize("number", range(13))
def test_taylor_remainders_of_every_target_fall_at_second_order(extension, number):
    """Through the harmonic map, the conjugate and the offset: F(t) - F(0) - t <grad F, turn> ~ t²."""
    extend, normals = extension
    random = np.random.default_rng(4)
    turn = sphere.project(normals, random.normal(size=normals.shape))
    turn = sphere.project(normals, smooth_along(extend, turn))
    state = extend(normals, tolerance=1e-12)

    def placed(state):
        points = 0.8 * (state.g + state.N) + [0.1, -0.2, 0.3]
        return Shape(extend.domain, extend.fixed, points, state.N, 2.5, 0.8 * state.periods)

    target = all_targets(extend, placed(state).points)[number]
    if isinstance(target, Closed) and not len(state.periods):
        pytest.skip("there is no hole to close around")
    if isinstance(target, Crown) and len(state.periods):
        pytest.skip("the ridge around a courtyard is level: its highest point jumps")
    here = target.partials(placed(state))
    by_conjugate = 0.8 * here.by_points
    pulled = extend.pull_back(state, here.by_normals + by_conjugate, by_conjugate, 0.8 * here.by_periods)
    slope = sphere.inner(pulled, turn)
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
    for loop in extend.domain.boundary_loops:
        place = np.searchsorted(extend.fixed, loop)
        for _ in range(20):
            turn[place] = (np.roll(turn[place], 1, axis=0) + turn[place] + np.roll(turn[place], -1, axis=0)) / 3
    return turn
