"""Live: the shell follows changes of its plan, its groups and its settings.

A change marks its plan. A tick of the timer reads the marked plans and updates one of them, in a thread (see `update`);
one update runs at a time and plans take turns. An update that is out of date when it ends is shown all the same, or
nothing would move during a long drag, but never after a newer one. A plan at rest is solved once more as by Solve, and
only that result is measured. This last update gives way to any change.

Nothing here makes a step of undo: a drag is one, as Blender makes it. What undo, redo or a file brings back need not
fit together, so all of it is solved again.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import bpy
from bpy.app.handlers import persistent

from ...solver.errors import CmcError
from ..background.timer import TICK, BackgroundTask, may_start, rest, wake
from ..drawing.viewport import redraw
from ..properties.changes import watchers
from ..properties.links import results_of
from ..properties.live_settings import limit
from ..properties.registration import registration
from ..results.objects import check_writable
from .update import COARSE, FINAL, QUICK, WHOLE, FullTask, LiveTask, Memory, QuickTask, Reading, read

# Seconds without a change or an update after which a plan is at rest.
_REST = 0.3
# Seconds between two ticks while Blender renders, when no data may be touched.
_RENDERING = 0.5


@dataclass(eq=False)
class State:
    """The state of a live plan.

    reading: the plan as last read; since: when it last changed; is_dirty: it may have changed again. shown: key of what
    the results show, None where that is not known; grade: how good they are. failed: key of a reading that cannot be
    solved; problem: why. served: when it was last updated. memory: what the next quick update starts from.
    """

    is_dirty: bool = True
    reading: Reading | None = None
    since: float = 0.0
    shown: tuple | None = None
    grade: int = 0
    failed: tuple | None = None
    problem: str = ""
    served: float = 0.0
    memory: Memory | None = None

    @property
    def is_behind(self) -> bool:
        """Whether the results show something older."""
        return self.reading is not None and self.reading.key not in (self.shown, self.failed)

    @property
    def is_settled(self) -> bool:
        """Whether there is nothing to do until the next change."""
        return self.reading is None or self.reading.key == self.failed or (not self.is_behind and self.grade == FINAL)

    def next_grade(self, now: float) -> int:
        """The grade of the next update; 0 for none now."""
        if self.reading is None or self.is_settled:
            return 0
        if self.is_behind:
            if self.memory is None or not self.memory.serves(self.reading):
                return WHOLE
            return COARSE if len(self.reading.solve.mesh.positions) > limit() else QUICK
        if now - max(self.since, self.served) < _REST:  # large ones take longer than that
            return 0
        return QUICK if self.grade == COARSE else FINAL


class Live:
    """States by the number that survives undo. The running update, the plan it belongs to, and whether it can wait.
    is_deaf: changes that Blender announces come from reading."""

    states: dict[int, State] = {}
    running: BackgroundTask | None = None
    uid: int = 0
    can_wait: bool = False
    is_deaf: bool = False


def problem_of(plan: bpy.types.Object) -> str:
    """Why the shell of this plan does not follow; empty where it does."""
    state = Live.states.get(plan.session_uid)
    return "" if state is None else state.problem


# --- what has changed ----------------------------------------------------------------------

def changed(what: bpy.types.ID) -> None:
    """An object or a mesh has changed: the next tick reads the live plans that it belongs to."""
    if isinstance(what, bpy.types.Object):
        if is_live(what):
            Live.states.setdefault(what.session_uid, State()).is_dirty = True
        elif what.session_uid not in Live.states:
            return
    elif not _mark_users(what):
        return
    wake(tick)


def is_live(ob: bpy.types.Object) -> bool:
    return ob.type == "MESH" and ob.cmc.live and ob.cmc.role == "NONE"


def _mark_users(mesh: bpy.types.ID) -> bool:
    """Mark the live plans that use a mesh, or whose results use it and failed to be written; whether there are any."""
    marked = False
    for uid, plan in _plans().items():
        state = Live.states[uid]
        if plan.data == mesh or (state.failed and any(ob.data == mesh for ob in results_of(plan).values())):
            state.is_dirty, state.failed, marked = True, None, True
    return marked


def _plans() -> dict[int, bpy.types.Object]:
    """The plans of all states that still exist."""
    return {ob.session_uid: ob for ob in bpy.data.objects if ob.session_uid in Live.states and ob.users_scene}


@persistent
def _on_change(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    for update in () if Live.is_deaf else depsgraph.updates:
        what = update.id.original
        if isinstance(what, bpy.types.Object):
            if what.session_uid in Live.states or is_live(what):
                changed(what)
        elif isinstance(what, bpy.types.Mesh) and Live.states:
            changed(what)


@persistent
def _on_frame(*_: object) -> None:
    """Another frame: anything may be animated."""
    for state in Live.states.values():
        state.is_dirty = True
    if Live.states:
        wake(tick)


@persistent
def _on_other_data(*_: object) -> None:
    """Undo, redo, another file: find the live plans; their results may be out of date."""
    _drop()
    Live.states = {ob.session_uid: State() for ob in bpy.data.objects if is_live(ob)}
    if Live.states:
        wake(tick)


# --- updating ------------------------------------------------------------------------------

def tick() -> float | None:
    """Look after the updates; returns seconds until the next tick, or None when all plans are at rest."""
    if bpy.app.is_job_running("RENDER"):
        return _RENDERING
    context, plans = bpy.context, _plans()
    for uid in [uid for uid in Live.states if uid not in plans]:
        _forget(uid)
    while Live.running is not None and _look(context, plans):
        pass
    _read(context, plans)
    if Live.running is not None and Live.can_wait and any(state.is_behind for state in Live.states.values()):
        _drop()
    if Live.running is None and may_start():
        _start(context, plans)
    for uid, plan in plans.items():
        if not plan.cmc.live and Live.states[uid].is_settled and not Live.states[uid].is_dirty:
            _forget(uid)
    is_quiet = all(state.is_settled and not state.is_dirty for state in Live.states.values())
    return None if is_quiet and Live.running is None else TICK


def _read(context: bpy.types.Context, plans: dict[int, bpy.types.Object]) -> None:
    """Read the plans that may have changed; not while a change is being updated, which nothing overtakes."""
    marked = [uid for uid, state in Live.states.items() if state.is_dirty]
    if Live.running is not None and not Live.can_wait:
        return
    if marked:
        context.view_layer.update()
    for uid in marked:
        state, plan = Live.states[uid], plans[uid]
        state.is_dirty = False
        try:
            check_writable(plan)
            reading = read(context, plan)
        except CmcError as error:
            state.reading, state.problem = None, str(error)
            redraw()
            continue
        if state.reading is None or state.reading.key != reading.key:
            state.since = time.monotonic()
        state.reading = reading
        if reading.key != state.failed and state.problem:
            state.problem = ""
            redraw()
    if marked:
        _not_hearing(context)


def _not_hearing(context: bpy.types.Context) -> None:
    """Let Blender announce now that reading has touched plans in edit mode or with modifiers."""
    Live.is_deaf = True
    try:
        context.view_layer.update()
    finally:
        Live.is_deaf = False


def _start(context: bpy.types.Context, plans: dict[int, bpy.types.Object]) -> None:
    """Start the most urgent update: changed plans before plans at rest, the longest waiting first."""
    now = time.monotonic()
    wanted = [(uid, state, grade) for uid, state in Live.states.items() if (grade := state.next_grade(now))]
    if not wanted:
        return
    uid, state, grade = min(wanted, key=lambda one: (not one[1].is_behind, one[1].served))
    Live.uid, Live.can_wait = uid, not state.is_behind
    reading, memory = state.reading, state.memory
    assert reading is not None  # else there is no grade
    if memory is None or grade in (WHOLE, FINAL):
        Live.running = BackgroundTask(FullTask(reading, grade))
    else:
        Live.running = BackgroundTask(QuickTask(reading, grade, memory))
    _look(context, plans)


def _look(context: bpy.types.Context, plans: dict[int, bpy.types.Object]) -> bool:
    """Whether the update has ended; if so, write it."""
    state, task = Live.states[Live.uid], Live.running.task
    try:
        has_ended, result = Live.running.look()
        if not has_ended:
            return False
        plan, Live.running = plans[Live.uid], None
        state.served = time.monotonic()
        if result is not None:  # else it has given way
            check_writable(plan)
            _write(context, plan, state, task, result)
    except CmcError as error:
        _fail(context, state, task, str(error))
    except BaseException:
        _fail(context, state, task, "Something unexpected went wrong; see the console.")
        raise
    return True


def _write(context: bpy.types.Context, plan: bpy.types.Object, state: State, task: LiveTask, result) -> None:
    reading = task.reading
    state.memory = task.write(context, plan, result)
    if state.memory is None:  # it no longer fits the results: solve from scratch
        state.shown, state.is_dirty = None, True
        return
    is_all = task.grade == WHOLE and not reading.solve.settings.intersections
    state.shown, state.grade = reading.key, FINAL if is_all else task.grade
    state.failed, state.problem = None, ""
    redraw()


def _fail(context: bpy.types.Context, state: State, task: LiveTask, problem: str) -> None:
    Live.running = None
    state.failed, state.problem = task.reading.key, problem
    redraw()


def _drop() -> None:
    """Cancel the running update."""
    if Live.running is not None:
        Live.running.drop()
        Live.running = None


def _forget(uid: int) -> None:
    if Live.uid == uid:
        _drop()
    del Live.states[uid]


_listen, _unlisten = registration(
    handlers={
        "depsgraph_update_post": _on_change,
        "frame_change_post": _on_frame,
        "undo_post": _on_other_data,
        "redo_post": _on_other_data,
        "load_post": _on_other_data,
    }
)


def register() -> None:
    watchers.append(changed)
    _listen()


def unregister() -> None:
    _drop()
    Live.states = {}
    rest(tick)
    if changed in watchers:
        watchers.remove(changed)
    _unlisten()
