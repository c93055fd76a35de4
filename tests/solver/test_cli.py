"""The command `cmc`, which is `python -m solver`: exit codes, one sentence on stderr, help."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from solver import __version__
from solver.__main__ import main

ROOT = Path(__file__).parents[2]
DISC = "[shape]\nkind = 'disc'\nn = 100\nscale = 5\n"


@pytest.fixture
def job(tmp_path):
    def write(text: str, name: str = "job.toml") -> str:
        (tmp_path / name).write_text(text)
        return str(tmp_path / name)

    return write


def test_done(job, tmp_path, capsys):
    assert main([job(DISC + "[output]\nf_plus = 'shell.obj'")]) == 0
    shown = capsys.readouterr()
    assert "f+: span 10" in shown.out
    assert f"f+ → {tmp_path / 'shell.obj'}" in shown.out
    assert (tmp_path / "shell.obj").exists()


def test_quiet_and_verbose(job, capsys):
    assert main(["-q", job(DISC)]) == 0
    assert capsys.readouterr().out == ""
    assert main(["--verbose", job(DISC)]) == 0
    assert "step 1: residual" in capsys.readouterr().err


def test_a_bad_job(job, tmp_path, capsys):
    assert main([job(DISC + "[siez]\nspan = 3")]) == 2
    error = capsys.readouterr().err
    assert error == f'{tmp_path / "job.toml"}: unknown key "siez"; did you mean "size"?\n'


def test_a_mesh_that_is_no_plan(job, tmp_path, capsys):
    (tmp_path / "one.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    path = job("mesh = 'one.obj'")
    assert main([path]) == 2
    assert capsys.readouterr().err.startswith(f"{path}: The mesh (1 triangle) has no vertex inside")


def test_a_solve_that_does_not_converge(job, capsys):
    path = job(DISC + "[default]\ntilt = 20\n[solver]\ntolerance = 1e-15")
    assert main([path]) == 1
    assert path in capsys.readouterr().err


def test_a_shell_that_cannot_be_placed(job, capsys):
    assert main([job(DISC + "[size]\nsheet = 'f-'")]) == 1
    assert "f- degenerates to a point" in capsys.readouterr().err


def test_a_file_that_cannot_be_written(job, tmp_path, capsys):
    (tmp_path / "taken").write_text("a file where a folder is wanted")
    assert main([job(DISC + "[output]\nf_plus = 'taken/shell.obj'")]) == 1
    assert "shell.obj cannot be written" in capsys.readouterr().err


def test_one_failure_does_not_stop_the_rest(job, tmp_path, capsys):
    bad = job(DISC + "x = 1", "bad.toml")
    good = job(DISC + "[output]\nreport = 'report.json'", "good.toml")
    assert main([bad, good]) == 2
    assert (tmp_path / "report.json").exists()
    assert "bad.toml" in capsys.readouterr().err


def test_help_shows_a_job(capsys):
    with pytest.raises(SystemExit) as left:
        main(["--help"])
    assert left.value.code == 0
    shown = capsys.readouterr().out
    assert "[[conditions]]" in shown
    assert "exit code" in shown


def test_arguments_are_checked(capsys):
    with pytest.raises(SystemExit) as left:
        main([])
    assert left.value.code == 2
    assert "job.toml" in capsys.readouterr().err


def test_as_a_module_from_anywhere(job, tmp_path):
    """The real command in a process of its own: version, exit code, no traceback."""

    def call(*arguments: str) -> subprocess.CompletedProcess[str]:
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        command = [sys.executable, "-m", "solver", *arguments]
        return subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)

    assert call("--version").stdout.strip() == f"cmc-formfinding {__version__}"
    failed = call("nosuch.toml")
    assert failed.returncode == 2
    assert failed.stderr == "nosuch.toml cannot be read: No such file or directory.\n"


def test_the_command_is_called_cmc(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    assert capsys.readouterr().out.startswith("usage: cmc ")
