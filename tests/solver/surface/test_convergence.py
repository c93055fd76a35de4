"""Paper, Section 6: how H and the distortion converge on the discs of Figure 3, normals on vertices and on faces."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.spatial import KDTree

from solver import Domain, conditions, shapes, solve_cmc
from tests.solver.exact_surfaces import disc, moved, rates
from tests.solver.surface_errors import errors_of

KINDS = [
    ("vertices", "cotan"),
    ("faces", "dual_cotan"),
    ("faces", "mobius"),
    ("faces_and_rim", "dual_cotan"),
    ("faces_and_rim", "mobius"),
]
IDS = [f"{energy} on {sites}" for sites, energy in KINDS]
SIZES = (600, 2400, 9600)


@cache
def one_of_the_solutions(m):
    """Normals at the vertices of a disc, from which all solves start: for m >= 2 there are several harmonic maps."""
    plan = shapes.disc(2400)
    rim = conditions.twisted(plan.domain, plan.positions, plan.sides["outer"], m)
    return KDTree(plan.positions), solve_cmc(plan.domain, rim).harmonic.normals


def solved(domain, points, m, sites, energy, **options):
    """The surface of Figure 3 for m turns, from the common start."""
    tree, normals = one_of_the_solutions(m)
    middles = points[domain.faces].mean(axis=1), points[domain.edges[domain.boundary_edges]].mean(axis=1)
    places = {"vertices": points, "faces": middles[0], "faces_and_rim": np.concatenate(middles)}[sites]
    start = normals[tree.query(places)[1]] if not options.get("delaunay") else None
    rim = conditions.twisted(domain, points, domain.boundary_edges, m)
    return solve_cmc(domain, rim, sites=sites, energy=energy, initial=start, **options)


def immersed_sheet(surface, m):
    """For m = 2 there are two mirror images of one map; f+ of one is f- of the other, and pinches at the rim."""
    return "f-" if m == 2 and surface.harmonic.degree > 0 else "f+"


def measured(make, m, sites, energy, sizes=SIZES, **options):
    surfaces = [solved(*make(n), m, sites, energy, **options) for n in sizes]
    return [errors_of(surface, immersed_sheet(surface, m)) for surface in surfaces]


@pytest.mark.parametrize("m", [1, 2, 3])
@pytest.mark.parametrize(("sites", "energy"), KINDS, ids=IDS)
def test_errors_converge_on_discs(sites, energy, m):
    found = measured(lambda n: disc(n, jitter=0.0), m, sites, energy)
    assert rates([e.l2 for e in found]).min() > 0.9
    assert rates([e.linf for e in found]).mean() > 0.9
    assert rates([e.distortion for e in found]).mean() > 1.8


def jittered_but_at_the_rim(n):
    """The disc with points moved that are two rows and more from the rim."""
    plan = shapes.disc(n)
    step = plan.domain.edge_lengths.mean()
    inside = np.linalg.norm(plan.positions, axis=1) < 1 - 2.5 * step
    points = moved(plan.positions, inside, 0.2 * step, seed=1)
    return Domain.from_positions(points, plan.domain.faces), points


@pytest.mark.parametrize(("sites", "energy"), KINDS, ids=IDS)
def test_errors_converge_on_irregular_delaunay_meshes(sites, energy):
    found = measured(jittered_but_at_the_rim, 1, sites, energy, delaunay=True)
    assert rates([e.l2 for e in found]).min() > 0.9
    assert rates([e.linf for e in found]).mean() > 0.8
    assert rates([e.distortion for e in found]).mean() > 1.8


def irregular(n):
    return disc(n, jitter=0.2)


@pytest.mark.parametrize("energy", ["dual_cotan", "mobius"])
def test_errors_converge_at_irregular_rims_where_conditions_hold_on_the_rim(energy):
    found = measured(irregular, 1, "faces_and_rim", energy, delaunay=True)
    assert rates([e.l2 for e in found]).min() > 0.9
    assert rates([e.linf for e in found]).mean() > 0.8
    assert rates([e.distortion for e in found]).mean() > 1.8


def test_curvature_does_not_converge_at_irregular_rims_where_conditions_hold_on_faces():
    """A face takes the normal of its boundary edge half a triangle inside, which is rough on such rims."""
    found = measured(irregular, 1, "faces", "mobius", delaunay=True)
    assert min(e.linf for e in found) > 0.5


def test_mobius_does_not_converge_where_edges_are_not_delaunay():
    """Its star is |w*| there, which is no Laplacian."""
    found = measured(jittered_but_at_the_rim, 1, "faces", "mobius", sizes=(300, 1200))
    assert rates([e.l2 for e in found])[0] < 0.5 and found[-1].l2 > 0.02


def test_dual_cotangents_are_lost_where_edges_are_not_delaunay():
    """Weights of both signs: the energy falls to less than nothing, far from any surface."""
    surface = solved(*jittered_but_at_the_rim(200), 1, "faces", "dual_cotan")
    assert surface.harmonic.energy < 0.0 and errors_of(surface).l2 > 0.1
