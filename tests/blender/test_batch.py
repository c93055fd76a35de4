"""Batches in Blender: folders, tasks and formats, provenance, resuming, disks that are full, memory."""

from __future__ import annotations

import json
import os
import resource
import shutil
from pathlib import Path

import bpy

# isort: split
import numpy as np
import pytest
from cmc_formfinding.cmc_addon.headless import cli, exporters
from cmc_formfinding.cmc_addon.headless.folders import folder_names, input_folders
from cmc_formfinding.cmc_addon.properties.links import result_of
from cmc_formfinding.solver.io.mesh_files import read_mesh
from cmc_formfinding.solver.jobs.job import load_job, run_job
from cmc_formfinding.solver.version import PROGRAM
from numpy.testing import assert_allclose

from .conftest import ROOT
from .scenes import activate, add_group, boundary_edges, positions, quad_disc

DISC = '[shape]\nkind = "disc"\nn = 200\nscale = 5.0\n'
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


def plans(path: Path, *names: str, scale: float = 1.0) -> Path:
    """A .blend with a disc for each name."""
    bpy.context.scene.unit_settings.scale_length = scale
    for number, name in enumerate(names):
        disc = quad_disc(name, rings=4)
        disc.location.x = 3.0 * number
        add_group(disc, "rim", boundary_edges(disc.data), "BINORMAL", tilt=0.2)
    path.parent.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


def report(folder: Path) -> dict:
    return json.loads((folder / "report.json").read_text())


def files(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


# --- folders -------------------------------------------------------------------------------


def test_a_name_gives_its_folder_whatever_is_beside_it():
    assert folder_names(["Hall", "Café", "Hall 1"]) == {"Hall": "Hall", "Café": "Café", "Hall 1": "Hall 1"}
    alone = folder_names(["Hall/1"])["Hall/1"]
    assert alone == folder_names(["Hall/1", "Hall 1", "Hall:1"])["Hall/1"] and alone.startswith("Hall_1-")


def test_folders_never_clash():
    names = ["Hall/1", "Hall:1", "Hall_1", "hall", "HALL", "Cafe\u0301", "Café", "CON", "a.", "a", ".."]
    names += ["x" * 70, "x" * 71, folder_names(["Hall/1"])["Hall/1"], "report.json", "in.blend", "ß", "ss"]
    folders = folder_names(names, ("report.json", "in.blend"))
    assert len({folder.casefold() for folder in folders.values()}) == len(names)
    assert not {"..", "CON", "report.json", "in.blend"} & set(folders.values())
    assert not any(set(folder) & set('\\/:*?"<>|') or folder.endswith(".") for folder in folders.values())


def test_folders_of_inputs_mirror_theirs_where_names_are_equal():
    a, b, c, d = (Path("/p") / name for name in ("x/hall.blend", "y/hall.blend", "y/hall.obj", "court.blend"))
    assert set(map(str, input_folders([a, d]).values())) == {"hall", "court"}
    assert [str(input_folders([a, b, d])[path]) for path in (a, b, d)] == ["x/hall", "y/hall", "court"]
    assert [str(input_folders([a, b, c])[path]) for path in (a, b, c)] == ["x/hall", "y/hall.blend", "y/hall.obj"]
    x = Path("/p/x.blend")  # its plans would lie where the folder of x/hall.blend does
    assert [str(input_folders([a, b, x])[path]) for path in (a, b, x)] == ["x/hall", "y/hall", "x.blend"]


def test_each_plan_has_its_file(tmp_path):
    names = ("Café", "Cafè", "Hall 1", "Hall-1", "Hall/1", "hall-1")
    assert cli.run([str(plans(tmp_path / "in.blend", *names)), "-o", str(tmp_path / "out"), "-f", "glb"]) == 0
    folders = json.loads((tmp_path / "out/in/plans.json").read_text())["plans"]
    assert list(folders) == sorted(names, key=list(folders).index) and len(set(folders.values())) == len(names)
    for name, folder in folders.items():
        assert report(tmp_path / "out" / "in" / folder)["plan"] == name
        assert (tmp_path / "out" / "in" / folder / "shell.glb").exists()


def test_equal_stems_mirror_the_folder_tree(tmp_path):
    inputs = [str(plans(tmp_path / place / "hall.blend", place)) for place in ("a",)]
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    inputs.append(str(plans(tmp_path / "b" / "hall.blend", "b")))
    assert cli.run([*inputs, "-o", str(tmp_path / "out"), "-f", "obj"]) == 0
    assert (tmp_path / "out/a/hall/a/shell.obj").exists() and (tmp_path / "out/b/hall/b/shell.obj").exists()


# --- tasks and formats ---------------------------------------------------------------------


def job(folder: Path, name: str, text: str) -> Path:
    (folder / name).write_text(text)
    if "unduloid.obj" in text:
        shutil.copy(ROOT / "assets/modules/unduloid.obj", folder)
    return folder / name


@pytest.mark.parametrize(
    ("name", "text", "role", "task"),
    [
        ("fit", DISC + "[fit]\nrise = 0.3\n", "FIT", "fit"),
        ("close", COURT, "F_PLUS", "close"),
        ("each", COURT + 'by = "both"\nmove = { 1 = ["x", "y"] }\n', "F_PLUS", "close"),
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
    bpy.ops.cmc.fit_outline(fit_rise=0.3)
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    assert cli.run([str(path), "-o", str(tmp_path / "1"), "-f", "ply"]) == 0
    assert [report(tmp_path / "1/in" / name)["task"] for name in "AB"] == ["fit", "solve"]
    assert cli.run([str(path), "-o", str(tmp_path / "2"), "-f", "ply", "--fit-rise", "0.6"]) == 0
    rises = [report(tmp_path / "2/in" / name)["sheets"]["f+"]["rise"] for name in "AB"]
    assert_allclose(rises, 0.6 * 4.0, rtol=1e-3)
    assert cli.run([str(path), "-o", str(tmp_path / "3"), "-f", "ply", "--task", "solve"]) == 0
    assert [report(tmp_path / "3/in" / name)["task"] for name in "AB"] == ["solve", "solve"]


def test_settings_of_another_task_are_refused(tmp_path, capsys):
    assert cli.run(["a.blend", "--task", "solve", "--fit-rise", "0.6"]) == 2
    assert "--fit-rise goes with --task fit, not with solve" in capsys.readouterr().err


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


# --- provenance and resuming ---------------------------------------------------------------


def test_reports_say_where_they_come_from(tmp_path):
    path = plans(tmp_path / "in.blend", "A")
    assert cli.run([str(path), "-o", str(tmp_path / "out"), "-f", "glb", "--span", "12"]) == 0
    made = report(tmp_path / "out/in/A")["made"]
    assert (made["program"], made["blender"]) == (PROGRAM, bpy.app.version_string)
    assert list(made["input"]) == ["in.blend"] and made["settings"]["span"] == 12.0 and made["time"].endswith("Z")
    assert made["conditions"] == [{"name": "rim", "kind": "binormal", "edges": 24, "tilt": pytest.approx(0.2)}]
    assert made["files"] == {"shell.glb": (tmp_path / "out/in/A/shell.glb").stat().st_size}


def test_reports_of_the_window_do_so_too():
    plan = quad_disc("A", rings=4)
    activate(plan)
    bpy.ops.cmc.solve()
    bpy.ops.cmc.fit_outline(fit_rise=0.3)
    for text in (plan.cmc.report, plan.cmc.design_report):
        made = json.loads(text)["made"]
        assert made["program"] == PROGRAM and list(made["input"]) == ["A"] and made["seconds"] > 0


def test_two_runs_into_one_folder_do_not_mix(tmp_path):
    path, out = plans(tmp_path / "in.blend", "A"), tmp_path / "out/in/A"
    assert cli.run([str(path), "-o", str(tmp_path / "out"), "-f", "glb"]) == 0
    (out / "notes.txt").write_text("mine")
    assert cli.run([str(path), "-o", str(tmp_path / "out"), "-f", "obj"]) == 0  # the same shell in another format
    assert files(out) == ["notes.txt", "report.json", "shell.glb", "shell.mtl", "shell.obj"]
    assert set(report(out)["made"]["files"]) == {"shell.glb", "shell.mtl", "shell.obj"}
    assert cli.run([str(path), "-o", str(tmp_path / "out"), "-f", "stl", "--span", "9"]) == 0  # another shell
    assert files(out) == ["notes.txt", "report.json", "shell.stl"]


def test_resume_does_the_rest_only(tmp_path, capsys):
    path, out = plans(tmp_path / "in.blend", "A", "B", "C"), tmp_path / "out/in"
    arguments = [str(path), "-o", str(tmp_path / "out"), "-f", "obj"]
    assert cli.run(arguments) == 0
    (out / "B/shell.obj").unlink()
    before = (out / "A/shell.obj").stat().st_mtime_ns
    capsys.readouterr()
    assert cli.run([*arguments, "--resume"]) == 0
    shown = capsys.readouterr().out
    assert shown.count("skipped") == 2 and (out / "B/shell.obj").exists()
    assert (out / "A/shell.obj").stat().st_mtime_ns == before
    assert cli.run([*arguments, "--resume", "--span", "9"]) == 0
    assert "skipped" not in capsys.readouterr().out


def test_resume_with_the_scene(tmp_path, capsys):
    """It holds all plans, so it is done as a whole."""
    path, out = plans(tmp_path / "in.blend", "A", "B"), tmp_path / "out/in"
    arguments = [str(path), "-o", str(tmp_path / "out"), "-f", "blend", "obj", "--resume"]
    assert cli.run(arguments) == 0
    assert cli.run(arguments) == 0
    assert capsys.readouterr().out.count("skipped") == 2
    (out / "in.blend").unlink()
    assert cli.run(arguments) == 0
    assert "skipped" not in capsys.readouterr().out and (out / "in.blend").exists()


def test_processes_and_json(tmp_path, capsys):
    for name in ("a", "b", "c"):
        job(tmp_path, f"{name}.toml", DISC)
    inputs = [str(tmp_path / f"{name}.toml") for name in ("a", "b", "c")]
    arguments = ["-o", str(tmp_path / "out"), "-f", "glb", "--jobs", "2", "--json"]
    assert cli.run([*inputs, str(tmp_path / "no.blend"), *arguments]) == 2
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert {(Path(line["input"]).stem, line["code"]) for line in lines} == {("a", 0), ("b", 0), ("c", 0), ("no", 2)}
    assert all((tmp_path / f"out/{name}/{name}/shell.glb").exists() for name in ("a", "b", "c"))


# --- faults --------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", ["glb", "obj", "blend"])
def test_half_a_file_never_replaces_a_whole_one(tmp_path, capsys, monkeypatch, suffix):
    """On a full disk Blender's exporters write a part, and say that they have finished."""
    path, out = plans(tmp_path / "in.blend", "A"), tmp_path / "out"
    assert cli.run([str(path), "-o", str(out), "-f", suffix, "stl"]) == 0
    before = {name: (out / name).read_bytes() for name in files(out)}
    real = exporters.call

    def half(operator, complaint, **arguments):
        real(operator, complaint, **arguments)
        file = Path(arguments["filepath"])
        if file.suffix == f".{suffix}" and ".export-" in str(file):
            file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])

    monkeypatch.setattr(exporters, "call", half)
    assert cli.run([str(path), "-o", str(out), "-f", suffix, "stl", "--span", "9"]) == 1
    assert f".{suffix} cannot be written: only a part of it was; the disk may be full." in capsys.readouterr().err
    if suffix == "blend":  # the plan itself is written
        before = {name: before[name] for name in ("in/in.blend", "in/plans.json")}
    else:  # which says what became of the plans
        del before["in/plans.json"]
    assert {name: (out / name).read_bytes() for name in before} == before
    assert list(out.rglob(".*")) == []


def test_an_error_of_the_program_is_a_sentence_and_the_next_plan_is_formed(tmp_path, capsys, monkeypatch):
    from cmc_formfinding.cmc_addon.tasks.solve import SolveTask

    path, real = plans(tmp_path / "in.blend", "A", "B"), SolveTask.work

    def broken(self, progress):
        if self.name == "A":
            raise ZeroDivisionError("of a length")
        return real(self, progress)

    monkeypatch.setattr(SolveTask, "work", broken)
    assert cli.run([str(path), "-o", str(tmp_path / "out"), "-f", "glb"]) == 1
    error = capsys.readouterr().err
    assert "A: An error of the program itself (ZeroDivisionError: of a length); please report it" in error
    assert "Traceback (" in (tmp_path / "out/cmc.log").read_text() and "Traceback (" not in error
    assert "ZeroDivisionError" in report(tmp_path / "out/in/A")["error"]
    assert (tmp_path / "out/in/B/shell.glb").exists()


def test_ctrl_c_ends_the_run(tmp_path, capsys, monkeypatch):
    import signal

    from cmc_formfinding.cmc_addon.tasks.solve import SolveTask

    path = plans(tmp_path / "in.blend", "A", "B")
    monkeypatch.setattr(SolveTask, "work", lambda *_: os.kill(os.getpid(), signal.SIGINT))
    assert cli.run([str(path), "-o", str(tmp_path / "out"), "-f", "glb"]) == 130
    assert capsys.readouterr().err.count("Interrupted") == 1 and files(tmp_path / "out") == []


def test_what_killed_runs_left_is_removed(tmp_path):
    path = plans(tmp_path / "in.blend", "A")
    left = [tmp_path / place / ".export-abc" for place in ("out", "out/in", "out/in/A")]
    for folder in left:
        folder.mkdir(parents=True)
        (folder / "shell.glb").write_text("half")
    assert cli.run([str(path), "-o", str(tmp_path / "out"), "-f", "glb"]) == 0
    assert not any(folder.exists() for folder in left)


def test_memory_stays_flat(tmp_path):
    """Forty plans take no more than ten: results go when they are in files."""
    grown = []
    for count in (10, 40):
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        path = plans(tmp_path / f"{count}.blend", *[f"P{number}" for number in range(count)])
        assert cli.run([str(path), "-o", str(tmp_path / "out"), "-f", "glb"]) == 0
        assert not [ob for ob in bpy.data.objects if ob.cmc.role != "NONE"]
        grown.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
    assert grown[1] - grown[0] < 30.0


def test_the_documented_call(tmp_path, monkeypatch):
    """Under the name that the package has here."""
    page = (ROOT / "docs/how-to/headless.md").read_text(encoding="utf-8").split("## From Python")[1]
    lines = [line[4:] for line in page.splitlines() if line.startswith("    ")]
    monkeypatch.chdir(tmp_path)
    plans(tmp_path / "hall.blend", "A")
    names: dict[str, object] = {}
    exec("\n".join(lines).replace("bl_ext.user_default.", ""), names)
    assert names["code"] == 0 and (tmp_path / "out/hall/hall.blend").exists()
