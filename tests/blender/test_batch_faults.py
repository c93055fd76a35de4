"""Batches that meet full disks, errors and Ctrl-C, and their memory."""

from __future__ import annotations

import os
import resource
from pathlib import Path

import bpy

# isort: split
import pytest
from cmc_formfinding.cmc_addon.headless import cli, exporters

from .batches import files, plans, report


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
