"""Approximation of surfaces: CMC ones come back, saddles too, places come near where they count."""

from functools import partial

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from solver import ConditionError, Domain, conformal_distortion, fit_gauss_map, mean_curvature_of, shapes
from solver.fitting import gauss_map
from solver.fitting.closest_point import Triangles
from solver.fitting.fit import FitStatus
from solver.fitting.shape_similarity import LEAST, ShapeSimilarity, bending, cosine, dirichlet_matrix
from solver.fitting.target import Shape
from solver.gauss.drawn_normals import drawn_normals
from tests.solver.exact_surfaces import rates


def over_the_disc(n, height):
    """A domain and its places (V, 3): the graph of a function over the unit disc."""
    shape = shapes.disc(n)
    x, y = shape.positions[:, :2].T
    points = np.column_stack([x, y, height(x, y)])
    return Domain.from_positions(points, shape.domain.faces), points


def cap(n):
    return over_the_disc(n, lambda x, y: np.sqrt(2 - x**2 - y**2))


def unduloid(n, c=-0.6, middle=0.7, size=0.8):
    """A round patch (in conformal coordinates) of the unduloid ψ'² = c + sin² ψ, off its neck: g + N, as in `exact`."""
    shape = shapes.disc(n)
    t, s = size * shape.positions[:, 0], middle + size * shape.positions[:, 1]

    def slope(_, y):
        return [y[1], np.sin(y[0]) * np.cos(y[0]), np.sin(y[0]) ** 2]

    start = [np.pi / 2, np.sqrt(1 + c), 0.0]
    ends = (min(s.min(), 0.0) - 0.01, s.max() + 0.01)
    ahead = solve_ivp(slope, (0, ends[1]), start, dense_output=True, rtol=1e-11, atol=1e-12).sol
    behind = solve_ivp(slope, (0, ends[0]), start, dense_output=True, rtol=1e-11, atol=1e-12).sol
    psi, turn, along = np.where(s >= 0, ahead(np.maximum(s, 0)), behind(np.minimum(s, 0)))
    normals = np.column_stack([np.sin(psi) * np.cos(t), np.sin(psi) * np.sin(t), np.cos(psi)])
    points = np.column_stack([-turn * np.cos(t), -turn * np.sin(t), along]) + normals
    return Domain.from_positions(points, shape.domain.faces), points


def wavy(n):
    return over_the_disc(n, lambda x, y: 0.3 * (1 - x**2 - y**2) + 0.05 * np.sin(5 * x) * np.cos(4 * y))


def rippled(n):
    return over_the_disc(n, lambda x, y: 0.4 * (1 - x**2 - y**2) + 0.12 * (x**3 - 3 * x * y**2))


def size_of(points):
    return np.linalg.norm(np.ptp(points, axis=0))


def off(domain, a, b):
    """Root mean square of |a - b|, as a part of the size."""
    return np.sqrt(np.average(np.sum((a - b) ** 2, axis=1), weights=domain.vertex_areas)) / size_of(b)


@pytest.mark.parametrize(("surface", "side"), [(cap, 1), (cap, -1), (unduloid, 1)])
def test_cmc_surfaces_come_back_at_second_order(surface, side):
    """Bulging along their normals and against them: reflected in a point they keep their normals."""
    misses, turns = [], []
    for n in (100, 400, 1600):
        domain, points = surface(n)
        found = fit_gauss_map(domain, side * points, 0.0)
        misses.append(off(domain, found.points(), side * points))
        turns.append(found.distances["Gauss map"])
        assert found.sheet == "f+" and found.sign == side and found.status is FitStatus.CONVERGED
    assert rates(misses).min() > 1.6 and misses[-1] < 1e-3
    assert rates(turns).min() > 1.2 and turns[-1] < 5e-3  # N_φ itself is of first order at the rim


SADDLES = {
    "saddle": lambda x, y: 0.5 * (x**2 - y**2),
    "monkey saddle": lambda x, y: 0.4 * (x**3 - 3 * x * y**2),
    "tilted saddle": lambda x, y: 0.3 * (x**2 - y**2) + 0.4 * x,
    "waves": lambda x, y: 0.3 * (x**2 - y**2) + 0.05 * np.sin(5 * x) * np.cos(4 * y + 0.3),
}


@pytest.mark.parametrize("name", SADDLES)
def test_saddles_are_spanned(name):
    """Their mean curvature is nearly zero or changes sign: the surface on their rim, with their volume."""
    domain, points = over_the_disc(300, SADDLES[name])
    found = fit_gauss_map(domain, points)
    surface, rim = Triangles(points, domain.faces), domain.boundary_vertices
    assert found.ok and found.span is not None and len(found.history) < 10
    assert np.sqrt(np.mean(surface.closest(found.points()).distances ** 2)) < 0.01 * size_of(points)
    assert surface.closest(found.points()[rim]).distances.max() < 1e-3 * size_of(points)
    assert cosine(dirichlet_matrix(domain), found.points(), points) > 0.99
    assert found.distances["Gauss map"] < 0.15
    H = found.sign * found.surface.mean_curvature
    measured = mean_curvature_of(found.points(), domain.faces, found.normals())
    assert np.nanmedian(np.abs(measured - H)) * size_of(points) < 0.08
    Q = conformal_distortion(domain, found.points())
    assert np.average(0.5 * (Q + 1 / Q) - 1, weights=domain.face_areas) < 1e-3


@pytest.mark.parametrize("side", [1, -1])
def test_the_side_of_a_saddle_is_that_of_its_volume(side):
    domain, points = over_the_disc(200, lambda x, y: 0.3 * side * (x**2 - 1.3 * y**2))
    assert abs(cosine(dirichlet_matrix(domain), drawn_normals(domain, points), points)) < 0.2
    found = fit_gauss_map(domain, points)
    assert found.sign == side and found.surface.mean_curvature > 0.05
    rim = Triangles(points, domain.faces).closest(found.points()[domain.boundary_vertices])
    assert rim.distances.max() < 1e-3 * size_of(points)


@pytest.mark.parametrize("radius", [0.0, 0.5])
@pytest.mark.parametrize("turned", [False, True])
def test_a_hypar_over_a_square_comes_near_the_minimal_surface(radius, turned):
    """H = 0 to the last digit; its corners sharp or rounded, lying or upright."""
    square = [[-5, -5], [5, -5], [5, 5], [-5, 5]]
    shape = shapes.polygon(square, max_edge=0.8, corner_radius=radius)
    points = np.column_stack([shape.positions, 0.1 * shape.positions.prod(axis=1)])
    points = points[:, [1, 2, 0]] if turned else points
    domain = Domain.from_positions(points, shape.domain.faces)
    found = fit_gauss_map(domain, points)
    assert found.ok and found.surface.mean_curvature == 0.0
    surface = Triangles(points, domain.faces)
    assert surface.closest(found.points()).distances.max() < 0.005 * size_of(points)
    assert surface.closest(found.points()[domain.boundary_vertices]).distances.max() < 3e-4 * size_of(points)


def test_minimal_surfaces_come_back():
    """A catenoid between two circles, and Scherk's over a square, whose rims alone decide them."""
    ring, square = shapes.annulus(0.5, 1.0, 600), shapes.polygon([[-1, -1], [1, -1], [1, 1], [-1, 1]], max_edge=0.1)
    x, y = ring.positions.T
    catenoid = np.column_stack([x, y, -0.45 * np.arccosh(np.hypot(x, y) / 0.45)])
    x, y = square.positions.T
    scherk = np.column_stack([x, y, np.log(np.cos(1.2 * y) / np.cos(1.2 * x)) / 1.2])
    for shape, points in ((ring, catenoid), (square, scherk)):
        domain = Domain.from_positions(points, shape.domain.faces)
        found = fit_gauss_map(domain, points)
        away = Triangles(points, domain.faces).closest(found.points()).distances
        assert found.ok and away.max() < 3e-3 * size_of(points)
        assert found.surface.mean_curvature * size_of(points) < 0.01


def test_a_saddle_without_a_span_is_searched(monkeypatch):
    """And the message says why it may not be near."""
    domain, points = over_the_disc(200, SADDLES["saddle"])
    hasty = partial(gauss_map.span_outline, max_iterations=1, tolerance=1e-12)
    monkeypatch.setattr(gauss_map, "span_outline", hasty)
    found = fit_gauss_map(domain, points)
    assert found.span is None and not found.is_met and "limit of steps" in found.message
    assert off(domain, found.points(), points) < 0.03


def test_without_likeness_a_saddle_is_lost():
    """What the paper's functional gives there: tangent planes that are near, and another surface."""
    domain, points = over_the_disc(300, SADDLES["saddle"])
    found = fit_gauss_map(domain, points, 1e-4, likeness=0.0)
    assert found.distances["Gauss map"] < 0.05
    assert off(domain, found.points(), points) > 0.2


def test_boundary_normals_vary_less_the_larger_the_regularisation():
    """Figure 10, small: what is found has constant mean curvature and is conformal to the surface given."""
    domain, points = wavy(1200)
    fits = [fit_gauss_map(domain, points, weight) for weight in (1e-4, 1e-3, 1e-2)]
    variation = [f.distances["smooth rim"] for f in fits]
    deviation = [f.distances["Gauss map"] for f in fits]
    assert variation == sorted(variation, reverse=True) and deviation == sorted(deviation)
    assert deviation[0] < 0.2 < deviation[2]
    for f in fits:
        H = mean_curvature_of(f.points(), domain.faces, f.surface.normals)
        assert np.nanstd(H) < 0.03 * f.surface.mean_curvature
        Q = conformal_distortion(domain, f.points())
        assert np.average(0.5 * (Q + 1 / Q) - 1, weights=domain.face_areas) < 2e-4


@pytest.mark.parametrize("side", [1, -1])
def test_places_come_near_where_they_count(side):
    domain, points = rippled(500)
    points = side * points + [3.0, -2.0, 1.0]
    rim = domain.boundary_loops[0]
    first = fit_gauss_map(domain, points, 1e-3)
    near = fit_gauss_map(domain, points, 1e-3, near=300.0)
    assert near.sign == first.sign == side
    surface = Triangles(points, domain.faces)
    mean = [np.sqrt(np.mean(surface.closest(f.points()).distances ** 2)) for f in (first, near)]
    assert mean[1] < 0.7 * mean[0]
    rims = [surface.closest(f.points()[rim]).distances.max() for f in (first, near)]
    assert rims[1] < 0.4 * rims[0] and rims[1] < 0.01 * size_of(points)
    assert_allclose(near.distances["near surface"], surface.closest(near.points()).distances.max(), rtol=1e-3, atol=0)
    assert_allclose(first.distances["near surface"], surface.closest(first.points()).distances.max(), rtol=1e-9, atol=0)
    assert near.distances["rim on curve"] < 0.01 * size_of(points)
    again = fit_gauss_map(domain, points, 1e-3, near=300.0, initial=near)
    assert again.value <= near.value * (1 + 1e-9) and len(again.history) < len(near.history)


def test_a_fit_goes_on_from_another():
    domain, points = wavy(500)
    first = fit_gauss_map(domain, points, 1e-3, max_evaluations=3)
    assert first.status is FitStatus.EVALUATION_LIMIT
    whole, rest = fit_gauss_map(domain, points, 1e-3), fit_gauss_map(domain, points, 1e-3, initial=first)
    assert_allclose(rest.value, whole.value, rtol=1e-3, atol=0)
    assert rest.history[0] <= 1.001 * first.value < whole.history[0]


def test_fits_are_told_and_cancelled_in_both_stages():
    domain, points = wavy(200)
    seen = []

    def progress(evaluation, value):
        seen.append((evaluation, value))
        return len(seen) < limit

    limit = 2
    assert fit_gauss_map(domain, points, near=100.0, progress=progress).status is FitStatus.CANCELLED
    assert len(seen) == 2
    limit = 1000
    seen.clear()
    found = fit_gauss_map(domain, points, near=100.0, progress=progress)
    assert [k for k, _ in seen].count(seen[0][0]) == 2  # counted from the beginning in each stage
    seen.clear()
    limit = 3
    domain, points = over_the_disc(200, SADDLES["saddle"])
    found = fit_gauss_map(domain, points, progress=progress)
    assert found.status is FitStatus.CANCELLED and len(seen) == 3


def test_closest_points_are_those_of_the_closest_triangle():
    """Against all triangles, one by one; near the surface and far from it, on a mesh of triangles of all sizes."""
    random = np.random.default_rng(0)
    corners = random.normal(size=(60, 1, 3)) + random.lognormal(-1, 1, (60, 1, 1)) * random.normal(size=(60, 3, 3))
    surface = Triangles(corners.reshape(-1, 3), np.arange(180).reshape(-1, 3))
    queries = np.concatenate([2 * random.normal(size=(300, 3)), corners.reshape(-1, 3), corners.mean(axis=1)])
    found = surface.closest(queries)
    each = [trimesh.triangles.closest_point(np.broadcast_to(t, (len(queries), 3, 3)), queries) for t in corners]
    least = np.min([np.linalg.norm(points - queries, axis=1) for points in each], axis=0)
    assert_allclose(found.distances, least, rtol=0, atol=1e-12)
    assert_allclose(np.linalg.norm(found.points - queries, axis=1), least, rtol=0, atol=1e-12)
    own = trimesh.triangles.closest_point(corners[found.faces], queries)
    assert_allclose(found.points, own, rtol=0, atol=1e-7)


@pytest.mark.parametrize("height", [SADDLES["saddle"], lambda x, y: 0.3 * x**2 + 0.2 * y**2])
def test_the_derivatives_of_likeness(height):
    """Where the bending is too small, and where it is not."""
    domain, points = over_the_disc(150, height)
    random = np.random.default_rng(2)
    L = dirichlet_matrix(domain)
    target = ShapeSimilarity(points, L)
    N = drawn_normals(domain, points)
    x, a, b = points + 0.1 * random.normal(size=points.shape), random.normal(size=N.shape), random.normal(size=N.shape)

    def value(t):
        return target.partials(Shape(domain, domain.boundary_vertices, x + t * a, N + t * b, 1.0)).value

    here = target.partials(Shape(domain, domain.boundary_vertices, x, N, 1.0))
    slope = np.sum(here.by_points * a) + np.sum(here.by_normals * b)
    assert_allclose((value(1e-5) - value(-1e-5)) / 2e-5, slope, rtol=1e-6, atol=0)
    assert (np.abs(here.by_normals).max() > 0) == (bending(domain, L, N)[0] < LEAST**2)


def test_bending_is_mean_curvature_over_all_curvature():
    """At the middle of a saddle y² - x²/2 and of a bowl, where h is (k₁ + k₂) / √(2 (k₁² + k₂²))."""
    for a, b in ((1.0, 1.0), (1.0, 0.0), (1.0, -0.5), (1.0, -1.0)):
        domain, points = over_the_disc(2000, lambda x, y, a=a, b=b: -0.025 * (a * x**2 + b * y**2))
        N, L = drawn_normals(domain, points), dirichlet_matrix(domain)
        h = (a + b) / np.sqrt(2 * (a**2 + b**2))
        assert_allclose(bending(domain, L, N)[0], h**2, rtol=0, atol=0.01)
        assert_allclose(cosine(L, N, points), h, rtol=0, atol=0.02)


def test_wrong_goals_are_refused():
    domain, points = over_the_disc(100, lambda x, y: x**2)
    for arguments, message in (
        ({"regularisation": -1.0}, "regularisation"),
        ({"likeness": np.nan}, "likeness"),
        ({"near": -2.0}, "nearness"),
    ):
        with pytest.raises(ConditionError, match=message):
            fit_gauss_map(domain, points, **arguments)
    flat, level = over_the_disc(100, lambda x, y: 0.3 * x + 0.1)
    with pytest.raises(ConditionError, match="flat"):
        fit_gauss_map(flat, level)
