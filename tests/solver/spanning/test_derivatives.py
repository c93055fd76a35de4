"""Derivatives of volume, energy and plan weights against finite differences and identities."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import Domain, shapes
from solver.gauss.frames import area_vectors
from solver.spanning.coordinates import Step
from solver.spanning.linearised import Linearised
from solver.spanning.setting import setting
from solver.spanning.volume import Volume
from tests.solver.exact_surfaces import disc
from tests.solver.spanned_plans import raised


def bump(points: np.ndarray, seed: int = 0) -> np.ndarray:
    """A surface (V, 3) over the plan, not special in any way."""
    random = np.random.default_rng(seed)
    x, y = points.T
    return np.column_stack([x + 0.1 * y**2, y - 0.2 * x * y, 0.5 - x**2]) + 0.01 * random.normal(size=(len(x), 3))


def test_the_volume_is_a_cubic_form():
    domain, points = disc(200)
    volume, f, d = Volume(domain), bump(points), bump(points, 1)
    second = volume.second(f)
    assert_allclose(np.sum(volume.first(f) * f) / 3, volume.of(f), rtol=1e-12)
    assert_allclose(second(d), volume.second(d)(f), rtol=0, atol=1e-14)
    for t in (-0.7, 0.3, 2.0):
        assert_allclose(np.polyval(volume.along(f, d)[::-1], t), volume.of(f + t * d), rtol=1e-11)


def test_inside_the_derivative_of_the_volume_is_a_third_of_the_area_vectors():
    domain, points = disc(200)
    f = bump(points)
    areas = np.zeros_like(f)
    np.add.at(areas, domain.faces, area_vectors(f, domain.faces)[:, None, :] / 3.0)
    inside = np.setdiff1d(np.arange(len(f)), domain.boundary_vertices)
    assert_allclose(Volume(domain).first(f)[inside], areas[inside], rtol=0, atol=1e-14)


def court_with_corners():
    """A square with a round hole, both at their own heights: a rim with pins and slides, and four moduli."""
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    hole = 0.35 * np.column_stack([np.cos(angle), np.sin(angle)]) + [0.1, 0.05]
    plan = shapes.polygon([[-1, -1], [1, -1], [1, 1], [-1, 1]], holes=[hole], max_edge=0.25)
    return plan.domain, raised(plan.domain, plan.positions, 0.4)


def shifted(problem, seed: int):
    """A state off the start in all its numbers."""
    random = np.random.default_rng(seed)
    start = problem.start()
    u, x, q = (random.normal(size=part.shape) for part in (start.u, start.x, start.q))
    return problem.state(0.05 * u, start.x + 0.01 * x, 0.03 * q)


def saddle_over_a_disc():
    domain, flat = disc(150)
    return setting(domain, np.column_stack([flat, 0.2 * flat[:, 0] * flat[:, 1]]))[0]


def leans_and_mirrors():
    """A pentagon: two sides that lean and meet at a corner, a mirror that meets one of them, two sides on lines."""
    plan = shapes.polygon([[0, 0], [2, 0], [2, 1], [1, 2], [0, 1]], max_edge=0.25)
    leans = [(plan.sides["side0"], 1.2), (plan.sides["side1"], 1.9)]
    points = np.column_stack([plan.positions, 0.1 * plan.positions[:, 1] ** 2])
    return setting(plan.domain, points, None, [(plan.sides["side4"], [1, 0, 0])], leans)[0]


def between_parallel_mirrors():
    plan = shapes.polygon([[0, 0], [2, 0], [2, 1], [0, 1]], max_edge=0.25)
    mirrors = [(plan.sides["side0"], [0, 1, 0]), (plan.sides["side2"], [0, 1, 0])]
    return setting(plan.domain, np.column_stack([plan.positions, 0 * plan.positions[:, 0]]), None, mirrors)[0]


PROBLEMS = {
    "disc": (saddle_over_a_disc, 0),
    "court": (lambda: setting(*court_with_corners())[0], 4),
    "leans and mirrors": (leans_and_mirrors, 2),
    "parallel mirrors": (between_parallel_mirrors, 1),
}


@pytest.mark.parametrize("name", PROBLEMS)
def test_gradient_and_hessian_of_the_energy(name):
    problem, moduli = PROBLEMS[name][0](), PROBLEMS[name][1]
    assert problem.motions.count == moduli
    state, H, eps = shifted(problem, 1), 0.7, 1e-5
    here = Linearised(problem, state, H)
    random = np.random.default_rng(2)
    step = Step(*(random.normal(size=part.shape) for part in (state.u, state.x, state.q)))

    def at(t: float):
        return problem.state(state.u + t * step.u, state.x + t * step.x, state.q + t * step.q)

    def energy(t: float) -> float:
        moved = at(t)
        return moved.energy - 2 * H * problem.volume.of(moved.f)

    assert_allclose(here.gradient(step), (energy(eps) - energy(-eps)) / (2 * eps), rtol=1e-7)
    assert_allclose(here.push(step), (at(eps).f - at(-eps).f) / (2 * eps), rtol=0, atol=1e-7)
    ahead, back = Linearised(problem, at(eps), H).gradient, Linearised(problem, at(-eps), H).gradient
    found = here.hessian(step, here.push(step))
    for name in ("u", "lifted", "x", "q"):
        difference = (getattr(ahead, name) - getattr(back, name)) / (2 * eps)
        scale = np.abs(difference).max(initial=1e-300)
        assert_allclose(getattr(found, name) / scale, difference / scale, rtol=0, atol=1e-6)


def test_the_preconditioner_is_symmetric_and_positive():
    domain, points = court_with_corners()
    problem, _ = setting(domain, points)
    state = shifted(problem, 3)
    here = Linearised(problem, state, 0.5)
    other = Linearised(problem, shifted(problem, 4), 0.5)
    a, b = here.gradient, other.gradient
    assert_allclose(a(here.precondition(b)), b(here.precondition(a)), rtol=1e-9)
    assert a(here.precondition(a)) > 0.0 and b(here.precondition(b)) > 0.0


def test_weights_of_a_moving_plan_are_those_of_the_moved_domain():
    domain, points = court_with_corners()
    motions = setting(domain, points)[0].motions
    q, eps = np.array([0.05, -0.1, 0.08, 0.1]), 1e-5
    assert_allclose(motions.weights(0 * q), domain.cotan_weights, rtol=0, atol=1e-12)
    assert_allclose(motions.weights(q), motions.moved(q).cotan_weights, rtol=0, atol=1e-10)
    assert_allclose(Domain.from_positions(motions.at(q), domain.faces).edge_lengths, motions.moved(q).edge_lengths)
    squares = np.random.default_rng(0).uniform(size=len(domain.edge_lengths))
    second = motions.second(q, squares)
    for k, e in enumerate(eps * np.eye(4)):
        slope = (motions.weights(q + e) - motions.weights(q - e)) / (2 * eps)
        assert_allclose(motions.slopes(q)[k], slope, rtol=0, atol=1e-6 * np.abs(slope).max())
        bent = (motions.slopes(q + e) - motions.slopes(q - e)) @ (0.5 * squares) / (2 * eps)
        assert_allclose(second[k], bent, rtol=0, atol=1e-5 * np.abs(bent).max())
