"""Fit to Outline: the shell whose rim lies on a line or passes through anchors."""

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
from ...solver.notes import Note
from ...solver.shells.rim_curves import curves_of_loops
from ..background import plan_cache
from ..bridges import outline_bridge
from ..bridges.drawn_bridge import drawn_warnings
from ..properties.design_settings import POINTERS
from .design import LIMIT, DesignResult, DesignTask, counted, read_common
from .design_frame import Frame

Array = NDArray[np.float64]

# Evaluations of the first slice of a fit; after each slice the shape is shown, and the next one is twice as long.
_FIRST_SLICE = 10
# Evaluations that a fit gets even when it is out of date, so that a shell that follows a drag moves at all.
_LEAST = 5


class Latest:
    """The last fit that was written, from which the next one of its plan starts; for one plan at a time.

    settings: those that it fulfils as well as can be; None where that is not known.
    """

    fit: Fit | None = None
    drawn: tuple[int, bytes] | None = None
    settings: SimpleNamespace | None = None


@dataclass(eq=False)
class FitTask(DesignTask):
    """settings: `FIT_SETTINGS`.

    curves: closed lines (m, 3) for the rim, None for the plan's own; see `curves_of_loops`. anchors: places (k, 3) and
    weights (k,), or None. initial: an earlier fit to start from. newer: set when this task is out of date; it then
    ends with what it has.
    """

    curves: list[Array] | None = None
    anchors: tuple[Array, Array] | None = None
    initial: Fit | None = None
    newer: Event = field(default_factory=Event)

    @classmethod
    def read(
        cls,
        context: bpy.types.Context,
        plan: bpy.types.Object,
        settings: SimpleNamespace,
        curve: bpy.types.Object | None,
        anchors: bpy.types.Collection | None,
        stored: tuple[str, ...] = (),
    ) -> FitTask:
        """Read the plan, the curve and the anchors, which stay with the plan, as do the `stored` settings.

        Raises `CmcError` on what is missing.
        """
        common = read_common(context, plan, settings)
        if curve is not None and settings.fit_to == "CURVE":
            common["warnings"] += drawn_warnings(context, curve, outline_bridge.WAY_OUT)
        return cls(
            **common,
            role="FIT",
            stored=stored,
            targets={
                POINTERS["curve"]: None if curve is None else ("objects", curve.name),
                POINTERS["anchors"]: None if anchors is None else ("collections", anchors.name),
            },
            curves=_curves(plan, curve) if settings.fit_to == "CURVE" else None,
            anchors=_anchors(context, anchors, needed=settings.fit_to == "ANCHORS"),
        )

    def go_on(self, plan: bpy.types.Object) -> FitTask:
        """This task, started from the last fit if that was of this plan as it is drawn now."""
        self.initial = Latest.fit if Latest.drawn == self._drawn(plan) else None
        return self

    def _drawn(self, plan: bpy.types.Object) -> tuple[int, bytes]:
        return plan.session_uid, plan_cache.fingerprint(self.mesh)

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

        def unless_newer(count: int, value: float) -> bool | None:
            return False if self.newer.is_set() and count >= _LEAST else progress(count, value)

        return in_slices(call, self.initial, unless_newer, show)

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

    def write(self, context: bpy.types.Context, plan: bpy.types.Object, result: DesignResult) -> list[Note]:
        warnings = super().write(context, plan, result)
        Latest.fit, Latest.drawn = result.fit, self._drawn(plan)
        Latest.settings = None if self.newer.is_set() else self.settings
        return warnings


def _bounds(least: float, most: float) -> tuple[float, float]:
    """Blender's 90° is a little more than that."""
    right = 0.5 * math.pi
    return max(least, -right), min(most, right)


def in_slices(
    call: Callable[..., Fit], initial: Fit | None, progress: Progress, show: Callable[[Fit], None]
) -> Fit:
    """call(initial=…, max_evaluations=…, progress=…), repeated from where it stopped until it ends by itself.

    Each slice is twice as long as the one before, since it starts without the curvature that the one before has
    learnt. Lines alone are spanned at once, whatever the size of the slice.
    """
    past: list[float] = []
    fit, size, counting = initial, _FIRST_SLICE, counted(progress)
    while True:
        fit = call(initial=fit, max_evaluations=size, progress=counting)
        past += fit.history
        if fit.status is not FitStatus.EVALUATION_LIMIT or len(past) >= LIMIT:
            return replace(fit, history=past)
        show(fit)
        size = min(2 * size, LIMIT - len(past))


def fulfilled(plan: bpy.types.Object) -> SimpleNamespace | None:
    """The settings that the fitted shell of a plan fulfils, where that is known."""
    return Latest.settings if Latest.drawn is not None and Latest.drawn[0] == plan.session_uid else None


def _curves(plan: bpy.types.Object, curve: bpy.types.Object | None) -> list[np.ndarray]:
    """Points (m, 3) of each closed loop of an object, in the world and in order."""
    if curve is None:
        raise CmcError(f"'{plan.name}' has no curve to fit to; choose a closed curve or a mesh under Fit to Outline.")
    return outline_bridge.closed_lines(curve, "under Fit to Outline")


def _anchors(
    context: bpy.types.Context, collection: bpy.types.Collection | None, needed: bool
) -> tuple[np.ndarray, np.ndarray] | None:
    """Places (k, 3) and weights (k,) of the empties of a collection; without one, of the selected ones if needed."""
    if collection is not None:
        objects, where = collection.all_objects, f"The collection '{collection.name}' has no empties that count"
    elif needed:
        objects, where = context.selected_objects, "There are no anchors"
    else:
        return None
    empties = [ob for ob in objects if ob.type == "EMPTY" and ob.cmc.anchor_weight > 0.0]
    if not empties:
        raise CmcError(f"{where}; add empties where the shell must pass, and select them, or choose a collection.")
    places = np.array([ob.matrix_world.translation for ob in empties], dtype=np.float64)
    return places, np.array([ob.cmc.anchor_weight for ob in empties])
