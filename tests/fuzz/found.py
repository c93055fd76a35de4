"""The cases that ended badly once: found.txt has a line for each, "generator:seed  what it was"."""

from __future__ import annotations

from pathlib import Path

FOUND = Path(__file__).with_name("found.txt")


def found() -> list[str]:
    """Their names."""
    return [line.split()[0] for line in FOUND.read_text(encoding="utf-8").splitlines() if line and line[0] != "#"]
