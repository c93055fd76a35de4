"""`make demo` without the rendering, and the scripts in docs/reference/blender.md."""

from __future__ import annotations

import json
import re
from pathlib import Path

import bpy
import numpy as np
import pytest
import trimesh

from .scenes import mesh_object

ROOT = Path(__file__).parents[2]


@pytest.fixture
def demo(monkeypatch, tmp_path):
    """The module of the demo, writing somewhere else and with a camera that takes no time."""
    from scripts.gallery import demo as module

    monkeypatch.setattr(module.blender_session, "ROOT", tmp_path)
    monkeypatch.setattr(module, "OUTPUT", tmp_path / "build" / "demo")
    monkeypatch.setattr(module, "EDGE_LENGTH", 0.8)
    render = module.scene.render
    monkeypatch.setattr(module.scene, "render", lambda path, *_, **__: render(path, 64, 40, 1))
    return module


def test_the_demo_leaves_four_files_and_nothing_else(demo, tmp_path, capsys):
    assert demo.main() == 0
    folder = tmp_path / "build" / "demo"
    assert {file.name for file in folder.iterdir()} == {
        "pavilion.blend", "pavilion.glb", "pavilion.png", "report.json",
    }  # fmt: skip
    report = json.loads((folder / "report.json").read_text())
    assert report["converged"] and report["sheets"]["f+"]["intersections"]["count"] == 0
    printed = capsys.readouterr().out
    assert f"{report['sheets']['f+']['span']:.1f} m" in printed and "pavilion.glb" in printed


def test_the_glb_of_the_demo_carries_its_uvs(demo, tmp_path, capsys):
    demo.main()
    scene = trimesh.load(tmp_path / "build" / "demo" / "pavilion.glb")
    (shell,) = scene.geometry.values()
    uv = shell.visual.uv
    assert uv.shape == (len(shell.vertices), 2)
    assert np.ptp(uv, axis=0).min() > 10.0, "plan coordinates in metres"
    assert sorted(shell.extents)[0] > 3.0, "a shell, not a plan"


def test_the_blend_of_the_demo_opens_ready_to_render(demo, tmp_path, capsys):
    demo.main()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "build" / "demo" / "pavilion.blend"), load_ui=False)
    scene = bpy.context.scene
    assert scene.camera is not None and scene.render.engine == "CYCLES"
    shell = bpy.data.objects["Rounded Pavilion f+"]
    assert not shell.hide_render and bpy.data.objects["Rounded Pavilion g"].hide_render
    assert shell.material_slots[0].material.name == "Plaster"
    assert shell.cmc.source.name == "Rounded Pavilion"


def text() -> str:
    return (ROOT / "docs" / "reference" / "blender.md").read_text(encoding="utf-8")


def test_scripts_in_the_documentation_run(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)  # "//hall.glb" of a file that was never saved
    (example,) = re.findall(r"^```py\n(.*?)^```", text(), flags=re.DOTALL | re.MULTILINE)
    corners = [(0, 0, 0), (18, 0, 0), (18, 12, 0), (0, 12, 0)]
    around = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    rings = [(r * np.cos(a), r * np.sin(a), 1 - r**2 / 2) for r in (0.4, 0.7, 1.0) for a in around]
    inner = [24 * k + i for k in (0, 1) for i in range(24)]
    quads = [(a, a + 24, after + 24, after) for a in inner for after in [a - a % 24 + (a + 1) % 24]]
    mesh_object("Dome", rings, [tuple(range(24)), *quads])
    mesh_object("Hall", corners, [(0, 1, 2, 3)])
    names: dict[str, object] = {}
    exec(compile(example, "docs/reference/blender.md", "exec"), names)
    assert names["shell"].name == "Hall Plan f+"
    assert bpy.data.objects["Dome"].cmc.nearest["cmc_met"]
    assert json.loads(bpy.context.object.cmc.report)["closing"]["closed"]
    assert np.isclose(json.loads(names["plan"].cmc.report)["sheets"]["f+"]["span"], 18.0)


def test_the_documentation_knows_the_kinds_and_the_panels():
    from cmc_formfinding.solver.gauss.conditions import KINDS

    for kind in KINDS.values():
        assert f"| {kind.label} |" in text(), kind.label
    for panel in ("plan", "boundary", "shell", "options", "results", "checks", "solver"):
        label = getattr(bpy.types, f"CMC_PT_{panel}").bl_label
        assert f"*{label}*" in text() or f"## {label}" in text(), label
