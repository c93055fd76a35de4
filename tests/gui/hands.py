"""Hands for a Blender window: move, click, drag, type, find a button by its command or its text, take a picture.

Everything that takes time is a generator; a story goes through it with `yield from`, and what it yields is how
many seconds to wait while Blender handles events and draws. Coordinates are window pixels from the bottom left.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import bpy
import eyes
import keys
from eyes import Box

PICTURES = "/pictures"
ROW = 15  # less than the height of a button: every one is met
COLUMNS = (0.45, 0.65, 0.9, 0.25, 0.1, 0.97)  # parts of the panels' width where buttons are looked for
TAB = "CMC"
TABS = 35  # width of the strip of tabs beside the panels
PAUSE = 0.01  # until Blender has handled what was simulated

Steps = Iterator[float]
Place = tuple[int, int]


class NotThereError(LookupError):
    """The thing sought is not in the window."""


class Hands:
    """One pair of hands at the first window, which shows one 3D viewport as large as the window."""

    def __init__(self, story: str) -> None:
        self.story = story
        self.shots = 0
        self._places: dict[str, Place] = {}

    # --- where things are

    @property
    def window(self) -> bpy.types.Window:
        """Another one after a file was loaded."""
        return bpy.context.window_manager.windows[0]

    @property
    def area(self) -> bpy.types.Area:
        return max(
            (area for area in self.window.screen.areas if area.type == "VIEW_3D"), key=lambda a: a.width * a.height
        )

    @property
    def sidebar(self) -> bpy.types.Region:
        return next(region for region in self.area.regions if region.type == "UI")

    @property
    def panels(self) -> Box:
        """The sidebar without its tabs."""
        side = self.sidebar
        return Box(side.x, side.y, side.width - TABS, side.height)

    @property
    def whole(self) -> Box:
        return Box(0, 0, self.window.width, self.window.height)

    @property
    def view(self) -> Place:
        """A place in the viewport with nothing in it."""
        return self.area.x + 120, self.area.y + 120

    # --- doing things

    def move(self, x: float, y: float) -> None:
        self.window.event_simulate(type="MOUSEMOVE", value="NOTHING", x=int(x), y=int(y))

    def _key(self, name: str, at: Place, **modifiers: bool) -> None:
        for value in ("PRESS", "RELEASE"):
            self.window.event_simulate(type=name, value=value, x=int(at[0]), y=int(at[1]), **modifiers)

    def press(self, name: str, at: Place | None = None, **modifiers: bool) -> Steps:
        """Press and release a key with the mouse over the viewport, or over `at`."""
        at = at or self.view
        self.move(*at)
        yield 0.1
        self._key(name, at, **modifiers)
        yield 0.4

    def click(self, x: float, y: float, **modifiers: bool) -> Steps:
        """Click. A double click cannot be simulated; in a list Ctrl and a click do the same, rename."""
        self.move(x, y)
        yield 0.2
        self._key("LEFTMOUSE", (int(x), int(y)), **modifiers)
        yield 0.4

    def drag(self, start: Place, to: Place, steps: int = 10, pause: float = 0.05, **modifiers: bool) -> Steps:
        """Press the left button at one place, move to another and let go there."""
        self.move(*start)
        yield 0.3
        x, y = start
        self.window.event_simulate(type="LEFTMOUSE", value="PRESS", x=int(x), y=int(y), **modifiers)
        yield pause
        for k in range(1, steps + 1):
            x, y = (round(a + (b - a) * k / steps) for a, b in zip(start, to, strict=True))
            self.window.event_simulate(type="MOUSEMOVE", value="NOTHING", x=x, y=y, **modifiers)
            yield pause
        self.window.event_simulate(type="LEFTMOUSE", value="RELEASE", x=x, y=y, **modifiers)
        yield 0.4

    def type(self, text: str, at: Place) -> Steps:
        """Type into the field that is being edited, and confirm."""
        for letter in text:
            for value in ("PRESS", "RELEASE"):
                typed = {"unicode": letter} if value == "PRESS" else {}
                self.window.event_simulate(type=keys.name(letter), value=value, x=int(at[0]), y=int(at[1]), **typed)
            yield 0.05
        yield from self.press("RET", at)

    def enter(self, text: str, at: Place) -> Steps:
        """Click a field and write this into it instead of what is there."""
        yield from self.click(*at)
        yield from self.press("A", at, ctrl=True)
        yield from self.type(text, at)

    def settle(self) -> Steps:
        """Until the window is drawn as it is: a panel takes its new height with the second redraw."""
        for _ in range(3):
            self.area.tag_redraw()
            yield 0.15

    def wait_for(self, condition: Callable[[], object], what: str, seconds: float = 60.0) -> Steps:
        """Wait for something to become true; AssertionError names it if it does not."""
        waited = 0.0
        while not condition():
            assert waited < seconds, f"waited in vain until {what}"
            waited += 0.05
            yield 0.05

    # --- the sidebar

    def open_tab(self) -> Steps:
        """Show the sidebar with our tab."""
        self.area.spaces.active.show_region_ui = True
        yield 0.5
        self.sidebar.active_panel_category = TAB
        self.area.tag_redraw()
        yield 0.5

    def scroll(self, notches: int) -> Iterator[float]:
        """Turn the wheel over the sidebar, positive is down; whether anything moved. At its top: below its last panel
        the wheel would be the viewport's."""
        at = self.panels.x + self.panels.width // 2, self.panels.y + self.panels.height - 14
        before = self._scrolled()
        self.move(*at)
        yield 0.1
        for _ in range(abs(notches)):
            self._key("WHEELDOWNMOUSE" if notches > 0 else "WHEELUPMOUSE", at)
            yield 0.02
        yield 0.3
        return self._scrolled() != before

    def _scrolled(self) -> float:
        return self.sidebar.view2d.region_to_view(0, 0)[1]

    def _on_some_page(self, look: Callable[[], Iterator[float]], what: str) -> Iterator[float]:
        """What `look` finds in the sidebar as it is, or else scrolled to its top and down page by page."""
        found = yield from look()
        if found is None and (yield from self.scroll(-60)):
            found = yield from look()
        while found is None:
            if not (yield from self.scroll(8)):
                raise NotThereError(f"no {what} in the sidebar")
            found = yield from look()
        return found

    def find(
        self, command: str, columns: tuple[float, ...] = COLUMNS, near: int | None = None
    ) -> Iterator[float]:
        """The place of the button that runs `command` ("cmc.solve" or, with its arguments, "cmc.go_to(target='PLAN')").

        Asked of Blender, which copies the command of the button under the mouse on Ctrl C, at parts of the panels'
        width; within a hundred pixels of the height `near`, if that is given, which is quick. Raises NotThereError."""
        if near is None:
            return (yield from self._find(f"bpy.ops.{command}", columns, f"button {command}"))
        found = yield from self._probe(f"bpy.ops.{command}", columns, near + 100, near - 100)
        if found is None:
            raise NotThereError(f"no button {command} at that height")
        return found

    def find_field(self, path: str, columns: tuple[float, ...] = (0.75, 0.35, 0.9)) -> Iterator[float]:
        """The place of the field, tick or menu of a property, by the end of its data path ("cmc.fit_rise")."""
        return (yield from self._find(path, columns, f"field {path}", shift=True, alt=True))

    def _find(self, wanted: str, columns: tuple[float, ...], what: str, **modifiers: bool) -> Iterator[float]:
        def look() -> Iterator[float]:
            box = self.panels
            return (yield from self._probe(wanted, columns, box.y + box.height - 8, box.y + 4, **modifiers))

        known = self._places.get(wanted)  # most buttons stay where they were
        if known and is_it((yield from self._ask(*known, **modifiers)), wanted):
            return known
        self._places[wanted] = yield from self._on_some_page(look, what)
        return self._places[wanted]

    def _probe(
        self, wanted: str, columns: tuple[float, ...], top: int, bottom: int, **modifiers: bool
    ) -> Iterator[float]:
        for column in columns:
            x = self.panels.x + round(column * self.panels.width)
            for y in range(top, bottom, -ROW):
                if is_it((yield from self._ask(x, y, **modifiers)), wanted):
                    return x, y
        return None

    def _ask(self, x: int, y: int, **modifiers: bool) -> Iterator[float]:
        """What Ctrl C copies of the button at a place: its command; with Shift and Alt, its data path."""
        bpy.context.window_manager.clipboard = ""
        self.move(x, y)
        yield PAUSE
        self._key("C", (x, y), ctrl=True, **modifiers)
        yield PAUSE
        return bpy.context.window_manager.clipboard

    def click_button(self, command: str, columns: tuple[float, ...] = COLUMNS, near: int | None = None) -> Steps:
        yield from self.click(*(yield from self.find(command, columns, near)))

    def click_field(self, path: str) -> Steps:
        yield from self.click(*(yield from self.find_field(path)))

    def set_field(self, path: str, text: str) -> Steps:
        """Write into the field of a property."""
        yield from self.enter(text, (yield from self.find_field(path)))

    def choose(self, path: str, item: str) -> Steps:
        """Open the menu of a property and click the line that says `item`."""
        x, y = yield from self.find_field(path)
        yield from self.click(x, y)
        yield from self.click_words(item, Box(self.panels.x - 300, 0, self.window.width - self.panels.x + 300, 900))

    def panel(self, label: str, opened: bool = True) -> Steps:
        """Click the header of a panel of the sidebar unless it is open (or, wanted closed, closed) already."""
        words = yield from self._find_header(label)
        arrow = Box(words.x - 16, words.middle[1] - 6, 12, 12)
        if eyes.is_open(arrow, self.window.height) != opened:
            yield from self.click(*words.middle)
        if opened and words.y < self.panels.y + self.panels.height // 3:
            yield from self.scroll(8)  # what has opened may be below the window
        yield 0.3

    def only_panel(self, label: str) -> Steps:
        """Open this panel and close all others, by Ctrl and a click on its header: it has the sidebar's height."""
        words = yield from self._find_header(label)
        yield from self.click(*words.middle, ctrl=True)
        yield from self.scroll(-60)
        yield from self.panel(label)

    def _find_header(self, label: str) -> Iterator[float]:
        def look() -> Iterator[float]:
            self.move(*self.view)  # no tooltip over what is read
            yield from self.settle()
            return self._header(label)

        return (yield from self._on_some_page(look, f"panel {label}"))

    def _header(self, label: str) -> Box | None:
        """Where the sidebar says this at its left: a header is the arrow, the words, perhaps an icon far right."""
        lines = [line for scattered in (False, True) for line in eyes.read(self.panels, self.window.height, scattered)]
        for line in lines:
            found = eyes.find([line], label)
            if found and found[0].box.x < self.panels.x + 60 and line.index(found[0]) <= 1:
                return eyes.around(found)
        return None

    # --- the panel of the last operator

    @property
    def viewport(self) -> Box:
        """All to the left of the sidebar."""
        return Box(0, 0, self.panels.x, self.window.height)

    def redo_click(self, label: str) -> Steps:
        """Click what says this in the panel that F9 has opened over the viewport."""
        yield from self.click_words(label, self.viewport)

    def redo_enter(self, label: str, text: str) -> Steps:
        """Write into the field that stands right of these words in the panel that F9 has opened."""
        yield from self.settle()
        words = self.words(label, self.viewport)
        yield from self.enter(text, (words.x + words.width + 60, words.middle[1]))

    def redo_choose(self, label: str, item: str) -> Steps:
        """Open the menu that stands right of these words there, and click the line that says `item`."""
        yield from self.settle()
        words = self.words(label, self.viewport)
        yield from self.click(words.x + words.width + 60, words.middle[1])
        yield from self.click_words(item, self.viewport)

    # --- reading

    def read(self, box: Box | None = None) -> list[eyes.Line]:
        return eyes.read(box or self.whole, self.window.height)

    def words(self, text: str, box: Box | None = None) -> Box:
        """Where the window shows this text; NotThereError lists its text."""
        lines = self.read(box)
        found = eyes.find(lines, text)
        if found is None:
            raise NotThereError(f"no text in the window is {text!r}, but {[eyes.text_of(line) for line in lines]}")
        return eyes.around(found)

    def click_words(self, text: str, box: Box | None = None) -> Steps:
        yield from self.settle()
        yield from self.click(*self.words(text, box).middle)

    # --- pictures

    def picture(self, name: str) -> Steps:
        """Take a picture of the whole window, numbered and kept."""
        yield from self.settle()
        yield 0.4
        self.shots += 1
        eyes.picture(f"{PICTURES}/{self.story}-{self.shots:02d}-{name}.png")
        yield 0.1


def is_it(copied: str, wanted: str) -> bool:
    """Whether what was copied is this command or path, and not one whose name is longer."""
    after = copied.partition(wanted)[2]
    return wanted in copied and not (after[:1].isalnum() or after[:1] == "_")
