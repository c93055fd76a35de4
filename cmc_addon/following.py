"""Follow: the fitted shell follows while the settings of its plan are changed.

Each change is answered by a fit that goes on from the last one, in a thread; a timer looks after it. While a number is
dragged a fit that is out of date ends with what it has, which is shown, and the next one begins with the newest
number. What came of it is one step of undo.
"""

from __future__ import annotations

from collections.abc import Generator
from types import SimpleNamespace

import bpy
from bpy.app.handlers import persistent

from ..solver.errors import CmcError
from . import preview, session
from .design_settings import FIT_SETTINGS, KNOB_PROPERTY, stored_settings, watchers
from .fit_order import FitOrder, Latest, fulfilled, go_on, take_fit
from .operators.solve import by_uid, redraw
from .results import check_writable, result_of

_TICK = 0.02


class Following:
    """The plan whose shell follows, as the number that survives undo; its fit while one runs; whether it has moved; the
    plan with which something went wrong, and what."""

    uid: int | None = None
    order: FitOrder | None = None
    work: Generator | None = None
    moved: bool = False
    problem: tuple[int, str] | None = None


def changed(plan: bpy.types.Object) -> None:
    """A setting of this plan has changed: see to it from the next tick on."""
    if not plan.cmc.follow or result_of(plan, "FIT") is None:
        return
    if Following.uid != plan.session_uid:
        stop()
    Following.uid, Following.problem = plan.session_uid, None
    if not bpy.app.background and not bpy.app.timers.is_registered(tick):  # there timers never fire
        bpy.app.timers.register(tick, first_interval=0.0)


def tick() -> float | None:
    """Look after the fit; returns seconds until the next time, or None when the shell is what it should be."""
    plan = by_uid(Following.uid)
    if plan is None or not plan.cmc.follow or result_of(plan, "FIT") is None:
        stop()
        return None
    try:
        return _TICK if _advance(bpy.context, plan) else None
    except CmcError as error:
        stop()
        Following.problem = plan.session_uid, str(error)
        redraw(bpy.context)
        return None


def _advance(context: bpy.types.Context, plan: bpy.types.Object) -> bool:
    """Whether there is more to do."""
    wanted = stored_settings(plan.cmc, FIT_SETTINGS)
    if Following.work is None:
        if session.Running.stop is not None:
            return True
        if _is(wanted, fulfilled(plan)):
            return _end()
        check_writable(plan)
        order = go_on(take_fit(context, plan, wanted, plan.cmc.fit_curve, plan.cmc.fit_anchors), plan)
        Following.order = order
        Following.work = session.steps(order.work, order.settings.tolerance, wait=0.0, gives_way=True)
    elif not _is(wanted, Following.order.settings):
        Following.order.newer.set()
    try:
        while next(Following.work) is not None:
            pass
    except StopIteration as end:
        return _deliver(context, plan, end.value)
    if Following.order.latest is not None:
        preview.show(*Following.order.latest)
        Following.order.latest = None
        redraw(context)
    return True


def _is(wanted: SimpleNamespace, settings: SimpleNamespace | None) -> bool:
    """Whether the settings are those that are wanted, as far as they count now."""
    others = {name for knob, name in KNOB_PROPERTY.items() if knob != wanted.knob}
    others |= set() if wanted.limit_tilt else {"tilt_min", "tilt_max"}
    return settings is not None and all(
        getattr(settings, name) == value for name, value in vars(wanted).items() if name not in others
    )


def _deliver(context: bpy.types.Context, plan: bpy.types.Object, outcome) -> bool:
    order, Following.order, Following.work = Following.order, None, None
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
    if Following.work is not None:
        Following.work.close()
        preview.clear()
    Following.uid = Following.order = Following.work = None
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


def _handlers() -> list[tuple[list, object]]:
    handlers = bpy.app.handlers
    return [(handlers.undo_pre, _on_undo), (handlers.redo_pre, _on_undo), (handlers.load_pre, _on_load)]


def register() -> None:
    watchers.append(changed)
    for handlers, told in _handlers():
        handlers.append(told)


def unregister() -> None:
    stop()
    if bpy.app.timers.is_registered(tick):
        bpy.app.timers.unregister(tick)
    if changed in watchers:
        watchers.remove(changed)
    for handlers, told in _handlers():
        if told in handlers:
            handlers.remove(told)
