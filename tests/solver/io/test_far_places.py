"""Meshes in geographic coordinates: nothing is rounded when they are written, and what came in rounded is said."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial import KDTree

from solver import shapes
from solver.io.far_places import is_far, step_of
from solver.io.mesh_files import read_mesh, write_mesh
from solver.io.obj import MeshData
from solver.jobs.job import load_job, run_job
from solver.surface.convert import save_mesh
from tests.solver.job_files import job

UTM = np.array([500000.123, 5400000.456, 420.789])
FORMATS = ["glb", "ply", "stl", "obj"]


def dome(where=UTM) -> MeshData:
    disc = shapes.disc(200)
    x, y = 10.0 * disc.positions.T
    points = np.column_stack([x, y, 3.0 - 0.02 * (x**2 + y**2)]) + where
    faces = list(disc.domain.faces)
    return MeshData(points, faces, uvs=disc.positions, uv_corners=faces)


def error_of(points: np.ndarray, exact: np.ndarray) -> float:
    """The largest distance of a point from the nearest exact one."""
    return float(KDTree(exact).query(points)[0].max())


@pytest.mark.parametrize("suffix", FORMATS)
def test_nothing_is_rounded_far_from_the_origin(tmp_path, suffix):
    mesh = dome()
    normals = np.tile([0.6, 0.0, 0.8], (len(mesh.positions), 1))
    write_mesh(tmp_path / f"far.{suffix}", mesh, normals=normals)
    read = read_mesh(tmp_path / f"far.{suffix}")
    assert len(read.positions) == len(mesh.positions) and len(read.polygons) == len(mesh.polygons)
    assert error_of(read.positions, mesh.positions) < 1e-6 and not read.notes
    assert step_of(mesh.positions) == 0.5  # what single precision would leave


def test_a_glb_stands_around_a_node_that_single_precision_keeps(tmp_path):
    """Programs that place objects in single precision put it where it is, too; UVs and material are there."""
    mesh = dome()
    write_mesh(tmp_path / "far.glb", mesh)
    data = (tmp_path / "far.glb").read_bytes()
    length = struct.unpack("<I", data[12:16])[0]
    header = json.loads(data[20 : 20 + length])
    node = next(node for node in header["nodes"] if "matrix" in node and "mesh" in node)
    origin = np.array(node["matrix"][12:15])
    assert_allclose(origin, [UTM[0], UTM[2], -UTM[1]], rtol=0, atol=3.0)  # y is up there
    assert (origin == np.float32(origin)).all()
    corners = [a for a in header["accessors"] if a["type"] == "VEC3" and "max" in a]
    assert max(np.abs(a[end]).max() for a in corners for end in ("min", "max")) < 11.0
    assert header["materials"][0]["doubleSided"] and "TEXCOORD_0" in header["meshes"][0]["primitives"][0]["attributes"]


def test_normals_of_a_ply_stay(tmp_path):
    mesh = dome()
    write_mesh(tmp_path / "far.ply", mesh, normals=np.tile([0.6, 0.0, 0.8], (len(mesh.positions), 1)))
    text = (tmp_path / "far.ply").read_bytes().split(b"end_header")[0].decode()
    assert text.count("property double") == 6 and "property double nz" in text


@pytest.mark.parametrize("suffix", ["glb", "ply", "stl"])
def test_near_the_origin_files_are_as_they_were(tmp_path, suffix):
    mesh = dome(np.array([20.0, 5.0, 0.0]))
    assert not is_far(mesh.positions) and is_far(dome().positions)
    write_mesh(tmp_path / f"near.{suffix}", mesh)
    data = (tmp_path / f"near.{suffix}").read_bytes()
    assert b"property double" not in data and not data.startswith(b"solid \n")
    assert not read_mesh(tmp_path / f"near.{suffix}").notes


@pytest.mark.parametrize("suffix", ["glb", "ply", "stl"])
def test_points_that_another_program_rounded_are_read_with_a_warning(tmp_path, suffix):
    import trimesh

    mesh = dome(UTM if suffix != "glb" else UTM[[0, 2, 1]])
    trimesh.Trimesh(mesh.positions, mesh.polygons, process=False).export(tmp_path / f"site.{suffix}")
    (note,) = read_mesh(tmp_path / f"site.{suffix}").notes
    assert note.code == "far"
    assert note.startswith(f"site.{suffix} has its coordinates in single precision") and "steps of 0.5, 0.02 of" in note
    assert "as OBJ" in note


def test_a_node_far_away_is_not_rounding(tmp_path):
    import trimesh

    scene = trimesh.Scene()
    mesh = dome(np.zeros(3))
    part = trimesh.Trimesh(mesh.positions, mesh.polygons, process=False)
    scene.add_geometry(part, transform=trimesh.transformations.translation_matrix(UTM))
    scene.export(tmp_path / "node.glb")
    read = read_mesh(tmp_path / "node.glb", up="z")
    assert not read.notes and error_of(read.positions, mesh.positions + UTM) < 1e-6


@pytest.mark.parametrize("suffix", FORMATS)
def test_what_python_saves_is_not_rounded(tmp_path, suffix):
    mesh = dome()
    normals = np.tile([0.0, 0.0, 1.0], (len(mesh.positions), 1))
    save_mesh(tmp_path / f"saved.{suffix}", mesh.positions, mesh.polygons, normals)
    assert error_of(read_mesh(tmp_path / f"saved.{suffix}").positions, mesh.positions) < 1e-6


@pytest.mark.parametrize("suffix", ["glb", "stl", "ply"])
def test_a_job_in_geographic_coordinates_gives_the_shell_it_gives_at_the_origin(tmp_path, suffix):
    shells = {}
    for name, where in (("near", np.zeros(3)), ("far", UTM)):
        flat = dome(where)
        flat.positions[:, 2] = where[2]
        write_mesh(tmp_path / f"{name}.obj", flat)
        text = f'mesh = "{name}.obj"\n[default]\ntilt = 30\n[output]\nf_plus = "{name}_shell.{suffix}"\n'
        run_job(load_job(job(tmp_path, text)))
        shells[name] = read_mesh(tmp_path / f"{name}_shell.{suffix}").positions
    assert error_of(shells["far"] - UTM, shells["near"]) < 3e-6
