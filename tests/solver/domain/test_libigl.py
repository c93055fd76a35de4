"""Delaunay triangulations by libigl and by our own flips: both agree; a note recommends libigl."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import Domain, conditions, shapes, solve_cmc
from solver.domain import delaunay
from solver.domain.delaunay import intrinsic_delaunay, speed_note
from solver.domain.flips import Flips
from solver.shells.form import form
from solver.shells.plan import Plan, Settings
from tests.solver.thin_domains import DOMAINS, opposite_angles, sheared_grid, stretched, stretched_faces


def as_list(domain: Domain) -> tuple[np.ndarray, np.ndarray]:
    """Edges by their vertices and lengths, in an order that no numbering changes."""
    pairs = np.sort(domain.edges, axis=1)
    order = np.lexsort((np.round(domain.edge_lengths, 9), *pairs.T))
    return pairs[order], domain.edge_lengths[order]


@pytest.mark.parametrize("name", ["a sheared grid", "needles", "two holes, stretched", "a twisted sphere"])
def test_our_flips_and_libigl_agree(name):
    domain = DOMAINS[name]()
    ours, theirs = as_list(Flips(domain).domain()), as_list(delaunay._flipped_by(delaunay._libigl(), domain))
    assert_array_equal(ours[0], theirs[0])
    assert_allclose(ours[1], theirs[1], rtol=1e-9, atol=0)


def test_libigl_does_what_it_can(monkeypatch):
    """Our flips, which are slow, run for coarse domains and for those with holes only."""
    monkeypatch.setattr(delaunay, "Flips", lambda domain: pytest.fail("libigl was not used"))
    for name in ("a sheared grid", "needles", "a twisted sphere"):
        assert intrinsic_delaunay(DOMAINS[name]()).flips is None


@pytest.mark.parametrize("name", ["a torus in space", "seven vertices", "a tube"])
def test_contradicting_tables_of_libigl_are_rejected(name):
    """On the way these have vertices with two edges only."""
    assert delaunay._flipped_by(delaunay._libigl(), DOMAINS[name]()) is None


@pytest.mark.parametrize(("sites", "energy"), [("vertices", "cotan"), ("faces", "mobius")])
def test_surfaces_of_both_ways_agree(sites, energy, request):
    """A disc of needles."""
    plan = shapes.disc(300)
    domain = Domain.from_positions(plan.positions, stretched_faces(plan.positions[:, :2], 15.0))
    rim = conditions.twisted(domain, plan.positions, domain.boundary_edges, 1)
    theirs = solve_cmc(domain, rim, sites=sites, energy=energy, delaunay=True, tolerance=1e-10)
    request.getfixturevalue("without_libigl")
    ours = solve_cmc(domain, rim, sites=sites, energy=energy, delaunay=True, tolerance=1e-10)
    assert np.degrees(domain.corner_angles.min()) < 2
    assert_allclose(ours.f_plus, theirs.f_plus, rtol=0, atol=1e-8)
    assert_array_equal(ours.faces, domain.faces)


def test_a_libigl_that_does_not_load_counts_as_missing(monkeypatch):
    """Such as a wheel for another system."""

    def broken(name):
        raise ImportError(f"{name}: wrong ELF class")

    monkeypatch.setattr(delaunay, "compiled", broken)
    new = intrinsic_delaunay(Domain.from_positions(*sheared_grid())).domain
    assert opposite_angles(new).max() <= np.pi + 1e-10


def test_a_note_recommends_libigl_for_large_meshes(monkeypatch, request):
    """No note where libigl would not help: on Delaunay meshes, around holes, on coarse domains."""
    needles, tidy = DOMAINS["needles"](), shapes.disc(300).domain
    monkeypatch.setattr(delaunay, "_LARGE", 18)
    assert speed_note(needles) is None
    request.getfixturevalue("without_libigl")
    assert "libigl is not installed" in speed_note(needles) and "pip install libigl" in speed_note(needles)
    assert speed_note(tidy) is None
    for name in ("two holes, stretched", "a torus of nine vertices", "a cylinder of three columns"):
        assert speed_note(DOMAINS[name]()) is None
    monkeypatch.setattr(delaunay, "_LARGE", len(needles.faces) + 1)
    assert speed_note(needles) is None


@pytest.mark.usefixtures("without_libigl")
def test_the_note_comes_with_the_shell(monkeypatch):
    points, faces = stretched(4.0, 150)
    plan = Plan(np.column_stack([points, 0 * points[:, 0]]), faces)
    chosen, usual = Settings(default_tilt=0.3, delaunay=True), Settings(default_tilt=0.3)
    notes = lambda settings: [note for note in form(plan, settings).warnings if "libigl" in note]  # noqa: E731
    assert notes(chosen) == []
    monkeypatch.setattr(delaunay, "_LARGE", 200)
    assert notes(chosen) == [speed_note(Domain.from_positions(points, faces))]
    assert notes(usual) == []
