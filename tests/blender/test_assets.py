"""The plans in assets/: each opens, is an asset on its shelf, and Solve forms a shell worth standing under."""

from __future__ import annotations

import json
import re
from pathlib import Path

import bpy
import numpy as np
import pytest

from .scenes import boundary_edges, positions

ASSETS = Path(__file__).parents[2] / "assets"
BLENDS = sorted(ASSETS.glob("*.blend"))
PLANS = {"pavilion", "hall", "canopy", "courtyard", "market"}


def opened(file: Path) -> bpy.types.Object:
    """The plan of an asset file; the add-on stays enabled."""
    bpy.ops.wm.open_mainfile(filepath=str(file), load_ui=False)
    (plan,) = [ob for ob in bpy.data.objects if ob.asset_data is not None]
    bpy.context.view_layer.objects.active = plan
    return plan


def solved(plan: bpy.types.Object, **settings) -> tuple[bpy.types.Object, dict]:
    """The shell over a plan, and its report."""
    assert bpy.ops.cmc.solve(**settings) == {"FINISHED"}
    return plan.cmc.f_plus, json.loads(plan.cmc.report)


def test_every_plan_is_there_and_small():
    assert {file.stem for file in BLENDS} == PLANS
    assert {file.stem for file in ASSETS.glob("*.obj")} >= PLANS
    assert all(file.stat().st_size < 1_000_000 for file in ASSETS.rglob("*") if file.is_file())


def catalogue() -> dict[str, str]:
    """UUID → path of the asset browser's shelves."""
    text = (ASSETS / "blender_assets.cats.txt").read_text(encoding="utf-8")
    assert "VERSION 1" in text.splitlines()
    return dict(re.findall(r"^([0-9a-f-]{36}):([^:]+):[^:]+$", text, flags=re.MULTILINE))


@pytest.mark.parametrize("file", BLENDS, ids=lambda file: file.stem)
def test_the_plan_is_an_asset(file):
    plan = opened(file)
    data = plan.asset_data
    assert catalogue()[data.catalog_id] == "CMC Form-Finding/Plans"
    assert len(data.description) > 30 and len(data.tags) >= 2
    picture = np.array(plan.preview.image_pixels_float[:]).reshape(-1, 4)
    assert len(picture) >= 128**2 and picture[:, :3].std() > 0.05, "the preview is a picture of something"
    assert bpy.context.scene.unit_settings.system == "METRIC"
    assert {ob.name for ob in bpy.data.objects} == {plan.name}, "nothing else comes along"


@pytest.mark.parametrize("file", BLENDS, ids=lambda file: file.stem)
def test_the_plan_lies_flat_and_faces_up(file):
    plan = opened(file)
    points = positions(plan)
    np.testing.assert_allclose(points[:, 2], 0.0, atol=1e-6)
    assert min(polygon.normal.z for polygon in plan.data.polygons) > 0.999
    assert 10.0 < np.ptp(points, axis=0).max() < 80.0, "metres"


@pytest.mark.parametrize("file", BLENDS, ids=lambda file: file.stem)
def test_every_boundary_edge_is_in_a_group(file):
    mesh = opened(file).data
    uids = {group.uid for group in mesh.cmc.groups}
    values = [mesh.attributes["cmc_group"].data[int(edge)].value for edge in boundary_edges(mesh)]
    assert set(values) == uids, "no group is empty and no edge forgotten"


@pytest.mark.parametrize("file", BLENDS, ids=lambda file: file.stem)
def test_the_shell_stands(file):
    plan = opened(file)
    shell, report = solved(plan)
    measured = report["sheets"]["f+"]
    assert report["converged"] and not report["is_open"], report["sentence"]
    normals = np.array([item.vector[:] for item in shell.data.attributes["cmc_normal"].data])
    rim = np.unique([shell.data.edges[int(edge)].vertices[:] for edge in boundary_edges(shell.data)])
    inside = np.setdiff1d(np.arange(len(normals)), rim)
    assert normals[inside, 2].min() > 0.0
    assert measured["rise"] > 0.1 * measured["span"]
    assert measured["mean_curvature"]["relative_l2"] < 0.07
    assert measured["intersections"]["count"] == 0
    assert measured["overhang"]["area_share"] < 0.01
    np.testing.assert_allclose(positions(shell)[:, 2].min(), 0.0, atol=1e-5)


@pytest.mark.parametrize("file", BLENDS, ids=lambda file: file.stem)
def test_the_obj_is_the_same_plan(file):
    from cmc_formfinding.solver.io.mesh_files import read_mesh

    plan = opened(file)
    drawn = read_mesh(file.with_suffix(".obj"))
    np.testing.assert_allclose(drawn.positions, positions(plan), atol=1e-6)
    assert [polygon.tolist() for polygon in drawn.polygons] == [list(p.vertices) for p in plan.data.polygons]
    assert set(drawn.edge_groups) == {group.name for group in plan.data.cmc.groups}


def test_the_quad_plan_has_two_uv_layers_and_two_materials_and_so_has_its_shell():
    plan = opened(ASSETS / "market.blend")
    shell, _ = solved(plan)
    for ob in (plan, shell):
        assert {len(polygon.vertices) for polygon in ob.data.polygons} == {4}
        assert [layer.name for layer in ob.data.uv_layers] == ["Plan", "Grid"]
        assert [slot.material.name for slot in ob.material_slots] == ["Membrane", "Glass"]
        assert {polygon.material_index for polygon in ob.data.polygons} == {0, 1}


def test_the_canopy_has_different_tilts():
    plan = opened(ASSETS / "canopy.blend")
    tilts = {group.name: round(np.degrees(group.tilt)) for group in plan.data.cmc.groups}
    assert tilts == {"Platform": 65, "Street": 30, "Ends": 45}
