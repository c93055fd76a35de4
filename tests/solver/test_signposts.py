"""The table "Where is, or where do I add" of CONTRIBUTING leads to files, and to names that are in them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TABLE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").partition("where do I add:")[2].partition("\n## ")[0]
NAMED = re.findall(r"`([A-Za-z_]+)` (?:of its class )?in `([\w./]+)`", TABLE)
FILES = re.findall(r"`((?:solver|cmc_addon|docs)/[\w./-]+)`", TABLE)


def test_there_are_signposts():
    assert len(NAMED) >= 8 and len(FILES) >= 14


@pytest.mark.parametrize(("name", "file"), NAMED)
def test_a_name_is_where_the_table_says(name: str, file: str):
    path = ROOT / file
    sources = path.rglob("*.py") if path.is_dir() else [path]
    assert any(re.search(rf"\b{name}\b", source.read_text(encoding="utf-8")) for source in sources)


@pytest.mark.parametrize("file", FILES)
def test_a_file_exists(file: str):
    assert (ROOT / file).exists()
