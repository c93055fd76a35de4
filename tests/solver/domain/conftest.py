"""A machine without libigl."""

from __future__ import annotations

import sys

import pytest


@pytest.fixture
def without_libigl(monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "igl", None)  # makes the import fail
