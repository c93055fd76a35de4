"""Shapes and sides by name in place of domains and edges, degrees refused, short texts, solvers pickled and copied."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import ConditionError, Conditions, Domain, HarmonicSolver, Status, conditions, modes_of, shapes
from solver.gauss.conditions import build

E_X, E_Y, E_Z = np.eye(3)


@pytest.fixture
def strip():
    return shapes.strip(2.0, 1.0, 12)


def assert_same(first: Conditions, second: Conditions) -> None:
    for name, values in vars(first).items():
        assert_array_equal(values, vars(second)[name], err_msg=name)


PARAMETERS = {"binormal": {"tilt": 0.3}, "twisted": {"m": 2}, "gauss_map": {}}


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_shape_brings_domain_positions_and_sides(strip, name):
    make, named = getattr(conditions, name), PARAMETERS[name]
    top = strip.sides["top"]
    given = make(strip.domain, strip.positions, top, *named.values())
    for same in (
        make(strip, strip.positions, "top", *named.values()),
        make(strip, None, top, **named),
        make(strip, top, **named),
        make(strip, "top", **named),
        make(strip, "top", *named.values()),
        make(strip, edges=["top"], **named),
    ):
        assert_same(same, given)


def test_conditions_without_positions_take_a_shape(strip):
    edges = np.concatenate([strip.sides["left"], strip.sides["right"]])
    for make in (
        lambda *at: conditions.fixed(*at, E_Z),
        lambda *at: conditions.mirror(*at, E_X),
        conditions.free,
    ):
        assert_same(make(strip, ["left", "right"]), make(strip.domain, edges))
    assert_same(conditions.fixed_at(strip, [0], E_Z), conditions.fixed_at(strip.domain, [0], E_Z))
    assert_same(conditions.fixed_at_faces(strip, [0], E_Z), conditions.fixed_at_faces(strip.domain, [0], E_Z))
    assert_same(conditions.corner(strip, [0], E_Z), conditions.corner(strip.domain, [0], E_Z))
    torus = shapes.torus(1.0, 1.0, 6)
    assert conditions.balanced(torus).is_balanced
    assert_same(build("plane", strip, edges="top"), conditions.fixed(strip, "top", E_Z))
    assert_same(build("binormal", strip, None, "top", tilt=0.3), conditions.binormal(strip, "top", 0.3))


def test_an_edge_on_two_named_sides_counts_once(strip):
    assert_array_equal(conditions.fixed(strip, ["top", "outer", "top"], E_Z).edges[:12], strip.sides["top"])
    assert len(conditions.fixed(strip, ["top", "outer"], E_Z).edges) == len(strip.sides["outer"])


@pytest.mark.parametrize(
    ("edges", "words"),
    [
        ("botom", r'no side "botom"; did you mean "bottom"\?'),
        (["top", "z"], r'no side "z"; known are bottom, right, top, left, outer\.$'),
    ],
)
def test_a_misspelt_side_lists_the_sides(strip, edges, words):
    with pytest.raises(ConditionError, match=words):
        conditions.binormal(strip, edges, tilt=0.3)


def test_what_a_bare_domain_lacks(strip):
    with pytest.raises(ConditionError, match="A Domain has no side 'top'; pass the Shape"):
        conditions.fixed(strip.domain, "top", E_Z)
    with pytest.raises(ConditionError, match="A Domain has no positions"):
        conditions.binormal(strip.domain, edges=[0])
    with pytest.raises(ConditionError, match="The edges are missing"):
        conditions.gauss_map(strip)
    with pytest.raises(ConditionError, match="needs m, the number of turns"):
        conditions.twisted(strip, "top")


def test_degrees_are_refused(strip):
    with pytest.raises(ConditionError, match=r"tilt 35 .* radians. For 35° write np\.radians\(35\)"):
        conditions.binormal(strip, "top", tilt=35)
    with pytest.raises(ConditionError, match="tilt -20"):
        conditions.binormal(strip, "top", tilt=np.linspace(-20, 3, 12))
    conditions.binormal(strip, "top", tilt=[-np.pi, np.pi] * 6)


def test_a_solver_takes_a_shape_and_its_result_speaks():
    disc = shapes.disc(100)
    rim = conditions.binormal(disc, "outer", tilt=0.3)
    harmonic = HarmonicSolver(disc).solve(rim)
    assert harmonic.ok and harmonic.message == Status.CONVERGED.sentence
    assert repr(harmonic).startswith("HarmonicMap(91 normals, energy 4.") and "converged after" in repr(harmonic)
    stopped = HarmonicSolver(disc).solve(rim, max_iterations=0)
    assert not stopped.ok and stopped.message == Status.ITERATION_LIMIT.sentence
    assert "array" not in repr(harmonic)
    solver = HarmonicSolver(disc)
    modes = modes_of(solver, rim, harmonic.normals)
    assert modes.ok and modes.message == "Index 0, nullity 0." and repr(modes).startswith("Modes(index 0, nullity 0, ")
    rough = modes_of(solver, rim, stopped.normals)
    assert not rough.ok and "not critical" in rough.message


def test_conditions_count_what_they_hold(strip):
    assert repr(Conditions()) == "Conditions(free)"
    both = conditions.binormal(strip, "top") + conditions.mirror(strip, ["left", "right"], E_X)
    sides = len(strip.sides["left"]) + len(strip.sides["right"])
    assert repr(both) == f"Conditions(12 fixed edges, {sides} mirror edges)"
    assert repr(conditions.fixed_at(strip, [0, 1], E_Z)) == "Conditions(2 fixed vertices)"


def pickled(value):
    return pickle.loads(pickle.dumps(value))


@pytest.mark.parametrize("duplicate", [pickled, copy.deepcopy])
@pytest.mark.parametrize(("sites", "energy"), [("vertices", "cotan"), ("faces", "mobius")])
def test_a_used_solver_can_be_copied(duplicate, sites, energy):
    disc = shapes.disc(300)
    first, second = conditions.binormal(disc, "outer", tilt=0.3), conditions.binormal(disc, "outer", tilt=0.5)
    solver = HarmonicSolver(disc, sites, energy)
    used = solver.solve(first)
    again = duplicate(solver)
    assert_allclose(again.solve(first).normals, used.normals, rtol=0, atol=1e-12)
    assert_allclose(again.solve(second).normals, solver.solve(second).normals, rtol=0, atol=1e-12)
    copied = duplicate(used)
    assert_array_equal(copied.normals, used.normals)
    assert copied.status is used.status


@pytest.mark.parametrize("duplicate", [pickled, copy.deepcopy])
def test_a_solver_with_reused_factors_can_be_copied(duplicate):
    disc = shapes.disc(300)
    rim = conditions.binormal(disc, "outer", tilt=0.3)
    solver = HarmonicSolver(disc)
    solver.solve(rim)
    moved = solver.moved(disc.domain.with_lengths(1.001 * disc.domain.edge_lengths))
    again = duplicate(moved)
    normals = moved.solve(rim).normals
    assert_allclose(again.solve(rim).normals, normals, rtol=0, atol=1e-12)
    assert_allclose(duplicate(moved).solve(rim).normals, normals, rtol=0, atol=1e-12)


def test_a_copied_domain_is_the_same_domain():
    domain = shapes.disc(100).domain
    _ = domain.boundary_loops, domain.laplacian
    for other in (pickled(domain), copy.deepcopy(domain)):
        assert isinstance(other, Domain)
        assert_array_equal(other.edges, domain.edges)
        assert_array_equal(other.edge_lengths, domain.edge_lengths)
