"""Blender in this process (the bpy module), with the add-on enabled from the sources.

The checkout is linked into a temporary folder as the package `cmc_formfinding` and enabled from
there. Tests reach the solver through it (`from cmc_formfinding.solver import …`), never as the
top-level `solver`, which would be a second copy of every class.
"""

from __future__ import annotations

import atexit
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = "cmc_formfinding"

SCRATCH = Path(tempfile.mkdtemp(prefix="cmc-blender-"))
atexit.register(shutil.rmtree, SCRATCH, ignore_errors=True)


class OneSolver:
    """Refuses the top-level names of what the add-on brings along."""

    def find_spec(self, name: str, path: object = None, target: object = None) -> None:
        if name in ("solver", "cmc_addon"):
            raise ImportError(f"Blender tests use the add-on's copy: import {PACKAGE}.{name}")


def prepare() -> None:
    """Before bpy is imported: user files of its own, the checkout on the path as a package."""
    if "solver" in sys.modules:
        raise pytest.UsageError("tests/blender needs a pytest process of its own; see `make test`")
    os.environ["BLENDER_USER_RESOURCES"] = str(SCRATCH / "user")
    (SCRATCH / "user").mkdir()
    packages = SCRATCH / "packages"
    packages.mkdir()
    (packages / PACKAGE).symlink_to(ROOT, target_is_directory=True)
    sys.path.insert(0, str(packages))
    sys.meta_path.insert(0, OneSolver())  # type: ignore[arg-type]


prepare()


@pytest.fixture(autouse=True)
def addon() -> Iterator[ModuleType]:
    """An empty scene in factory settings with the add-on enabled; the package `cmc_formfinding`."""
    import bpy

    # isort: split
    import addon_utils  # is on the path once bpy is imported

    bpy.ops.wm.read_factory_settings(use_empty=True)
    failures: list[BaseException] = []
    module = addon_utils.enable(PACKAGE, default_set=True, handle_error=failures.append)
    if failures:
        raise failures[0]
    assert module is not None
    yield module
    addon_utils.disable(PACKAGE, default_set=True, handle_error=failures.append)
    if failures:
        raise failures[0]
