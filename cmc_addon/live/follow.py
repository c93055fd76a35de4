"""Follow: the fitted shell follows changes of its plan's settings.

Each change starts a fit from the last one, in a thread; a timer looks after it. While a number is dragged, a fit that
is out of date ends with the shape it has, which is shown, and the next fit starts with the newest number. All of it is
one step of undo.
"""

from __future__ import annotations

from types import SimpleNamespace

import bpy
from bpy.app.handlers import persistent

from ...solver.errors import CmcError
from ..background.timer import TICK, BackgroundTask, may_start, rest, wake
from ..drawing import preview
from ..drawing.viewport import redraw
from ..properties.changes import watchers
from ..properties.design_settings import FIT_SETTINGS, HEIGHT_PROPERTY, stored_settings
from ..properties.links import by_uid, result_of
from ..properties.registration import registration
from ..results.objects import check_writable
from ..tasks.design import DesignResult
from ..tasks.fit_outline import FitTask, Latest, fulfilled


class Follow:
    """The plan whose shell follows, as the number that survives undo; its running fit; whether the shell has moved;
    the plan whose fit failed, and why."""

    uid: int = 0
    running: BackgroundTask | None = None
    moved: bool = False
    problem: tuple[int, str] | None = None


def changed(what: bpy.types.ID) -> None:
    """A setting has changed: if it belongs to a plan whose shell follows, fit from the next tick on."""
    if not isinstance(what, bpy.types.Object) or not what.cmc.follow or result_of(what, "FIT") is None:
        return
    if Follow.uid != what.session_uid:
        stop()
    Follow.uid, Follow.problem = what.session_uid, None
    wake(tick)


def tick() -> float | None:
    """Look after the fit; returns seconds until the next tick, or None when the shell fits the settings."""
    plan = by_uid(Follow.uid)
    if plan is None or not plan.cmc.follow or result_of(plan, "FIT") is None:
        stop()
        return None
    try:
        return TICK if _advance(bpy.context, plan) else None
    except CmcError as error:
        stop()
        Follow.problem = plan.session_uid, str(error)
        redraw()
        return None


def _advance(context: bpy.types.Context, plan: bpy.types.Object) -> bool:
    """Whether there is more to do."""
    wanted = stored_settings(plan.cmc, FIT_SETTINGS)
    if Follow.running is None:
        if not may_start():
            return True
        if _is(wanted, fulfilled(plan)):
            return _end()
        check_writable(plan)
        task = FitTask.read(context, plan, wanted, plan.cmc.fit_curve, plan.cmc.fit_anchors)
        Follow.running = BackgroundTask(task.go_on(plan))
    elif not _is(wanted, Follow.running.task.settings):
        Follow.running.task.newer.set()
    has_ended, result = Follow.running.look()
    if has_ended:
        return _write(context, plan, result)
    task: FitTask = Follow.running.task
    if task.latest is not None:
        preview.show(*task.latest)
        task.latest = None
        redraw()
    return True


def _is(wanted: SimpleNamespace, settings: SimpleNamespace | None) -> bool:
    """Whether the settings equal the wanted ones, apart from those without effect now."""
    others = {name for height_parameter, name in HEIGHT_PROPERTY.items() if height_parameter != wanted.height_parameter}
    others |= set() if wanted.limit_tilt else {"tilt_min", "tilt_max"}
    return settings is not None and all(
        getattr(settings, name) == value for name, value in vars(wanted).items() if name not in others
    )


def _write(context: bpy.types.Context, plan: bpy.types.Object, result: DesignResult | None) -> bool:
    task, Follow.running = Follow.running.task, None
    preview.clear()
    if result is None:  # it has given way to a solve, after which it starts again
        return True
    task.write(context, plan, result)
    Follow.moved = True
    redraw()
    return True


def problem_of(plan: bpy.types.Object) -> str:
    """Why the shell of this plan does not follow; empty if it does."""
    return Follow.problem[1] if Follow.problem and Follow.problem[0] == plan.session_uid else ""


def _end() -> bool:
    if Follow.moved:
        bpy.ops.ed.undo_push(message="Follow")
    stop()
    return False


def stop() -> None:
    """Leave the shell as it is now."""
    if Follow.running is not None:
        Follow.running.drop()
        preview.clear()
    Follow.uid, Follow.running = 0, None
    Follow.moved, Follow.problem = False, None


@persistent
def _on_undo(*_) -> None:
    """State restored by Blender need not fit the last settings."""
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
