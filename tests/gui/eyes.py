"""Eyes for a Blender window: take pictures of it and read its text.

Places are window pixels from the bottom left, as Blender counts them; in pictures they are from the top left.
"""

from __future__ import annotations

import difflib
import os
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

LARGER = 3  # interface text is 11 pixels high; the reader wants about 30
ALIKE = 0.8  # of the letters of a word or phrase: 1 and l, 0 and O look alike


@dataclass(frozen=True)
class Box:
    """A part of the window: its lower left corner and its size."""

    x: int
    y: int
    width: int
    height: int

    @property
    def middle(self) -> tuple[int, int]:
        return self.x + self.width // 2, self.y + self.height // 2


@dataclass(frozen=True)
class Word:
    """A word and its place; icons read as stray letters."""

    text: str
    box: Box


Line = list[Word]


def picture(file: str | Path) -> None:
    """The X server's, since Blender's own are black without a GPU."""
    subprocess.run(["import", "-window", "root", str(file)], check=True)


def _is_dark(box: Box, window_height: int) -> bool:
    command = [*_crop(box, window_height), "-format", "%[fx:mean]", "info:-"]
    return float(subprocess.run(command, check=True, capture_output=True).stdout) < 0.5


def _crop(box: Box, window_height: int) -> list[str]:
    """The command that takes a picture of a part of the window."""
    corner = f"+{box.x}+{window_height - box.y - box.height}"
    return ["convert", "x:root", "-crop", f"{box.width}x{box.height}{corner}", "+repage", "-colorspace", "Gray"]


def read(box: Box, window_height: int, scattered: bool = False) -> list[Line]:
    """The lines of text in a part of the window, read as a column of lines or as scattered words."""
    negative = ["-negate"] if _is_dark(box, window_height) else []  # the reader knows dark letters on light paper
    larger = [*_crop(box, window_height), "-resize", f"{LARGER}00%", *negative, "png:-"]
    shot = subprocess.run(larger, check=True, capture_output=True).stdout
    command = ["tesseract", "-", "-", "--psm", "11" if scattered else "6", "tsv"]
    single = {**os.environ, "OMP_THREAD_LIMIT": "1"}
    table = subprocess.run(command, input=shot, check=True, capture_output=True, env=single).stdout.decode()
    lines: dict[tuple[str, ...], Line] = {}
    for row in table.splitlines()[1:]:
        cells = row.split("\t")
        if cells[0] == "5" and cells[11].strip():  # a word; the cells before it number its block and line
            left, top, width, height = (int(cell) // LARGER for cell in cells[6:10])
            place = Box(box.x + left, box.y + box.height - top - height, width, height)
            lines.setdefault(tuple(cells[1:5]), []).append(Word(cells[11], place))
    return list(lines.values())


def find(lines: list[Line], wanted: str) -> Line | None:
    """The neighbouring words most like these, whole lines before parts of longer ones; None if none are similar."""
    count = len(wanted.split())
    shortest = sorted(lines, key=len)
    runs = [line[k : k + count] for line in shortest for k in range(len(line) - count + 1)]
    best = max(runs, key=lambda run: _alike(text_of(run), wanted), default=None)
    return best if best is not None and _alike(text_of(best), wanted) >= ALIKE else None


def text_of(line: Line) -> str:
    return " ".join(word.text for word in line)


def around(line: Line) -> Box:
    """The box around words."""
    left, low = min(word.box.x for word in line), min(word.box.y for word in line)
    right = max(word.box.x + word.box.width for word in line)
    return Box(left, low, right - left, max(word.box.y + word.box.height for word in line) - low)


def _alike(read: str, wanted: str) -> float:
    """From 0 to 1; signs and capitals do not count."""
    plain = [re.sub(r"[^a-z0-9+ ]", "", text.lower()) for text in (read, wanted)]
    return difflib.SequenceMatcher(None, *plain).ratio()


def is_open(box: Box, window_height: int) -> bool:
    """Whether the arrow in this box, that of a panel's header, points down and not to the right."""
    command = [*_crop(box, window_height), "-auto-level", "-threshold", "50%", "-trim", "-format", "%w %h", "info:-"]
    width, height = map(int, subprocess.run(command, check=True, capture_output=True).stdout.split())
    return width > height
