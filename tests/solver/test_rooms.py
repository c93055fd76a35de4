"""The opening docstring of a room ends with an example; it runs as it stands, with the public names and numpy."""

from __future__ import annotations

import ast
import textwrap
from pathlib import Path

import numpy as np
import pytest

import solver

ROOMS = Path(solver.__file__).parent
WITH_EXAMPLE = {"domain", "gauss", "io", "meshing"}


def example_of(docstring: str) -> str:
    """The indented block after a line that ends with `::`, or ""."""
    lines = iter(docstring.splitlines())
    for line in lines:
        if line.endswith("::"):
            break
    block = []
    for line in lines:
        if line.strip() and not line.startswith("    "):
            break
        block.append(line)
    return textwrap.dedent("\n".join(block)).strip()


def examples() -> dict[str, str]:
    result = {}
    for path in sorted(ROOMS.glob("*/__init__.py")):
        docstring = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
        if text := example_of(docstring):
            result[path.parent.name] = text
    return result


@pytest.mark.parametrize("room", sorted(WITH_EXAMPLE | examples().keys()))
def test_the_example_of_a_room_runs(room, tmp_path, monkeypatch):
    text = examples().get(room)
    assert text, f"the docstring of solver/{room}/__init__.py has no example"
    monkeypatch.chdir(tmp_path)
    names = {name: getattr(solver, name) for name in solver.__all__} | {"np": np}
    exec(compile(text, f"solver/{room}/__init__.py", "exec"), names)


def test_an_example_ends_with_its_indentation():
    docstring = "A room.\n\nWords::\n\n    a = 1\n\n    b = 2\nMore words.\n    c = 3"
    assert example_of(docstring) == "a = 1\n\nb = 2"
    assert example_of("A room.") == ""
