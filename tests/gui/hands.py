"""Eyes and hands for a Blender window: move, click, type, find a button, take a picture.

Everything that takes time is a generator; a story goes through it with `yield from`, and what it yields is how
many seconds to wait while Blender handles events and draws. Coordinates are window pixels from the bottom left.
"""

from __future__ import annotations

import subprocess
from collections.abc import Iterator

import bpy

PICTURES = "/pictures"
ROW = 11  # half a row of buttons: every row is met once
TAB = "CMC"
TABS = 35  # width of the strip of tabs beside the panels

Steps = Iterator[float]


class Hands:
    """One pair of hands at the first window, which shows one 3D viewport as large as the window."""

    def __init__(self, story: str) -> None:
        self.story = story
        self.shots = 0
        self.window = bpy.context.window_manager.windows[0]

    # --- where things are

    @property
    def area(self) -> bpy.types.Area:
        return max(
            (area for area in self.window.screen.areas if area.type == "VIEW_3D"), key=lambda a: a.width * a.height
        )

    @property
    def sidebar(self) -> bpy.types.Region:
        return next(region for region in self.area.regions if region.type == "UI")

    @property
    def view(self) -> tuple[int, int]:
        """A place in the viewport with nothing in it."""
        return self.area.x + 120, self.area.y + 120

    # --- doing things

    def move(self, x: int, y: int) -> None:
        self.window.event_simulate(type="MOUSEMOVE", value="NOTHING", x=int(x), y=int(y))

    def press(self, name: str, at: tuple[int, int] | None = None, **modifiers: bool) -> Steps:
        """Press and release a key with the mouse over the viewport, or over `at`."""
        x, y = at or self.view
        self.move(x, y)
        yield 0.1
        for value in ("PRESS", "RELEASE"):
            self.window.event_simulate(type=name, value=value, x=int(x), y=int(y), **modifiers)
        yield 0.4

    def click(self, x: int, y: int, **modifiers: bool) -> Steps:
        """Click. A double click cannot be simulated; in a list Ctrl and a click do the same, rename."""
        self.move(x, y)
        yield 0.2
        for value in ("PRESS", "RELEASE"):
            self.window.event_simulate(type="LEFTMOUSE", value=value, x=int(x), y=int(y), **modifiers)
        yield 0.4

    def type(self, text: str, at: tuple[int, int]) -> Steps:
        """Type into the field that is being edited, and confirm."""
        for letter in text:
            self.window.event_simulate(
                type=_key(letter), value="PRESS", unicode=letter, x=int(at[0]), y=int(at[1])
            )
            self.window.event_simulate(type=_key(letter), value="RELEASE", x=int(at[0]), y=int(at[1]))
            yield 0.05
        yield from self.press("RET", at)

    # --- the sidebar

    def open_tab(self, width: int = 0) -> Steps:
        """Show the sidebar with our tab."""
        self.area.spaces.active.show_region_ui = True
        yield 0.5
        self.sidebar.active_panel_category = TAB
        self.area.tag_redraw()
        yield 0.5

    def find(
        self, command: str, fractions: tuple[float, ...] = (0.5,), near: int | None = None
    ) -> Iterator[float]:
        """The place of the button that runs `command` ("cmc.solve"), looked for at parts of the panels' width,
        and only within a hundred pixels of the height `near` if that is given.

        Asked of Blender, which copies the command of the button under the mouse on Ctrl C. Raises LookupError
        if there is none."""
        side = self.sidebar
        top, bottom = side.y + side.height - 30, side.y + 4
        if near is not None:
            top, bottom = near + 100, near - 100
        for fraction in fractions:
            x = side.x + fraction * (side.width - TABS)
            for y in range(top, bottom, -ROW):
                bpy.context.window_manager.clipboard = ""
                self.move(x, y)
                yield 0.03
                for value in ("PRESS", "RELEASE"):
                    self.window.event_simulate(type="C", value=value, x=int(x), y=int(y), ctrl=True)
                yield 0.03
                if command in bpy.context.window_manager.clipboard:
                    return int(x), int(y)
        raise LookupError(f"no button {command} in the sidebar")

    def click_button(
        self, command: str, fractions: tuple[float, ...] = (0.5,), near: int | None = None
    ) -> Steps:
        x, y = yield from self.find(command, fractions, near)
        yield from self.click(x, y)

    # --- pictures

    def picture(self, name: str) -> Steps:
        """Take a picture of the whole window: the X server's, since Blender's own are black without a GPU."""
        for _ in range(3):  # a panel takes its new height with the second redraw
            self.area.tag_redraw()
            yield 0.4
        self.shots += 1
        file = f"{PICTURES}/{self.story}-{self.shots:02d}-{name}.png"
        subprocess.run(["import", "-window", "root", file], check=True)
        yield 0.1


_NAMES = {"0": "ZERO", "1": "ONE", "2": "TWO", "3": "THREE", "4": "FOUR", "5": "FIVE", "6": "SIX", "7": "SEVEN",
          "8": "EIGHT", "9": "NINE", ".": "PERIOD", " ": "SPACE", "-": "MINUS"}


def _key(letter: str) -> str:
    return _NAMES.get(letter, letter.upper())
