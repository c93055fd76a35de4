"""Blender in this process with the add-on enabled from this checkout, for scripts that draw or solve.

The checkout is linked into a temporary folder as the package `cmc_formfinding`, as in the tests: the scripts
reach the solver through it, and the user's own Blender settings are left alone.
"""

from __future__ import annotations

import atexit
import os
import shutil
import sys
import tempfile
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = "cmc_formfinding"


def start() -> ModuleType:
    """Start Blender with an empty scene and the add-on enabled; returns its package. Later calls only return it."""
    if PACKAGE in sys.modules:
        return sys.modules[PACKAGE]
    scratch = Path(tempfile.mkdtemp(prefix="cmc-script-"))
    atexit.register(shutil.rmtree, scratch, ignore_errors=True)
    os.environ["BLENDER_USER_RESOURCES"] = str(scratch)
    (scratch / "packages").mkdir()
    (scratch / "packages" / PACKAGE).symlink_to(ROOT, target_is_directory=True)
    sys.path.insert(0, str(scratch / "packages"))
    import bpy  # reads the environment when it is imported

    # isort: split
    import addon_utils  # is on the path once bpy is imported

    bpy.ops.wm.read_factory_settings(use_empty=True)
    failures: list[BaseException] = []
    package = addon_utils.enable(PACKAGE, default_set=True, handle_error=failures.append)
    if failures:
        raise failures[0]
    assert package is not None
    return package


def empty_scene() -> None:
    """Open an empty file; the add-on stays enabled."""
    import bpy

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True, load_ui=False)
