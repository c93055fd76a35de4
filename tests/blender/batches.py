"""Inputs of batches, and what they leave on the disk."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import bpy

from .conftest import ROOT
from .scenes import add_group, boundary_edges, quad_disc

DISC = '[shape]\nkind = "disc"\nn = 200\nscale = 5.0\n'


def plans(path: Path, *names: str, scale: float = 1.0) -> Path:
    """A .blend with a disc for each name."""
    bpy.context.scene.unit_settings.scale_length = scale
    for number, name in enumerate(names):
        disc = quad_disc(name, rings=4)
        disc.location.x = 3.0 * number
        add_group(disc, "rim", boundary_edges(disc.data), "BINORMAL", tilt=0.2)
    path.parent.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


def report(folder: Path) -> dict:
    return json.loads((folder / "report.json").read_text())


def files(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def job(folder: Path, name: str, text: str) -> Path:
    (folder / name).write_text(text)
    if "unduloid.obj" in text:
        shutil.copy(ROOT / "assets/modules/unduloid.obj", folder)
    return folder / name
