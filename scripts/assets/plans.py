"""Example plans as an architect draws them; `make_assets.py` draws them in Blender.

Lengths in metres, angles in degrees, outlines counter-clockwise; arrays only.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]


@dataclass(frozen=True)
class Rim:
    """A boundary group: the tilt of the shell's rim, and its segments (loop 0 is the outline)."""

    name: str
    tilt: float
    segments: Sequence[int]
    loop: int = 0


@dataclass(frozen=True, kw_only=True)
class Sketch:
    """A plan: name, description, boundary groups."""

    name: str
    description: str
    tags: Sequence[str]
    rims: Sequence[Rim] = ()
    blend: float = 0.0
    """Length of rim over which the tilts of neighbouring groups flow into each other."""
    view: tuple[float, float] = (-60.0, 0.17)
    """Where a picture is taken from: direction in plan, in degrees, and slope of the line of sight."""


@dataclass(frozen=True, kw_only=True)
class OutlineSketch(Sketch):
    """An outline with holes, and the settings of Mesh Plan."""

    outline: Points
    holes: Sequence[Points] = ()
    edge_length: float
    corner_radius: float = 0.0


@dataclass(frozen=True, kw_only=True)
class QuadSketch(Sketch):
    """A plan drawn as quads (F, 4); the last `rim` vertices are its outline, counter-clockwise.

    uv_layers: name → coordinates of the vertices; materials: name → which faces (F,), bool.
    """

    positions: Points
    quads: NDArray[np.int32]
    rim: int
    uv_layers: Mapping[str, Points] = field(default_factory=dict)
    materials: Mapping[str, NDArray[np.bool_]] = field(default_factory=dict)


def pavilion() -> OutlineSketch:
    """A superellipse: smooth all the way, so that the curvature of the rim never jumps."""
    outline = superellipse(18.0, 13.0, 2.8)
    middle = 0.5 * (outline + np.roll(outline, -1, axis=0))
    at_end = np.degrees(np.arctan(np.abs(middle[:, 1] / middle[:, 0]))) < 32.0
    return OutlineSketch(
        name="Rounded Pavilion",
        description="A pavilion of 18 x 13 m on a superellipse. Its rim leans in by 38 degrees on the long sides, "
        "which open, and by 15 at the ends, and changes over 6 m; it stands on four feet.",
        tags=("pavilion", "smooth outline"),
        outline=outline,
        edge_length=0.5,
        rims=(
            Rim("Long Sides", 38.0, np.flatnonzero(~at_end).tolist()),
            Rim("Ends", 15.0, np.flatnonzero(at_end).tolist()),
        ),
        blend=6.0,
        view=(-62.0, 0.14),
    )


def hall() -> OutlineSketch:
    """An L with wings of 12 m; Mesh Plan rounds all corners, the inner one too."""
    outline = np.array([(0, 0), (34, 0), (34, 12), (12, 12), (12, 28), (0, 28)], dtype=float) - [11.0, 9.0]
    return OutlineSketch(
        name="L-Shaped Hall",
        description="A hall of two wings, 34 and 28 m long and 12 m wide. Corners are rounded with 4 m; the rim "
        "leans in by 30 degrees.",
        tags=("hall", "rounded corners"),
        outline=outline,
        edge_length=0.8,
        corner_radius=4.0,
        rims=(Rim("Rim", 30.0, range(6)),),
        view=(-40.0, 0.45),
    )


def canopy() -> OutlineSketch:
    """A long roof along a curved platform, open towards the train."""
    outline, sides = bent_bar(length=60.0, width=9.0, radius=90.0, steps=60)
    return OutlineSketch(
        name="Station Canopy",
        description="A canopy of 60 x 9 m over a curved platform: flat towards the train (65 degrees), steeper to "
        "the street (30), its ends between (45).",
        tags=("canopy", "different tilts"),
        outline=outline,
        edge_length=0.75,
        corner_radius=2.0,
        rims=(
            Rim("Platform", 65.0, sides["outer"]),
            Rim("Street", 30.0, sides["inner"]),
            Rim("Ends", 45.0, sides["ends"]),
        ),
        blend=4.0,
        view=(-65.0, 0.16),
    )


def courtyard() -> OutlineSketch:
    """A rounded rectangle around a round court, twofold symmetric: its shell closes around the court."""
    outline = np.array([(-14, -11), (14, -11), (14, 11), (-14, 11)], dtype=float)
    court = superellipse(9.0, 6.5, 2.0)
    return OutlineSketch(
        name="Courtyard",
        description="A house of 28 x 22 m around an oval court. Both rims stand vertically; by its symmetry the "
        "shell closes around the court.",
        tags=("courtyard", "hole"),
        outline=outline,
        holes=(court,),
        edge_length=0.6,
        corner_radius=6.0,
        rims=(Rim("Outside", 0.0, range(4)), Rim("Court", 0.0, range(len(court)), loop=1)),
        view=(-62.0, 0.42),
    )


def market() -> QuadSketch:
    """A freeform plan of quads: the conformal image of a round grid, so that its quads stay near-square."""
    disc, quads, rim = round_grid(cells=32, rings=11)
    z = disc[:, 0] + 1j * disc[:, 1]
    w = 13.0 * (z + (0.04 + 0.03j) * z**2 - 0.07 * z**4)
    plan = np.column_stack([w.real, w.imag])
    glass = np.hypot(*disc[quads].mean(axis=1).T) < 0.3
    return QuadSketch(
        name="Freeform Market",
        description="A market roof of about 26 x 27 m, drawn as quads: two UV layers (plan coordinates in metres, and "
        "the round grid), a glazed middle. The rim leans in by 25 degrees; it stands on three feet.",
        tags=("quads", "freeform", "materials"),
        positions=plan,
        quads=quads,
        rim=rim,
        uv_layers={"Plan": plan, "Grid": 0.5 + 0.5 * disc},
        materials={"Membrane": ~glass, "Glass": glass},
        rims=(Rim("Rim", 25.0, range(rim)),),
        view=(-38.0, 0.14),
    )


SKETCHES = {"pavilion": pavilion, "hall": hall, "canopy": canopy, "courtyard": courtyard, "market": market}
"""File name → the plan."""


# --- outlines ------------------------------------------------------------------------------


def superellipse(width: float, depth: float, power: float, count: int = 144) -> Points:
    """Points (count, 2) of |2x/width|^p + |2y/depth|^p = 1, counter-clockwise from (width/2, 0)."""
    t = 2 * np.pi * np.arange(count) / count
    c, s = np.cos(t), np.sin(t)
    r = (np.abs(c) ** power + np.abs(s) ** power) ** (-1.0 / power)
    return np.column_stack([0.5 * width * r * c, 0.5 * depth * r * s])


def bent_bar(length: float, width: float, radius: float, steps: int) -> tuple[Points, dict[str, list[int]]]:
    """A bar bent along an arc about (0, radius), and the segments of its "outer", "inner" side and its "ends"."""
    angle = np.linspace(-0.5, 0.5, steps + 1) * length / radius
    arc = np.column_stack([np.sin(angle), -np.cos(angle)])
    outer, inner = (radius + width / 2) * arc, (radius - width / 2) * arc[::-1]
    sides = {
        "outer": list(range(steps)),
        "ends": [steps, 2 * steps + 1],
        "inner": list(range(steps + 1, 2 * steps + 1)),
    }
    return np.concatenate([outer, inner]) + [0.0, radius], sides


def round_grid(cells: int, rings: int) -> tuple[Points, NDArray[np.int32], int]:
    """The unit disc as quads: a bulging square of cells × cells, and rings around it out to the circle.

    Returns points, quads, and the number 4 · cells of points on the circle, which come last.
    """
    s = np.linspace(-1.0, 1.0, cells + 1)
    x, y = (a.ravel() for a in np.meshgrid(s, s, indexing="ij"))
    square = 0.5 * np.column_stack([x * (1.25 - 0.25 * y**2), y * (1.25 - 0.25 * x**2)])
    number = np.arange(len(square)).reshape(cells + 1, cells + 1)
    inner = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    ring = np.concatenate([number[:-1, 0], number[-1, :-1], number[:0:-1, -1], number[0, :0:-1]])
    rim, count = square[ring], 4 * cells
    angle = -0.75 * np.pi + 2 * np.pi * np.arange(count) / count
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    points, quads = [square], [np.column_stack([part.ravel() for part in inner])]
    for k in range(1, rings + 1):
        points.append(rim + (circle - rim) * (k / rings))
        outer = len(square) + (k - 1) * count + np.arange(count)
        quads.append(np.column_stack([ring, outer, np.roll(outer, -1), np.roll(ring, -1)]))
        ring = outer
    return np.concatenate(points), np.concatenate(quads).astype(np.int32), count
