"""Export: files in every format, read back by the solver's own reader."""

from __future__ import annotations

import json
import os
from pathlib import Path

import bpy
import numpy as np
import pytest

from .scenes import activate

FINISHED = {"FINISHED"}
FORMATS = ["glb", "obj", "ply", "stl"]


@pytest.fixture
def plan():
    bpy.ops.cmc.add_plan(columns=12)
    bpy.ops.cmc.solve()
    return bpy.context.object


def points(ob) -> np.ndarray:
    return np.array([ob.matrix_world @ vertex.co for vertex in ob.data.vertices])


def read(path):
    from cmc_formfinding.solver.io.mesh_files import read_mesh

    return read_mesh(path)


@pytest.mark.parametrize("suffix", FORMATS)
def test_every_format_has_the_shell_in_its_place(plan, tmp_path, suffix):
    shell = plan.cmc.f_plus
    shell.location.x += 2.0
    bpy.context.view_layer.update()
    path = tmp_path / f"hall.{suffix}"
    assert bpy.ops.cmc.export(filepath=str(path)) == FINISHED
    mesh, wanted = read(path), points(shell)
    assert len(mesh.polygons) == len(shell.data.polygons)
    task = [np.lexsort(np.round(p, 4).T) for p in (mesh.positions, wanted)]
    assert len(mesh.positions) == len(wanted)
    np.testing.assert_allclose(mesh.positions[task[0]], wanted[task[1]], atol=2e-4)
    assert sorted(os.listdir(tmp_path)) == sorted([f"hall.{suffix}", "hall.json"])
    reported = json.loads((tmp_path / "hall.json").read_text(encoding="utf-8"))
    assert reported["objects"] == [shell.name] and reported["energy"] == json.loads(plan.cmc.report)["energy"]


def test_an_obj_has_uvs_and_materials(plan, tmp_path):
    shell = plan.cmc.f_plus
    shell.data.materials.append(bpy.data.materials.new("Concrete"))
    bpy.ops.cmc.export(filepath=str(tmp_path / "hall.obj"), export_report=False)
    mesh = read(tmp_path / "hall.obj")
    assert os.listdir(tmp_path) == ["hall.obj"]
    assert set(mesh.materials) == {"Concrete"} and set(mesh.objects) == {shell.name}
    layer = shell.data.uv_layers.active.uv
    for polygon, corners, face in zip(mesh.polygons, mesh.uv_corners, shell.data.polygons, strict=True):
        assert list(face.vertices) == polygon.tolist()
        mine = [layer[k].vector[:] for k in face.loop_indices]
        np.testing.assert_allclose(mesh.uvs[corners], mine, atol=1e-5)


def test_normals_are_those_of_the_surface(plan, addon):
    from cmc_formfinding.cmc_addon.bridges.export_bridge import joined
    from cmc_formfinding.cmc_addon.tasks.export import ExportTask

    shell = plan.cmc.f_plus
    shell.rotation_euler = (0.3, -0.2, 1.0)
    bpy.context.view_layer.update()
    task = ExportTask.read(bpy.context, plan, Path("/nowhere/x.ply"), "SHELL", True, False)
    turn = np.array(shell.matrix_world)[:3, :3]
    own = np.array([item.vector for item in shell.data.attributes["cmc_normal"].data])
    np.testing.assert_allclose(joined(task.parts)[1], own @ turn.T, atol=1e-5)
    shell.scale.z = -1.0
    bpy.context.view_layer.update()
    mirrored = ExportTask.read(bpy.context, plan, Path("/nowhere/x.ply"), "SHELL", True, False)
    mesh, normals = joined(mirrored.parts)
    a, b, c = (mesh.positions[[polygon[k] for polygon in mesh.polygons]] for k in range(3))
    faces = np.cross(b - a, c - a)
    nearby = normals[[polygon[0] for polygon in mesh.polygons]]
    assert (np.einsum("ij,ij->i", faces, nearby) > 0).all(), "faces look where the normals point"


def test_modifiers_are_written_as_seen(plan, tmp_path):
    shell = plan.cmc.f_plus
    shell.modifiers.new("Thick", "SOLIDIFY").thickness = 0.2
    for with_modifiers, name in ((True, "thick"), (False, "thin")):
        bpy.ops.cmc.export(filepath=str(tmp_path / f"{name}.ply"), export_modifiers=with_modifiers)
    thick, thin = (read(tmp_path / f"{name}.ply") for name in ("thick", "thin"))
    assert len(thick.polygons) > 2 * len(thin.polygons) == 2 * len(shell.data.polygons)


def raised(plan):
    """The plan as a surface in space."""
    for vertex in plan.data.vertices:
        vertex.co.z += 1.0 - 0.02 * (vertex.co.x**2 + vertex.co.y**2)


def test_what_is_exported_by_itself(plan, tmp_path):
    from cmc_formfinding.cmc_addon.tasks.export import wanted_objects

    def automatic():
        return wanted_objects(bpy.context, plan, "AUTO")

    assert automatic() == [plan.cmc.f_plus]
    raised(plan)
    bpy.ops.cmc.approximate_surface()
    assert automatic() == [plan.cmc.nearest]
    bpy.ops.cmc.go_to(target="SHELL")
    assert automatic() == [plan.cmc.f_plus]
    for ob in (plan.cmc.f_plus, plan.cmc.nearest):
        ob.select_set(True)
    assert bpy.ops.cmc.export(filepath=str(tmp_path / "both.obj"), export_what="SELECTED") == FINISHED
    both = read(tmp_path / "both.obj")
    assert len(both.polygons) == 2 * len(plan.data.polygons) and len(set(both.objects)) == 2
    assert plan.cmc.export_what == "SELECTED", "the next time it is the same"


@pytest.mark.parametrize("made_as", ["MESH", "INSTANCES"])
def test_copies_are_one_mesh(tmp_path, made_as):
    bpy.ops.cmc.add_module(module="HONEYCOMB", edges=6)
    plan = bpy.context.object
    bpy.ops.cmc.complete(complete_count=4, complete_as=made_as)
    assert bpy.ops.cmc.export(filepath=str(tmp_path / "grid.obj")) == FINISHED
    grid = read(tmp_path / "grid.obj")
    assert len(grid.polygons) == 4 * len(plan.data.polygons) == len(grid.uv_corners)
    a, b, c = (grid.positions[[polygon[k] for polygon in grid.polygons]] for k in range(3))
    made = bpy.data.objects if made_as == "INSTANCES" else [plan.cmc.completed]
    area = sum(face.area for ob in made if ob.cmc.role == "COMPLETED" for face in ob.data.polygons)
    np.testing.assert_allclose(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum(), area, rtol=1e-4)
    assert json.loads((tmp_path / "grid.json").read_text(encoding="utf-8"))["copies"] == 4


def test_files_are_named_after_the_plan(plan):
    from cmc_formfinding.cmc_addon.operators.export import file_name

    plan.name = "Hall: north/south"
    assert file_name(plan, plan.cmc.f_plus) == "Hall_ north_south shell"
    raised(plan)
    bpy.ops.cmc.approximate_surface()
    assert file_name(plan, plan.cmc.nearest) == "Hall_ north_south nearest"


def test_the_ending_says_the_format(plan, tmp_path):
    bpy.ops.cmc.export(filepath=str(tmp_path / "hall.v2"), export_format="STL", export_report=False)
    assert os.listdir(tmp_path) == ["hall.v2.stl"]
    bpy.ops.cmc.export(filepath=str(tmp_path / "deeper" / "hall.PLY"), export_format="GLB", export_report=False)
    assert os.listdir(tmp_path / "deeper") == ["hall.PLY"] and plan.cmc.export_format == "PLY"


def test_what_goes_wrong_is_said_and_leaves_nothing(plan, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RuntimeError, match="cannot be written"):
        bpy.ops.cmc.export(filepath=str(tmp_path / "file" / "hall.glb"))
    (tmp_path / "hall.glb").mkdir()
    with pytest.raises(RuntimeError, match="cannot be written"):
        bpy.ops.cmc.export(filepath=str(tmp_path / "hall.glb"))
    for long in ("x" * 300, "x" * 300 + ".glb"):
        with pytest.raises(RuntimeError, match="cannot be written: File name too long"):
            bpy.ops.cmc.export(filepath=str(tmp_path / long))
    assert sorted(os.listdir(tmp_path)) == ["file", "hall.glb"]
    with pytest.raises(RuntimeError, match="Repeat by Symmetry makes it"):
        bpy.ops.cmc.export(filepath=str(tmp_path / "x.glb"), export_what="COMPLETED")
    activate(None)
    with pytest.raises(RuntimeError, match="No object is active"):
        bpy.ops.cmc.export(filepath=str(tmp_path / "x.glb"))
    bpy.ops.mesh.primitive_plane_add()
    with pytest.raises(RuntimeError, match="has no shell yet; Solve makes one"):
        bpy.ops.cmc.export(filepath=str(tmp_path / "x.glb"))


def test_cancelled_nothing_is_written(plan, tmp_path):
    from cmc_formfinding.cmc_addon.tasks.export import ExportTask

    task = ExportTask.read(bpy.context, plan, tmp_path / "hall.obj", "SHELL", True, True)
    assert task.work(lambda *_: False) == [] and os.listdir(tmp_path) == []


def test_meshes_with_and_without_uvs_together(plan, tmp_path):
    raised(plan)
    bpy.ops.cmc.approximate_surface()
    shell, nearest = plan.cmc.f_plus, plan.cmc.nearest
    while shell.data.uv_layers:
        shell.data.uv_layers.remove(shell.data.uv_layers[0])
    for ob in (shell, nearest):
        ob.select_set(True)
    bpy.ops.cmc.export(filepath=str(tmp_path / "both.obj"), export_what="SELECTED", export_report=False)
    both = read(tmp_path / "both.obj")
    textured = [bool(len(corners)) for corners in both.uv_corners]
    assert sum(textured) == len(nearest.data.polygons)
    assert {name for name, there in zip(both.objects, textured, strict=True) if there} == {nearest.name}


def test_a_foreign_json_is_never_replaced(plan, tmp_path):
    own = '{"my": "own data"}'
    (tmp_path / "site.json").write_text(own)
    with pytest.raises(RuntimeError, match=r"would replace .*site.json, which is not a report"):
        bpy.ops.cmc.export(filepath=str(tmp_path / "site.glb"))
    assert os.listdir(tmp_path) == ["site.json"] and (tmp_path / "site.json").read_text() == own
    assert bpy.ops.cmc.export(filepath=str(tmp_path / "site.glb"), export_report=False) == FINISHED
    assert (tmp_path / "site.json").read_text() == own
    for _ in range(2):  # a report of its own is replaced
        assert bpy.ops.cmc.export(filepath=str(tmp_path / "hall.glb")) == FINISHED


@pytest.mark.parametrize("path", ["/", ".", "//", "..", "sub/", "sub"])
def test_a_path_without_a_name(plan, tmp_path, monkeypatch, path):
    (tmp_path / "sub").mkdir()
    monkeypatch.chdir(tmp_path)
    given = f"{tmp_path}/{path}" if path.startswith("sub") else path
    with pytest.raises(RuntimeError, match="names a folder; add the name of a file"):
        bpy.ops.cmc.export(filepath=given)
    assert os.listdir(tmp_path) == ["sub"] and os.listdir(tmp_path / "sub") == []


def test_if_the_second_file_fails_the_first_stays(plan, tmp_path, monkeypatch):
    (tmp_path / "half.glb").write_text("OLD")
    (tmp_path / "half.json").mkdir()
    with pytest.raises(RuntimeError, match=r"half.json cannot be written: it is a folder"):
        bpy.ops.cmc.export(filepath=str(tmp_path / "half.glb"))
    assert (tmp_path / "half.glb").read_text() == "OLD"
    (tmp_path / "half.json").rmdir()
    real = os.replace

    def full(source, target):
        if str(target) == str(tmp_path / "half.json"):
            raise OSError(28, "No space left on device")
        real(source, target)

    monkeypatch.setattr(os, "replace", full)
    for name in ("half", "new"):
        (tmp_path / f"{name}.json").unlink(missing_ok=True)
    with pytest.raises(RuntimeError, match="cannot be written: No space left"):
        bpy.ops.cmc.export(filepath=str(tmp_path / "half.glb"))
    assert (tmp_path / "half.glb").read_text() == "OLD" and os.listdir(tmp_path) == ["half.glb"]
    (tmp_path / "half.glb").unlink()
    with pytest.raises(RuntimeError, match="cannot be written: No space left"):
        bpy.ops.cmc.export(filepath=str(tmp_path / "half.glb"))
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("text", ["[1]", "3", "null", "[" * 3000, '{"sheets": 1}', '{"sheets": {}, "sheet": []}'])
def test_a_foreign_report_in_the_plan(plan, tmp_path, capfd, text):
    plan.cmc.report = text
    assert bpy.ops.cmc.export(filepath=str(tmp_path / "e.obj")) == FINISHED
    assert "has no report to write beside the mesh; solve again" in capfd.readouterr().out
    assert json.loads((tmp_path / "e.json").read_text())["objects"] == [plan.cmc.f_plus.name]


def test_glb_is_in_metres(plan, tmp_path):
    bpy.context.scene.unit_settings.scale_length = 0.001
    for suffix, scale in (("glb", 0.001), ("obj", 1.0)):
        bpy.ops.cmc.export(filepath=str(tmp_path / f"hall.{suffix}"), export_report=False)
        found = np.ptp(read(tmp_path / f"hall.{suffix}").positions, axis=0)
        np.testing.assert_allclose(found, scale * np.ptp(points(plan.cmc.f_plus), axis=0), rtol=1e-4)
