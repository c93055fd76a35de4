"""What a notebook and a script expect of results and solvers: short texts, files, other packages, copies, keywords."""

from __future__ import annotations

import copy
import inspect
import pickle
import re
import sys
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose, assert_array_equal

from solver import CmcSolver, CmcSurface, Status, conditions, shapes, solve_cmc
from solver.errors import CmcError, JobError
from solver.gauss.harmonic import HarmonicSolver
from solver.gauss.options import MapOptions
from solver.io.mesh_files import FORMATS, read_mesh
from solver.surface.options import CmcOptions, SolveOptions

L_SHAPE = np.array([[0, 0], [4, 0], [4, 2], [2, 2], [2, 4], [0, 4]], dtype=np.float64)
SHAPE = shapes.polygon(L_SHAPE, max_edge=0.5, corner_radius=0.3)
HELD = conditions.binormal(SHAPE.domain, SHAPE.positions, SHAPE.sides["outer"], 0.7)
COURT = np.array([[0.6, 0.6], [1.4, 0.6], [1.4, 1.0], [0.6, 1.0]])
COURTYARD = shapes.polygon(L_SHAPE, [COURT], max_edge=0.5, corner_radius=0.1)
DUPLICATES = {"copy": copy.deepcopy, "pickle": lambda one: pickle.loads(pickle.dumps(one))}


@pytest.fixture(scope="module")
def surface() -> CmcSurface:
    return solve_cmc(SHAPE, HELD)


@pytest.fixture(scope="module")
def open_surface() -> CmcSurface:
    domain = COURTYARD.domain
    return solve_cmc(domain, conditions.binormal(domain, COURTYARD.positions, domain.boundary_edges, 0.7))


def test_the_repr_is_a_line_without_arrays(surface, open_surface):
    text = repr(surface)
    assert text.startswith(f"CmcSurface({SHAPE.domain.vertex_count} vertices, {len(SHAPE.domain.faces)} faces, H = 0.5")
    assert text.endswith("converged)") and len(text) < 120 and "\n" not in text
    assert re.search(r"gap \d", repr(open_surface))
    points = len(COURTYARD.domain.faces)
    assert repr(open_surface.conjugate).startswith(f"Conjugate({points} points, 1 periods, closure error")
    assert repr(surface.as_mesh("f+", "dual")).startswith("PolygonMesh(")


def test_a_surface_says_whether_it_worked(surface, open_surface):
    assert surface.ok and surface.message == Status.CONVERGED.sentence
    assert not open_surface.ok and open_surface.status is Status.GAP
    stopped = solve_cmc(SHAPE, HELD, max_iterations=1, tolerance=1e-12)
    assert not stopped.ok and "Residual" in stopped.message


def test_the_table_of_numbers_needs_no_matplotlib(surface, open_surface, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    html = surface._repr_html_()
    assert f"{surface.harmonic.energy:.6g}" in html and "<table>" in html
    assert "<img" not in html and ">gap<" not in html
    assert f"{open_surface.gap:.4g}" in open_surface._repr_html_()


def test_the_picture_is_a_png(surface):
    pytest.importorskip("matplotlib")
    assert "data:image/png;base64,iVBOR" in surface._repr_html_()


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("sheet", ["f+", "f-"])
def test_a_saved_sheet_reads_back(surface, tmp_path, suffix, sheet):
    file = tmp_path / f"sheet{suffix}"
    surface.save(file, sheet)
    mesh = read_mesh(file)
    expected, size = surface.sheet(sheet), np.ptp(surface.sheet(sheet))
    corners, wanted = mesh.positions[np.array(mesh.polygons)], expected[surface.faces]
    assert_allclose(corners, wanted, rtol=0.0, atol=1e-6 * size)


def test_f_plus_is_saved_unless_told_otherwise_and_normals_go_along(surface, tmp_path):
    surface.save(tmp_path / "shell.ply")
    loaded = trimesh.load(tmp_path / "shell.ply", process=False)
    assert_allclose(loaded.vertices, surface.f_plus, rtol=0.0, atol=1e-6)
    assert_allclose(loaded.vertex_normals, surface.normals, rtol=0.0, atol=1e-6)
    surface.save(tmp_path / "dual.obj", combinatorics="dual")
    assert len(read_mesh(tmp_path / "dual.obj").polygons) == SHAPE.domain.vertex_count
    with pytest.raises(JobError, match="has no format known here"):
        surface.save(tmp_path / "shell.txt")


@pytest.mark.parametrize("sheet", ["f+", "f-"])
def test_trimesh_gets_normals_on_the_side_of_the_faces(surface, sheet):
    mesh = surface.to_trimesh(sheet)
    assert_array_equal(mesh.faces, surface.faces)
    assert_allclose(mesh.vertices, surface.sheet(sheet))
    assert_allclose(mesh.vertex_normals, surface.sheet_normals(sheet), atol=1e-12)
    along = np.einsum("fi,fki->f", mesh.face_normals, mesh.vertex_normals[mesh.faces])
    assert np.mean(along > 0.0) > 0.95


@pytest.mark.parametrize("name", ["pyvista", "meshio"])
def test_a_package_that_is_missing_is_named(surface, monkeypatch, name):
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(CmcError, match=f"package {name}, which is not installed"):
        getattr(surface, f"to_{name}")()


def test_pyvista_and_meshio_get_points_faces_and_normals(surface, monkeypatch):
    class PointData(dict):
        active_normals_name = ""

    poly = SimpleNamespace(PolyData=lambda points, cells: SimpleNamespace(args=(points, cells), point_data=PointData()))
    monkeypatch.setitem(sys.modules, "pyvista", poly)
    monkeypatch.setitem(sys.modules, "meshio", SimpleNamespace(Mesh=lambda *args, **named: (args, named)))
    mesh = surface.to_pyvista("f-")
    points, cells = mesh.args
    assert_array_equal(points, surface.f_minus)
    assert_array_equal(cells.reshape(-1, 4)[:, 1:], surface.faces)
    assert (cells.reshape(-1, 4)[:, 0] == 3).all()
    assert_array_equal(mesh.point_data["Normals"], -surface.normals)
    (points, [(kind, faces)]), named = surface.to_meshio()
    assert kind == "triangle"
    assert_array_equal(points, surface.f_plus)
    assert_array_equal(faces, surface.faces)
    assert_array_equal(named["point_data"]["normals"], surface.normals)


@pytest.mark.parametrize("duplicate", DUPLICATES.values(), ids=DUPLICATES)
@pytest.mark.parametrize("delaunay", [False, True])
def test_a_used_solver_can_be_copied(duplicate, delaunay):
    solver = CmcSolver(SHAPE, delaunay=delaunay)
    expected = solver.solve(HELD)
    other = duplicate(solver)
    assert other.domain is not solver.domain and other.delaunay == delaunay
    assert_allclose(other.solve(HELD).f_plus, expected.f_plus, rtol=0.0, atol=1e-12)
    moved = duplicate(solver.moved(2.0 * SHAPE.domain.edge_lengths))
    assert_allclose(moved.domain.edge_lengths, 2.0 * SHAPE.domain.edge_lengths)
    assert_allclose(moved.solve(HELD).f_plus, expected.f_plus, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("duplicate", DUPLICATES.values(), ids=DUPLICATES)
@pytest.mark.parametrize("name", ["surface", "open_surface"])
def test_a_used_surface_can_be_copied(duplicate, name, request):
    surface = request.getfixturevalue(name)
    dual = surface.as_mesh("f+", "dual")
    other = duplicate(surface)
    assert_array_equal(other.f_plus, surface.f_plus)
    assert other.status is surface.status and other.graph.domain is other.domain
    assert_array_equal(other.as_mesh("f+", "dual").vertices, dual.vertices)


def test_solver_and_function_take_a_shape(surface):
    for other in (CmcSolver(SHAPE).solve(HELD), solve_cmc(SHAPE.domain, HELD)):
        assert_array_equal(other.f_plus, surface.f_plus)


OPTIONS = {HarmonicSolver.solve: MapOptions, CmcSolver.solve: SolveOptions, solve_cmc: CmcOptions}


@pytest.mark.parametrize(("function", "options"), OPTIONS.items())
def test_every_option_is_a_keyword(function, options):
    fields = {name: parameter.default for name, parameter in inspect.signature(options).parameters.items()}
    given = {name: parameter.default for name, parameter in inspect.signature(function).parameters.items()}
    assert fields.items() <= given.items()
    assert list(given)[-len(fields) - 1] == "conditions"


def test_arguments_go_by_name_and_an_unknown_one_is_named(surface):
    assert_array_equal(solve_cmc(conditions=HELD, domain=SHAPE).f_plus, surface.f_plus)
    with pytest.raises(TypeError, match="solve_cmc: got an unexpected keyword argument 'tolerence'"):
        solve_cmc(SHAPE, HELD, tolerence=1e-3)  # pyright: ignore[reportCallIssue]


def test_every_option_is_typed_once():
    typed = [name for options in OPTIONS.values() for name in options.__annotations__ if name != "_"]
    assert len(typed) == len(set(typed))
    assert issubclass(CmcOptions, SolveOptions) and issubclass(SolveOptions, MapOptions)
