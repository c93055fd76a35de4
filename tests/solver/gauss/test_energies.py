"""Edge energies: derivatives, both ends of their range, and the Möbius energy of surfaces (Appendix A)."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ConditionError, Domain
from solver.domain.sites import SITES, SiteGraph
from solver.gauss.energies import ENERGIES, energy_on
from tests.solver import meshes

MOBIUS = ENERGIES["mobius"]
ON_FACES = [name for name, energy in ENERGIES.items() if "faces" in energy.sites]
# Opposite angles θ_k, θ_l: of Delaunay edges, of others, of halves of rectangles and of almost such, of slivers.
ANGLES = np.array(
    [
        [1.0, 0.9], [0.7, 0.7], [0.3, 2.2], [0.02, 0.03],
        [2.0, 1.6], [3.1, 0.1], [1.7, 1.7],
        [1.2, np.pi - 1.2 - 1e-2], [1.2, np.pi - 1.2 + 1e-2],
    ]
)  # fmt: skip
COCIRCULAR = np.array([[np.pi / 2, np.pi / 2], [1.2, np.pi - 1.2], [0.1, np.pi - 0.1]])
COSINES = np.array([1.0, 1.0 - 1e-9, 1.0 - 1e-4, 0.9, 0.3, 0.0, -0.5, -0.9, -1.0 + 1e-4])


def links(angles, name="mobius"):
    """Links (K,) with the weights that an edge with these opposite angles has."""
    w = 0.5 * np.sum(1.0 / np.tan(angles), axis=1)
    return SimpleNamespace(angles=angles, weights=w if name == "cotan" else 1.0 / w)


def all_pairs(name, angles=ANGLES):
    """Every cosine with every pair of angles."""
    return np.repeat(COSINES, len(angles)), links(np.tile(angles, (len(COSINES), 1)), name)


def room(name, c, at):
    """How far c (K,) is from c = -1, and from the next singularity of the Möbius energy: where β = 0 or π."""
    if name != "mobius":
        return 1.0 + c
    k, ell = at.angles.T
    p = np.sin(k) * np.sin(ell)
    below, above = 1.0 - np.cos(k - ell) + p * (1 + c), 1.0 - np.cos(k + ell - np.pi) + p * (1 - c)
    return np.minimum(np.minimum(below, above) / p, 1.0 + c)


def slope(function, c, step):
    """Derivatives by differences of sixth order; to one side where c + 3 step would be more than 1."""
    result = np.zeros_like(c)
    for offsets, where in ((np.arange(-3, 4), c + 3 * step <= 1.0), (np.arange(-6, 1), c + 3 * step > 1.0)):
        right = np.zeros(7)
        right[1] = 1.0
        weights = np.linalg.solve(offsets[None, :] ** np.arange(7.0)[:, None], right)
        values = [function(c + offset * step) for offset in offsets]
        result = np.where(where, np.einsum("o,ok->k", weights, values) / step, result)
    return result


@pytest.mark.parametrize("name", ENERGIES)
def test_star_and_its_derivative_agree_with_differences(name):
    """Away from c = ±1, at c = 1, near -1; on Delaunay edges, on others (negative weights) and on slivers."""
    energy = ENERGIES[name]
    c, at = all_pairs(name)
    step = 0.02 * room(name, c, at)
    star, dstar = energy.star(c, at), energy.dstar(c, at)
    assert_allclose(star, -slope(lambda x: energy.value(x, at), c, step), rtol=1e-7, atol=0)
    scale = np.abs(star) / room(name, c, at)  # dstar of the cotangent energies is zero
    assert_allclose(dstar / scale, slope(lambda x: energy.star(x, at), c, step) / scale, rtol=1e-7, atol=1e-9)


def test_mobius_on_cocircular_edges_agrees_with_differences():
    """Inside the smoothed range, t = 1 - cos β < t₀ of β₀ = 1e-4, and outside of it."""
    t0 = 1.0 - np.cos(1e-4)
    for parts, step in ((np.array([0.3, 0.5, 0.8]), 0.02), (np.array([1.5, 10.0, 1e4]), 0.05)):
        at = links(np.repeat(COCIRCULAR, 3, axis=0))
        p = np.sin(at.angles[:, 0]) ** 2
        part = np.tile(parts, 3)
        c, h = 1.0 - part * t0 / p, step * np.minimum(part, 1.0 if step == 0.05 else part) * t0 / p
        # p (1 - c) is known to 1e-16 / t₀ = 2e-8 of itself only, so this is as far as differences reach
        assert_allclose(MOBIUS.star(c, at), -slope(lambda x: MOBIUS.value(x, at), c, h), rtol=2e-6, atol=0)  # noqa: B023
        assert_allclose(MOBIUS.dstar(c, at), slope(lambda x: MOBIUS.star(x, at), c, h), rtol=2e-6, atol=0)  # noqa: B023


def test_mobius_is_smooth_where_the_smoothing_ends():
    t0 = 1.0 - np.cos(1e-4)
    at = links(COCIRCULAR)
    edge = 1.0 - t0 / np.sin(COCIRCULAR[:, 0]) ** 2
    for method, rtol in ((MOBIUS.value, 1e-6), (MOBIUS.star, 1e-6), (MOBIUS.dstar, 1e-5)):
        inside, outside = method(edge + 1e-7 * (1 - edge), at), method(edge - 1e-7 * (1 - edge), at)
        assert_allclose(inside, outside, rtol=rtol, atol=1e-14)


def test_mobius_is_defined_on_cocircular_edges_where_normals_agree():
    at = links(COCIRCULAR)
    one = np.ones(len(COCIRCULAR))
    assert_allclose(MOBIUS.value(one, at), 0.0, rtol=0, atol=1e-15)
    assert np.isfinite(MOBIUS.star(one, at)).all()
    assert (MOBIUS.star(one, at) > 1e3 * np.sin(COCIRCULAR[:, 0]) ** 2).all()
    assert np.isfinite(MOBIUS.dstar(one, at)).all()


@pytest.mark.parametrize("name", ENERGIES)
def test_stars_are_those_of_the_paper(name):
    """ε'(α) / sin α with the derivatives as printed (Sec. 4.1, Eq. 16), away from the ends."""
    alpha = np.repeat([0.2, 1.0, 2.0, 3.0], len(ANGLES))
    at = links(np.tile(ANGLES, (4, 1)), name)
    k, ell = at.angles.T
    w = at.weights
    beta = np.arccos(np.sin(k) * np.sin(ell) * np.cos(alpha) - np.cos(k) * np.cos(ell))
    printed = {
        "cotan": w * np.sin(alpha),
        "dual_cotan": w * np.sin(alpha),
        "mobius": 2.0 * np.sin(k) * np.sin(ell) / np.sin(beta) * np.sin(alpha),
        "shell": w * alpha,
        "tan": 2.0 * w * np.tan(alpha / 2),
    }
    assert_allclose(ENERGIES[name].star(np.cos(alpha), at), printed[name] / np.sin(alpha), rtol=1e-10, atol=0)


@pytest.mark.parametrize("name", ENERGIES)
def test_values_are_the_dirichlet_energy_to_second_order(name):
    """½ w α² + o(α²) on Delaunay edges: Proposition A.1, and the same for every energy."""
    at = links(ANGLES[:4], name)
    for alpha in (1e-2, 1e-3):
        ratio = ENERGIES[name].value(np.full(4, np.cos(alpha)), at) / (0.5 * at.weights * alpha**2)
        assert_allclose(ratio, 1.0, rtol=0, atol=10 * alpha)


@pytest.mark.parametrize("name", ["shell", "tan", "mobius"])
def test_energies_that_diverge_at_opposite_normals_are_infinite(name):
    """Shell and tan everywhere, Möbius where the two angles are equal; no warning, no nan."""
    c = np.array([-1.0])
    equal, unequal = links(np.array([[0.7, 0.7]])), links(np.array([[0.7, 0.9]]))
    assert np.isposinf(ENERGIES[name].value(c, equal)) and np.isposinf(ENERGIES[name].star(c, equal))
    assert np.isfinite(MOBIUS.value(c, unequal)) and np.isfinite(MOBIUS.star(c, unequal))


def test_mobius_is_positive_on_every_edge():
    """Its star is; its value is zero at c = 1 on Delaunay edges and 4 (θ_k + θ_l - π) on others (footnote 5)."""
    random = np.random.default_rng(1)
    angles = random.uniform(0.01, np.pi - 0.01, (5000, 2))
    at, one = links(angles), np.ones(5000)
    assert (MOBIUS.star(random.uniform(-1, 1, 5000), at) > 0).all()
    assert (MOBIUS.value(random.uniform(-1, 1, 5000), at) > -1e-14).all()
    assert_allclose(MOBIUS.value(one, at), np.maximum(0.0, 4 * (angles.sum(axis=1) - np.pi)), rtol=1e-11, atol=1e-14)


# --- on meshes -----------------------------------------------------------------------------

CLOSED = {
    "sphere": lambda: meshes.sphere(300, jitter=0.3),
    "twisted sphere": lambda: twisted_sphere(400, 8.0),
    "torus": lambda: meshes.torus(22, 11),
    "genus two": lambda: meshes.genus_two(),
}


def twisted_sphere(n, stretch):
    points, faces = meshes.sphere(n, jitter=0.2)
    return meshes.twisted(points, stretch), faces


def on_faces(points, faces):
    """The graph of the faces of a closed mesh, and the cosines of its own bending angles."""
    graph = SiteGraph.of(Domain.from_positions(points, faces), "faces")
    N = meshes.face_normals(points, graph.domain.faces)
    return graph, N, np.einsum("ij,ij->i", *N[graph.links.T])


@pytest.mark.parametrize("mesh", CLOSED)
def test_mobius_star_is_the_dual_weight_where_normals_agree(mesh):
    """Proposition A.1; on edges that are not Delaunay it is its absolute value."""
    graph, _, _ = on_faces(*CLOSED[mesh]())
    star = MOBIUS.star(np.ones(len(graph.links)), graph)
    assert_allclose(star, np.abs(graph.weights), rtol=1e-9, atol=0)
    delaunay = graph.angles.sum(axis=1) < np.pi
    assert_allclose(star[delaunay], graph.weights[delaunay], rtol=1e-9, atol=0)
    assert mesh == "sphere" or 0 < np.count_nonzero(~delaunay) < len(delaunay)


def quaternion_product(p, q):
    """(K, 4) products of quaternions, the real part first."""
    a, u, b, v = p[:, :1], p[:, 1:], q[:, :1], q[:, 1:]
    real = a * b - np.sum(u * v, axis=1, keepdims=True)
    return np.concatenate([real, a * v + b * u + np.cross(u, v)], axis=1)


def intersection_angles(domain, points):
    """β of each edge of a closed mesh from the cross-ratio e_il e_lj e_jk e_ki = -cos β + sin β n of positions."""
    i, j = domain.edges.T
    left, right = domain.edge_faces.T
    k, ell = (domain.faces[f].sum(axis=1) - i - j for f in (left, right))
    product = None
    for a, b in ((i, ell), (ell, j), (j, k), (k, i)):
        along = points[b] - points[a]
        e = np.column_stack([np.zeros(len(along)), along / np.linalg.norm(along, axis=1, keepdims=True)])
        product = e if product is None else quaternion_product(product, e)
    return np.arctan2(np.linalg.norm(product[:, 1:], axis=1), -product[:, 0])


@pytest.mark.parametrize("mesh", CLOSED)
def test_mobius_energy_of_a_gauss_map_is_the_willmore_energy(mesh):
    """½ E = W + π χ (Proposition A.2), W = Σ_i ½ (Σ_j β_ij - 2π) from positions alone."""
    points, faces = CLOSED[mesh]()
    graph, _, c = on_faces(points, faces)
    willmore = np.sum(intersection_angles(graph.domain, points)) - np.pi * len(points)
    chi = {"torus": 0, "genus two": -2}.get(mesh, 2)
    assert graph.domain.euler_characteristic == chi
    assert_allclose(0.5 * MOBIUS.value(c, graph).sum(), willmore + np.pi * chi, rtol=0, atol=1e-9)
    assert willmore > 1.0 or mesh == "sphere"


def test_inscribed_delaunay_polyhedra_are_their_own_conjugates():
    """The face normals of a convex polyhedron on the unit sphere are Möbius harmonic, of energy 4π, and dg = df.

    (By the law of sines in the spherical triangle of two neighbouring normals and a vertex, star sin α is the edge.)
    """
    points, faces = meshes.sphere(300, jitter=0.3)
    graph, N, c = on_faces(points, faces)
    assert_allclose(MOBIUS.value(c, graph).sum(), 4 * np.pi, rtol=0, atol=1e-9)
    f, h = graph.links.T
    tau = MOBIUS.star(c, graph)[:, None] * np.cross(N[f], N[h])
    left, right = graph.cells.T
    assert_allclose(tau, points[left] - points[right], rtol=0, atol=1e-11)
    assert_allclose(graph.sums(tau), 0.0, rtol=0, atol=1e-11)


# --- the registry --------------------------------------------------------------------------


@pytest.mark.parametrize("name", ENERGIES)
def test_every_energy_has_a_label_a_description_and_sites(name):
    energy = ENERGIES[name]
    assert energy.label and energy.description and set(energy.sites) <= set(SITES)
    assert energy_on(name, energy.sites[0]) is energy


def test_cotan_on_faces_is_the_dual_one():
    assert energy_on("cotan", "faces") is ENERGIES["dual_cotan"]


@pytest.mark.parametrize("name", ON_FACES)
def test_energies_on_the_wrong_sites_are_refused(name):
    with pytest.raises(ConditionError, match="cotan"):
        energy_on(name, "vertices")
    with pytest.raises(ConditionError, match="mobius"):
        energy_on("nosuch", "faces")


def test_the_series_of_shell_ends_where_the_formula_begins():
    """Either side of α = 0.1 dstar is -(sin α - α cos α) / sin³ α."""
    angle = np.array([0.09, 0.0999, 0.1001, 0.11])
    at = SimpleNamespace(angles=np.full((4, 2), 1.0), weights=np.ones(4))
    expected = -(np.sin(angle) - angle * np.cos(angle)) / np.sin(angle) ** 3
    assert_allclose(ENERGIES["shell"].dstar(np.cos(angle), at), expected, rtol=1e-11, atol=0)
