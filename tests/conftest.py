"""What holds for every test."""

from __future__ import annotations

from pathlib import Path

import pytest

TESTS = Path(__file__).parent


def pytest_collection_finish(session: pytest.Session) -> None:
    """Refuse a run that would import the solver twice, as `solver` and as the extension's own copy."""
    rooms = {item.path.relative_to(TESTS).parts[0] for item in session.items if TESTS in item.path.parents}
    if {"solver", "blender"} <= rooms:
        raise pytest.UsageError(
            "tests/solver and tests/blender import the solver under two names and need a pytest "
            "process each: run them one after the other, or `make test`"
        )
