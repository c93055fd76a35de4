"""Every operator in every state: allowed, or disabled with a reason; faulty elements selected after errors."""

from __future__ import annotations

import bpy
import pytest

# isort: split
import bmesh  # is on the path once bpy is imported

from .scenes import activate, add_group, boundary_edges, mesh_object
from .sidebar import draw, text_of
from .test_panels import STATES

BARE = "context is incorrect"  # what Blender says where a poll says nothing


def names() -> list[str]:
    return [name for name in dir(bpy.ops.cmc) if not name.startswith("_")]


def reasons() -> dict[str, str]:
    """Operator → why it is disabled now."""
    found = {}
    for name in names():
        call = getattr(bpy.ops.cmc, name)
        if call.poll():
            continue
        with pytest.raises(RuntimeError) as failure:
            call()
        found[name] = str(failure.value).strip()
    return found


def check(expected: dict[str, str]) -> None:
    reported = reasons()
    bare = [name for name, reason in reported.items() if BARE in reason]
    assert not bare, "disabled without a reason"
    for name, text in expected.items():
        assert text in reported[name], f"{name}: {reported.get(name)}"
    draw()


@pytest.fixture
def solved():
    bpy.ops.cmc.add_plan(columns=10)
    plan = bpy.context.object
    add_group(plan, "Rim", boundary_edges(plan.data), "BINORMAL", tilt=0.8)
    bpy.ops.cmc.solve()
    return bpy.context.object


@pytest.mark.parametrize("build", [build for build, _ in STATES.values()], ids=STATES.keys())
def test_every_state_gives_a_reason(build):
    build()
    check({})


def test_nothing_selected():
    activate(None)
    check({
        "solve": "No object is active", "complete": "No object is active",
        "mesh_plan": "Select an outline", "export": "No object is active", "group_add": "Select a mesh first",
        "go_to": "Select an outline",
    })


def test_a_curve():
    bpy.ops.curve.primitive_bezier_circle_add()
    check({"solve": "is not a mesh; select a plan, or make one with Mesh Plan", "group_assign": "Select a mesh first"})
    assert bpy.ops.cmc.mesh_plan.poll()


def test_a_mesh_without_faces():
    mesh_object("Wire", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], edges=[(0, 1), (1, 2), (2, 0)])
    wanted = {"solve": "'Wire' has no faces; fill its outline (F), or use Mesh Plan"}
    check(wanted)
    bpy.ops.object.mode_set(mode="EDIT")
    check(wanted)


def test_faces_made_in_edit_mode_count():
    mesh_object("Wire", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], edges=[(0, 1), (1, 2), (2, 0)])
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.edge_face_add()
    assert bpy.ops.cmc.solve.poll()


def test_a_result(solved):
    activate(solved.cmc.f_plus)
    check({"group_add": "its boundary groups are those of its plan", "mesh_plan": "This is a result"})
    assert bpy.ops.cmc.solve.poll() and bpy.ops.cmc.export.poll() and bpy.ops.cmc.go_to.poll()
    bpy.ops.object.mode_set(mode="EDIT")
    check({"solve": "is in edit mode; leave it (Tab)"})


def test_edit_mode(solved):
    bpy.ops.object.mode_set(mode="EDIT")
    check({"complete": "Leave edit mode first", "tile_periods": "Leave edit mode first", "add_plan": "Leave edit mode"})
    assert bpy.ops.cmc.solve.poll() and bpy.ops.cmc.group_assign.poll()


def test_while_something_runs(solved):
    bpy.context.window_manager.cmc.running = True
    for name in ("solve", "flip", "mesh_plan", "approximate_surface", "complete", "tile_periods",
                 "export"):
        assert "wait for it, or cancel it (Esc)" in reasons()[name]
    assert draw("CMC_PT_shell").operators == ["cmc.cancel"], "the bar is where the button was"
    assert draw().operators.count("cmc.cancel") == 1, "the progress is drawn once"
    check({})


def test_a_closed_mesh_cannot_be_live():
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    check({"live": "'Cube' is closed, and a plan has a boundary; delete the faces beyond its rim"})
    cube.cmc.live = True
    assert bpy.ops.cmc.live() == {"FINISHED"} and not cube.cmc.live, "it can always be switched off"
    bpy.ops.mesh.primitive_grid_add()
    assert bpy.ops.cmc.live() == {"FINISHED"} and bpy.context.object.cmc.live
    mesh_object("Wire", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], edges=[(0, 1), (1, 2), (2, 0)])
    check({"live": "'Wire' has no faces"})
    bpy.ops.cmc.add_bubble(bubble="TORUS", columns=8)
    assert bpy.ops.cmc.live.poll(), "a closed mesh with a start is a plan"


@pytest.mark.parametrize("add", [
    lambda: bpy.ops.cmc.add_module(module="CAPITAL", edges=8),
    lambda: bpy.ops.cmc.add_plan(shape="CYLINDER", columns=16),
    lambda: bpy.ops.cmc.add_bubble(bubble="WENTE", columns=8),
])
def test_ready_made_plans_are_not_meshed_again(add):
    assert add() == {"FINISHED"}
    check({"mesh_plan": "is meshed already, with the corners of its surface"})
    record = draw("CMC_PT_plan")
    assert record.operators == [] and record.props == []
    bpy.ops.cmc.add_plan(columns=10)
    assert bpy.ops.cmc.mesh_plan.poll() and "cmc.mesh_plan" in draw("CMC_PT_plan").operators


def test_the_empty_tab_offers_plans():
    for active in (lambda: activate(None), bpy.ops.object.empty_add):
        active()
        record = draw("CMC_PT_plan")
        assert record.operators == ["cmc.add_plan"] * 4
    mesh_object("Flat", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    assert "cmc.add_plan" not in draw("CMC_PT_plan").operators


def test_linked_from_a_library(solved, tmp_path):
    name = solved.name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, taken):
        taken.objects = [name]
    bpy.context.collection.objects.link(taken.objects[0])
    activate(taken.objects[0])
    check({"solve": "is linked from another file; make it local", "group_add": "make it local",
           "mesh_plan": "make it local"})
    assert "linked from another" in text_of(draw("CMC_PT_shell"))


def test_no_shell_yet():
    bpy.ops.cmc.add_plan(columns=8)
    check({"export": "has no shell yet; Solve makes one"})


# --- offenders -----------------------------------------------------------------------------

def bow_tie():
    """Two triangles that share vertex 2 only."""
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (2, 1, 0), (2, 2, 0)]
    return mesh_object("Tie", points, [(0, 1, 2), (2, 3, 4)])


def selected(ob) -> tuple[set[int], set[int], set[int]]:
    bm = bmesh.from_edit_mesh(ob.data)
    return tuple({e.index for e in elements if e.select} for elements in (bm.verts, bm.edges, bm.faces))


@pytest.fixture
def show(addon):
    return addon.cmc_addon.bridges.highlight_bridge.show


def error(**elements):
    from cmc_formfinding.solver.errors import MeshError

    return MeshError("wrong", **elements)


def test_what_an_error_names_is_selected_in_edit_mode(show):
    ob = bow_tie()
    assert show(bpy.context, ob, error(vertices=[2]))
    assert bpy.context.mode == "EDIT_MESH" and selected(ob)[0] == {2}
    assert show(bpy.context, ob, error(faces=[1])), "from edit mode, too"
    assert selected(ob)[2] == {1} and tuple(bpy.context.tool_settings.mesh_select_mode) == (False, False, True)
    assert show(bpy.context, ob, error(edges=[0, 1]))
    assert selected(ob)[1] == {0, 1}


def test_hidden_outlines_are_shown(show):
    ob, other = bow_tie(), mesh_object("Other", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    ob.hide_set(True)
    activate(other)
    assert show(bpy.context, ob, error(vertices=[0])) and bpy.context.object == ob and not ob.hide_get()


def test_what_cannot_be_shown_changes_nothing(show):
    ob = bow_tie()
    ob.data.polygons[0].select = True
    for elements in ({}, {"vertices": [7]}, {"faces": [-1]}):
        assert not show(bpy.context, ob, error(**elements))
    ob.modifiers.new("Subdivided", "SUBSURF")
    ob.cmc.apply_modifiers = True
    assert not show(bpy.context, ob, error(vertices=[0]))
    assert not show(bpy.context, None, error(vertices=[0]))
    bpy.ops.object.light_add()
    assert not show(bpy.context, bpy.context.object, error(vertices=[0]))
    assert bpy.context.mode == "OBJECT" and ob.data.polygons[0].select


def test_a_click_that_fails_ends_there(addon):
    """As the window does it: `_fail` after the error of a solve, which names polygons of the plan."""
    from cmc_formfinding.cmc_addon.operators.solve import CMC_OT_solve
    from cmc_formfinding.solver.errors import CmcError

    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (1, 1, 1)]
    ob = mesh_object("Fins", points, [(0, 1, 2), (1, 0, 3), (0, 1, 4)])
    reports = []

    class Operator(CMC_OT_solve.__mro__[1]):
        bl_label, properties = "Solve", None

        def task_settings(self, plan):
            return addon.cmc_addon.tasks.solve.settings_of(plan.cmc)

        def report(self, kind, text):
            reports.append(text)

    hand = Operator()
    hand._about = hand.about(bpy.context).session_uid
    with pytest.raises(CmcError) as failure:
        for _ in hand.steps(bpy.context, 0.01):
            pass
    assert hand._fail(bpy.context, failure.value) == {"CANCELLED"}
    assert "has more than two faces" in reports[0]
    edge = next(e.index for e in ob.data.edges if set(e.vertices) == {0, 1})
    assert bpy.context.mode == "EDIT_MESH" and edge in selected(ob)[1]


# --- beside Solve --------------------------------------------------------------------------

def test_before_a_solve_there_is_nothing_to_tell():
    bpy.ops.cmc.add_plan(columns=8)
    record = draw("CMC_PT_shell")
    assert record.operators == ["cmc.solve", "cmc.live", "cmc.flip"] and record.operators.count("cmc.solve") == 1
