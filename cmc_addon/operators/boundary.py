"""Boundary groups: a list on the plan's mesh, used like Blender's vertex groups.

A group is an entry of `Mesh.cmc.groups` (name, kind, parameters). Its edges are those with its number in the edge
attribute `cmc_group`, so a boundary edge is in at most one group, and assigning it moves it. In edit mode the
operators act on the selected edges, in object mode on the edges selected when edit mode was left. Selected edges off
the boundary are never assigned; a report counts them.
"""

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ...solver.errors import CmcError, MeshError
from ..bridges import edge_bridge, group_history
from ..properties import group_list
from ..properties.group_settings import condition_annotations, kind_parameters
from ..properties.libraries import keeps_changes, why_not_kept

SCRIPT_ONLY = {"HIDDEN", "SKIP_SAVE"}


def active_mesh(context: bpy.types.Context) -> bpy.types.Mesh | None:
    """The mesh of the active object, the one whose groups the panel lists."""
    ob = context.object
    return ob.data if ob is not None and ob.type == "MESH" else None


class GroupOperator:
    """Common to all: needs an editable mesh; a CmcError becomes a report and leaves the scene unchanged."""

    bl_options = {"REGISTER", "UNDO"}
    needs_group = True

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        mesh = active_mesh(context)
        if mesh is None:
            cls.poll_message_set("Select a mesh first")
        elif context.object.cmc.role != "NONE":
            cls.poll_message_set("This is a result; its boundary groups are those of its plan")
        elif not keeps_changes(mesh):
            cls.poll_message_set(why_not_kept(mesh))
        elif cls.needs_group and not mesh.cmc.groups:
            cls.poll_message_set("Add a boundary group first")
        else:
            return True
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        mesh = active_mesh(context)
        assert mesh is not None  # see `poll`
        group_history.before(mesh)
        try:
            self.act(context, mesh)
        except CmcError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        group_history.after(mesh)
        return {"FINISHED"}


class OnOneGroup(GroupOperator):
    """Acts on the named group, or on the active one."""

    group: StringProperty(
        name="Group", description="Name of the group; empty for the active one", options=SCRIPT_ONLY)

    def chosen(self, mesh: bpy.types.Mesh):
        return group_list.find(mesh, self.group)


class CMC_OT_group_add(GroupOperator, bpy.types.Operator):
    """Add a boundary group to the active mesh; along it the shell leans over its line"""

    bl_idname = "cmc.group_add"
    bl_label = "Add Boundary Group"
    needs_group = False

    __annotations__ = {
        "name": StringProperty(name="Name", default="Group", options={"SKIP_SAVE"}),
        "assign": BoolProperty(
            name="Assign", description="Put the selected boundary edges into the group", options={"SKIP_SAVE"}),
        **condition_annotations({"SKIP_SAVE"}, kind_of_new="LEAN"),
    }

    def act(self, context, mesh):
        edges = selected_boundary(self, mesh) if self.assign else None
        group = group_list.add(mesh, self.name)
        group.kind = self.kind
        for name in kind_parameters(self.kind):
            setattr(group, name, getattr(self, name))
        if edges is not None:
            edge_bridge.write_groups(mesh, edges, group.uid)

    def draw(self, context):
        column = self.layout.column()
        column.use_property_split = True
        for name in ("name", "assign", "kind", *kind_parameters(self.kind)):
            column.prop(self, name)


class CMC_OT_group_remove(OnOneGroup, bpy.types.Operator):
    """Remove the active boundary group; its edges are then in no group"""

    bl_idname = "cmc.group_remove"
    bl_label = "Remove Boundary Group"

    all: BoolProperty(name="All", description="Remove every group", options={"SKIP_SAVE"})

    def act(self, context, mesh):
        doomed = list(mesh.cmc.groups) if self.all else [self.chosen(mesh)]
        uids = [group.uid for group in doomed]
        edges = np.nonzero(np.isin(edge_bridge.read_edges(mesh).group, uids))[0]
        if edges.size:
            edge_bridge.write_groups(mesh, edges, 0)
        for uid in uids:
            group_list.remove(mesh, uid)


class CMC_OT_group_move(GroupOperator, bpy.types.Operator):
    """Move the active boundary group up or down in the list"""

    bl_idname = "cmc.group_move"
    bl_label = "Move Boundary Group"

    direction: EnumProperty(
        name="Direction", description="Up or down in the list",
        items=[("UP", "Up", "Before the group above"), ("DOWN", "Down", "After the group below")])

    def act(self, context, mesh):
        cmc = mesh.cmc
        target = cmc.active_index + (-1 if self.direction == "UP" else 1)
        if 0 <= target < len(cmc.groups):
            cmc.groups.move(cmc.active_index, target)
            cmc.active_index = target


class CMC_OT_group_assign(OnOneGroup, bpy.types.Operator):
    """Move the selected boundary edges into the active group"""

    bl_idname = "cmc.group_assign"
    bl_label = "Assign to Boundary Group"

    @classmethod
    def description(cls, context, properties):
        where = f"the group '{properties.group}'" if properties.group else "the active group"
        return f"Move the selected boundary edges into {where}"

    def act(self, context, mesh):
        group = self.chosen(mesh)
        edges = selected_boundary(self, mesh)
        edge_bridge.write_groups(mesh, edges, group.uid)


class CMC_OT_group_remove_from(OnOneGroup, bpy.types.Operator):
    """Take the selected edges out of the active group"""

    bl_idname = "cmc.group_remove_from"
    bl_label = "Remove from Boundary Group"

    all: BoolProperty(
        name="All", description="Take them out of any group", options={"SKIP_SAVE"})

    def act(self, context, mesh):
        state = edge_bridge.read_edges(mesh)
        members = state.group != 0 if self.all else state.group == self.chosen(mesh).uid
        edges = np.nonzero(state.selected & members)[0]
        if not edges.size:
            raise MeshError("None of the selected edges is in this group. Select some that are.")
        edge_bridge.write_groups(mesh, edges, 0)


class CMC_OT_group_select(OnOneGroup, bpy.types.Operator):
    """Select the edges of the active group"""

    bl_idname = "cmc.group_select"
    bl_label = "Select Boundary Group"

    def act(self, context, mesh):
        select(context, mesh, edge_bridge.read_edges(mesh).group == self.chosen(mesh).uid, True)


class CMC_OT_group_deselect(OnOneGroup, bpy.types.Operator):
    """Deselect the edges of the active group"""

    bl_idname = "cmc.group_deselect"
    bl_label = "Deselect Boundary Group"

    def act(self, context, mesh):
        select(context, mesh, edge_bridge.read_edges(mesh).group == self.chosen(mesh).uid, False)


class CMC_OT_select_ungrouped(GroupOperator, bpy.types.Operator):
    """Select the boundary edges that are in no group"""

    bl_idname = "cmc.select_ungrouped"
    bl_label = "Select Edges in No Group"
    needs_group = False

    def act(self, context, mesh):
        state = edge_bridge.read_edges(mesh)
        known = [group.uid for group in mesh.cmc.groups]
        select(context, mesh, state.boundary & ~np.isin(state.group, known), True)


def select(context: bpy.types.Context, mesh: bpy.types.Mesh, edges: np.ndarray, on: bool) -> None:
    """Select or deselect edges (mask); if only faces can be selected, first change to edge mode."""
    tools = context.tool_settings
    if mesh.is_editmode and not any(tools.mesh_select_mode[:2]):
        tools.mesh_select_mode = (False, True, False)
    edge_bridge.write_selection(mesh, np.nonzero(edges)[0], on)


def selected_boundary(operator: bpy.types.Operator, mesh: bpy.types.Mesh) -> np.ndarray:
    """Indices of the selected boundary edges; selected ones off the boundary are counted in a report.

    Raises MeshError without any, naming the selected edges off the boundary.
    """
    state = edge_bridge.read_edges(mesh)
    inner = np.nonzero(state.selected & ~state.boundary)[0]
    edges = np.nonzero(state.selected & state.boundary)[0]
    verb = "is" if inner.size == 1 else "are"
    if not edges.size and inner.size:
        raise MeshError(
            f"The {count(inner.size)} selected {verb} not on the boundary. Select edges "
            "of the rim: they have one face.",
            edges=inner,
        )
    if not edges.size:
        raise MeshError("No edge is selected. Select edges of the rim in edit mode.")
    text = f"{count(edges.size)} of the boundary assigned"
    if inner.size:
        operator.report({"WARNING"}, f"{text}; {count(inner.size)} inside the mesh left out")
    else:
        operator.report({"INFO"}, text)
    return edges


def count(edges: int) -> str:
    return "1 edge" if edges == 1 else f"{edges} edges"


CLASSES = (
    CMC_OT_group_add,
    CMC_OT_group_remove,
    CMC_OT_group_move,
    CMC_OT_group_assign,
    CMC_OT_group_remove_from,
    CMC_OT_group_select,
    CMC_OT_group_deselect,
    CMC_OT_select_ungrouped,
)
