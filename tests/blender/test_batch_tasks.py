"""Tasks and formats of batches: what is made of a plan or a job, and in which files."""

from __future__ import annotations

import os
from pathlib import Path

import bpy

# isort: split
import numpy as np
import pytest
from cmc_formfinding.cmc_addon.headless import cli
from cmc_formfinding.cmc_addon.properties.links import result_of
from cmc_formfinding.solver.io.mesh_files import read_mesh
from cmc_formfinding.solver.jobs.job import load_job, run_job
from numpy.testing import assert_allclose

from .batches import DISC, files, job, plans, report
from .conftest import ROOT
from .scenes import activate, positions, quad_disc, quad_ring

COURT = """\
[shape]
kind = "annulus"
inner = 0.4
outer = 1.0
n = 300
[[conditions]]
side = "outer"
kind = "gauss_map"
[[conditions]]
side = "inner"
tilt = 20
[close]
"""
UNDULOID = """\
mesh = "unduloid.obj"
conditions = [
    { group = "Axis", kind = "mirror", normal = [0, -1, 0] },
    { group = "Floor", kind = "mirror", normal = [0, 0, -1] },
    { group = "Bisector", kind = "mirror", normal = [-1, 0, 0] },
    { group = "End", kind = "mirror", normal = [1, 0, 0] },
]
[complete]
repeat = 2
mesh = "tube.obj"
"""


@pytest.mark.parametrize(
    ("name", "text", "role", "task"),
    [
        ("close", COURT + 'by = "both"\nmove = ["x", "y"]\n', "F_PLUS", "solve"),
        ("complete", UNDULOID, "COMPLETED", "complete"),
    ],
)
def test_a_job_makes_what_it_makes_without_blender(tmp_path, name, text, role, task):
    path = job(tmp_path, f"{name}.toml", text)
    assert cli.run([str(path), "-o", str(tmp_path / "out"), "-f", "blend", "obj"]) == 0
    plan = bpy.data.objects[name]
    shell = run_job(load_job(path))
    found = report(tmp_path / "out" / name / name)
    assert found["task"] == task and found["made"]["blender"] == bpy.app.version_string
    stem = "completed" if task == "complete" else "shell"
    mesh = read_mesh(tmp_path / "out" / name / name / f"{stem}.obj")
    assert_allclose(np.sort(mesh.positions, axis=0), np.sort(positions(result_of(plan, role)), axis=0), atol=1e-4)
    if task == "complete":
        assert found["completed"]["copies"] == 16
        tube = read_mesh(tmp_path / "tube.obj")
        assert_allclose(np.ptp(mesh.positions, axis=0), np.ptp(tube.positions, axis=0), rtol=1e-3)
    for name in ("rise", "volume", "area"):
        assert found["sheets"]["f+"][name] == pytest.approx(getattr(shell.report.shown, name), rel=1e-3)


def test_a_job_approximates(tmp_path):
    mesh = tmp_path / "cap.obj"
    disc = quad_disc("Cap", rings=6)
    for vertex in disc.data.vertices:
        vertex.co.z = -0.03 * (vertex.co.x**2 + vertex.co.y**2)
    activate(disc)
    bpy.ops.wm.obj_export(filepath=str(mesh), forward_axis="Y", up_axis="Z")
    path = job(tmp_path, "near.toml", 'mesh = "cap.obj"\n[fit]\napproximate = true\n')
    assert cli.run([str(path), "-o", str(tmp_path / "out"), "-f", "stl"]) == 0
    assert report(tmp_path / "out/near/near")["deviation"]["max"] < 0.1
    assert files(tmp_path / "out") == ["near/near/report.json", "near/near/shell.stl", "near/plans.json"]


def test_a_stored_plan_does_what_made_its_shell_or_what_is_asked(tmp_path):
    path = plans(tmp_path / "in.blend", "A", "B")
    activate(bpy.data.objects["A"])
    for vertex in bpy.data.objects["A"].data.vertices:
        vertex.co.z = -0.03 * (vertex.co.x**2 + vertex.co.y**2)
    bpy.ops.cmc.approximate_surface()
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    assert cli.run([str(path), "-o", str(tmp_path / "1"), "-f", "ply"]) == 0
    assert [report(tmp_path / "1/in" / name)["task"] for name in "AB"] == ["approximate", "solve"]
    assert cli.run([str(path), "-o", str(tmp_path / "2"), "-f", "ply", "--plan", "A", "--smoothness", "0.1"]) == 0
    made = [report(tmp_path / run / "in/A")["made"]["settings"]["smoothness"] for run in "12"]
    assert_allclose(made, [1e-3, 0.1], rtol=1e-6)
    assert cli.run([str(path), "-o", str(tmp_path / "3"), "-f", "ply", "--task", "solve"]) == 0
    assert [report(tmp_path / "3/in" / name)["task"] for name in "AB"] == ["solve", "solve"]


def test_settings_of_another_task_are_refused(tmp_path, capsys):
    assert cli.run(["a.blend", "--task", "solve", "--smoothness", "0.6"]) == 2
    assert "--smoothness goes with --task approximate, not with solve" in capsys.readouterr().err


def test_a_fit_to_an_outline_is_refused(tmp_path, capsys):
    path = job(tmp_path, "fit.toml", DISC + "[fit]\nrise = 0.3\n")
    assert cli.run([str(path), "-o", str(tmp_path / "out"), "-f", "obj"]) == 2
    assert 'give the sides kind = "line"' in capsys.readouterr().err


def test_what_is_chosen_for_single_holes_is_refused(tmp_path, capsys):
    path = job(tmp_path, "each.toml", COURT + 'by = "both"\nmove = { 1 = ["x", "y"] }\n')
    assert cli.run([str(path), "-o", str(tmp_path / "out"), "-f", "obj"]) == 2
    assert "In Blender all holes of a plan move alike" in capsys.readouterr().err


@pytest.mark.parametrize(("given", "closed"), [([], True), (["--no-keep-closed"], False)])
def test_a_mesh_file_is_kept_closed_as_a_new_plan_is(tmp_path, given, closed):
    quad_ring("Ring", rings=4, columns=24)
    bpy.ops.wm.obj_export(filepath=str(tmp_path / "ring.obj"), forward_axis="Y", up_axis="Z")
    condition = ["--condition", "loop = 0, tilt = 40"]
    code = cli.run([str(tmp_path / "ring.obj"), "-o", str(tmp_path / "out"), "-f", "obj", *condition, *given])
    found = report(tmp_path / "out/ring/ring")
    assert (code == 0) == closed and found["is_open"] != closed and ("closing" in found) == closed


def test_all_formats_and_metres(tmp_path):
    """GLB leaves in metres, as Export writes it; the other formats have no unit."""
    path = plans(tmp_path / "in.blend", "A", scale=0.001)
    assert cli.run([str(path), "-o", str(tmp_path / "out"), "-f", "glb", "obj", "ply", "stl"]) == 0
    meshes = {suffix: read_mesh(tmp_path / f"out/in/A/shell.{suffix}") for suffix in ("glb", "obj", "ply", "stl")}
    extents = {suffix: np.ptp(mesh.positions, axis=0) for suffix, mesh in meshes.items()}
    assert_allclose(extents["ply"], extents["obj"], rtol=1e-5)
    assert_allclose(extents["stl"], extents["obj"], rtol=1e-5)
    assert_allclose(extents["glb"], 0.001 * extents["obj"], rtol=1e-5)


def test_paths_of_textures_stay_valid(tmp_path):
    image = bpy.data.images.new("wood", 4, 4)
    image.filepath_raw, image.file_format = str(tmp_path / "tex" / "wood.png"), "PNG"
    (tmp_path / "tex").mkdir()
    image.save()
    path = plans(tmp_path / "in.blend", "A")
    material = bpy.data.materials.new("Wood")
    if material.node_tree is None:  # before Blender 5, where the setting is deprecated
        material.use_nodes = True
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    material.node_tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
    bpy.data.objects["A"].data.materials.append(material)
    bpy.data.objects["A"].data.uv_layers.new(name="Map")
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    image.filepath = bpy.path.relpath(str(tmp_path / "tex" / "wood.png"))
    bpy.ops.wm.save_mainfile()
    assert cli.run([str(path), "-o", str(tmp_path / "out"), "-f", "blend", "obj"]) == 0
    text = (tmp_path / "out/in/A/shell.mtl").read_text()
    named = next(line.split(" ", 1)[1] for line in text.splitlines() if line.startswith("map_Kd"))
    assert not os.path.isabs(named) and (tmp_path / "out/in/A" / named).is_file()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out/in/in.blend"))
    stored = bpy.data.images["wood"].filepath
    assert stored.startswith("//") and Path(bpy.path.abspath(stored)).is_file()


def test_the_documented_call(tmp_path, monkeypatch):
    """Under the name that the package has here."""
    page = (ROOT / "docs/how-to/headless.md").read_text(encoding="utf-8").split("## From Python")[1]
    lines = [line[4:] for line in page.splitlines() if line.startswith("    ")]
    monkeypatch.chdir(tmp_path)
    plans(tmp_path / "hall.blend", "A")
    names: dict[str, object] = {}
    exec("\n".join(lines).replace("bl_ext.user_default.", ""), names)
    assert names["code"] == 0 and (tmp_path / "out/hall/hall.blend").exists()
