"""Completions in a notebook: one line each, whether the copies meet, and copies of the object itself."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import Side, complete, conditions, modules, side_plane, solve_cmc, whole
from solver.io.mesh_files import read_mesh


@pytest.fixture(scope="module")
def completion():
    module = modules.node(3, 2.4, max_edge=0.4)
    held = conditions.Conditions()
    for name, edges in module.shape.sides.items():
        held += conditions.mirror(module.shape.domain, edges, module.normals[name])
    sides = [Side(name, edges, "mirror", module.normals[name]) for name, edges in module.shape.sides.items()]
    return complete(solve_cmc(module.shape, held), sides)


def test_results_are_one_line(completion):
    faces = 24 * len(completion.surface.faces)
    assert repr(completion) == f"Completion(24 copies of f+, {faces} faces, repeats by 2 translations)"
    assert repr(completion.mesh).endswith(f"{faces} faces, 24 copies)")
    joined = whole(completion)
    assert repr(joined).startswith("GluedMap(24 copies, Domain(") and joined.ok and "24 copies" in joined.message
    assert repr(completion.planes[0]).startswith("SidePlane(Side 'axis' (mirror) lies in the plane (0, -1, 0)")


def test_a_side_is_one_line(completion):
    shape = modules.node(3, 2.4, max_edge=0.4).shape
    count = len(shape.sides["end"])
    assert repr(Side("end", shape.sides["end"], "mirror", (1, 0, 0))) == (
        f"Side('end', mirror, {count} edges, normal (1, 0, 0))"
    )
    assert repr(Side("end", shape.sides["end"], "free")) == f"Side('end', free, {count} edges)"
    assert len(repr(side_plane(completion.surface, Side("end", shape.sides["end"])))) < 200


def test_a_completion_says_whether_its_copies_meet(completion):
    assert completion.ok
    start = f"24 copies with {completion.face_count} faces; before welding, neighbours were up to"
    assert completion.message.startswith(start)
    surface = completion.surface
    moved = surface.f_plus.copy()
    moved[completion.planes[0].cut_vertices] += 0.2
    torn = replace(completion, surface=replace(surface, f_plus=moved))
    assert not torn.ok and "Refine the mesh" in torn.message
    stopped = replace(surface.harmonic, status=type(surface.status).ITERATION_LIMIT)
    unfinished = replace(completion, surface=replace(surface, harmonic=stopped))
    assert not unfinished.ok and unfinished.message.startswith("The iteration limit comes")


def test_the_welded_mesh_goes_to_files_and_trimesh(completion, tmp_path):
    mesh = completion.mesh
    mesh.save(tmp_path / "honeycomb.obj")
    assert_allclose(read_mesh(tmp_path / "honeycomb.obj").positions, mesh.vertices, rtol=0.0, atol=1e-6)
    solid = mesh.to_trimesh()
    assert_array_equal(solid.faces, mesh.faces)
    assert (np.einsum("fi,fi->f", solid.face_normals, mesh.normals[mesh.faces].mean(axis=1)) > 0.0).mean() > 0.95


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_a_used_completion_can_be_copied(completion, duplicate):
    vertices = completion.mesh.vertices
    assert_array_equal(duplicate(completion).mesh.vertices, vertices)
