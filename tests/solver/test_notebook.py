"""What somebody sees who tries the library in a notebook: short results, names after a dot, first errors."""

from __future__ import annotations

import inspect

import numpy as np
import pytest
from numpy.testing import assert_allclose

import solver
from solver import (
    CmcSolver,
    ConditionError,
    Group,
    HarmonicSolver,
    MeshError,
    Plan,
    Settings,
    Side,
    close_periods,
    complete,
    conditions,
    fit_outline,
    form,
    hole,
    modules,
    principal_curvatures,
    read_plan,
    report,
    shapes,
    solve_cmc,
    vertex_principal_curvatures,
    wente,
    wente_height,
)

DISC = shapes.disc(100)
RIM = conditions.binormal(DISC, "outer", tilt=0.4)


@pytest.fixture(scope="module")
def surface():
    return solve_cmc(DISC, RIM)


def test_measures_solvers_moduli_and_groups_are_short(surface):
    measured = surface.f_plus, surface.faces, surface.normals
    ring = shapes.annulus(0.4, 1.0, 100)
    pairs = DISC.domain.edges[DISC.sides["outer"]]
    for shown, start in (
        (vertex_principal_curvatures(*measured), "VertexCurvatures(91 vertices, k1 0."),
        (principal_curvatures(*measured), "PrincipalCurvatures(150 faces, k1 0."),
        (CmcSolver(DISC), "CmcSolver(Domain(91 vertices, "),
        (HarmonicSolver(DISC, sites="faces"), "HarmonicSolver(Domain(91 vertices, "),
        (hole(ring, ring.positions, 1, ("x", "twist")), "Moduli(x -0.5 to 0.5, twist "),
        (Group("street", pairs, "binormal", {"tilt": 0.3}), "Group('street', 30 edges, binormal, tilt=0.3)"),
        (report(surface, intersections=False).shown, "SheetReport(f+: area "),
    ):
        assert repr(shown).startswith(start) and len(repr(shown)) < 120, repr(shown)


def test_curvatures_without_a_proper_face_have_a_repr():
    flat = principal_curvatures(np.zeros((3, 3)), [[0, 1, 2]], np.tile([0.0, 0.0, 1.0], (3, 1)))
    assert repr(flat) == "PrincipalCurvatures(1 faces, k1 nan, k2 nan)"


@pytest.mark.parametrize("module", [shapes, modules, conditions])
def test_after_the_dot_come_a_modules_own_names(module):
    own = {
        name
        for name, value in vars(module).items()
        if not name.startswith("_") and (inspect.isfunction(value) or inspect.isclass(value))
        if value.__module__ == module.__name__
    }
    assert own <= set(dir(module)) and not {"np", "annotations", "MeshError", "Array"} & set(dir(module))
    assert dir(module) == sorted(dir(module))


def test_form_takes_a_shape():
    shell = form(DISC, Settings(default_tilt=0.4))
    assert shell.ok
    assert_allclose(shell.points(), form(Plan.from_shape(DISC), Settings(default_tilt=0.4)).points())


@pytest.mark.parametrize("edges", ["outer", ["outer"], DISC.sides["outer"]])
def test_a_group_of_names_or_indices_names_the_way_out(edges):
    with pytest.raises(ConditionError, match=r'Group "street": .*vertex pairs.*Plan\.from_shape takes names'):
        Group("street", edges)


def test_a_side_of_names_names_the_way_out():
    with pytest.raises(ConditionError, match=r"Side 'a': .* not 'outer'; write shape\.sides\['outer'\]"):
        Side("a", "outer")


def test_a_module_is_told_from_a_domain():
    module = modules.node(3, 3.0, max_edge=0.5)
    for call in (
        lambda: conditions.mirror(module, "axis", [0, -1, 0]),  # type: ignore[arg-type]
        lambda: solve_cmc(module, RIM),  # type: ignore[arg-type]
    ):
        with pytest.raises(MeshError, match=r"not Module; pass its \.shape"):
            call()


def test_the_message_of_a_fit_that_worked_says_so():
    fitted = fit_outline(DISC.domain, DISC.positions, rise=0.3)
    assert fitted.ok and fitted.message == "The surface spans its lines."


def test_results_of_public_calls_are_public_types():
    """Each has a page in the reference, with what it can do."""
    for call in (solve_cmc, fit_outline, form, close_periods, complete, report, read_plan):
        assert inspect.signature(call).return_annotation.strip("'") in solver.__all__, call


@pytest.mark.parametrize(
    "call",
    [
        lambda: fit_outline(DISC.domain, DISC.positions, rise=0.3, tilt=(10, 60)),
        lambda: wente(120, 12),
        lambda: wente_height(90),
        lambda: conditions.binormal(DISC, "outer", tilt=20),
    ],
)
def test_degrees_in_place_of_radians_are_noticed_wherever_an_angle_goes(call):
    with pytest.raises(ConditionError, match=r"more than half a turn: angles are in radians.*write np\.radians\("):
        call()


@pytest.mark.parametrize("given", ["outer", None, DISC])
def test_anything_but_conditions_is_named(given):
    ring = shapes.annulus(0.4, 1.0, 100)
    for call in (
        lambda: solve_cmc(DISC, given),
        lambda: solve_cmc(DISC, given, delaunay=True),
        lambda: HarmonicSolver(DISC).solve(given),
        lambda: close_periods(ring, given),
    ):
        with pytest.raises(ConditionError, match=f"Conditions are needed here, not {type(given).__name__}; "):
            call()


def test_form_names_what_it_takes():
    with pytest.raises(MeshError, match="takes a Plan or a Shape, not Domain; read_plan"):
        form(DISC.domain)  # type: ignore[arg-type]
