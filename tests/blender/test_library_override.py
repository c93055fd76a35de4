"""A plan that is a library override: what Blender would drop on the next start is refused with a sentence."""

from __future__ import annotations

import bpy
import pytest

from .scenes import activate, link, quad_disc
from .sidebar import draw

OVERRIDE = "is a library override, which keeps no groups, settings and shells; make it local"
ON_GROUPS = ("group_add", "group_remove", "group_move", "group_assign", "group_remove_from", "group_new",
             "group_preset", "flip_corner")
ON_SHELLS = ("solve", "solve_selection", "flip", "approximate_surface", "complete",
             "tile_periods", "count_modes", "start_clear")


@pytest.fixture
def override(tmp_path):
    """A linked plan made local by Library Override, object and mesh."""
    plan = quad_disc()
    bpy.ops.cmc.group_add(name="Rim", kind="BINORMAL", tilt=0.5)
    path = str(tmp_path / "plans.blend")
    bpy.data.libraries.write(path, {plan})
    bpy.data.objects.remove(plan)
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.objects = ["Disc"]
    linked = link(wanted.objects[0])
    bpy.context.view_layer.update()
    made = linked.override_create(remap_local_usages=True)
    activate(made)
    made.data.override_create(remap_local_usages=True)
    assert made.is_editable and made.data.is_editable
    return made


@pytest.mark.parametrize("name", ON_GROUPS + ON_SHELLS)
def test_refused_in_a_sentence(override, name):
    before = len(bpy.data.objects), [group.name for group in override.data.cmc.groups]
    with pytest.raises(RuntimeError, match=OVERRIDE) as caught:
        getattr(bpy.ops.cmc, name)()
    assert "Traceback" not in str(caught.value)
    assert (len(bpy.data.objects), [group.name for group in override.data.cmc.groups]) == before


def test_the_panel_says_so(override):
    assert "library override" in str(draw("CMC_PT_shell"))


def test_made_local_it_works(override):
    override.select_set(True)
    bpy.ops.object.make_local(type="SELECT_OBDATA")
    assert bpy.ops.cmc.group_add(name="Other") == {"FINISHED"}
    assert bpy.ops.cmc.solve() == {"FINISHED"}
