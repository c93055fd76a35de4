"""The plans of `tests.mixed_plans` in Blender: their sides as groups."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.mixed_plans import LINE_OFF, MIXED_PLANS, misses

from .scenes import add_group, mesh_object
from .solved_plans import solved


@pytest.mark.parametrize("mixed", MIXED_PLANS, ids=lambda mixed: mixed.name)
def test_every_side_is_as_asked_or_told(addon, mixed):
    from cmc_formfinding.solver import shapes

    positions, triangles, pairs = mixed.mesh(shapes)
    plan = mesh_object("Hall", positions, triangles)
    plan.cmc.default_kind = "LINE"
    edge_of = {frozenset(edge.vertices): edge.index for edge in plan.data.edges}
    for name, (kind, parameters) in mixed.sides.items():
        edges = [edge_of[frozenset(pair)] for pair in pairs[name].tolist()]
        turned = {key: value if key == "normal" else np.radians(value) for key, value in parameters.items()}
        add_group(plan, name, edges, kind.upper(), **turned)
    points = solved(plan, size="RISE", rise=mixed.rise)
    report = json.loads(plan.cmc.report)
    assert report["converged"], report["sentence"]
    assert mixed.off_line(points, positions, triangles, pairs) < (LINE_OFF if mixed.is_fitted else 1e-3)
    assert ("sides" in report, "span" in report) == (mixed.is_fitted, not mixed.is_fitted)
    assert not misses(report, {warning["code"] for warning in report["warnings"]})
