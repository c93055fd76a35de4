"""The modules in assets/: each is an asset on its shelf, completes itself, and has a job that does the same."""

from __future__ import annotations

import json
import shutil

import bpy
import numpy as np
import pytest

from .solved_modules import COPIES, FINISHED, completion_report
from .test_assets import ASSETS, catalogue, opened

MODULES = {file.stem: file for file in sorted((ASSETS / "modules").glob("*.blend"))}


def test_every_module_of_the_menu_is_there():
    assert {name.upper() for name in MODULES} == set(COPIES)


@pytest.mark.parametrize("name", MODULES)
def test_the_module_is_an_asset_that_completes_itself(name):
    plan = opened(MODULES[name])
    data = plan.asset_data
    assert catalogue()[data.catalog_id] == "CMC Form-Finding/Modules"
    assert len(data.description) > 30 and len(data.tags) >= 2
    picture = np.array(plan.preview.image_pixels_float[:]).reshape(-1, 4)
    assert len(picture) >= 128**2 and picture[:, :3].std() > 0.05, "the preview is a picture of something"
    assert {ob.name for ob in bpy.data.objects} == {plan.name}, "nothing else comes along"
    assert bpy.ops.cmc.solve() == FINISHED
    assert bpy.ops.cmc.complete() == FINISHED
    units = int(np.prod(list(plan.cmc.complete_repeat)))
    report = completion_report(plan)
    assert report["copies"] == units * COPIES[name.upper()] and report["relative_gap"] < 1e-3


@pytest.mark.parametrize("name", MODULES)
def test_the_job_does_the_same(name, tmp_path):
    from cmc_formfinding.solver.jobs.job import load_job, run_job

    folder, made = tmp_path / "assets" / "modules", tmp_path / "build" / "jobs"
    folder.mkdir(parents=True)
    for suffix in (".obj", ".toml"):
        shutil.copy(MODULES[name].with_suffix(suffix), folder)
    job = load_job(folder / f"{name}.toml")
    assert run_job(job).ok
    completed = json.loads((made / f"{name}.json").read_text())["completed"]
    plan = opened(MODULES[name])
    units = int(np.prod(list(plan.cmc.complete_repeat)))
    assert completed["copies"] == units * COPIES[name.upper()] and completed["relative_gap"] < 1e-3
    assert (made / f"{name}.obj").stat().st_size > 100_000
