"""Charts drawn in Blender, in the plane y = 0: a frame with ticks, curves, labels.

Needs Blender (`blender_session.start()` first).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scripts.gallery import scene

GREY = (0.30, 0.30, 0.31)


@dataclass(frozen=True)
class Chart:
    """A frame of `size` with its lower left corner at `corner` (x, z), and the ranges it shows."""

    corner: tuple[float, float]
    size: tuple[float, float]
    x: tuple[float, float]
    y: tuple[float, float]

    def place(self, x, y) -> np.ndarray:
        """Points (n, 3) of values in the chart."""
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        across = self.corner[0] + (x - self.x[0]) / (self.x[1] - self.x[0]) * self.size[0]
        up = self.corner[1] + (y - self.y[0]) / (self.y[1] - self.y[0]) * self.size[1]
        return np.stack([across, 0 * across, up], axis=-1)

    def frame(self, title: str, ticks_x: dict[str, float], ticks_y: dict[str, float], size: float = 0.2) -> None:
        """Draw two axes with ticks at their labels, and a title above."""
        low, right, high = self.place(self.x[0], self.y[0]), self.place(self.x[1], self.y[0]), self.place(*self._top)
        scene.add_line("axes", [high, low, right], 0.02, closed=False, colour=GREY)
        for label, x in ticks_x.items():
            at = self.place(x, self.y[0])
            scene.add_line("tick", [at, at - [0, 0, 0.06]], 0.015, closed=False, colour=GREY)
            scene.add_text(label, at - [0, 0, 0.24], size)
        for label, y in ticks_y.items():
            at = self.place(self.x[0], y)
            scene.add_line("tick", [at, at - [0.06, 0, 0]], 0.015, closed=False, colour=GREY)
            scene.add_text(label, at - [0.12, 0, 0], size, align="RIGHT")
        scene.add_text(title, high + [0.5 * self.size[0], 0, 0.3], 1.15 * size)

    def line(self, x, y, colour: Sequence[float], width: float = 0.035, dashed: bool = False) -> None:
        """A curve, clipped to the frame."""
        fine = np.linspace(0.0, 1.0, 600)
        own = np.linspace(0.0, 1.0, len(x))
        x, y = np.interp(fine, own, x), np.interp(fine, own, y)
        seen = (y >= self.y[0]) & (y <= self.y[1]) & (x >= self.x[0]) & (x <= self.x[1])
        if dashed:
            seen &= np.arange(600) // 12 % 2 == 0
        runs = np.split(np.arange(600), np.flatnonzero(np.diff(seen)) + 1)
        for run in runs:
            if seen[run[0]] and len(run) > 1:
                line = scene.add_line("curve", self.place(x[run], y[run]), width, closed=False, colour=colour)
                line.data.materials[0] = scene.glow("curve", colour)

    def word(self, text: str, x: float, y: float, colour: Sequence[float], size: float = 0.2) -> None:
        """Text that starts at a point of the chart."""
        scene.add_text(text, self.place(x, y), size, colour=0.5 * np.array(colour), align="LEFT")

    @property
    def _top(self) -> tuple[float, float]:
        return self.x[0], self.y[1]
