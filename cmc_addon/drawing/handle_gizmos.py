"""The handles of the active plan, as gizmos of the 3D view in object mode: levers that lean, the crown that rises.

A drag writes the group's angle or the number of the plan's size, which Live follows, and is one step of undo. They are
drawn and found in pixels of the region, so that they are as large in every view.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.gauss.kinds import KINDS
from ..bridges.geometry_changes import version
from ..bridges.mesh_cache import is_on_lines
from ..bridges.overlay_bridge import points_of
from ..properties.libraries import keeps_changes
from ..properties.links import by_uid, plan_to_solve, shown_shell
from ..properties.registration import registration
from ..properties.settings import SIZE_PROPERTY
from ..properties.units import in_units, length_text, per_length
from . import handle_draw
from .caption_gizmo import CMC_GT_caption, Side
from .crown import Crown, crown_of, number_at
from .handles import ANGLES, Lever, arc, levers, lifted, snapped, turned
from .overlay import Seen, is_plan, is_visible, seen_plan_of
from .overlay_cache import kept
from .palette import colour_of
from .rim import Rim
from .screen import Screen
from .viewport import redraw, right_end, screen_of

Array = NDArray[np.float64]

# Pixels at an interface scale of 1: length of a lever and of the crown's arrow, and how near the mouse must come.
_LEVER, _ARROW, _NEAR = 52.0, 34.0, 11.0
_MOST = 12  # levers
# Steps of a drag with Ctrl: of an angle, radians, and of a size, two digits.
_STEP = np.radians(5.0)
_SLOW = 0.1  # with Shift
_CROWN = (0.95, 0.95, 0.95)
_UP = np.array([0.0, 0.0, 1.0])


# --- where they are --------------------------------------------------------------------------

def handled_plan(context: bpy.types.Context) -> bpy.types.Object | None:
    """The plan whose handles are shown: the active one, in object mode, if it keeps what is dragged."""
    settings, plan = context.scene.cmc, plan_to_solve(context)
    if context.mode != "OBJECT" or plan is None or not (settings.show_all and settings.show_handles):
        return None
    return plan if is_plan(plan) and keeps_changes(plan) and keeps_changes(plan.data) else None


def levers_of(context: bpy.types.Context, plan: bpy.types.Object, view=None) -> list[Lever]:
    """The levers of a plan that is visible, in the world."""
    seen = seen_plan_of(context, plan) if is_visible(plan, context, view) else None
    if seen is None:
        return []
    origin = np.array(plan.matrix_world.translation, dtype=np.float64)
    return [replace(lever, at=lever.at + origin) for lever in levers(seen.rim)][:_MOST]


def sides_of(context: bpy.types.Context, plan: bpy.types.Object, view=None) -> list[Side]:
    """The sides of a plan that is visible, with their captions, in the world."""
    seen = seen_plan_of(context, plan) if is_visible(plan, context, view) else None
    if seen is None:
        return []
    origin = np.array(plan.matrix_world.translation, dtype=np.float64)
    return [Side(walk.points + origin, side_text(seen.rim, walk.uid)) for walk in seen.rim.walks]


def crown(context: bpy.types.Context, plan: bpy.types.Object, view=None) -> Crown | None:
    """The crown of the shell of a plan, in the world, while it is visible."""
    shell, seen = shown_shell(context), seen_plan_of(context, plan)
    if shell is None or seen is None or shell.cmc.role != plan.cmc.sheet or not is_visible(shell, context, view):
        return None
    if shell.data.is_editmode:
        return None
    spans, matrix = is_on_lines(plan), tuple(map(tuple, shell.matrix_world))
    key = version(shell, shell.data), seen.number, spans, matrix, tuple(plan.matrix_world.translation)
    return kept(("crown", shell.session_uid), key, lambda: _crown(plan, shell, seen, spans))


def _crown(plan: bpy.types.Object, shell: bpy.types.Object, seen: Seen, spans: bool) -> Crown | None:
    matrix = np.array(shell.matrix_world, dtype=np.float64)
    points = points_of(shell.data) @ matrix[:3, :3].T + matrix[:3, 3]
    origin = np.array(plan.matrix_world.translation, dtype=np.float64)
    rim = np.concatenate([np.zeros((0, 2, 3)), *seen.rim.lines.values()]).reshape(-1, 3)
    return crown_of(points, rim + origin, seen.rim.outer + origin, spans)


def side_text(rim: Rim, uid: int) -> str:
    """What the shell does along a side, for a caption."""
    group = rim.group(uid)
    name, kind = ("Other edges", rim.default_kind) if group is None else (group.name, group.kind)
    angle = dict(group.parameters).get(ANGLES.get(kind, "")) if group is not None else None
    text = f"{name}: {KINDS[kind].label[0].lower()}{KINDS[kind].label[1:]}"
    return f"{text}, {np.degrees(angle):.4g}°" if isinstance(angle, float) else text


def size_text(size: str, number: float) -> str:
    """A size, as the solver names it, for a caption."""
    if size == "rise":
        return f"Rise {number:.2f}"
    if size == "mean_curvature":
        return f"H {in_units(number):.3g} {per_length()}"
    return f"{size.title()} {length_text(number, 3 if size == 'volume' else 1)}"


# --- the gizmos ------------------------------------------------------------------------------

class _Handle:
    """What both gizmos share. `plan`: uid of the plan; `grabbed`: the handle, its values and the mouse at the start.

    mouse, moved: the mouse, and the place to which it drags, which moves slowly with Shift.
    """

    def setup(self) -> None:
        self.plan, self.grabbed, self.now = 0, None, 0.0
        self.mouse = self.moved = np.zeros(2)
        self.use_draw_modal = True

    def test_select(self, context, location) -> int:
        track = self.track(context)
        near = _NEAR * context.preferences.system.ui_scale
        tip = self.grip(track, context.preferences.system.ui_scale)
        return 0 if np.linalg.norm(tip - np.array(location)) <= near else -1  # nan is not

    def grip(self, track: Array, scale: float) -> Array:
        """The place (2,) to take it at."""
        return track[-1]

    def draw(self, context) -> None:
        with handle_draw.blended():
            self.show(context, context.preferences.system.ui_scale, self.is_highlight or self.grabbed is not None)

    def invoke(self, context, event):
        self.mouse = self.moved = _mouse(event)
        self.grab(context, self.mouse)
        return {"RUNNING_MODAL"}

    def modal(self, context, event, _tweak):
        mouse = _mouse(event)
        self.moved = self.moved + (_SLOW if event.shift else 1.0) * (mouse - self.mouse)
        self.mouse = mouse
        self.drag(context, self.moved, event.ctrl)
        redraw()
        return {"RUNNING_MODAL"}

    def exit(self, context, cancel) -> None:
        plan, grabbed, self.grabbed = by_uid(self.plan), self.grabbed, None
        if plan is None or grabbed is None:
            return
        changed = self.stored(plan) != grabbed[1]
        if cancel:
            self.store(plan, grabbed[1])
        elif changed:
            bpy.ops.ed.undo_push(message=self.bl_label)
        redraw()


class CMC_GT_lever(_Handle, bpy.types.Gizmo):
    """Turns the shell along a side that leans"""

    bl_idname = "CMC_GT_lever"
    bl_label = "Lean"
    __slots__ = ("grabbed", "lever", "mouse", "moved", "now", "plan")

    def track(self, context) -> Array:
        """Foot and tip of the lever on the screen, (2, 2)."""
        lever, screen = self.held, screen_of(context)
        angle = lever.angle if self.grabbed is None else self.now
        tip = lever.tips(np.array([angle]), _length(context, screen, lever.at, _LEVER))
        return screen.pixels(np.concatenate([lever.at[None], tip]))

    @property
    def held(self) -> Lever:
        return self.lever if self.grabbed is None else self.grabbed[0]

    def show(self, context, scale: float, is_hot: bool) -> None:
        lever, screen = self.held, screen_of(context)
        colour, track = colour_of(lever.uid), self.track(context)
        if is_hot:
            plan = by_uid(self.plan)
            angle = self.stored(plan)
            way = arc(lever, _length(context, screen, lever.at, _LEVER), angle)
            handle_draw.line(screen.pixels(np.concatenate([lever.at[None], way])), (*colour, 1.0), 2.0 * scale)
            text = f"{lever.name} leans {np.degrees(angle):.4g}°"
            handle_draw.caption(text + _hint(plan, self.grabbed), track[-1], scale, right_end(context))
        handle_draw.handle(track, colour, scale, is_hot)

    def grab(self, context, mouse: Array) -> None:
        self.now = self.lever.angle
        self.grabbed = self.lever, self.stored(by_uid(self.plan)), self.track(context)[-1] - mouse

    def drag(self, context, mouse: Array, snaps: bool) -> None:
        lever, _, offset = self.grabbed
        screen = screen_of(context)
        length = _length(context, screen, lever.at, _LEVER)
        angle = turned(lever, screen, length, self.now, mouse + offset)
        self.now = angle
        wanted = snapped(angle, _STEP) if snaps else snapped(angle, np.radians(0.1))
        self.store(by_uid(self.plan), float(np.clip(wanted, lever.least, lever.most)))

    def stored(self, plan) -> float:
        return getattr(_group(plan, self.held.uid), self.held.parameter, np.nan)

    def store(self, plan, value: float) -> None:
        group = _group(plan, self.lever.uid)
        if group is not None and getattr(group, self.lever.parameter) != value:
            setattr(group, self.lever.parameter, value)


class CMC_GT_crown(_Handle, bpy.types.Gizmo):
    """Raises and lowers the crown of the shell"""

    bl_idname = "CMC_GT_crown"
    bl_label = "Size"
    __slots__ = ("crown", "grabbed", "mouse", "moved", "now", "plan")

    @property
    def held(self) -> Crown:
        return self.crown if self.grabbed is None else self.grabbed[0]

    def track(self, context) -> Array:
        """Foot and tip of the arrow on the screen, (2, 2): over where the crown is dragged to."""
        screen = screen_of(context)
        at = self.held.at + (0.0 if self.grabbed is None else self.now) * _UP
        length = _length(context, screen, at, _ARROW)
        return screen.pixels(np.stack([at, at + length * _UP]))

    def grip(self, track: Array, scale: float) -> Array:
        return track[-1] + [0.0, 0.5 * _NEAR * scale]

    def show(self, context, scale: float, is_hot: bool) -> None:
        track, plan = self.track(context), by_uid(self.plan)
        if is_hot and plan is not None:
            name = SIZE_PROPERTY[plan.cmc.size]
            text = "Drag to set the rise" if name is None else size_text(name, getattr(plan.cmc, name))
            handle_draw.caption(text + _hint(plan, self.grabbed), track[-1], scale, right_end(context))
            if self.grabbed is not None:
                foot = screen_of(context).pixels(np.stack([self.held.at, self.held.at + self.now * _UP]))
                handle_draw.line(foot, (*_CROWN, 1.0), 2.0 * scale)
        handle_draw.handle(track, _CROWN, scale, is_hot, is_arrow=True)

    def grab(self, context, mouse: Array) -> None:
        self.now = 0.0
        self.grabbed = self.crown, self.stored(by_uid(self.plan)), mouse

    def drag(self, context, mouse: Array, snaps: bool) -> None:
        plan, (held, before, start) = by_uid(self.plan), self.grabbed
        if plan is None:
            return
        self.now = lifted(held.at, _UP, screen_of(context), start, mouse)
        name = SIZE_PROPERTY[before["size"]]
        size, number = number_at(held, before["size"].lower(), before[name] if name else 0.0, self.now, plan.cmc.flip)
        if snaps:
            number = snapped(number, 0.5 * 10.0 ** np.floor(np.log10(max(abs(number), 1e-9))))
        self.store(plan, {**before, SIZE_PROPERTY[size.upper()]: number, "size": size.upper()})

    def stored(self, plan) -> dict[str, Any]:
        """The size, and the numbers of all sizes."""
        return {name: getattr(plan.cmc, name) for name in ("size", *filter(None, SIZE_PROPERTY.values()))}

    def store(self, plan, values: dict[str, Any]) -> None:
        for name, value in values.items() if plan is not None else ():
            if getattr(plan.cmc, name) != value:
                setattr(plan.cmc, name, value)


class CMC_GGT_handles(bpy.types.GizmoGroup):
    """The handles of the active plan"""

    bl_idname = "CMC_GGT_handles"
    bl_label = "CMC Handles"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"PERSISTENT"}

    @classmethod
    def poll(cls, context):
        return context.space_data.overlay.show_overlays and handled_plan(context) is not None

    def setup(self, context):
        self.levers = [self.gizmos.new(CMC_GT_lever.bl_idname) for _ in range(_MOST)]
        self.crown = self.gizmos.new(CMC_GT_crown.bl_idname)
        self.caption = self.gizmos.new(CMC_GT_caption.bl_idname)
        self.draw_prepare(context)

    def draw_prepare(self, context):
        """Give the gizmos their handles, and hide those that are left over."""
        plan, view = handled_plan(context), context.space_data
        found = levers_of(context, plan, view) if plan is not None else []
        for k, gizmo in enumerate(self.levers):
            gizmo.hide = k >= len(found)
            if not gizmo.hide:
                gizmo.plan, gizmo.lever = plan.session_uid, found[k]
        top = crown(context, plan, view) if plan is not None else None
        self.caption.sides = [] if plan is None else sides_of(context, plan, view)
        self.crown.hide = top is None
        if top is not None:
            self.crown.plan, self.crown.crown = plan.session_uid, top


def _group(plan: bpy.types.Object | None, uid: int):
    return None if plan is None else next((group for group in plan.data.cmc.groups if group.uid == uid), None)


def _hint(plan: bpy.types.Object | None, grabbed: Any) -> str:
    """What to do to see it, while dragging."""
    return "; Solve to see it" if grabbed is not None and plan is not None and not plan.cmc.live else ""


def _mouse(event: bpy.types.Event) -> Array:
    return np.array([event.mouse_region_x, event.mouse_region_y], dtype=np.float64)


def _length(context: bpy.types.Context, screen: Screen, at: Array, pixels: float) -> float:
    """A length in pixels as one in the world, at a point (3,)."""
    return pixels * context.preferences.system.ui_scale * screen.pixel(at)


CLASSES = (CMC_GT_caption, CMC_GT_lever, CMC_GT_crown, CMC_GGT_handles)
register, unregister = registration(CLASSES)
