"""What the package shows of itself: public names, its opening example, its types, and the command `cmc`."""

from __future__ import annotations

import importlib
import inspect
import textwrap
import tomllib
from pathlib import Path

import pytest

import solver

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def test_dir_lists_the_public_names_only():
    assert dir(solver) == solver.__all__ == sorted(solver.__all__)
    assert all(hasattr(solver, name) for name in dir(solver))
    assert not {"catalogue", "domain", "gauss", "measure", "surface", "linalg", "errors"} & set(dir(solver))


def test_every_public_name_says_what_it_is():
    for name in solver.__all__:
        text = inspect.getdoc(getattr(solver, name)) or ""
        assert text and not text.startswith(f"{name}("), name


def test_the_opening_example_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    exec(textwrap.dedent((solver.__doc__ or "").partition("::\n")[2]), names)
    assert (tmp_path / "shell.obj").stat().st_size > 0
    assert str(names["text"]).startswith("Done. Curvature is even to")


def test_types_are_shipped():
    assert (Path(solver.__file__).parent / "py.typed").exists()
    assert PROJECT["tool"]["setuptools"]["package-data"]["solver"] == ["py.typed"]
    assert PROJECT["project"]["version"] == solver.__version__


def test_the_command_is_a_script_that_returns_its_exit_code(tmp_path, monkeypatch, capsys):
    module, _, name = PROJECT["project"]["scripts"]["cmc"].partition(":")
    main = getattr(importlib.import_module(module), name)
    monkeypatch.setattr("sys.argv", ["cmc", str(tmp_path / "missing.toml")])
    assert main() == 2
    assert "missing.toml" in capsys.readouterr().err
    monkeypatch.setattr("sys.argv", ["cmc", "--version"])
    with pytest.raises(SystemExit) as stopped:
        main()
    assert stopped.value.code == 0 and solver.__version__ in capsys.readouterr().out
