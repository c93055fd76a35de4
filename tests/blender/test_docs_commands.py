"""The commands for Blender that README and docs show run, with files of the names they use."""

from __future__ import annotations

import ast
import re
import shlex
import shutil
from glob import glob
from pathlib import Path

import pytest
from cmc_formfinding.cmc_addon.headless import cli

from .conftest import ROOT

ASSETS = ROOT / "assets"
# Stand-ins for the files of the examples.
FILES = {
    ".blend": ASSETS / "hall.blend",
    ".toml": ASSETS / "jobs" / "canopy.toml",
    ".obj": ASSETS / "jobs" / "canopy.obj",
}


def examples() -> list[str]:
    """The arguments of `blender --command cmc …` and of `cli.run([…])`, each once."""
    found = []
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))):
        text = page.read_text(encoding="utf-8")
        found += re.findall(r"^(?:    )?blender --command cmc (.*)$", text, flags=re.MULTILINE)
        found += [shlex.join(ast.literal_eval(given)) for given in re.findall(r"cli\.run\((\[.*\])\)", text)]
    return list(dict.fromkeys(line.partition(" #")[0].strip() for line in found))


def test_there_are_commands():
    assert len(examples()) >= 3


@pytest.mark.parametrize("command", examples())
def test_commands_run(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(FILES[".obj"], tmp_path)  # the mesh of the job
    arguments = shlex.split(command)
    for name in [argument.replace("*", "hall") for argument in arguments]:
        if (suffix := Path(name).suffix) in FILES:
            asset = ASSETS / name
            (tmp_path / name).parent.mkdir(exist_ok=True)
            shutil.copy(asset if suffix == ".blend" and asset.is_file() else FILES[suffix], tmp_path / name)
    arguments = [part for argument in arguments for part in (sorted(glob(argument)) if "*" in argument else [argument])]
    assert cli.run(arguments) == 0
    assert list(tmp_path.rglob("report.json"))
