"""How long work runs: one generator, to its end or in small steps.

A script, the redo panel and Blender without a window run it to its end. A click advances it twenty times a second, so
that the window keeps drawing, the status bar shows the progress, and Esc works. Work of a moment is done at once.
Where the mesh itself is at fault, a click ends in edit mode with the faulty elements selected (see
`highlight_bridge`).
"""

from collections.abc import Generator
from time import monotonic

import bpy

from ...solver.errors import CmcError
from ..background import worker
from ..bridges import highlight_bridge
from ..bridges.mesh_cache import contacts
from ..drawing.viewport import redraw
from ..properties.links import by_uid

Steps = Generator[worker.Step | None, None, set[str]]
TICK = 0.05
_MOMENT = 0.15  # seconds in which nobody misses a progress bar


class ModalOperator:
    """An operator whose work is the generator `steps`; a mixin for `bpy.types.Operator`."""

    bl_options = {"REGISTER", "UNDO"}
    _work: Steps | None = None
    _timer = None
    _about = 0

    # --- what differs between operators

    def steps(self, context: bpy.types.Context, wait: float) -> Steps:
        """Do the work and write its result; yields steps of `worker.steps`, or None after `wait` seconds without one.

        Returns what the operator returns. Raises `CmcError`, with nothing changed.
        """
        raise NotImplementedError

    def progress_of(self, step: worker.Step) -> tuple[float, str]:
        """The progress of the work, from 0 to 1 and as a text."""
        return step.fraction, f"Step {step.iteration}"

    def about(self, context: bpy.types.Context) -> bpy.types.Object | None:
        """The object whose vertices, edges and faces the numbers in an error refer to."""
        return context.object

    def _report_cancelled(self) -> set[str]:
        self.report({"INFO"}, f"{self.bl_label} was cancelled; nothing was changed.")
        return {"CANCELLED"}

    # --- what all have in common

    def execute(self, context: bpy.types.Context) -> set[str]:
        work = self.steps(context, wait=TICK)
        try:
            while True:
                next(work)
        except StopIteration as end:
            return end.value
        except CmcError as error:
            self.report({"ERROR"}, _explained(error, self.about(context) if error.vertices else None))
            return {"CANCELLED"}

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if bpy.app.background:  # timers never fire there
            return self.execute(context)
        about = self.about(context)
        self._about = about.session_uid if about is not None else 0
        self._work = self.steps(context, wait=0.01)
        try:
            until = monotonic() + _MOMENT
            while monotonic() < until:
                next(self._work)
        except StopIteration as end:
            self._cleanup(context)
            return end.value
        except CmcError as error:
            return self._fail(context, error)
        self._start(context)
        return {"RUNNING_MODAL"}

    def _start(self, context: bpy.types.Context) -> None:
        window_manager = context.window_manager
        run = window_manager.cmc
        run.running, run.progress, run.message = True, 0.0, self.bl_label
        self._timer = window_manager.event_timer_add(TICK, window=context.window)
        window_manager.modal_handler_add(self)
        _status(context, f"{self.bl_label}   |   Esc: cancel")

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type == "ESC" and event.value == "PRESS":
            self._cleanup(context)
            return self._report_cancelled()
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        try:
            return self._advance(context)
        except CmcError as error:
            return self._fail(context, error)
        except BaseException:
            self._cleanup(context)
            raise

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator: a file is opened, the window is closed."""
        self._cleanup(context)

    def _advance(self, context: bpy.types.Context) -> set[str]:
        """Take in the steps since the last tick."""
        assert self._work is not None
        try:
            for _ in range(1000):  # a thread with more steps than that in a tick must not hold up the window
                step = next(self._work)
                if step is None:
                    break
                run = context.window_manager.cmc
                run.progress, run.message = self.progress_of(step)
                _status(context, f"{self.bl_label}: {run.message}   |   Esc: cancel")
        except StopIteration as end:
            self._cleanup(context)
            return end.value
        redraw()
        return {"RUNNING_MODAL"}

    def _fail(self, context: bpy.types.Context, error: CmcError) -> set[str]:
        self._cleanup(context)
        about = by_uid(self._about)
        self.report({"ERROR"}, _explained(error, about))
        highlight_bridge.show(context, about, error)
        return {"CANCELLED"}

    def _cleanup(self, context: bpy.types.Context) -> None:
        if self._work is not None:
            self._work.close()
            self._work = None
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None
            _status(context, None)
        context.window_manager.cmc.running = False
        context.window_manager.cmc.message = ""
        redraw()


def _explained(error: CmcError, ob: bpy.types.Object | None) -> str:
    """The error, and the button that helps where parts of the mesh only touch."""
    if not error.vertices or ob is None or ob.cmc.role != "NONE" or ob.type != "MESH" or not contacts(ob.data):
        return str(error)
    return f"{error} Weld, in the panel Plan, joins them."


def _status(context: bpy.types.Context, text: str | None) -> None:
    """Show a text in the status bar; None gives it back to Blender."""
    if context.workspace is not None and not bpy.app.background:
        context.workspace.status_text_set(text)
