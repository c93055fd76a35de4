"""Approximate Surface and Fit to Outline: the shell nearest to what is there or wanted.

They run as Solve does, see `solve`. In the window the best shape so far is drawn over the scene (`preview`), which
itself stays as it is until the fit is done: Esc leaves nothing behind.
"""

import math

import bpy
import numpy as np

from ...solver.errors import CmcError
from .. import outline_bridge, preview
from ..design_settings import (
    APPROXIMATE_SETTINGS,
    FIT_SETTINGS,
    KNOB_PROPERTY,
    POINTERS,
    approximate_annotations,
    fit_annotations,
    take_settings,
    take_targets,
)
from ..designing import LIMIT, ApproximateOrder, DesignOrder, FitOrder
from ..forming import plan_depsgraph
from ..mesh_bridge import read_plan
from ..outline import chain
from .solve import Solving, as_settings


class Designing(Solving):
    """What the two have in common."""

    _order: DesignOrder | None = None

    def tell(self, update) -> tuple[float, str]:
        off = 100.0 * math.sqrt(2.0 * max(update.residual, 0.0))  # the value is half a square, in parts of the size
        return min(update.iteration / LIMIT, 0.99), f"Step {update.iteration}, off by {off:.2g} %"

    def _say_cancelled(self) -> set[str]:
        self.report({"INFO"}, "The fit was cancelled; nothing was changed.")
        return {"CANCELLED"}

    def _advance(self, context: bpy.types.Context) -> set[str]:
        if self._order is not None and self._order.latest is not None:
            preview.show(*self._order.latest)
            self._order.latest = None
        return super()._advance(context)

    def _cleanup(self, context: bpy.types.Context) -> None:
        preview.clear()
        self._order = None
        super()._cleanup(context)

    def _read(self, context, plan, settings) -> dict:
        settings.apply_modifiers, settings.tolerance = plan.cmc.apply_modifiers, plan.cmc.tolerance
        mesh = read_plan(plan, plan_depsgraph(context, settings))
        return {"name": plan.name, "mesh": mesh, "settings": settings}


class CMC_OT_approximate_surface(Designing, bpy.types.Operator):
    """Make the surface of constant mean curvature whose tangent planes are nearest to those of the active surface"""

    bl_idname = "cmc.approximate_surface"
    bl_label = "Approximate Surface"
    __annotations__ = approximate_annotations({"SKIP_SAVE"})

    def take(self, context, plan):
        settings = take_settings(self, plan.cmc, APPROXIMATE_SETTINGS)
        given = self._read(context, plan, settings)
        self._order = ApproximateOrder(**given, stored=APPROXIMATE_SETTINGS, role="NEAREST")
        return self._order

    def draw(self, context):
        as_settings(self.layout)
        self.layout.prop(self, "smoothness")


class CMC_OT_fit_outline(Designing, bpy.types.Operator):
    """Make the shell over the active plan whose rim lies on its outline, on another curve, or goes through anchors"""

    bl_idname = "cmc.fit_outline"
    bl_label = "Fit to Outline"
    __annotations__ = fit_annotations({"SKIP_SAVE"})

    def take(self, context, plan):
        curve, anchors = take_targets(self, plan.cmc).values()
        settings = take_settings(self, plan.cmc, FIT_SETTINGS)
        given = self._read(context, plan, settings)
        self._order = FitOrder(
            **given,
            stored=FIT_SETTINGS,
            role="FIT",
            chosen={
                POINTERS["curve"]: None if curve is None else ("objects", curve.name),
                POINTERS["anchors"]: None if anchors is None else ("collections", anchors.name),
            },
            curve=_curve_points(plan, curve) if settings.fit_to == "CURVE" else None,
            anchors=_anchors(context, anchors, needed=settings.fit_to == "ANCHORS"),
        )
        return self._order

    def draw(self, context):
        as_settings(self.layout)
        draw_fit(self.layout, self)


def draw_fit(layout: bpy.types.UILayout, owner) -> None:
    """Rows for the settings of Fit to Outline, of an object or the operator; only the ones that count now."""
    layout.row().prop(owner, "fit_to", expand=True)
    stored = isinstance(owner, bpy.types.PropertyGroup)
    if owner.fit_to == "CURVE":
        _target_row(layout, owner, "curve", stored, "objects")
    _target_row(layout, owner, "anchors", stored, "collections")
    layout.prop(owner, "knob")
    layout.prop(owner, KNOB_PROPERTY[owner.knob], slider=owner.knob == "RISE")
    if owner.fit_to != "ANCHORS":
        layout.prop(owner, "free_heights")
    layout.prop(owner, "hanging")


def _target_row(layout: bpy.types.UILayout, owner, name: str, stored: bool, among: str) -> None:
    if stored:
        layout.prop(owner, POINTERS[name])
    else:
        layout.prop_search(owner, name, bpy.data, among)


def _curve_points(plan: bpy.types.Object, curve: bpy.types.Object | None) -> np.ndarray:
    """Points (m, 3) of the one closed loop of an object, in the world and in order."""
    if curve is None:
        raise CmcError(f"'{plan.name}' has no curve to fit to; choose a closed curve or a mesh under Fit to Outline.")
    if not curve.users_scene:
        raise CmcError(f"The curve '{curve.name}' has been deleted; choose another one under Fit to Outline.")
    wire = outline_bridge.read_wire(curve)
    if not len(wire.edges):
        raise CmcError(f"'{curve.name}' has no edges; draw a closed loop in it.")
    loops = chain(wire)
    if len(loops) > 1:
        raise CmcError(f"'{curve.name}' has {len(loops)} loops, but a shell has one rim; leave one of them.")
    return wire.points[loops[0][0]]


def _anchors(context, collection, needed: bool) -> tuple[np.ndarray, np.ndarray] | None:
    """Places (k, 3) and weights (k,) of the empties of a collection, or where only anchors count and there is no
    collection of the selected ones."""
    if collection is not None:
        found, where = collection.all_objects, f"The collection '{collection.name}' has no empties that count"
    elif needed:
        found, where = context.selected_objects, "There are no anchors"
    else:
        return None
    empties = [ob for ob in found if ob.type == "EMPTY" and ob.cmc.anchor_weight > 0.0]
    if not empties:
        raise CmcError(f"{where}; add empties where the shell is to be held, and select them, or choose a collection.")
    places = np.array([ob.matrix_world.translation for ob in empties], dtype=np.float64)
    return places, np.array([ob.cmc.anchor_weight for ob in empties])


CLASSES = (CMC_OT_approximate_surface, CMC_OT_fit_outline)
