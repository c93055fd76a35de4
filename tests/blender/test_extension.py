"""The zip for users: its contents, and whether it works in clean Blenders.

`make test-blender` builds it (dist/) and the environments (.venvs/), which have bpy and what bpy
itself depends on. scipy is not among these, so that the extension's own wheels are what is tested.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DRIVER = Path(__file__).with_name("install_and_solve.py")
BUILD = ROOT / "scripts" / "build" / "build_extension.py"
MANIFEST = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
BLENDERS = ("4.5", "5.0", "5.2")
WITHOUT_ENVIRONMENT = {"5.2": "no Python 3.13 was found on PATH or in ~/.pyenv/versions"}
GRID_VERTICES, GRID_FACES, GRID_SIZE = 81, 64, 2.0  # the plan of install_and_solve.py


@pytest.fixture(autouse=True)
def addon() -> None:
    """These tests leave the Blender of this process alone."""


@pytest.fixture(scope="module")
def archive() -> Path:
    """The newest zip for this machine."""
    stamp = ROOT / "dist" / "here"
    if not stamp.exists():
        pytest.fail("the extension is not built: run `make test-blender`, or `make dist/here` first")
    return ROOT / "dist" / stamp.read_text(encoding="utf-8").strip()


@pytest.fixture(scope="module", params=BLENDERS)
def facts(request: pytest.FixtureRequest, archive: Path, tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What happened in a clean Blender of each version."""
    version = request.param
    folder = ROOT / ".venvs" / f"bpy-{version}"
    if not (folder / "ready").exists():
        not_run(version)
    scratch = tmp_path_factory.mktemp(f"blender-{version}")
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    environment["BLENDER_USER_RESOURCES"] = str(scratch / "user")
    (scratch / "user").mkdir()
    command = [str(folder / "bin" / "python"), str(DRIVER), str(archive), str(scratch / "facts.json")]
    done = subprocess.run(command, env=environment, cwd=scratch, capture_output=True, text=True, timeout=300)
    output = done.stdout + done.stderr
    assert done.returncode == 0, output
    result = json.loads((scratch / "facts.json").read_text(encoding="utf-8"))
    return {**result, "version": version, "user": str(scratch / "user"), "output": output}


def not_run(version: str) -> None:
    """A missing environment is reported, and on a CI machine it is a failure."""
    reason = WITHOUT_ENVIRONMENT.get(version)
    if reason is None:
        pytest.fail(f"the environment .venvs/bpy-{version} is missing: run `make test-blender`")
    sentence = f"Blender {version} was not run: {reason}"
    if os.environ.get("CI", "").lower() in ("1", "true"):
        pytest.fail(sentence)
    pytest.skip(sentence)


def test_a_blender_that_cannot_run_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CI", raising=False)
    with pytest.raises(pytest.skip.Exception, match=r"Blender 5\.2 was not run: no Python 3\.13"):
        not_run("5.2")
    monkeypatch.setenv("CI", "true")
    with pytest.raises(pytest.fail.Exception, match=r"Blender 5\.2 was not run: no Python 3\.13"):
        not_run("5.2")


def test_is_the_blender_asked_for(facts: dict) -> None:
    assert facts["blender"].startswith(facts["version"] + ".")


def test_installs_and_enables(facts: dict) -> None:
    assert facts["bundled packages before"] == []
    assert facts["enabled"] == [True, True]


def test_solves(facts: dict) -> None:
    assert facts["solve"] == ["FINISHED"]
    assert facts["shells"], "no result object"
    vertices, faces, width, depth, rise = facts["shells"][0]
    assert (vertices, faces) == (GRID_VERTICES, GRID_FACES)
    assert 0.5 * GRID_SIZE < max(width, depth) < 1.5 * GRID_SIZE
    assert rise > 0.1 * GRID_SIZE
    assert {"cmc_normal", "cmc_mean_curvature"} <= set(facts["attributes"])


def test_solves_on_the_delaunay_triangulation(facts: dict) -> None:
    """By our own flips: there is no libigl."""
    assert not facts["libigl"]
    before, after = facts["weights"]
    assert before < -1 and after > 0.1
    assert facts["delaunay"] == ["converged", 25, 32]


def test_the_command_line_works(facts: dict) -> None:
    assert facts["command"] == 0
    assert {"shell.glb", "report.json"} <= set(facts["written"])


def test_uses_its_own_wheels(facts: dict) -> None:
    pins = dict(pin.split("==") for pin in PYPROJECT["dependency-groups"]["wheels"])
    assert set(facts["origins"]) == set(pins)
    for name, (path, version) in facts["origins"].items():
        assert Path(path).is_relative_to(Path(facts["user"]) / "extensions"), name
        assert version == pins[name]


def test_disables(facts: dict) -> None:
    assert facts["disabled"]
    assert facts["left"] == []


def test_says_nothing_alarming(facts: dict) -> None:
    """On the console: no traceback, and no warning of Blender's about our classes, wheels or files."""
    alarming = re.compile("traceback|exception|(warning|error).*(cmc|wheel|extension)", re.IGNORECASE)
    assert [line for line in facts["output"].splitlines() if alarming.search(line)] == []


def test_contents(archive: Path) -> None:
    with zipfile.ZipFile(archive) as built:
        names = built.namelist()
        manifest = tomllib.loads(built.read("blender_manifest.toml").decode())
    wheels = {name for name in names if name.endswith(".whl")}
    assert wheels == {wheel.removeprefix("./") for wheel in manifest["wheels"]}
    assert not any("numpy-" in name for name in wheels)
    assert not any("igl" in name for name in names)  # it contains Triangle, which the GPL does not allow
    others = {name.split("/")[0] for name in names} - {"wheels"}
    assert others <= {"__init__.py", "solver", "cmc_addon", "blender_manifest.toml", "LICENSE"} | {
        "README.md",
        "CHANGELOG.md",
        "help",
    }
    assert {"__init__.py", "solver", "cmc_addon", "LICENSE"} <= others
    assert not any("__pycache__" in name for name in names)
    pages = ("reference/blender", "reference/operators/solve", "reference/python/solve_cmc", "search")
    assert {f"help/{page}.html" for page in pages} <= set(names)
    assert not any(name.endswith(".md") for name in names if name.startswith("help/"))


def test_manifest_lists_every_pin_for_every_platform() -> None:
    files = [Path(wheel).name for wheel in MANIFEST["wheels"]]
    for pin in PYPROJECT["dependency-groups"]["wheels"]:
        wheels = [file for file in files if file.startswith(pin.replace("==", "-") + "-")]
        if any(file.endswith("-none-any.whl") for file in wheels):
            continue
        for platform in ("manylinux", "win_amd64", "macosx"):
            mine = [file for file in wheels if f"-{platform}" in file]
            assert len(mine) == 2, f"{pin} on {platform}: not one wheel for each of two Pythons, but {mine}"
            assert any("-cp311-cp311-" in file for file in mine)


def test_versions_agree() -> None:
    assert MANIFEST["version"] == PYPROJECT["project"]["version"]
    assert MANIFEST["license"] == [f"SPDX:{PYPROJECT['project']['license']}"]


def test_a_tag_blender_does_not_know_is_refused(tmp_path: Path) -> None:
    """The validation that the build runs is one that can fail."""
    sys.path.insert(0, str(BUILD.parent))
    try:
        from build_extension import blender_tool
    finally:
        sys.path.remove(str(BUILD.parent))
    tool, tags = blender_tool()
    text = (ROOT / "blender_manifest.toml").read_text(encoding="utf-8")
    (tmp_path / "__init__.py").touch()
    for tag, code in (("Mesh", 0), ("Shells", 1)):
        (tmp_path / "blender_manifest.toml").write_text(text.replace('"Mesh"', f'"{tag}"'), encoding="utf-8")
        command = [sys.executable, str(tool), "validate", f"--valid-tags={tags}", str(tmp_path)]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == code, done.stdout + done.stderr
