"""The shell as a library's object: short in print, saved and handed on, copied with its solver."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import Plan, Settings, fit_outline, form, shapes
from solver.errors import CmcError
from solver.io.mesh_files import read_mesh

PLAN = Plan.from_shape(shapes.disc(150), {"outer": ("binormal", {"tilt": 0.3})})


@pytest.fixture(scope="module")
def shell():
    return form(PLAN, Settings(size="span", value=8.0))


@pytest.fixture(scope="module")
def fit():
    disc = shapes.disc(150)
    return fit_outline(disc, disc.positions, rise=0.4)


def test_it_prints_in_a_line(shell, fit):
    assert repr(shell).startswith("Shell(f+: ") and "span 8" in repr(shell) and repr(shell).endswith("converged)")
    assert repr(fit).startswith("Fit(f+: ") and repr(fit).endswith("goals met)")
    assert len(repr(shell)) < 120 and len(repr(fit)) < 160 and "array" not in repr(shell) + repr(fit)
    assert repr(PLAN) == "Plan(169 vertices, 294 triangles, groups: outer: binormal)"
    assert repr(Settings(size="span", value=8.0)) == "Settings(size='span', value=8.0)"


def test_in_a_notebook(shell, fit):
    assert "span, rise" in shell._repr_html_() and "<table>" in shell._repr_html_()
    assert "rim on curve" in fit._repr_html_()


def test_one_way_to_ask(shell, fit):
    assert shell.ok and shell.message and fit.ok and fit.message
    cancelled = form(PLAN, progress=lambda step, residual: False)
    assert not cancelled.ok and "cancelled" in cancelled.message


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".glb"])
def test_it_is_saved(shell, fit, tmp_path, suffix):
    for result, points in ((shell, shell.placed["f+"]), (fit, fit.points())):
        file = tmp_path / f"sheet{suffix}"
        result.save(file)
        saved = read_mesh(file).positions
        assert_allclose(np.sort(saved, axis=0), np.sort(points, axis=0), atol=1e-5)


def test_it_becomes_a_trimesh(shell, fit):
    for result, faces in ((shell, shell.faces), (fit, fit.surface.faces)):
        mesh = result.to_trimesh()
        assert_array_equal(mesh.faces, faces)
        assert_allclose(mesh.vertices, result.points(), atol=0)
        # normals are on the side from which faces are counter-clockwise
        assert (np.einsum("fi,fi->f", mesh.face_normals, mesh.vertex_normals[faces[:, 0]]) > 0.5).all()
    with pytest.raises(CmcError, match=r'no sheet "f-"; it has f\+, g, gauss'):
        shell.to_trimesh("f-")


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_a_used_shell_is_copied(shell, copied):
    other = copied(shell)
    assert_allclose(other.placed["f+"], shell.placed["f+"], atol=0)
    settings = Settings(size="span", value=9.0)
    again = form(PLAN, settings, solver=other.solver)
    assert again.solver is other.solver, "it is used again"
    assert_allclose(again.placed["f+"], form(PLAN, settings).placed["f+"], atol=1e-12)


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_a_used_fit_is_copied_and_continued(fit, copied):
    disc = shapes.disc(150)
    other = copied(fit)
    assert_allclose(other.points(), fit.points(), atol=0)
    both = [fit_outline(disc, disc.positions, rise=0.5, initial=one) for one in (fit, other)]
    assert_allclose(both[0].points(), both[1].points(), atol=1e-6)
