"""What the add-on stores in a .blend file, and nothing else.

=========================  ==================================================================
`Mesh.cmc`                 the boundary groups of a plan (`CmcMesh`); which edge belongs to
                           which group is the INT attribute `cmc_group` on the mesh's edges
                           (0: no group, else the group's `uid`), see `mesh_bridge`
`Object.cmc`               how a plan is solved, links to its results, and on a result what
                           it is and which plan it came from (`CmcObject`)
`Scene.cmc`                settings of Mesh Plan (`CmcScene`)
`Collection.cmc_plan`      on the collection that results were put in: their plan
`WindowManager.cmc`        what is running now (`CmcRun`), never saved
=========================  ==================================================================

Enums and parameters come from the solver's registry of boundary conditions: a kind added there
appears here; how a plan is solved is in `settings`. Identifiers are the solver's names in capitals. Lengths
are Blender units, angles radians (shown as degrees). Annotations must be real objects, not strings, for
Blender to see them.
"""

from functools import partial

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

from ...solver.gauss.conditions import KINDS
from .changes import tell
from .colour_settings import stored_colour_annotations
from .design_settings import stored_design_annotations
from .export_settings import stored_export_annotations
from .group_list import free_name
from .live_settings import live_annotations
from .overlay_settings import overlay_annotations
from .periods_settings import stored_period_annotations
from .settings import stored_setting_annotations
from .symmetry_settings import stored_complete_annotations

GROUP_ATTRIBUTE = "cmc_group"

ROLES = {"F_PLUS": "f+", "F_MINUS": "f-", "G": "g", "GAUSS": "gauss"}
"""Role of a result object of Solve -> the solver's name of that sheet."""

DESIGN_ROLES = {"NEAREST": "nearest CMC surface", "FIT": "shell fitted to an outline"}
"""Role of a result object of Approximate Surface and of Fit to Outline -> what it is."""

COMPLETED_ROLES = {"COMPLETED": "shell completed by symmetry"}
"""Role of a result object of Complete by Symmetry -> what it is."""


# --- from the registry of kinds ------------------------------------------------------------

def kind_items() -> list[tuple[str, str, str]]:
    """(identifier, label, description) of every boundary condition, for an EnumProperty."""
    return [(name.upper(), kind.label, kind.description) for name, kind in KINDS.items()]


def kind_parameters(kind: str) -> tuple[str, ...]:
    """Names of the parameters which the kind (an enum identifier) has: the rows to draw."""
    return tuple(parameter.name for parameter in KINDS[kind.lower()].parameters)


def parameter_values(kind: str, owner) -> dict:
    """The kind's parameters read from a group or an operator, as the solver takes them."""
    values = {}
    for name in kind_parameters(kind):
        value = getattr(owner, name)
        values[name] = value if isinstance(value, (int, float)) else tuple(value)
    return values


def _parameter_property(parameter, options: set, more: dict):
    texts = {**more, "name": parameter.label, "description": parameter.description, "options": options}
    if isinstance(parameter.default, (tuple, list)):
        return FloatVectorProperty(**texts, size=3, default=parameter.default, subtype="DIRECTION")
    if parameter.unit in ("radians", "rad", "angle", "degrees"):
        return FloatProperty(**texts, default=parameter.default, subtype="ANGLE", step=100)
    return FloatProperty(**texts, default=parameter.default)


def condition_annotations(options=frozenset(), **more) -> dict:
    """`kind` and the parameters of every kind, for a group or an operator; `more` goes to each property."""
    options = set(options)
    annotations = {"kind": EnumProperty(
        name="Kind", description="What the tangent planes of the shell do along these edges",
        items=kind_items(), default="BINORMAL", options=options, **more)}
    for kind in KINDS.values():
        for parameter in kind.parameters:
            annotations[parameter.name] = _parameter_property(parameter, options, more)
    return annotations


_ACROSS = [
    ("AUTO", "Automatic", "Mirrors and constant planes go on, free sides do not"),
    ("ON", "Yes", "The shell goes on across these edges"),
    ("OFF", "No", "The completed shell ends at these edges"),
]

# --- how a plan is meshed ------------------------------------------------------------------

_PLAN_SETTINGS = {
    "edge_length": partial(
        FloatProperty, name="Edge Length", description="Length of the edges; 0 chooses a fortieth of the plan's size",
        default=0.0, min=0.0, subtype="DISTANCE"),
    "round_corners": partial(
        BoolProperty, name="Round Corners", default=True,
        description="At a sharp corner the normals of the rim jump and the curvature diverges"),
    "corner_radius": partial(
        FloatProperty, name="Corner Radius",
        description="0 chooses a tenth of the plan's size; less where there is no room",
        default=0.0, min=0.0, subtype="DISTANCE"),
}
PLAN_SETTINGS = tuple(_PLAN_SETTINGS)
"""Names of the settings shared by `Scene.cmc` and Mesh Plan."""


def plan_annotations(options=frozenset()) -> dict:
    """The settings of Mesh Plan as property annotations."""
    return {name: make(options=set(options)) for name, make in _PLAN_SETTINGS.items()}


# --- what is stored ------------------------------------------------------------------------

def _keep_names_different(group, _context) -> None:
    """A name that another group of the mesh has gets a number, as Blender does it."""
    taken = {other.name for other in group.id_data.cmc.groups if other.uid != group.uid}
    if group.name in taken:
        group.name = free_name(group.name, taken)


class CmcGroup(bpy.types.PropertyGroup):
    """A set of boundary edges with one condition; `name` is the user's, `uid` never changes."""

    __annotations__ = {
        "name": StringProperty(name="Name", description="Name of the group", update=_keep_names_different),
        "uid": IntProperty(name="Identifier", description="Value of the edge attribute for this group"),
        **condition_annotations(update=tell),
        "across": EnumProperty(
            name="Goes On", description="Whether Complete by Symmetry continues the shell across these edges",
            items=_ACROSS, default="AUTO"),
    }


class CmcMesh(bpy.types.PropertyGroup):
    """The boundary groups of a plan. `next_uid` only grows: a uid is never used twice."""

    groups: CollectionProperty(
        name="Boundary Groups", description="Sets of boundary edges, each with one condition", type=CmcGroup)
    active_index: IntProperty(name="Active Group", description="Which group the panel shows")
    next_uid: IntProperty(
        name="Next Identifier", description="Identifier of the next group that is added", default=1, min=1)


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
        **stored_design_annotations(),
        **stored_complete_annotations(),
        **stored_period_annotations(),
        **stored_colour_annotations(),
        **stored_export_annotations(),
        # On a plan. A link counts only while the result's `source` points back (see results.py).
        "f_plus": PointerProperty(
            name="f+", description="The shell f+", type=bpy.types.Object, poll=_is_mesh_object),
        "f_minus": PointerProperty(
            name="f-", description="Its twin f-", type=bpy.types.Object, poll=_is_mesh_object),
        "g": PointerProperty(
            name="g", description="The surface between the two", type=bpy.types.Object, poll=_is_mesh_object),
        "gauss": PointerProperty(
            name="Gauss Image", description="The normals as points of a sphere",
            type=bpy.types.Object, poll=_is_mesh_object),
        "nearest": PointerProperty(
            name="Nearest CMC Surface", description="What Approximate Surface has made",
            type=bpy.types.Object, poll=_is_mesh_object),
        "fit": PointerProperty(
            name="Fit", description="What Fit to Outline has made", type=bpy.types.Object, poll=_is_mesh_object),
        "completed": PointerProperty(
            name="Completed", description="What Complete by Symmetry or Tile by Periods has made",
            type=bpy.types.Object, poll=_is_mesh_object),
        "copies": PointerProperty(
            name="Copies", description="Collection of the instances that were made of the shell",
            type=bpy.types.Collection),
        "complete_report": StringProperty(name="Copies Report", description="What the last completion gave, as JSON"),
        "collection": PointerProperty(
            name="Results", description="Collection that the results were put into", type=bpy.types.Collection),
        "design_report": StringProperty(name="Design Report", description="Report of the last fit, as JSON"),
        "report": StringProperty(name="Report", description="Report of the last solve, as JSON"),
        "message": StringProperty(name="Message", description="What the last solve said"),
        # Mesh Plan: on an outline its plan, on a plan its outline (counted as the links above are).
        "plan": PointerProperty(
            name="Plan", description="What Mesh Plan has made of this outline", type=bpy.types.Object,
            poll=_is_mesh_object),
        "outline": PointerProperty(
            name="Outline", description="What this plan was meshed from", type=bpy.types.Object),
        "meshed": BoolProperty(name="Meshed", description="This plan was made by Mesh Plan"),
        # On a result.
        "role": EnumProperty(name="Role", description="What this result is", items=_ROLE_ITEMS),
        "source": PointerProperty(name="Plan", description="The plan this result comes from", type=bpy.types.Object),
        "placed_at": FloatVectorProperty(
            name="Placed At", description="Where the plan was when this result was written",
            size=3, subtype="TRANSLATION"),
        "parked": BoolProperty(name="Parked", description="Hidden by Solve because not wanted now"),
        # On an empty.
        "anchor_weight": FloatProperty(
            name="Weight", description="How much this anchor of Fit to Outline counts; 0 leaves it out",
            default=1.0, min=0.0, soft_max=10.0),
    }


class CmcScene(bpy.types.PropertyGroup):
    """Settings of Mesh Plan, as last used, and what the viewport shows."""

    __annotations__ = {
        **plan_annotations(),
        **overlay_annotations(),
        "shading_before": StringProperty(
            name="Shading", description="What the viewports showed before results were coloured"),
    }


class CmcRun(bpy.types.PropertyGroup):
    """What is running now, for the panel."""

    running: BoolProperty(name="Running", description="Whether something is being worked on", options={"SKIP_SAVE"})
    progress: FloatProperty(
        name="Progress", description="How far it is", min=0.0, max=1.0, subtype="FACTOR", options={"SKIP_SAVE"})
    message: StringProperty(name="Message", description="How far it is, in words", options={"SKIP_SAVE"})
    plan: StringProperty(name="Plan", description="Name of the plan being solved", options={"SKIP_SAVE"})


CLASSES = (CmcGroup, CmcMesh, CmcObject, CmcScene, CmcRun)
ATTACHED = (
    (bpy.types.Mesh, CmcMesh),
    (bpy.types.Object, CmcObject),
    (bpy.types.Scene, CmcScene),
    (bpy.types.WindowManager, CmcRun),
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for owner, cls in ATTACHED:
        owner.cmc = PointerProperty(type=cls)
    bpy.types.Collection.cmc_plan = PointerProperty(
        name="Plan", description="The plan whose results are in this collection", type=bpy.types.Object)


def unregister() -> None:
    if hasattr(bpy.types.Collection, "cmc_plan"):
        del bpy.types.Collection.cmc_plan
    for owner, _ in reversed(ATTACHED):
        if hasattr(owner, "cmc"):
            del owner.cmc
    for cls in reversed(CLASSES):
        if cls.is_registered:
            bpy.utils.unregister_class(cls)
