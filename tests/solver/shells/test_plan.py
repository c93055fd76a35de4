"""Plans from arrays, shapes and files."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import Group, Plan, Settings, form, read_plan, shapes
from solver.errors import ConditionError, JobError, MeshError
from solver.io.mesh_files import write_mesh
from solver.io.obj import MeshData
from solver.shells.plan import plan_domain


def test_positions_in_two_dimensions_are_at_height_zero():
    disc = shapes.disc(80)
    flat = Plan(disc.positions, disc.domain.faces)
    assert_array_equal(flat.positions, np.column_stack([disc.positions, np.zeros(len(disc.positions))]))
    assert_allclose(form(flat).placed["f+"], form(Plan(flat.positions, disc.domain.faces)).placed["f+"], atol=0)
    with pytest.raises(MeshError, match="positions of a plan must be numbers"):
        Plan([["a", "b"]], disc.domain.faces)


def test_a_shape_is_a_plan_with_groups_on_its_sides():
    strip = shapes.strip(2.0, 1.0, 8)
    plan = Plan.from_shape(strip, {"bottom": "mirror", "top": ("binormal", {"tilt": 0.3})})
    assert [(group.name, group.kind) for group in plan.groups] == [("bottom", "mirror"), ("top", "binormal")]
    assert_array_equal(plan.groups[1].edges, strip.domain.edges[strip.sides["top"]])
    assert not Plan.from_shape(strip).groups
    with pytest.raises(ConditionError, match='no side "botom"; did you mean "bottom"'):
        Plan.from_shape(strip, {"botom": "mirror"})
    with pytest.raises(ConditionError, match='no side "x"; known are bottom'):
        Plan.from_shape(strip, {"x": "mirror"})


def test_a_plan_is_read_with_the_groups_of_its_file(tmp_path):
    disc = shapes.disc(80)
    points = np.column_stack([5.0 * disc.positions, np.zeros(len(disc.positions))])
    rim = disc.domain.edges[disc.sides["outer"]]
    file = tmp_path / "plan.obj"
    write_mesh(file, MeshData(points, list(disc.domain.faces), edge_groups={"supports": rim[:6]}))
    plan = read_plan(file)
    assert_array_equal(plan.triangles, disc.domain.faces)
    assert [group.name for group in plan.groups] == ["supports"] and plan.groups[0].kind == "binormal"
    assert_array_equal(np.sort(plan.groups[0].edges), np.sort(rim[:6]))
    plan.groups = [Group("supports", plan.groups[0].edges, "plane", {"normal": (0.6, 0.0, 0.8)})]
    assert form(plan, Settings(default_tilt=0.4)).ok
    with pytest.raises(JobError, match="There is no file"):
        read_plan(tmp_path / "none.obj")


def test_quads_of_a_file_stay_polygons(tmp_path):
    x, y = np.meshgrid(np.arange(4.0), np.arange(4.0))
    points = np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()])
    quads = [np.array([k, k + 1, k + 5, k + 4]) for k in range(12) if k % 4 < 3]
    write_mesh(tmp_path / "grid.obj", MeshData(points, quads))
    plan = read_plan(tmp_path / "grid.obj")
    assert len(plan.polygons or ()) == 9 and len(plan.triangles) == 18 and plan_domain(plan).vertex_count == 16
