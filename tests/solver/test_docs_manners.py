"""The page for Python shows what results can do, and the short forms that a newcomer would type."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "how-to" / "from-python.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["ok", "message", "pickle", "save", "to_trimesh", "to_pyvista()", "read_plan"])
def test_the_page_shows(name):
    assert name in PAGE


def test_examples_give_shapes_and_names_of_sides():
    for text in (PAGE, (ROOT / "README.md").read_text(encoding="utf-8")):
        assert 'conditions.binormal(plan, "outer"' in text
        assert '.sides["' not in text.split("## Mirrors")[0]


@pytest.mark.parametrize("page", ["README.md", "docs/how-to/job.md", "docs/reference/job-file.md"])
def test_the_installed_command_is_named(page):
    assert "cmc " in (ROOT / page).read_text(encoding="utf-8").replace("--command cmc", "")
