"""Modules to start from: plans of pieces between mirrors, to be solved and completed without further settings.

All corners of the plans have the angles of the surface.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.special import ellipk

from . import modules, shapes
from .modules import Module

EDGES = 26
"""Edges along the longest side of a module, by default."""


@dataclass(frozen=True)
class Preset:
    """A module as a user interface offers it.

    make(slenderness, edges): the module, slenderness from 0 to 1, with about `edges` edges along its longest side.
    size: of the plan's longest side, in metres. kinds: of groups that are no mirrors. ends: groups across which the
    completed shell does not continue. repeat: of the unit cell. settings: of `Object.cmc`, identifiers as in Blender.
    """

    name: str
    description: str
    make: Callable[[float, int], Module]
    size: float
    kinds: Mapping[str, str] = field(default_factory=dict)
    ends: tuple[str, ...] = ()
    repeat: tuple[int, int, int] = (1, 1, 1)
    settings: Mapping[str, object] = field(default_factory=dict)


def _nodoid(slenderness: float, edges: int) -> Module:
    """A quarter of a nodoid between two planes that it touches: ψ'² = c + sin²ψ, of length (2/√c) K(-1/c)."""
    c = 4.0 * 0.02**slenderness
    length, width = 2.0 / np.sqrt(c) * ellipk(-1.0 / c), 0.5 * np.pi
    columns = max(6, round(edges * length / max(length, width)))
    strip = shapes.strip(length, width, columns)
    names = {"bottom": "Axis", "top": "Floor", "left": "Start", "right": "End"}
    sides = {name: strip.sides[side] for side, name in names.items()}
    normals = {"Axis": (0, -1, 0), "Floor": (0, 0, -1), "Start": (-1, 0, 0), "End": (1, 0, 0)}
    shape = shapes.Shape(strip.domain, strip.positions, sides)
    return Module(shape, {name: np.array(normal, dtype=np.float64) for name, normal in normals.items()})


def _unduloid(slenderness: float, edges: int) -> Module:
    """A quarter of half a period: necks and bellies have radii 1 ∓ √(1 + c), the plan is K(1 + c) by a quarter turn."""
    part = 0.05 + 0.9 * slenderness
    length = 2.0 * ellipk(part**2) / (0.5 * np.pi)
    return _titled(modules.node(2, length, max_edge=length / edges))


def _quadrilateral(slenderness: float, edges: int) -> Module:
    length = 1.65 + 1.4 * slenderness
    return _titled(modules.node(4, length, bend=0.5, max_edge=length / edges))


def _honeycomb(slenderness: float, edges: int) -> Module:
    length = 1.3 + 1.8 * slenderness
    return _titled(modules.node(3, length, max_edge=length / edges))


def _capital(slenderness: float, edges: int) -> Module:
    return _titled(modules.capital(0.5 - 0.45 * slenderness, max_edge=0.5 / edges))


def _vault(slenderness: float, edges: int) -> Module:
    return _titled(modules.vault(4, 0.6 - 0.45 * slenderness, max_edge=2.0 / edges))


def _titled(module: Module) -> Module:
    """The module with capitalised names of sides."""
    shape = module.shape
    sides = {name.capitalize(): edges for name, edges in shape.sides.items()}
    normals = {name.capitalize(): normal for name, normal in module.normals.items()}
    return Module(shapes.Shape(shape.domain, shape.positions, sides), normals)


PRESETS: dict[str, Preset] = {
    "nodoid": Preset(
        "Nodoid",
        "A quarter of a nodoid between two planes that it touches; beyond them it continues as its other sheet",
        _nodoid,
        6.0,
        kinds={"Start": "plane", "End": "plane"},
        repeat=(3, 1, 1),
    ),
    "unduloid": Preset(
        "Unduloid",
        "A quarter of half a period of a tube with necks; completed, it can be of any length",
        _unduloid,
        6.0,
        repeat=(3, 1, 1),
    ),
    "quadrilateral": Preset(
        "Mirror Quadrilateral",
        "A quadrilateral between four mirrors: an eighth of a node of four tubes, a square grid when completed",
        _quadrilateral,
        6.0,
        repeat=(2, 2, 1),
    ),
    "honeycomb": Preset(
        "Honeycomb Module",
        "A quadrilateral between four mirrors: half of a sixth of a node of three tubes, a honeycomb when completed",
        _honeycomb,
        6.0,
        repeat=(3, 3, 1),
    ),
    "capital": Preset(
        "Column Capital",
        "A quarter of a bay between four walls: a column that flares into a vault, a grid of them when completed",
        _capital,
        8.0,
        ends=("Column",),
        repeat=(3, 3, 1),
    ),
    "vault": Preset(
        "Vault",
        "A shell on four feet between four walls that it touches: the floor is a mirror, each wall a constant plane",
        _vault,
        8.0,
        kinds={f"Wall{k}": "plane" for k in range(4)},
        ends=tuple(f"{name}{k}" for name in ("Wall", "Foot") for k in range(4)),
    ),
}
"""Name → module, in the order of the menu."""
