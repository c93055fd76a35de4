"""The property groups that the add-on stores in a .blend file.

=========================  ==================================================================
`Mesh.cmc`                 the boundary groups of a plan (`CmcMesh`); which edge belongs to
                           which group is the INT attribute `cmc_group` on the mesh's edges
                           (0: no group, else the group's `uid`), see `mesh_bridge`
`Object.cmc`               settings of a plan and links to its results; on a result its role
                           and its plan (`CmcObject`)
`Scene.cmc`                settings of Mesh Plan (`CmcScene`)
`Collection.cmc_plan`      on a collection of results: their plan
`WindowManager.cmc`        the running task (`CmcRun`), never saved
=========================  ==================================================================

Identifiers are the solver's names in capitals. Lengths are Blender units, angles radians (shown as degrees). Blender
needs annotations to be objects, not strings.
"""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .approximate_settings import approximate_annotations
from .changes import notify
from .closing_settings import stored_tile_annotations
from .colour_settings import stored_colour_annotations
from .export_settings import stored_export_annotations
from .group_list import free_name
from .group_settings import condition_annotations
from .live_settings import live_annotations
from .overlay_settings import overlay_annotations
from .plan_settings import plan_annotations
from .registration import registration
from .settings import stored_setting_annotations
from .symmetry_settings import stored_complete_annotations

GROUP_ATTRIBUTE = "cmc_group"

ROLES = {"F_PLUS": "f+", "F_MINUS": "f-", "G": "g", "GAUSS": "gauss"}
"""Role of a result of Solve -> the solver's name of that sheet."""

DESIGN_ROLES = {"NEAREST": "nearest CMC surface"}
"""Role of a result of Approximate Surface -> description."""

COMPLETED_ROLES = {"COMPLETED": "shell repeated by symmetry or by gaps"}
"""Role of a result of Repeat by Symmetry or Repeat by Gaps -> description."""

_ACROSS = [
    ("AUTO", "Automatic", "The shell continues across mirrors and constant planes, not across free edges"),
    ("ON", "Yes", "The shell continues across these edges"),
    ("OFF", "No", "The repeated shell ends at these edges"),
]


def _keep_names_different(group, _context) -> None:
    """A name that is taken by another group gets a number, as in Blender."""
    taken = {other.name for other in group.id_data.cmc.groups if other.uid != group.uid}
    if group.name in taken:
        group.name = free_name(group.name, taken)


def _is_curve(_owner, ob) -> bool:
    return ob.type in ("CURVE", "MESH")


class CmcGroup(bpy.types.PropertyGroup):
    """A set of boundary edges with one condition; `name` is the user's, `uid` never changes."""

    __annotations__ = {
        "name": StringProperty(name="Name", description="Name of the group", update=_keep_names_different),
        "uid": IntProperty(name="Identifier", description="Value of the edge attribute for this group"),
        **condition_annotations(update=notify),
        "curve": PointerProperty(
            name="Curve", description="A closed curve, or a mesh with a closed loop of edges, on which the rim lies in "
            "place of the drawn edges; empty: the edges themselves",
            type=bpy.types.Object, poll=_is_curve, update=notify),
        "across": EnumProperty(
            name="Continues", description="Whether Repeat by Symmetry continues the shell across these edges",
            items=_ACROSS, default="AUTO"),
    }


class CmcMesh(bpy.types.PropertyGroup):
    """The boundary groups of a plan. `next_uid` only grows, so a uid is never reused."""

    groups: CollectionProperty(
        name="Boundary Groups", description="Sets of boundary edges, each with one condition", type=CmcGroup)
    active_index: IntProperty(name="Active Group", description="Group that the panel shows")
    next_uid: IntProperty(
        name="Next Identifier", description="Identifier for the next group", default=1, min=1)


def _is_mesh_object(_owner, ob) -> bool:
    return ob.type == "MESH"


_ROLE_ITEMS = [("NONE", "None", "Not a result")] + [
    (role, what, "Result of a solve") for role, what in (ROLES | DESIGN_ROLES | COMPLETED_ROLES).items()
]


class CmcObject(bpy.types.PropertyGroup):
    """Settings of a plan and links to its results; on a result its role and its plan."""

    __annotations__ = {
        **stored_setting_annotations(),
        **live_annotations(),
        **approximate_annotations(),
        **stored_complete_annotations(),
        **stored_tile_annotations(),
        **stored_colour_annotations(),
        **stored_export_annotations(),
        # On a plan. A link counts only while the result's `source` points back (see `links`).
        "f_plus": PointerProperty(
            name="Shell", description="The shell f+", type=bpy.types.Object, poll=_is_mesh_object),
        "f_minus": PointerProperty(
            name="Twin", description="The twin f-", type=bpy.types.Object, poll=_is_mesh_object),
        "g": PointerProperty(
            name="K-Surface", description="The surface g between shell and twin", type=bpy.types.Object,
            poll=_is_mesh_object),
        "gauss": PointerProperty(
            name="Normals on a Sphere", description="The Gauss image: the normals as points on a sphere",
            type=bpy.types.Object, poll=_is_mesh_object),
        "nearest": PointerProperty(
            name="Nearest CMC Surface", description="Result of Approximate Surface",
            type=bpy.types.Object, poll=_is_mesh_object),
        "completed": PointerProperty(
            name="Repeated", description="Result of Repeat by Symmetry or Repeat by Gaps",
            type=bpy.types.Object, poll=_is_mesh_object),
        "copies": PointerProperty(
            name="Copies", description="Collection of the instances of the shell",
            type=bpy.types.Collection),
        "repeated": StringProperty(name="Repeated", description="How the shell was repeated: SYMMETRY or GAPS"),
        "behind": BoolProperty(name="Behind", description="The copies are of an older shell"),
        "complete_report": StringProperty(name="Copies Report", description="Report of the last repetition, as JSON"),
        "collection": PointerProperty(
            name="Results", description="Collection of the results", type=bpy.types.Collection),
        "design_report": StringProperty(name="Design Report", description="Report of the last approximation, as JSON"),
        "report": StringProperty(name="Report", description="Report of the last solve, as JSON"),
        "message": StringProperty(name="Message", description="Message of the last solve"),
        "latest": StringProperty(name="Latest", description="Role of the shell that was written last"),
        # Mesh Plan: on an outline its plan, on a plan its outline (valid as the links above are).
        "plan": PointerProperty(
            name="Plan", description="Plan that Mesh Plan made of this outline", type=bpy.types.Object,
            poll=_is_mesh_object),
        "outline": PointerProperty(
            name="Outline", description="Outline that this plan was meshed from", type=bpy.types.Object),
        "rounded": StringProperty(name="Rounded", description="How many corners Mesh Plan has rounded"),
        "meshed": BoolProperty(name="Meshed", description="This plan was made by Mesh Plan"),
        # On a result.
        "role": EnumProperty(name="Role", description="Kind of this result", items=_ROLE_ITEMS),
        "source": PointerProperty(name="Plan", description="Plan of this result", type=bpy.types.Object),
        "placed_at": FloatVectorProperty(
            name="Placed At", description="Position of the plan when this result was written",
            size=3, subtype="TRANSLATION"),
        "parked": BoolProperty(name="Parked", description="Hidden by Solve, since its role is switched off"),
    }


class CmcScene(bpy.types.PropertyGroup):
    """Settings of Mesh Plan, as last used, and of the overlay."""

    __annotations__ = {
        **plan_annotations(),
        **overlay_annotations(),
        "shading_before": StringProperty(
            name="Shading", description="Shading of the viewports before the results were coloured"),
    }


class CmcRun(bpy.types.PropertyGroup):
    """The running task, for the panel."""

    running: BoolProperty(name="Running", description="Whether a task is running", options={"SKIP_SAVE"})
    progress: FloatProperty(
        name="Progress", description="Part of the task that is done", min=0.0, max=1.0, subtype="FACTOR",
        options={"SKIP_SAVE"})
    message: StringProperty(name="Message", description="Current step of the task", options={"SKIP_SAVE"})
    plan: StringProperty(name="Plan", description="Name of the plan of the task", options={"SKIP_SAVE"})


CLASSES = (CmcGroup, CmcMesh, CmcObject, CmcScene, CmcRun)
ATTACHED = (
    (bpy.types.Mesh, CmcMesh),
    (bpy.types.Object, CmcObject),
    (bpy.types.Scene, CmcScene),
    (bpy.types.WindowManager, CmcRun),
)
_register, _unregister = registration(CLASSES)


def register() -> None:
    _register()
    for owner, cls in ATTACHED:
        owner.cmc = PointerProperty(type=cls)
    bpy.types.Collection.cmc_plan = PointerProperty(
        name="Plan", description="Plan whose results are in this collection", type=bpy.types.Object)


def unregister() -> None:
    if hasattr(bpy.types.Collection, "cmc_plan"):
        del bpy.types.Collection.cmc_plan
    for owner, _ in reversed(ATTACHED):
        if hasattr(owner, "cmc"):
            del owner.cmc
    _unregister()
