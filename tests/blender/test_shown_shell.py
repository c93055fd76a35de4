"""Results, checks, gaps, cut, legend and export are about the shell that is seen, and its name is in the header."""

from __future__ import annotations

import json
from itertools import pairwise

import bpy
import pytest

# isort: split

from .approximate_scenes import cap
from .scenes import activate, quad_disc
from .sidebar import draw, text_of

FINISHED = {"FINISHED"}


@pytest.fixture
def plan():
    """A plan that is a surface in space, too, with the shell of Solve."""
    bpy.ops.cmc.add_plan(columns=12)
    made = bpy.context.object
    made.name, made.cmc.default_kind = "Hall", "BINORMAL"
    for vertex in made.data.vertices:
        vertex.co.z = 2.0 - 0.02 * (vertex.co.x**2 + vertex.co.y**2)
    assert bpy.ops.cmc.solve() == FINISHED
    return made


def rows(*panels) -> dict:
    return dict(pairwise(draw(*panels).texts))


def header() -> str:
    return draw("CMC_PT_results").texts[-1]


def legend(addon):
    return addon.cmc_addon.drawing.legend.legend_of(bpy.context)


def exported(tmp_path) -> dict:
    bpy.ops.cmc.export(filepath=str(tmp_path / "shell.ply"))
    return json.loads((tmp_path / "shell.json").read_text(encoding="utf-8"))


def test_after_each_task_it_is_the_one_written_last(addon, plan, tmp_path):
    plan.cmc.colour_by = "MEAN_CURVATURE"
    solved = rows("CMC_PT_results")
    assert header() == "Hall f+" == exported(tmp_path)["objects"][0]
    bpy.ops.cmc.approximate_surface()
    nearest, report = rows("CMC_PT_results"), json.loads(plan.cmc.design_report)
    assert header() == "Hall nearest CMC" and legend(addon).subtitle.endswith("Hall nearest CMC")
    assert exported(tmp_path)["objects"] == ["Hall nearest CMC"]
    assert nearest["Span"] != solved["Span"] and nearest["H"].startswith(f"{report['mean_curvature']:.4g}")
    off = report["sheets"][report["sheet"]]["mean_curvature"]["relative_l2"]
    assert rows("CMC_PT_checks")["H Off By"] == f"{100 * off:.2g} %"
    assert "cmc.count_modes" not in draw("CMC_PT_solver").operators, "modes are those of the solve"
    bpy.ops.cmc.solve()
    assert not plan.cmc.nearest.hide_viewport
    assert header() == "Hall f+" and rows("CMC_PT_results") == solved
    assert legend(addon).subtitle.endswith("Hall f+") and exported(tmp_path)["objects"] == ["Hall f+"]


def test_what_is_hidden_is_not_shown(plan):
    bpy.ops.cmc.approximate_surface()
    plan.cmc.nearest.hide_set(True)
    plan.cmc.f_plus.hide_viewport = False
    assert header() == "Hall f+"
    plan.cmc.f_plus.hide_set(True)
    assert header() == "Hall nearest CMC", "all are hidden: the one written last"
    plan.cmc.nearest.hide_set(False)
    plan.cmc.f_plus.hide_set(False)
    activate(plan.cmc.f_plus)
    assert header() == "Hall f+", "the active one"


def test_after_approximating():
    surface = cap()
    assert bpy.ops.cmc.solve() == FINISHED
    assert bpy.ops.cmc.approximate_surface() == FINISHED
    assert header() == "Cap nearest CMC"
    assert "nearest surface" in text_of(draw("CMC_PT_results"))
    assert "Deviation" in draw("CMC_PT_approximate").texts
    bpy.ops.cmc.solve()
    activate(surface.cmc.nearest)
    assert header() == "Cap nearest CMC" and "nearest surface" in text_of(draw("CMC_PT_results"))


@pytest.mark.parametrize("kind", ["MESH", "INSTANCES"])
def test_after_repeating(addon, tmp_path, kind):
    bpy.ops.cmc.add_module(module="HONEYCOMB", edges=8)
    plan = bpy.context.object
    plan.cmc.colour_by = "MEAN_CURVATURE"
    assert bpy.ops.cmc.complete(complete_as=kind) == FINISHED
    name = plan.cmc.completed.name if kind == "MESH" else plan.cmc.copies.objects[0].name
    # the middle of a long name is left out, where it would run over the title
    assert header() == {"MESH": "Honeycomb…completed", "INSTANCES": "Honeycomb…odule copy"}[kind]
    assert legend(addon).subtitle.endswith(name)
    assert text_of(draw("CMC_PT_results")).startswith("Done. The shell is repeated.")
    assert rows("CMC_PT_results")["One Of"] == f"{json.loads(plan.cmc.complete_report)['copies']} copies"
    assert name in exported(tmp_path)["objects"]
    bpy.ops.cmc.solve()
    assert rows("CMC_PT_results")["One Of"], "they are made again"
    if kind == "MESH":
        bpy.data.objects.remove(plan.cmc.completed)
        bpy.ops.cmc.solve()
        assert header() == f"{plan.name} f+" and "One Of" not in draw("CMC_PT_results").texts


def test_undo_takes_it_back(plan):
    bpy.ops.ed.undo_push(message="Solved")
    bpy.ops.cmc.approximate_surface("EXEC_DEFAULT", True)
    assert header() == "Hall nearest CMC"
    bpy.ops.ed.undo()
    assert header() == "Hall f+"


@pytest.mark.parametrize("how", ["removed", "deleted"])
@pytest.mark.parametrize("nearest", [False, True])
def test_a_shell_whose_plan_is_deleted_can_be_exported(plan, tmp_path, how, nearest):
    if nearest:
        bpy.ops.cmc.approximate_surface()
    shell = plan.cmc.nearest if nearest else plan.cmc.f_plus
    energy = shell["cmc_energy"]
    if how == "removed":
        bpy.data.objects.remove(plan)
    else:
        bpy.context.scene.collection.objects.unlink(plan)
    activate(shell)
    record = draw("CMC_PT_export")
    assert shell.name in record.texts and record.operators == ["cmc.export"] and bpy.ops.cmc.export.poll()
    assert header() == shell.name, "its own report is there, too"
    report = exported(tmp_path)
    assert (report["objects"], report["plan"], report["energy"]) == ([shell.name], "Hall", energy)
    draw()


def test_copies_whose_plan_is_deleted_are_exported_together(tmp_path):
    bpy.ops.cmc.add_module(module="HONEYCOMB", edges=8)
    plan = bpy.context.object
    assert bpy.ops.cmc.complete(complete_as="INSTANCES") == FINISHED
    names = [ob.name for ob in plan.cmc.copies.objects]
    bpy.data.objects.remove(plan)
    activate(bpy.data.objects[names[1]])
    bpy.ops.cmc.export(filepath=str(tmp_path / "shell.ply"), export_report=False)
    assert (tmp_path / "shell.ply").stat().st_size > 10_000 and len(names) > 2


def test_a_plan_without_a_shell_has_none():
    quad_disc()
    assert not bpy.ops.cmc.export.poll()
