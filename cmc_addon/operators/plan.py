"""Mesh Plan: from an outline to a plan of well-shaped triangles.

**The outline** is the active object: a mesh whose faces have an outer loop and holes as their boundary, or whose
edges form such loops; or a curve object of closed splines, nested ones being holes. It may lie in any plane;
points off its best plane are projected to it, and the report says by how much. Its modifiers are not applied, which
a warning says.

**The plan** is an object of its own called "<outline> Plan", made once and updated by every later run; the
drawn outline never changes. If the outline has faces, which would coincide with the plan's, it is hidden (Alt H
shows it). With the plan active, Mesh Plan meshes its outline again. A plan whose outline has been deleted is
meshed again from its own rim. The plan lies over its outline, with that object's rotation and unit scale, and
its origin in its middle; name, materials and solve settings of the plan stay.

**Links** are like those of results: a duplicated outline gets a plan of its own, a duplicated plan is
updated when it is active, and a plan deleted from the scene is made again.

**Groups.** A piece of an edge is in the group of that edge. The plan gets the outline's groups; a group of the
same name keeps its kind and angle. Groups made on the plan itself stay where the outline has no group.
"""

from functools import partial

import bpy
import numpy as np

from ...solver.errors import CmcError, MeshError
from ...solver.meshing.mesher import PlanMesh, mesh_plan
from ...solver.meshing.rounding import rounded_sentence
from ...solver.meshing.wires import (
    Outline,
    default_edge_length,
    explained,
    is_flat,
    make_outline,
)
from ..background import worker
from ..bridges import outline_bridge
from ..bridges.drawn_bridge import drawn_warnings
from ..properties import group_list
from ..properties.group_settings import kind_parameters
from ..properties.libraries import keeps_changes, why_not_kept
from ..properties.links import by_uid
from ..properties.plan_settings import PLAN_SETTINGS, plan_annotations
from ..properties.units import length_text
from .activate import activate
from .modal import ModalOperator
from .poll import RUNNING


def outline_of(ob: bpy.types.Object) -> bpy.types.Object:
    """The object whose outline Mesh Plan meshes when this one is active."""
    return ob.cmc.outline if ob.cmc.meshed and ob.cmc.outline is not None else ob


def plan_of(ob: bpy.types.Object) -> bpy.types.Object | None:
    """The plan that Mesh Plan updates when this object is active; None if it makes one."""
    if ob.cmc.meshed:
        return ob
    plan = ob.cmc.plan
    if plan is not None and plan.cmc.meshed and plan.cmc.outline == ob and plan.users_scene:
        return plan
    return None


def is_ready_made(ob: bpy.types.Object) -> bool:
    """Whether a mesh is a plan of a module or a bubble: its faces and corners are those of its surface, and Mesh Plan
    would spoil them."""
    return ob.type == "MESH" and not ob.cmc.meshed and outline_bridge.has_plan_layer(ob.data)


class CMC_OT_mesh_plan(ModalOperator, bpy.types.Operator):
    """Fill the outline with well-shaped triangles, or update the plan made before"""

    bl_idname = "cmc.mesh_plan"
    bl_label = "Mesh Plan"

    __annotations__ = plan_annotations({"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        ob = context.object
        if context.window_manager.cmc.running:
            cls.poll_message_set(RUNNING)
        elif ob is None or ob.type not in {"MESH", "CURVE"}:
            cls.poll_message_set("Select an outline: a mesh or a closed curve")
        elif ob.cmc.role != "NONE":
            cls.poll_message_set("This is a result; select the outline or the plan it comes from")
        elif is_ready_made(ob):
            cls.poll_message_set(f"'{ob.name}' is meshed already, with the corners of its surface; Solve works on it")
        elif ob.mode not in {"OBJECT", "EDIT"}:
            cls.poll_message_set("Go to object mode or edit mode first")
        elif ob.cmc.meshed and not keeps_changes(ob.data):
            cls.poll_message_set(why_not_kept(ob.data))
        else:
            return True
        return False

    def about(self, context):
        assert context.object is not None  # see `poll`
        return outline_of(context.object)

    def steps(self, context, wait):
        context.view_layer.update()  # a script may have just moved the outline
        assert context.object is not None
        uid = context.object.session_uid
        self._take_settings(context.scene.cmc)
        source = outline_of(context.object)
        outline = make_outline(outline_bridge.read_wire(source))
        warnings = drawn_warnings(context, source, outline_bridge.WAY_OUT)
        work = partial(_mesh, outline, self.edge_length, self.corner_radius, self.corners)
        meshed = yield from worker.steps(lambda progress: work(), 1.0, wait)
        if meshed is None:
            return self._report_cancelled()
        ob = by_uid(uid)
        if ob is None:
            raise CmcError("The outline was deleted while it was being meshed.")
        if context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        plan = plan_of(ob) or _new_plan(ob)
        _write(plan, outline_of(ob), outline, meshed)
        plan.cmc.rounded = _rounded(meshed)
        _show(context, plan, outline_of(ob))
        for name in PLAN_SETTINGS:
            setattr(context.scene.cmc, name, getattr(self, name))
        self._report_plan(plan, outline, meshed)
        for warning in warnings:
            self.report({"WARNING"}, warning)
        return {"FINISHED"}

    def draw(self, context):
        column = self.layout.column()
        column.use_property_split = True
        column.prop(self, "edge_length")
        column.prop(self, "corners")
        row = column.row()
        row.active = self.corners != "NONE"
        row.prop(self, "corner_radius")

    def _take_settings(self, stored) -> None:
        """Settings that the call leaves out are those last used; the redo panel then shows them all."""
        for name in PLAN_SETTINGS:
            if not self.properties.is_property_set(name):
                setattr(self, name, getattr(stored, name))

    def _report_plan(self, plan: bpy.types.Object, outline: Outline, meshed: PlanMesh) -> None:
        text = f"'{plan.name}': {len(meshed.triangles)} triangles, {len(meshed.edges)} boundary edges."
        rounded = rounded_sentence(meshed.rounded)
        if rounded is not None:
            text = f"{text} {rounded.written(partial(length_text, digits=3))}"
        self.report({"INFO"}, text)
        if not is_flat(outline):
            off = length_text(outline.off, digits=3)
            self.report({"WARNING"}, f"The outline of '{plan.name}' leaves its plane by {off} and was flattened.")


def _rounded(meshed: PlanMesh) -> str:
    """How many corners are rounded, for the panel; empty on a plan without corners."""
    count = len(meshed.rounded)
    return f"{count or 'None'} of {meshed.corners} corners rounded" if meshed.corners else ""


def _mesh(outline: Outline, edge_length: float, corner_radius: float, corners: str) -> PlanMesh:
    """Mesh an outline, in any thread; lengths of 0 mean automatic, `corners` is an identifier."""
    first, *holes = outline.loops
    edge = edge_length or default_edge_length(outline.size)
    rounded = corners.lower().replace("_", "-")
    borders = [border.tolist() for border in outline.borders()]
    try:
        return mesh_plan(
            first, holes, max_edge=edge, corner_radius=corner_radius or None, corners=rounded, keep=borders
        )
    except MeshError as error:
        raise explained(error, outline) from error


def _new_plan(ob: bpy.types.Object) -> bpy.types.Object:
    """An empty plan object beside the outline, in its collections, with its materials; linked both ways."""
    name = f"{ob.name} Plan"
    plan = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    for collection in [c for c in ob.users_collection if c.is_editable] or [bpy.context.scene.collection]:
        collection.objects.link(plan)
    for slot in ob.material_slots:
        plan.data.materials.append(slot.material)
    plan.cmc.meshed, plan.cmc.outline = True, ob
    ob.cmc.plan = plan
    return plan


def _write(plan: bpy.types.Object, source: bpy.types.Object, outline: Outline, meshed: PlanMesh) -> None:
    middles = outline.plane.raised(meshed.positions[meshed.edges].mean(axis=1))
    before = outline_bridge.groups_nearby(plan, middles)
    own = plan == source
    groups = before if own else _merged(plan.data, source, outline, meshed, before)
    outline_bridge.write_plan(plan, meshed, outline, source.matrix_world.to_quaternion())
    if groups.any() or plan.data.cmc.groups:
        outline_bridge.write_boundary_groups(plan.data, meshed.edges, groups)


def _merged(
    mesh: bpy.types.Mesh, source: bpy.types.Object, outline: Outline, meshed: PlanMesh, before: np.ndarray
) -> np.ndarray:
    """Group of each boundary edge, in the plan's numbering; adds the groups that the plan lacks."""
    drawn = np.concatenate(outline.groups)
    starts = np.cumsum([0] + [len(groups) for groups in outline.groups])
    piece = drawn[starts[meshed.loop] + meshed.segment]
    theirs = source.data.cmc.groups if source.type == "MESH" else []
    number = {0: 0}
    for group in theirs:
        number[group.uid] = _counterpart(mesh, group).uid
    result = np.array([number.get(uid, 0) for uid in piece.tolist()], dtype=np.int32)
    own = (result == 0) & ~np.isin(before, list(number.values()))
    result[own] = before[own]
    return result


def _counterpart(mesh: bpy.types.Mesh, group):
    """The plan's group of the same name, or a new one with the same kind and parameters."""
    own = mesh.cmc.groups.get(group.name)
    if own is None:
        own = group_list.add(mesh, group.name)
        own.kind, own.across = group.kind, group.across
        for name in kind_parameters(group.kind):
            setattr(own, name, getattr(group, name))
        own.curve = group.curve
    return own


def _show(context: bpy.types.Context, plan: bpy.types.Object, source: bpy.types.Object) -> None:
    """Make the plan the only selected object; hide an outline whose faces would coincide with the plan's."""
    activate(context, plan)
    if plan != source and source.type == "MESH" and source.data.polygons and source.name in context.view_layer.objects:
        source.hide_set(True)
        source.hide_render = True


CLASSES = (CMC_OT_mesh_plan,)
