"""The bubbles in assets/: each is an asset on its shelf, is solved and completed, and has a job that does the same."""

from __future__ import annotations

import json
import shutil

import bpy
import numpy as np
import pytest

from .test_assets import ASSETS, catalogue, opened

BUBBLES = {file.stem: file for file in sorted((ASSETS / "bubbles").glob("*.blend"))}
COPIES = {"wente": 24, "torus": None, "ring": 9}
EULER = {"wente": 0, "torus": 0, "ring": -54}
"""Euler characteristic of the whole."""


def test_every_bubble_of_the_menu_is_there(addon):
    from cmc_formfinding.cmc_addon.operators.add_bubble import BUBBLES as OFFERED

    assert {name.upper() for name in BUBBLES} == {identifier for identifier, _, _ in OFFERED}


@pytest.mark.parametrize("name", BUBBLES)
def test_the_bubble_is_an_asset_that_is_solved(name):
    plan = opened(BUBBLES[name])
    data = plan.asset_data
    assert catalogue()[data.catalog_id] == "CMC Form-Finding/Bubbles"
    assert len(data.description) > 30 and len(data.tags) >= 2
    picture = np.array(plan.preview.image_pixels_float[:]).reshape(-1, 4)
    assert len(picture) >= 128**2 and picture[:, :3].std() > 0.05, "the preview is a picture of something"
    assert bpy.ops.cmc.solve() == {"FINISHED"}
    assert json.loads(plan.cmc.report)["converged"]
    whole = plan.cmc.f_plus.data
    if COPIES[name] is not None:
        assert bpy.ops.cmc.complete() == {"FINISHED"}
        assert json.loads(plan.cmc.complete_report)["copies"] == COPIES[name]
        whole = plan.cmc.completed.data
    assert len(whole.vertices) - len(whole.edges) + len(whole.polygons) == EULER[name]


@pytest.mark.parametrize("name", BUBBLES)
def test_the_job_does_the_same(name, tmp_path):
    from cmc_formfinding.solver.jobs.job import load_job, run_job

    folder, made = tmp_path / "assets" / "bubbles", tmp_path / "build" / "jobs"
    folder.mkdir(parents=True)
    for file in BUBBLES[name].parent.glob(f"{name}.*"):
        shutil.copy(file, folder)
    assert run_job(load_job(folder / f"{name}.toml")).ok
    reported = json.loads((made / f"{name}.json").read_text())
    if COPIES[name] is not None:
        assert reported["completed"]["copies"] == COPIES[name] and reported["completed"]["relative_gap"] < 2e-3
    else:
        assert reported["index"] > 5 and reported["gap"] < 1e-5
    assert (made / f"{name}.obj").stat().st_size > 100_000


def test_a_job_with_a_start_is_opened_in_blender(tmp_path):
    """As `blender --command cmc torus.toml` does; its torus is the one of the job."""
    from cmc_formfinding.cmc_addon.headless import cli

    out = tmp_path / "out"
    assert cli.run([str(BUBBLES["torus"].with_suffix(".toml")), "--output", str(out)]) == 0
    reported = json.loads((out / "torus" / "torus" / "report.json").read_text())
    assert reported["converged"] and reported["index"] > 5
