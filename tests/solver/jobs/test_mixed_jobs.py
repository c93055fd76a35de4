"""The plans of `tests.mixed_plans` as job files, beside their meshes."""

from __future__ import annotations

import json

import pytest

from solver import shapes
from solver.__main__ import main
from solver.io.mesh_files import read_mesh, write_mesh
from solver.io.obj import MeshData
from tests.mixed_plans import LINE_OFF, MIXED_PLANS, misses


@pytest.mark.parametrize("mixed", MIXED_PLANS, ids=lambda mixed: mixed.name)
def test_every_side_is_as_asked_or_told(tmp_path, mixed):
    positions, triangles, pairs = mixed.mesh(shapes)
    write_mesh(tmp_path / "plan.obj", MeshData(positions, list(triangles), edge_groups=pairs))
    lines = ['mesh = "plan.obj"', "[default]", 'kind = "line"', "[size]", f"rise = {mixed.rise}"]
    for name, (kind, parameters) in mixed.sides.items():
        lines += ["[[conditions]]", f'group = "{name}"', f'kind = "{kind}"']
        lines += [
            f"{key} = {list(map(float, value)) if key == 'normal' else value}" for key, value in parameters.items()
        ]
    lines += ["[output]", 'f_plus = "shell.obj"', 'report = "report.json"']
    (tmp_path / "job.toml").write_text("\n".join(lines))
    assert main(["-q", str(tmp_path / "job.toml")]) == 0
    report = json.loads((tmp_path / "report.json").read_text())
    points = read_mesh(tmp_path / "shell.obj").positions
    assert mixed.off_line(points, positions, triangles, pairs) < (LINE_OFF if mixed.is_fitted else 1e-3)
    assert ("sides" in report, "span" in report) == (mixed.is_fitted, not mixed.is_fitted)
    assert not misses(report, {warning["code"] for warning in report["warnings"]})
