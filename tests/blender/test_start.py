"""Edge lengths of a plan's own, a map to start from, closed plans; the large bubble, degree and unstable modes."""

from __future__ import annotations

import json

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .scenes import activate, add_group, boundary_edges, mesh_object, positions, snapshot
from .sidebar import draw


def wente_torus():
    """Domain and map of a small Wente torus, from the add-on's own solver."""
    from cmc_formfinding.solver import complete, whole
    from cmc_formfinding.solver.catalogue.wente import wente

    quarter = wente(2 * np.pi / 3, 8)
    return whole(complete(quarter.surface, quarter.sides))


@pytest.fixture
def torus(addon):
    """The torus drawn as a lump, with its own lengths and its map to start from."""
    from cmc_formfinding.cmc_addon.bridges.start_bridge import write_lengths, write_normals

    found = wente_torus()
    domain = found.domain
    noise = np.random.default_rng(0).uniform(-0.2, 0.2, found.normals.shape)
    plan = mesh_object("Torus", 2.0 * found.normals + noise, domain.faces)
    write_lengths(plan.data, domain.edges, domain.edge_lengths)
    write_normals(plan.data, found.normals)
    plan.cmc.method, plan.cmc.intersections = "CRITICAL", False
    return plan


def report(plan) -> dict:
    return json.loads(plan.cmc.report)


def disc(tilt: float = 0.25 * np.pi):
    bpy.ops.mesh.primitive_circle_add(vertices=60, radius=4.0, fill_type="NGON")
    bpy.ops.cmc.mesh_plan(edge_length=0.4)
    plan = bpy.context.object
    add_group(plan, "Rim", boundary_edges(plan.data), "BINORMAL", tilt=tilt)
    return plan


def fails(words: str, operator=None, **arguments) -> None:
    before = snapshot()
    with pytest.raises(RuntimeError, match=words):
        (operator or bpy.ops.cmc.solve)(**arguments)
    assert snapshot() == before


def test_a_closed_plan_becomes_a_closed_shell(torus):
    assert bpy.ops.cmc.solve() == {"FINISHED"}
    reported = report(torus)
    assert reported["converged"] and not reported["is_open"] and reported["residual"] < 1e-6
    assert reported["index"] > 20 and abs(reported["degree"]) < 1e-6
    shell = torus.cmc.f_plus
    assert len(shell.data.vertices) == len(torus.data.vertices) and not len(boundary_edges(shell.data))
    assert {"cmc_length", "cmc_start"}.isdisjoint(shell.data.attributes.keys())
    assert_allclose(positions(shell)[:, 2].min(), positions(torus)[:, 2].min(), rtol=0, atol=1e-4)


def test_what_a_closed_shell_can_and_cannot_do(torus):
    bpy.ops.cmc.solve()
    before = positions(torus.cmc.f_plus)
    activate(torus)
    bpy.ops.cmc.flip()
    low, high = before[:, 2].min(), before[:, 2].max()
    heights = positions(torus.cmc.f_plus)[:, 2]
    assert_allclose([heights.min(), heights.max()], [low, high], rtol=0, atol=1e-3)
    fails("no side to continue across", bpy.ops.cmc.complete)
    fails("closes|no hole|does not have a gap|nothing", bpy.ops.cmc.tile_periods)
    bpy.ops.cmc.solve(want_twin=True, want_g=True, want_gauss=True, combinatorics="DUAL")
    assert all(getattr(torus.cmc, name) is not None for name in ("f_plus", "f_minus", "g", "gauss"))
    for panel in ("CMC_PT_results", "CMC_PT_solver", "CMC_PT_checks", "CMC_PT_advanced", "CMC_PT_boundary"):
        draw(panel)


def test_a_start_survives_saving_and_undo(torus, tmp_path):
    bpy.ops.cmc.solve()
    before = positions(torus.cmc.f_plus)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "torus.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "torus.blend"))
    plan = bpy.data.objects["Torus"]
    activate(plan)
    assert bpy.ops.cmc.solve() == {"FINISHED"}
    assert_allclose(positions(plan.cmc.f_plus), before, rtol=0, atol=1e-5)
    bpy.ops.ed.undo_push(message="solved")
    bpy.ops.cmc.start_clear("EXEC_DEFAULT", True)
    assert "cmc_start" not in bpy.data.objects["Torus"].data.attributes
    bpy.ops.ed.undo()
    assert "cmc_start" in bpy.data.objects["Torus"].data.attributes
    assert report(bpy.data.objects["Torus"])["index"] > 20


def test_without_its_start_a_closed_plan_is_refused(torus):
    bpy.ops.cmc.start_clear()
    fails("closed.*map to start from")
    fails("no start", bpy.ops.cmc.start_clear)


def test_bad_lengths_and_starts_are_named(torus):
    lengths = torus.data.attributes["cmc_length"].data
    kept = lengths[5].value
    for bad, words in ((0.0, "are not positive numbers at"), (9.9, "make no triangle of")):
        lengths[5].value = bad
        fails(rf"\(cmc_length\) {words} faces \d+, \d+")
        lengths[5].value = kept
    torus.data.attributes["cmc_start"].data[7].vector = (0, 0, 0)
    fails("no normal at vertex 7")
    torus.data.attributes.remove(torus.data.attributes["cmc_start"])
    torus.data.attributes.new("cmc_start", "FLOAT", "POINT")
    fails("'cmc_start' of a plan must be a Vector on its vertices")


def test_lengths_are_for_triangles(addon):
    from .scenes import quad_disc

    plan = quad_disc()
    attribute = plan.data.attributes.new("cmc_length", "FLOAT", "EDGE")
    attribute.data.foreach_set("value", np.ones(len(plan.data.edges), dtype=np.float32))
    fails("a side without; triangulate the faces")


def test_own_lengths_change_the_shell_and_only_they(addon):
    """Lengths of an ellipse on a drawn circle: the normals of the ellipse with the same normals along its rim."""
    from cmc_formfinding.cmc_addon.bridges.start_bridge import write_lengths

    plan = disc()
    plan.data.cmc.groups[0].kind = "TWISTED"
    bpy.ops.cmc.solve()
    first = report(plan)["energy"]
    points = positions(plan) * [1.5, 1.0, 1.0]
    pairs = np.array([edge.vertices[:] for edge in plan.data.edges])
    activate(plan)
    write_lengths(plan.data, pairs, np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1))
    bpy.ops.cmc.solve()
    assert abs(report(plan)["energy"] - first) > 1e-3 * first
    activate(plan)
    write_lengths(plan.data, pairs, np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1) * 3.0)
    bpy.ops.cmc.solve()
    bpy.ops.cmc.start_clear()
    bpy.ops.cmc.solve()
    assert_allclose(report(plan)["energy"], first, rtol=1e-6, atol=0)


def test_the_large_bubble_over_a_round_plan(addon):
    plan = disc()
    bpy.ops.cmc.solve()
    small = report(plan)
    assert bpy.ops.cmc.solve(shell="BUBBLE") == {"FINISHED"}
    assert (plan.cmc.shell, plan.cmc.sheet) == ("BUBBLE", "F_MINUS")
    large = report(plan)
    assert large["converged"] and large["sheet"] == "f-"
    assert_allclose(small["degree"] - large["degree"], 1.0, rtol=0, atol=0.02)
    assert large["sheets"]["f-"]["rise"] > 4.0 * small["sheets"]["f+"]["rise"]
    plan.cmc.shell = "FIRST"
    assert plan.cmc.sheet == "F_PLUS"
    activate(plan)
    bpy.ops.cmc.solve(degree=-0.85)
    assert plan.cmc.shell == "DEGREE" and abs(report(plan)["degree"] - large["degree"]) < 1e-3
    options = draw("CMC_PT_options")
    assert {"shell", "degree"} <= set(options.props)


def test_the_other_side(addon):
    plan = disc(tilt=0.0)
    degrees = []
    for side in ("FRONT", "BACK"):
        activate(plan)
        bpy.ops.cmc.solve(side=side, sheet="F_PLUS" if side == "FRONT" else "F_MINUS")
        degrees.append(report(plan)["degree"])
    assert_allclose(degrees, [0.5, -0.5], rtol=0, atol=0.01)


def test_unstable_modes_are_counted_on_request(addon):
    plan = disc()
    bpy.ops.cmc.solve()
    panel = draw("CMC_PT_solver")
    assert "cmc.count_modes" in panel.operators and "Unstable Modes" not in panel.texts
    before = positions(plan.cmc.f_plus)
    assert bpy.ops.cmc.count_modes() == {"FINISHED"}
    assert report(plan)["index"] == 0 and plan.cmc.f_plus["cmc_index"] == 0
    assert_allclose(positions(plan.cmc.f_plus), before, rtol=0, atol=0)
    panel = draw("CMC_PT_solver")
    assert "cmc.count_modes" not in panel.operators and "Unstable Modes" in panel.texts and "None" in panel.texts
    activate(plan)
    bpy.ops.cmc.solve()
    assert report(plan)["index"] is None and "cmc_index" not in plan.cmc.f_plus
    bpy.ops.cmc.solve(method="SADDLE")
    assert report(plan)["index"] == 0


def test_counting_solves_what_was_not_solved(addon):
    plan = disc()
    assert bpy.ops.cmc.count_modes() == {"FINISHED"}
    assert plan.cmc.f_plus is not None and report(plan)["index"] == 0


def test_a_start_is_taken_from_a_shell(addon):
    plan = disc()
    fails("solve first", bpy.ops.cmc.start_from_shell)
    bpy.ops.cmc.solve(shell="BUBBLE")
    activate(plan)
    assert bpy.ops.cmc.start_from_shell() == {"FINISHED"}
    bubble = report(plan)["degree"]
    bpy.ops.cmc.solve(shell="FIRST", sheet="F_MINUS")
    assert_allclose(report(plan)["degree"], bubble, rtol=0, atol=1e-3)
    assert "Own start map" in draw("CMC_PT_advanced").texts
    activate(plan)
    bpy.ops.cmc.start_clear()
    bpy.ops.cmc.solve(shell="FIRST")
    assert report(plan)["degree"] > 0


def job(tmp_path, solver: str):
    """A round plan as a job file."""
    rows = f'[shape]\nkind = "disc"\nn = 600\n\n[default]\ntilt = 30\n\n[solver]\n{solver}\n'
    (tmp_path / "round.toml").write_text(rows)
    return tmp_path / "round.toml"


@pytest.mark.parametrize(
    ("solver", "settings", "degree"),
    [
        ("degree = -0.75", ("DEGREE", "FRONT"), -0.75),
        ('shell = "bubble"', ("BUBBLE", "FRONT"), -0.75),
        ("side = -1", ("FIRST", "BACK"), -0.75),
        ("side = 1", ("FIRST", "FRONT"), 0.25),
    ],
)
def test_a_job_with_a_shell_of_its_own_is_solved_in_blender(addon, tmp_path, solver, settings, degree):
    from cmc_formfinding.cmc_addon.headless.batch_files import open_input

    open_input(job(tmp_path, f"{solver}\ncount_modes = true"))
    plan = bpy.context.view_layer.objects.active
    assert (plan.cmc.shell, plan.cmc.side) == settings
    bpy.ops.cmc.solve(sheet="F_PLUS" if degree > 0 else "F_MINUS")
    assert abs(report(plan)["degree"] - degree) < 0.01 and report(plan)["index"] == 0


def test_the_command_line_chooses_a_shell(addon, tmp_path):
    from cmc_formfinding.cmc_addon.headless import cli

    for number, arguments in enumerate((["--shell", "bubble"], ["--degree", "-0.75", "--sheet", "f-"])):
        out = tmp_path / str(number)
        assert cli.run([str(job(tmp_path, "side = 1")), "--output", str(out), *arguments]) == 0
        reported = json.loads(next(out.rglob("report.json")).read_text())
        assert reported["sheet"] == "f-" and abs(reported["degree"] + 0.75) < 0.01


@pytest.mark.parametrize("name", ["start_from_shell", "start_clear"])
def test_a_plan_in_edit_mode_behind_another_active_object(name):
    bpy.ops.cmc.add_plan(columns=16)
    plan = bpy.context.object
    bpy.ops.cmc.solve()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.view_layer.objects.active = plan.cmc.f_plus
    with pytest.raises(RuntimeError, match="is in edit mode; leave it"):
        getattr(bpy.ops.cmc, name)()
    assert "cmc_start" not in plan.data.attributes
