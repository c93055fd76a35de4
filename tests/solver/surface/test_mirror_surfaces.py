"""Surfaces between mirrors against exact ones: pieces of Delaunay surfaces, of spheres, of the Wente torus; modules."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import solve_ivp
from scipy.special import ellipe

from solver import HarmonicSolver, Status, conditions, mean_curvature_of, shapes, solve_cmc
from solver.catalogue import modules
from solver.domain.sites import SITES
from solver.surface import mirror_galerkin
from solver.surface.averaging import _galerkin_load
from solver.surface.mirror_galerkin import MirrorGalerkin
from solver.surface.plane_projection import VertexPlanes
from tests.solver.exact_surfaces import Nodoid, hemisphere, rates
from tests.solver.fundamental_pieces import between_mirrors
from tests.solver.mirror_images import half_disc, jittered_strip

E_X, E_Y, E_Z = np.eye(3)


class Unduloid:
    """N = (sin ψ cos t, sin ψ sin t, cos ψ), ψ'² = c + sin² ψ, from one neck or belly (ψ = π/2) to the next."""

    def __init__(self, c: float) -> None:
        start = [0.5 * np.pi, -np.sqrt(1.0 + c), 0.0]
        back = lambda s, y: y[0] - 0.5 * np.pi if s > 0.1 else -1.0  # noqa: E731
        found = solve_ivp(
            lambda s, y: [y[1], np.sin(y[0]) * np.cos(y[0]), np.sin(y[0]) ** 2],
            (0, 12),
            start,
            dense_output=True,
            events=back,
            rtol=1e-11,
            atol=1e-12,
        )
        self.height = found.t_events[0][found.t_events[0] > 0.1][0]
        self._profile = found.sol

    def __call__(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """N and g (V, 3) at (t, s)."""
        t, s = points.T
        psi, slope, along = self._profile(s)
        N = np.column_stack([np.sin(psi) * np.cos(t), np.sin(psi) * np.sin(t), np.cos(psi)])
        return N, np.column_stack([-slope * np.cos(t), -slope * np.sin(t), along])


def mirrors(domain, sides, **normals):
    total = conditions.Conditions()
    for side, normal in normals.items():
        total = total + conditions.mirror(domain, sides[side], normal)
    return total


def misses(surface, N, g):
    """Largest errors of the normals and of f+, up to a translation."""
    off = surface.f_plus - (g + N)
    return np.abs(surface.normals - N).max(), np.abs(off - off.mean(axis=0)).max()


@pytest.mark.parametrize("c", [-0.15, -0.3, -0.45, -0.6, -0.75])
def test_a_quarter_of_an_unduloid_between_four_mirrors(c):
    """From its corner normals alone, which are those of a cylinder: it bulges by itself. Neck and belly have the radii
    1 ± √(1 + c) on f+, half a period lies between the mirrors."""
    exact, errors = Unduloid(c), []
    for columns in (6, 12, 24):
        shape, points = jittered_strip(0.5 * np.pi, exact.height, columns)
        planes = mirrors(shape.domain, shape.sides, bottom=-E_Z, top=E_Z, left=-E_Y, right=-E_X)
        surface = solve_cmc(shape.domain, planes, tolerance=1e-9)
        assert surface.status is Status.CONVERGED and surface.harmonic.iterations <= 10
        assert_allclose(surface.harmonic.admissible.corner_normals[:2], [E_X, E_Y], rtol=0, atol=1e-15)
        errors.append(misses(surface, *exact(points)))
    assert (rates([e[0] for e in errors]) > 1.5).all() and (rates([e[1] for e in errors]) > 1.5).all()
    assert errors[-1][0] < 1e-3 and errors[-1][1] < 3e-3
    ends = [surface.f_plus[np.unique(shape.domain.edges[shape.sides[side]])] for side in ("bottom", "top")]
    radii = sorted(np.ptp(end[:, 0]) for end in ends)
    assert_allclose(radii, [1 - np.sqrt(1 + c), 1 + np.sqrt(1 + c)], rtol=0, atol=3e-3)
    assert_allclose(ends[1][:, 2].mean() - ends[0][:, 2].mean(), 2 * ellipe(1 + c), rtol=2e-3, atol=0)


@pytest.mark.parametrize(
    ("c", "averaging"), [*((c, "galerkin") for c in (0.1, 0.25, 0.5, 1.0, 2.0)), (0.5, "linear")]
)
def test_a_quarter_of_a_nodoid_between_two_mirrors(c, averaging):
    """Its ends are opposite, and it turns between them by half a turn on the outer side of the mirrors."""
    exact, errors, energies = Nodoid(c), [], []
    for columns in (6, 12, 24):
        shape, points = jittered_strip(0.5 * np.pi, exact.height, columns)
        sides = shape.sides
        ends = conditions.fixed(shape.domain, sides["bottom"], E_X) + conditions.fixed(shape.domain, sides["top"], -E_X)
        given = ends + mirrors(shape.domain, sides, left=E_Z, right=E_Y)
        surface = solve_cmc(shape.domain, given, tolerance=1e-9, averaging=averaging)
        assert surface.status is Status.CONVERGED and surface.harmonic.iterations <= 8
        errors.append(misses(surface, *exact(points)))
        energies.append(abs(4.0 * surface.harmonic.energy - exact.energy))
    assert (rates([e[0] for e in errors]) > 1.4).all() and (rates([e[1] for e in errors]) > 1.5).all()
    assert (rates(energies) > 1.8).all()
    assert errors[-1][0] < 1.5e-3 and errors[-1][1] < 4e-3


@pytest.mark.parametrize("sites", SITES)
@pytest.mark.parametrize("side", [1, -1])
def test_an_eighth_of_a_sphere_from_a_quarter_of_a_disc(sites, side):
    angle = np.linspace(0.0, 0.5 * np.pi, 13)
    arc = np.column_stack([np.cos(angle), np.sin(angle)])
    plan = shapes.polygon(np.vstack([[0.0, 0.0], arc]), max_edge=0.13)
    domain, sides = plan.domain, plan.sides
    rim = np.concatenate([sides[f"side{k}"] for k in range(1, 13)])
    positions = np.column_stack([plan.positions, np.zeros(domain.vertex_count)])
    given = conditions.binormal(domain, positions, rim) + mirrors(domain, sides, side0=-E_Y, side13=-E_X)
    surface = solve_cmc(domain, given, sites=sites, side=side)
    assert surface.status is Status.CONVERGED
    N = hemisphere(plan.positions) * [1, 1, side]
    if sites == "faces":  # the conditions hold half a triangle further in
        assert_allclose(surface.normals, N, rtol=0, atol=0.2)
        return
    assert_allclose(surface.normals, N, rtol=0, atol=0.02)
    sphere = surface.f_plus if side > 0 else surface.f_minus
    centre = (sphere - 2 * side * surface.normals).mean(axis=0)
    assert_allclose(np.linalg.norm(sphere - centre, axis=1), 2.0, rtol=0, atol=0.02)
    for axis, vector in ((1, E_Y), (0, E_X)):
        on = np.abs(plan.positions[:, axis]) < 1e-9
        assert_allclose(np.ptp(sphere[on] @ vector), 0, rtol=0, atol=1e-7)
        assert_allclose(surface.normals[on] @ vector, 0, rtol=0, atol=1e-14)


@pytest.mark.parametrize("averaging", ["galerkin", "linear", "area"])
def test_curvature_next_to_a_mirror_is_as_good_as_inside(averaging):
    """Faces that touch the mirror, against those that do not, both away from the arc; not so without the plane."""
    domain, points, arc, flat = half_disc(1200)
    plan = np.column_stack([points, np.zeros(len(points))])
    given = conditions.binormal(domain, plan, arc, tilt=0.4) + conditions.mirror(domain, flat, -E_Y)
    surface = solve_cmc(domain, given, averaging=averaging, tolerance=1e-9)
    error = np.abs(mean_curvature_of(surface.f_plus, surface.faces, surface.normals) - 0.5)
    corners = points[surface.faces]
    away = np.linalg.norm(corners, axis=2).max(axis=1) < 0.8
    touching = (corners[:, :, 1] < 1e-9).any(axis=1)
    assert error[away & touching].max() < (2.5 if averaging == "area" else 1.1) * error[away & ~touching].max()
    assert_allclose(np.ptp(surface.f_plus[np.unique(domain.edges[flat])] @ E_Y), 0, rtol=0, atol=1e-9)


@pytest.mark.parametrize("sites", SITES)
def test_a_honeycomb_module_from_its_corner_normals(sites):
    """A rectangle 2 × 1 between tube axis, end, floor and bisector: six steps (MATH.md of the paper's Figure 16)."""
    shape = shapes.strip(2.0, 1.0, 20)
    bisector = np.array([-np.sin(np.pi / 3), np.cos(np.pi / 3), 0.0])
    given = mirrors(shape.domain, shape.sides, bottom=-E_Y, right=E_X, top=-E_Z, left=bisector)
    surface = solve_cmc(shape.domain, given, sites=sites, tolerance=1e-8)
    assert surface.status is Status.CONVERGED and surface.harmonic.iterations <= 8
    if sites == "vertices":
        corners = surface.harmonic.admissible
        assert_array_equal(shape.positions[corners.corners], [[0, 0], [2, 0], [0, 1], [2, 1]])
        along = [np.cos(np.pi / 3), np.sin(np.pi / 3), 0]
        assert_allclose(corners.corner_normals, [E_Z, E_Z, along, E_Y], rtol=0, atol=1e-15)
    for side, normal in {"bottom": E_Y, "right": E_X, "top": E_Z, "left": bisector}.items():
        rows = np.unique(shape.domain.edges[shape.sides[side]])
        assert_allclose(np.ptp(surface.f_plus[rows] @ normal), 0, rtol=0, atol=1e-7)
        assert_allclose(surface.normals[rows] @ normal, 0, rtol=0, atol=1e-13)


def test_the_quarter_of_the_wente_torus_is_a_minimiser():
    """One long side a mirror along which N goes the long way, 240°; the other free; energy 26.8240 / 4."""
    height, errors = 1.6248255393, []
    far = np.array([np.cos(2 * np.pi / 3), np.sin(2 * np.pi / 3), 0.0])
    for columns in (12, 24, 48):
        shape = shapes.strip(0.5 * np.pi, height, columns)
        domain, sides = shape.domain, shape.sides
        ends = conditions.fixed(domain, sides["bottom"], E_X) + conditions.fixed(domain, sides["top"], far)
        long_way = conditions.mirror(domain, sides["left"], E_Z, winding=1)
        found = HarmonicSolver(domain).solve(ends + long_way + conditions.free(domain, sides["right"]))
        assert found.status is Status.CONVERGED and found.iterations <= 10
        assert np.abs(found.normals[:, 2]).max() > 0.9
        errors.append(abs(4.0 * found.energy - 26.8240))
    assert (rates(errors) > 1.8).all() and errors[-1] < 0.03
    short = HarmonicSolver(domain).solve(ends + conditions.mirror(domain, sides["left"], E_Z))
    assert_allclose(np.abs(short.normals[:, 2]).max(), 0, rtol=0, atol=1e-6)


def test_a_vault_between_walls_and_floor():
    """Two walls touched along constant normals, two ground curves orthogonal to the floor (paper, Fig. 9)."""
    errors, floors = [], []
    for columns in (8, 16, 32):
        shape, _ = jittered_strip(1.5, 1.0, columns)
        domain, sides = shape.domain, shape.sides
        walls = conditions.fixed(domain, sides["left"], -E_X) + conditions.fixed(domain, sides["right"], E_X)
        surface = solve_cmc(domain, walls + mirrors(domain, sides, bottom=-E_Z, top=-E_Z), tolerance=1e-9)
        assert surface.status is Status.CONVERGED
        assert_allclose(surface.harmonic.degree, 0.5, rtol=0, atol=1e-12)
        heights = []
        for side, normal in {"left": E_X, "right": E_X, "bottom": E_Z, "top": E_Z}.items():
            heights.append(surface.f_plus[np.unique(domain.edges[sides[side]])] @ normal)
            assert_allclose(np.ptp(heights[-1]), 0, rtol=0, atol=1e-8)
        floors.append(abs(heights[2].mean() - heights[3].mean()))
        H = mean_curvature_of(surface.f_plus, surface.faces, surface.normals)
        errors.append(np.sqrt(np.mean((H - 0.5) ** 2)))
    assert (rates(errors) > 1.0).all() and errors[-1] < 7e-3
    assert max(floors) < 1e-3  # by symmetry the two ground curves lie in one plane, up to the irregular mesh


def test_mirrors_around_a_hole_keep_their_planes():
    """A cylinder with a mirror all the way around one end; at the other the normals lean."""
    shape = shapes.cylinder(2 * np.pi, 0.8, 24)
    top = np.unique(shape.domain.edges[shape.sides["top"]])
    t = shape.positions[top, 0]
    leaning = np.column_stack([0.8 * np.cos(t), 0.8 * np.sin(t), 0.6 + 0 * t])
    given = conditions.fixed_at(shape.domain, top, leaning) + mirrors(shape.domain, shape.sides, bottom=-E_Z)
    for averaging in ("galerkin", "linear", "area"):
        surface = solve_cmc(shape.domain, given, averaging=averaging, tolerance=1e-9)
        rows = np.unique(shape.domain.edges[shape.sides["bottom"]])
        assert surface.status is Status.CONVERGED and not surface.is_open
        assert_allclose(np.ptp(surface.f_plus[rows] @ E_Z), 0, rtol=0, atol=1e-8)
        ring = surface.f_plus[rows][:, :2]
        assert_allclose(np.linalg.norm(ring - ring.mean(axis=0), axis=1).std(), 0, rtol=0, atol=1e-8)


def test_isolated_fixed_vertices_leave_no_spike():
    """Normals held at single boundary vertices: g solves its equation there, too."""
    disc = shapes.disc(400)
    rim = disc.domain.boundary_loops[0][::6]
    N = hemisphere(disc.positions)
    surface = solve_cmc(disc.domain, conditions.fixed_at(disc.domain, rim, N[rim]), initial=N)
    rest = disc.domain.laplacian @ surface.g - _galerkin_load(disc.domain, surface.normals)
    assert_allclose(rest, 0, rtol=0, atol=1e-11)


def test_a_closed_surface_has_a_conjugate_too():
    """The sphere with its own normals: nothing is held, and f+ is a sphere of radius 2 about f- (to 1st order)."""
    ball = shapes.sphere(640)
    surface = solve_cmc(ball.domain, conditions.Conditions(), initial=ball.positions)
    sizes = sorted(np.ptp(points, axis=0).max() for points in (surface.f_plus, surface.f_minus))
    assert sizes[0] < 0.1 and abs(sizes[1] - 4.0) < 0.1


def test_g_settles_along_mirrors_in_few_steps(monkeypatch):
    """Conjugate gradients: a disturbance of g within its planes is taken back in the 15 to 25 steps promised."""
    surface = between_mirrors(modules.node(3, 2.3, max_edge=0.16)).surface
    domain, admissible = surface.domain, surface.harmonic.admissible
    galerkin = MirrorGalerkin(domain, admissible, HarmonicSolver(domain).dirichlet(admissible.fixed))
    load = domain.laplacian @ surface.g
    noise = np.random.default_rng(0).normal(size=surface.g.shape)
    kept = VertexPlanes.of(domain, admissible.sides.planes)
    noise[kept.vertices] = kept.nearest(noise[kept.vertices], np.zeros(len(kept.places)))
    monkeypatch.setattr(mirror_galerkin, "_MOST_STEPS", 25)
    settled = galerkin.run(load, surface.g + noise)
    assert np.linalg.norm(settled - surface.g) < 0.01 * np.linalg.norm(noise)
    monkeypatch.setattr(mirror_galerkin, "_MOST_STEPS", 500)
    assert np.array_equal(settled, galerkin.run(load, surface.g + noise)), "it ends by its residual, not by the limit"
