"""Fit to Outline: the order to find the shell whose rim lies on a line, and reading that line and anchors."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from threading import Event
from types import SimpleNamespace

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import CmcError, Progress
from ...solver.fitting.fit import Fit, FitStatus
from ...solver.fitting.outline import fit_outline
from ...solver.meshing.wires import chain
from ...solver.shells.rim_curves import curves_of_loops
from ..background import plan_cache
from ..bridges import outline_bridge
from ..properties.design_settings import POINTERS
from .design import LIMIT, DesignOrder, DesignOutcome, counted, read_order
from .design_frame import Frame

Array = NDArray[np.float64]

# Evaluations of the first slice of a fit, after which it is shown; each next slice is twice as long.
_FIRST_SLICE = 10
# Evaluations that a fit gets even when a newer wish is there, so that a shell that follows gets anywhere.
_LEAST = 5


class Latest:
    """The last fit that was delivered, from which the next one of this plan goes on; for one plan at a time.

    settings: those that it fulfils as well as can be; None where that is not known.
    """

    fit: Fit | None = None
    drawn: tuple[int, bytes] | None = None
    settings: SimpleNamespace | None = None


@dataclass(eq=False)
class FitOrder(DesignOrder):
    """settings: `FIT_SETTINGS`.

    curves: closed lines (m, 3) for the rim, None for the plan's own; see `curves_of_loops`. anchors: places (k, 3) and
    weights (k,), or None. initial: an earlier fit to go on from. newer: set when this order is out of date, so that it
    comes to an end with what it has.
    """

    curves: list[Array] | None = None
    anchors: tuple[Array, Array] | None = None
    initial: Fit | None = None
    newer: Event = field(default_factory=Event)

    def frame(self, prepared: plan_cache.Prepared) -> Frame:
        return Frame.over(self.mesh.positions, prepared.triangles, self.settings.hanging)

    def fit(self, frame: Frame, prepared: plan_cache.Prepared, progress: Progress, show: Callable[[Fit], None]) -> Fit:
        settings, local = self.settings, frame.inside(self.mesh.positions)
        height_parameter = settings.height_parameter.lower()
        call = partial(
            fit_outline,
            prepared.solver.domain,
            local,
            self._lines(frame, prepared),
            **{height_parameter: getattr(settings, f"fit_{height_parameter}")},
            free_heights=settings.free_heights and settings.fit_to != "ANCHORS",
            anchors=self._anchored(frame, local),
            on_curve=settings.fit_to != "ANCHORS",
            tilt=_bounds(settings.tilt_min, settings.tilt_max) if settings.limit_tilt else None,
            solver=prepared.solver,
        )

        def told(count: int, value: float) -> bool | None:
            return False if self.newer.is_set() and count >= _LEAST else progress(count, value)

        return in_slices(call, self.initial, told, show)

    def _lines(self, frame: Frame, prepared: plan_cache.Prepared) -> list[Array] | None:
        """A line for each loop of the plan, in the frame."""
        if self.curves is None:
            return None
        curves = [frame.inside(curve) for curve in self.curves]
        return curves_of_loops(prepared.solver.domain, frame.inside(self.mesh.positions), curves)

    def _anchored(self, frame: Frame, local: Array) -> tuple[NDArray, Array, Array] | None:
        """Each anchor holds the vertex nearest to it as seen from above."""
        if self.anchors is None:
            return None
        places, weights = frame.inside(self.anchors[0]), self.anchors[1]
        far = np.linalg.norm(places[:, None, :2] - local[None, :, :2], axis=2)
        return far.argmin(axis=1), places, weights

    def outline(self, frame: Frame, prepared: plan_cache.Prepared) -> Array | list[Array] | None:
        if self.settings.fit_to == "ANCHORS":
            return None
        lines = self._lines(frame, prepared)
        return self.mesh.positions if lines is None else [frame.outside(line) for line in lines]

    def deliver(self, context: bpy.types.Context, plan: bpy.types.Object, outcome: DesignOutcome) -> list[str]:
        warnings = super().deliver(context, plan, outcome)
        Latest.fit, Latest.drawn = outcome.fit, _drawn(plan, self)
        Latest.settings = None if self.newer.is_set() else self.settings
        return warnings


def _bounds(least: float, most: float) -> tuple[float, float]:
    """Blender's 90° is a little more than that."""
    right = 0.5 * math.pi
    return max(least, -right), min(most, right)


def in_slices(
    call: Callable[..., Fit], found: Fit | None, progress: Progress, show: Callable[[Fit], None]
) -> Fit:
    """call(initial=…, max_evaluations=…, progress=…), again and again from where it ended, until it ends by itself.

    Each slice is twice as long as the one before, since each forgets what the one before has learnt about the
    curvature of the problem. Where a wish is not met then, the last one is long enough to try another way.
    """
    past: list[float] = []
    size, told = _FIRST_SLICE, counted(progress)
    while True:
        found = call(initial=found, max_evaluations=size, progress=told)
        past += found.history
        ended = found.status is not FitStatus.EVALUATION_LIMIT or len(past) >= LIMIT
        if found.status is FitStatus.CANCELLED or size == LIMIT or (ended and found.is_met):
            return replace(found, history=past)
        show(found)
        size = LIMIT if ended else min(2 * size, LIMIT - len(past))


# --- taking an order -----------------------------------------------------------------------

def take_fit(
    context: bpy.types.Context,
    plan: bpy.types.Object,
    settings: SimpleNamespace,
    curve: bpy.types.Object | None,
    anchors: bpy.types.Collection | None,
) -> FitOrder:
    """An order with these settings; curve and anchors are kept with the plan. Raises `CmcError` on what is missing."""
    return FitOrder(
        **read_order(context, plan, settings),
        role="FIT",
        chosen={
            POINTERS["curve"]: None if curve is None else ("objects", curve.name),
            POINTERS["anchors"]: None if anchors is None else ("collections", anchors.name),
        },
        curves=_curves(plan, curve) if settings.fit_to == "CURVE" else None,
        anchors=_anchors(context, anchors, needed=settings.fit_to == "ANCHORS"),
    )


def go_on(order: FitOrder, plan: bpy.types.Object) -> FitOrder:
    """The order, going on from the last fit if that was of this plan as it is drawn now."""
    order.initial = Latest.fit if Latest.drawn == _drawn(plan, order) else None
    return order


def fulfilled(plan: bpy.types.Object) -> SimpleNamespace | None:
    """The settings that the fitted shell of a plan fulfils, where that is known."""
    return Latest.settings if Latest.drawn is not None and Latest.drawn[0] == plan.session_uid else None


def _drawn(plan: bpy.types.Object, order: FitOrder) -> tuple[int, bytes]:
    return plan.session_uid, plan_cache.fingerprint(order.mesh)


def _curves(plan: bpy.types.Object, curve: bpy.types.Object | None) -> list[np.ndarray]:
    """Points (m, 3) of each closed loop of an object, in the world and in order."""
    if curve is None:
        raise CmcError(f"'{plan.name}' has no curve to fit to; choose a closed curve or a mesh under Fit to Outline.")
    if not curve.users_scene:
        raise CmcError(f"The curve '{curve.name}' has been deleted; choose another one under Fit to Outline.")
    wire = outline_bridge.read_wire(curve)
    if not len(wire.edges):
        raise CmcError(f"'{curve.name}' has no edges; draw a closed loop in it.")
    return [wire.points[loop] for loop, _ in chain(wire)]


def _anchors(
    context: bpy.types.Context, collection: bpy.types.Collection | None, needed: bool
) -> tuple[np.ndarray, np.ndarray] | None:
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
