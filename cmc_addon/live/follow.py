"""Follow: the fitted shell follows while the settings of its plan are changed.

Each change is answered by a fit that goes on from the last one, in a thread; a timer looks after it. While a number is
dragged a fit that is out of date ends with what it has, which is shown, and the next one begins with the newest
number. What came of it is one step of undo.
"""

from __future__ import annotations

from types import SimpleNamespace

import bpy
from bpy.app.handlers import persistent

from ...solver.errors import CmcError
from ..background.timer import TICK, Errand, may_start, rest, wake
from ..drawing import preview
from ..drawing.viewport import redraw
from ..properties.changes import watchers
from ..properties.design_settings import FIT_SETTINGS, HEIGHT_PROPERTY, stored_settings
from ..properties.links import by_uid, result_of
from ..properties.registration import registration
from ..results.objects import check_writable
from ..tasks.fit_outline import FitOrder, Latest, fulfilled, go_on, take_fit


class Following:
    """The plan whose shell follows, as the number that survives undo; its fit while one is under way; whether it
    has moved; the plan with which something went wrong, and what."""

    uid: int | None = None
    errand: Errand | None = None
    moved: bool = False
    problem: tuple[int, str] | None = None


def changed(what: bpy.types.ID) -> None:
    """A setting has changed: if it is one of a plan whose shell follows, see to it from the next tick on."""
    if not isinstance(what, bpy.types.Object) or not what.cmc.follow or result_of(what, "FIT") is None:
        return
    if Following.uid != what.session_uid:
        stop()
    Following.uid, Following.problem = what.session_uid, None
    wake(tick)


def tick() -> float | None:
    """Look after the fit; returns seconds until the next time, or None when the shell is what it should be."""
    plan = by_uid(Following.uid)
    if plan is None or not plan.cmc.follow or result_of(plan, "FIT") is None:
        stop()
        return None
    try:
        return TICK if _advance(bpy.context, plan) else None
    except CmcError as error:
        stop()
        Following.problem = plan.session_uid, str(error)
        redraw(bpy.context)
        return None


def _advance(context: bpy.types.Context, plan: bpy.types.Object) -> bool:
    """Whether there is more to do."""
    wanted = stored_settings(plan.cmc, FIT_SETTINGS)
    if Following.errand is None:
        if not may_start():
            return True
        if _is(wanted, fulfilled(plan)):
            return _end()
        check_writable(plan)
        order = take_fit(context, plan, wanted, plan.cmc.fit_curve, plan.cmc.fit_anchors)
        Following.errand = Errand(go_on(order, plan))
    elif not _is(wanted, Following.errand.order.settings):
        Following.errand.order.newer.set()
    has_ended, outcome = Following.errand.look()
    if has_ended:
        return _deliver(context, plan, outcome)
    order: FitOrder = Following.errand.order
    if order.latest is not None:
        preview.show(*order.latest)
        order.latest = None
        redraw(context)
    return True


def _is(wanted: SimpleNamespace, settings: SimpleNamespace | None) -> bool:
    """Whether the settings are those that are wanted, as far as they count now."""
    others = {name for height_parameter, name in HEIGHT_PROPERTY.items() if height_parameter != wanted.height_parameter}
    others |= set() if wanted.limit_tilt else {"tilt_min", "tilt_max"}
    return settings is not None and all(
        getattr(settings, name) == value for name, value in vars(wanted).items() if name not in others
    )


def _deliver(context: bpy.types.Context, plan: bpy.types.Object, outcome) -> bool:
    order, Following.errand = Following.errand.order, None
    preview.clear()
    if outcome is None:  # it has given way to a solve, after which it begins again
        return True
    order.deliver(context, plan, outcome)
    Following.moved = True
    redraw(context)
    return True


def problem_of(plan: bpy.types.Object) -> str:
    """Why the shell of this plan does not follow; empty where it does."""
    return Following.problem[1] if Following.problem and Following.problem[0] == plan.session_uid else ""


def _end() -> bool:
    if Following.moved:
        bpy.ops.ed.undo_push(message="Follow")
    stop()
    return False


def stop() -> None:
    """Leave the shell as it is now."""
    if Following.errand is not None:
        Following.errand.drop()
        preview.clear()
    Following.uid = Following.errand = None
    Following.moved, Following.problem = False, None


@persistent
def _on_undo(*_) -> None:
    """What Blender brings back need not be what the last fit was for."""
    stop()
    Latest.settings = None


@persistent
def _on_load(*_) -> None:
    stop()
    Latest.fit = Latest.drawn = Latest.settings = None


_listen, _unlisten = registration(handlers={"undo_pre": _on_undo, "redo_pre": _on_undo, "load_pre": _on_load})


def register() -> None:
    watchers.append(changed)
    _listen()


def unregister() -> None:
    stop()
    rest(tick)
    if changed in watchers:
        watchers.remove(changed)
    _unlisten()
