"""Sites, energy, method, triangulation: settings that fit each other, and solves that keep them apart."""

from __future__ import annotations

import json
import sys

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from .scenes import activate, add_group, boundary_edges, jittered, mesh_object, positions, snapshot

CHOICE = ("sites", "energy", "method", "delaunay", "combinatorics")


def solve(plan, **settings) -> np.ndarray:
    activate(plan)
    assert bpy.ops.cmc.solve(**settings) == {"FINISHED"}
    return positions(plan.cmc.f_plus)


def choice(owner) -> tuple:
    return tuple(getattr(owner, name) for name in CHOICE)


@pytest.fixture
def plan():
    """Well-shaped triangles, as Mesh Plan makes them."""
    bpy.ops.mesh.primitive_circle_add(vertices=40, radius=4.0, fill_type="NGON")
    bpy.ops.cmc.mesh_plan(edge_length=0.5)
    plan = bpy.context.object
    plan.name = "Disc"
    add_group(plan, "Tilted", boundary_edges(plan.data), "BINORMAL", tilt=0.5)
    return plan


def registries(addon) -> dict:
    from cmc_formfinding.solver.domain.sites import SITES
    from cmc_formfinding.solver.gauss.energies import ENERGIES
    from cmc_formfinding.solver.gauss.methods import METHODS
    from cmc_formfinding.solver.surface.cmc_surface import COMBINATORICS

    return {"sites": SITES, "energy": ENERGIES, "method": METHODS, "combinatorics": COMBINATORICS}


def test_choices_are_the_solvers(addon, plan):
    """Identifiers, labels and descriptions; all there are."""
    for name, registry in registries(addon).items():
        items = plan.cmc.bl_rna.properties[name].enum_items
        assert [item.identifier for item in items] == [key.upper() for key in registry]
        assert all(item.name and item.description for item in items)
        assert items[0].identifier == plan.cmc.bl_rna.properties[name].default


# --- an energy that fits the sites ---------------------------------------------------------

def test_the_energy_follows_the_sites(plan):
    plan.cmc.sites = "FACES"
    assert plan.cmc.energy == "DUAL_COTAN"
    plan.cmc.energy = "SHELL"
    plan.cmc.sites = "FACES"
    assert plan.cmc.energy == "SHELL"
    plan.cmc.sites = "VERTICES"
    assert plan.cmc.energy == "COTAN"


@pytest.mark.parametrize(("given", "used"), [
    ({"sites": "FACES"}, ("FACES", "MOBIUS")),
    ({"sites": "FACES", "energy": "COTAN"}, ("FACES", "DUAL_COTAN")),
    ({"sites": "FACES", "energy": "TAN"}, ("FACES", "TAN")),
    ({"energy": "SHELL"}, ("FACES", "SHELL")),
    ({"sites": "VERTICES"}, ("VERTICES", "COTAN")),
])
def test_what_a_call_says_goes_before_what_is_stored(plan, given, used):
    plan.cmc.sites, plan.cmc.energy = "FACES", "MOBIUS"
    solve(plan, **given)
    assert (plan.cmc.sites, plan.cmc.energy) == used


@pytest.mark.parametrize("given", [
    {"energy": "MOBIUS"}, {"sites": "VERTICES", "energy": "DUAL_COTAN"}])
def test_an_energy_that_does_not_fit_is_refused(plan, given):
    solve(plan)
    before = snapshot()
    with pytest.raises(RuntimeError, match="is not defined for normals on vertices; choose Cotangent, or other sites"):
        bpy.ops.cmc.solve(**given)
    assert snapshot() == before


def test_flip_keeps_the_choice(plan):
    solve(plan, sites="FACES", energy="MOBIUS", combinatorics="DUAL")
    before = choice(plan.cmc)
    assert bpy.ops.cmc.flip() == {"FINISHED"}
    assert choice(plan.cmc) == before


# --- solves --------------------------------------------------------------------------------

@pytest.mark.parametrize("energy", ["DUAL_COTAN", "MOBIUS", "SHELL", "TAN"])
def test_every_energy_gives_nearly_the_same_shell(plan, energy):
    """On a plan of good triangles they differ by less than an edge: the normals of the rim are half of one inside."""
    expected = solve(plan)
    points = solve(plan, sites="FACES", energy=energy)
    assert json.loads(plan.cmc.report)["converged"]
    assert points.shape == expected.shape
    assert 1e-3 < np.abs(points - expected).max() < 0.7


@pytest.mark.parametrize("method", ["FLOW", "GAUSS_SEIDEL", "LAGRANGE"])
def test_every_method_gives_the_same_shell(plan, method):
    expected = solve(plan)
    steps = json.loads(plan.cmc.report)["iterations"]
    assert_allclose(solve(plan, method=method), expected, rtol=0, atol=1e-3)
    report = json.loads(plan.cmc.report)
    assert report["converged"] and report["iterations"] != steps


def poor_plan() -> bpy.types.Object:
    """A square of thin triangles: a column of vertices is pushed to the next one."""
    n = 12
    x, y = np.meshgrid(np.linspace(-3, 3, n + 1), np.linspace(-3, 3, n + 1))
    inside = (np.abs(x) < 2.9) & (np.abs(y) < 2.9)
    x = np.where(inside, x + 0.22 * np.where(np.arange(n + 1) % 2, 1, -1), x)
    index = np.arange(x.size).reshape(x.shape)
    faces = []
    for j in range(n):
        for i in range(n):
            a, b, c, d = index[j, i], index[j, i + 1], index[j + 1, i + 1], index[j + 1, i]
            faces += [(a, b, c), (a, c, d)] if (i + j) % 2 else [(a, b, d), (b, c, d)]
    return jittered(mesh_object("Poor", np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]), faces), 0.02)


@pytest.mark.parametrize(("sites", "energy", "most"), [("VERTICES", "COTAN", 0.5), ("FACES", "MOBIUS", 2.5)])
def test_other_triangles_below_the_same_faces(sites, energy, most):
    plan = poor_plan()
    add_group(plan, "Tilted", boundary_edges(plan.data), "BINORMAL", tilt=0.8)
    mine = solve(plan, sites=sites, energy=energy)
    faces = [tuple(p.vertices) for p in plan.cmc.f_plus.data.polygons]
    delaunay = solve(plan, delaunay=True)
    assert (plan.cmc.sites, plan.cmc.energy) == (sites, energy)
    assert [tuple(p.vertices) for p in plan.cmc.f_plus.data.polygons] == faces
    assert faces == [tuple(p.vertices) for p in plan.data.polygons]
    assert 1e-4 < np.abs(mine - delaunay).max() < most


def test_without_libigl(addon, monkeypatch):
    """The same shell, by our own flips, and no word about it: the plan is small."""
    plan = poor_plan()
    with_libigl = solve(plan, delaunay=True)
    addon.cmc_addon.background.plan_cache.forget()
    monkeypatch.setitem(sys.modules, "igl", None)  # what makes an import fail
    assert_allclose(solve(plan, delaunay=True), with_libigl, rtol=0, atol=1e-5)
    assert "libigl" not in plan.cmc.report


# --- what is kept between solves -----------------------------------------------------------

def test_solvers_of_different_choices_are_kept_apart(addon, plan, monkeypatch):
    """Each is made once and found again; the plan's triangles and domain serve all."""
    plan_cache = addon.cmc_addon.background.plan_cache
    made, real = [], plan_cache.CmcSolver

    def make(domain, **kind):
        made.append((domain, tuple(kind.values())))
        return real(domain, **kind)

    monkeypatch.setattr(plan_cache, "CmcSolver", make)
    plan_cache.forget()
    first = solve(plan)
    faces = solve(plan, sites="FACES", energy="DUAL_COTAN")
    mobius = solve(plan, energy="MOBIUS")
    assert [kind for _, kind in made] == [
        ("vertices", "cotan", False), ("faces", "dual_cotan", False), ("faces", "mobius", False)]
    assert len({id(domain) for domain, _ in made}) == 1
    assert_array_equal(solve(plan, sites="FACES", energy="COTAN"), faces)
    assert_array_equal(solve(plan, sites="VERTICES"), first)
    assert_array_equal(solve(plan, sites="FACES", energy="MOBIUS"), mobius)
    assert len(made) == 3


# --- files ---------------------------------------------------------------------------------

def test_settings_are_saved(plan, tmp_path):
    solve(plan, sites="FACES", energy="TAN", method="FLOW", delaunay=True, combinatorics="CORNER")
    before = choice(plan.cmc)
    faces = len(plan.cmc.f_plus.data.polygons)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "plan.blend"))
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "plan.blend"))
    plan = bpy.data.objects["Disc"]
    assert choice(plan.cmc) == before == ("FACES", "TAN", "FLOW", True, "CORNER")
    assert len(plan.cmc.f_plus.data.polygons) == faces
    points = positions(plan.cmc.f_plus)
    assert_allclose(solve(plan), points, rtol=0, atol=1e-4)


def test_the_report_is_of_the_triangles(plan):
    solve(plan)
    drawn = json.loads(plan.cmc.report)
    solve(plan, combinatorics="DUAL")
    made = json.loads(plan.cmc.report)
    assert made.pop("made") != drawn.pop("made"), "at another time, with another setting"
    assert made == drawn
