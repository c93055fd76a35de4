"""What README and docs show to type runs: every job and every command, in a copy of the assets."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from solver.jobs import job
from tests.solver.test_docs import IDS, PAGES, ROOT, blocks

# Commands that no test runs, by how they begin, and why.
LEFT_OUT = {
    "make ": "the tests are a part of it",
    "pip install": "it would change this environment",
    "blender ": "tests/blender/test_docs_commands.py runs them",
    ".venv/bin/python -m pytest": "that test runs here anyway",
    ".venv/bin/python -m scripts.tables.measure_periods --write": "it rewrites docs/measured",
    ".venv/bin/python -m scripts.tables.measure_faces discs": "a minute and a half; the rates have a test of their own",
    ".venv/bin/python scripts/build/": "it rewrites the manifest",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the assets, where results go to build/."""
    there = tmp_path_factory.mktemp("docs")
    shutil.copytree(ROOT / "assets", there / "assets")
    return there


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_job_examples_run(page: Path, folder: Path):
    """As they are; their meshes are the assets of that name."""
    for example in blocks(page, "toml"):
        shell = job.run_job(job.make_job(tomllib.loads(example), folder / "assets" / "job.toml"))
        assert shell.ok, f"{example}\n{shell.message}"


def commands(page: Path) -> list[str]:
    """The lines of console examples and of indented blocks that begin with a program, without their comments."""
    text = page.read_text(encoding="utf-8")
    lines = "".join(blocks(page, "console")).splitlines()
    lines += re.findall(r"^    ((?:make|cmc|pip|python|blender|\.venv/\S+) .*)$", text, flags=re.MULTILINE)
    return [line.partition(" #")[0].strip() for line in lines]


def expanded(folder: Path, argument: str) -> list[str]:
    """The files that a shell would name."""
    if "*" not in argument:
        return [argument]
    return sorted(str(file.relative_to(folder)) for file in folder.glob(argument))


def job_called(name: str, text: str) -> str:
    """A job with results of its own, since two jobs of a run may not write one file."""
    stem = Path(name).stem
    return re.sub(r'^(f_plus|f_minus|g|gauss|report) = "', rf'\1 = "{stem}-', text, flags=re.MULTILINE)


def test_there_are_commands():
    assert sum(len(commands(page)) for page in PAGES) > 15


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_commands_run(page: Path, folder: Path):
    """A job named on a page that shows one is the one shown."""
    for command in commands(page):
        if any(command.startswith(beginning) for beginning in LEFT_OUT):
            continue
        program, *arguments = shlex.split(command)
        if program == "cmc":
            arguments = ["-m", "solver", *arguments]
        else:
            assert program in ("python", ".venv/bin/python"), f"{page}: {command}"
        shown = folder if "assets/" in command else folder / "assets"
        arguments = [name for argument in arguments for name in expanded(shown, argument)]
        for name in arguments:
            if name.endswith(".toml") and not (shown / name).exists():
                (shown / name).write_text(job_called(name, blocks(page, "toml")[0]), encoding="utf-8")
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        ended = subprocess.run(
            [sys.executable, *arguments], cwd=shown, env=environment, capture_output=True, text=True, check=False
        )
        assert ended.returncode == 0, f"{page}: {command}\n{ended.stderr}"


def test_what_is_left_out_is_there():
    shown = [command for page in [*PAGES, ROOT / "CONTRIBUTING.md"] for command in commands(page)]
    for beginning in LEFT_OUT:
        assert any(command.startswith(beginning) for command in shown), beginning
