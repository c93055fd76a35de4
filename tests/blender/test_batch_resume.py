"""Where the results of a batch come from, and what --resume does again; several processes."""

from __future__ import annotations

import json
from pathlib import Path

import bpy

# isort: split
import pytest
from cmc_formfinding.cmc_addon.headless import cli
from cmc_formfinding.solver.version import PROGRAM

from .batches import DISC, files, job, plans, report
from .scenes import activate, quad_disc


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
    for vertex in plan.data.vertices:
        vertex.co.z = -0.03 * (vertex.co.x**2 + vertex.co.y**2)
    bpy.ops.cmc.approximate_surface()
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
