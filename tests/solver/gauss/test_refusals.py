"""Bad input is refused with a message, and a failed solve has a status: on every kind of site."""

import numpy as np
import pytest

from solver import CmcSolver, ConditionError, HarmonicSolver, Status, conditions, shapes, solve_cmc
from solver.domain.sites import SITES, SiteGraph
from solver.gauss.energies import ENERGIES
from solver.gauss.methods import METHODS

DISC = shapes.disc(80)
TWISTED = conditions.twisted(DISC.domain, DISC.positions, DISC.domain.boundary_edges, 1)
ON_SITES = [(sites, name) for name, energy in ENERGIES.items() for sites in energy.sites]


@pytest.mark.parametrize("name", ["sites", "energy", "method", "averaging"])
@pytest.mark.parametrize("value", ["neither", None, 3, ["faces"], {}])
def test_unknown_names(name, value):
    with pytest.raises(ConditionError, match=r"There is no .*; (known are|did you mean) |must be a text"):
        solve_cmc(DISC.domain, TWISTED, **{name: value})


@pytest.mark.parametrize("arguments", [("f", "dual"), ([], "dual"), ("f+", None), ("g", ["corner"])])
def test_unknown_meshes(arguments):
    surface = solve_cmc(DISC.domain, TWISTED)
    with pytest.raises(ConditionError, match=r"There is no .*; (known are|did you mean) |must be a text"):
        surface.as_mesh(*arguments)


@pytest.mark.parametrize("name", ["tolerance", "mean_curvature", "period_tolerance", "degree", "max_iterations"])
@pytest.mark.parametrize("value", ["a", [1.0], np.nan])
def test_values_that_are_not_numbers(name, value):
    with pytest.raises(ConditionError, match="must be"):
        CmcSolver(DISC.domain).solve(TWISTED, **{name: value})


@pytest.mark.parametrize("value", [-1, -1e-3])
@pytest.mark.parametrize("name", ["tolerance", "mean_curvature", "period_tolerance", "max_iterations"])
def test_numbers_below_zero(name, value):
    with pytest.raises(ConditionError, match="must be"):
        CmcSolver(DISC.domain).solve(TWISTED, **{name: value})


@pytest.mark.parametrize("delaunay", [False, True])
@pytest.mark.parametrize("sites", SITES)
@pytest.mark.parametrize("other", [shapes.disc(60), shapes.disc(300), shapes.rectangle(2, 1, 5)])
def test_conditions_of_another_domain(sites, delaunay, other):
    with pytest.raises(ConditionError, match=r"not on the boundary of this domain|which this domain does not have"):
        solve_cmc(other.domain, TWISTED, sites=sites, delaunay=delaunay)


@pytest.mark.parametrize("sites", ["faces", "faces_and_rim"])
def test_faces_of_another_domain(sites):
    """A face beyond the last one is no site of the rim."""
    larger = shapes.disc(200).domain
    count = len(DISC.domain.faces)
    beyond = conditions.fixed_at_faces(larger, [count, count + 1], [0, 0, 1])
    for solver in (HarmonicSolver(DISC.domain, sites=sites), CmcSolver(DISC.domain, sites=sites)):
        with pytest.raises(ConditionError, match=f"faces {count}, {count + 1}, which this domain does not have"):
            solver.solve(TWISTED + beyond)


@pytest.mark.parametrize("sites", SITES)
def test_wound_starts_beside_free_edges_turn_around_a_site_inside(sites):
    """The site farthest from the held edges is on the free edge opposite, which nothing surrounds."""
    strip = shapes.strip(2.0, 1.0, 8)
    result = HarmonicSolver(strip.domain, sites=sites).solve(
        conditions.binormal(strip, "bottom", tilt=0.4), degree=1, max_iterations=0
    )
    assert np.allclose(np.linalg.norm(result.normals, axis=1), 1.0, rtol=0, atol=1e-12)
    assert abs(result.degree) > 0.3


@pytest.mark.parametrize("length", [1e-300, 1e-160, 1e20, 1e30])
def test_normals_of_any_length_are_made_unit(length):
    held = conditions.fixed(DISC, "outer", np.array([0.0, 0.6, 0.8]) * length)
    np.testing.assert_allclose(held.edge_normals, np.tile([0.0, 0.6, 0.8], (len(held.edges), 1)), rtol=1e-12)


def test_sites_inside_are_named():
    domain = DISC.domain
    behind = int(domain.edge_faces[domain.boundary_edges[0], 0])
    with pytest.raises(ConditionError, match=f"inside, at face {behind};") as error:
        solve_cmc(domain, conditions.fixed_at_faces(domain, [behind], [0, 0, 1]), sites="faces_and_rim")
    assert error.value.faces == (behind,)


@pytest.mark.parametrize("sites", SITES)
def test_an_initial_map_of_another_kind(sites):
    for other in SITES:
        graph = SiteGraph.of(DISC.domain, other)
        start = np.tile([0.0, 0.0, 1.0], (graph.count, 1))
        if other == sites:
            assert HarmonicSolver(DISC.domain, sites=sites).solve(TWISTED, start).status is Status.CONVERGED
            continue
        with pytest.raises(ConditionError, match="must have shape"):
            solve_cmc(DISC.domain, TWISTED, sites=sites, initial=start)


def test_a_normal_of_the_rim_goes_by_its_edge():
    domain = DISC.domain
    graph = SiteGraph.of(domain, "faces_and_rim")
    start = np.tile([0.0, 0.0, 1.0], (graph.count, 1))
    start[[2, -1]] = 0.0
    edge = int(domain.boundary_edges[-1])
    with pytest.raises(ConditionError, match=f"at face 2 and edge {edge}") as error:
        HarmonicSolver(domain, sites="faces_and_rim").solve(TWISTED, start)
    assert error.value.faces == (2,) and error.value.edges == (edge,)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("sites, energy", ON_SITES)
def test_opposite_normals_to_start_from(sites, energy, method):
    """Infinite energy has no descent direction; the result is finite, and its residual or status shows the failure."""
    solver = CmcSolver(DISC.domain, sites=sites, energy=energy)
    start = np.tile([0.0, 0.0, 1.0], (solver.harmonic.graph.count, 1))
    start[::2] *= -1.0
    surface = solver.solve(TWISTED, start, method=method, max_iterations=20)
    assert np.isfinite(surface.f_plus).all() and np.isfinite(surface.harmonic.normals).all()
    assert surface.harmonic.residual < np.inf or surface.status is Status.UNDER_RESOLVED


@pytest.mark.parametrize("sites", SITES)
@pytest.mark.parametrize("degree", [-3, -1, 2, 5])
def test_wound_starts_are_made_of_unit_normals(sites, degree):
    """Bubbles turn forwards or backwards around a site in the middle, where there is no angle to turn by."""
    conormals = conditions.binormal(DISC.domain, DISC.positions, DISC.domain.boundary_edges)
    result = HarmonicSolver(DISC.domain, sites=sites).solve(conormals, degree=degree, max_iterations=0)
    assert np.allclose(np.linalg.norm(result.normals, axis=1), 1.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("degree", [1000.0, -1000.0, 400.0])
def test_a_degree_that_no_map_of_the_mesh_has(degree):
    with pytest.raises(ConditionError, match=r"No map of this mesh has degree .*below \d+ here"):
        solve_cmc(DISC.domain, TWISTED, degree=degree)
