"""Settings and boundary conditions: every kind, tilts that jump, sizes, sites, energies and methods."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solver.gauss.conditions import KINDS
from solver.gauss.energies import ENERGIES
from solver.gauss.methods import METHODS
from solver.shells.plan import Group, Settings
from solver.surface.averaging import AVERAGINGS
from solver.surface.placement import GROUNDS, SIZES

from .case import pick

Rng = np.random.Generator

ODD = (0.0, -1.0, 1e-300, 1e300, np.nan, np.inf, 1e9, 1e-12)
"""Numbers that nobody means."""


def settings(rng: Rng, size: float) -> Settings:
    """The defaults as a rule; `size` is the plan's. Raises `CmcError` where the program refuses them."""
    sites = pick(rng, ["vertices"] * 5 + ["faces", "faces_and_rim"])
    values: dict = {"default_tilt": pick(rng, [0.0, rng.uniform(-0.5, 1.55)]), "sites": sites}
    energies = [name for name, energy in ENERGIES.items() if sites in energy.sites]
    values["energy"] = pick(rng, energies if rng.random() < 0.97 else list(ENERGIES))
    values["size"] = pick(rng, ["match_plan"] * 3 + list(SIZES))
    values["value"] = size * rng.uniform(0.1, 3.0)
    if values["size"] == "mean_curvature":
        values["value"] = rng.uniform(0.1, 3.0) / size
    for chance, name, choices in (
        (0.2, "default_kind", list(KINDS)),
        (0.1, "method", list(METHODS)),
        (0.1, "delaunay", [True]),
        (0.1, "averaging", list(AVERAGINGS)),
        (0.2, "ground", list(GROUNDS)),
        (0.1, "rotate", [True]),
        (0.1, "flip", [True]),
        (0.1, "sheet", ["f-"]),
        (0.05, "count_modes", [True]),
        (0.03, "shell", ["bubble"]),
        (0.03, "degree", [-1.0, 0.0, 1.0, 2.0, 0.5]),
        (0.1, "blend", [0.1 * size, size, 10 * size]),
        (0.05, "side", [-1]),
        (0.02, "tolerance", [1e-12, 1e-3, *ODD]),
        (0.02, "value", ODD),
        (0.02, "blend", ODD),
        (0.02, "default_tilt", ODD),
        (0.01, "period_tolerance", ODD),
    ):
        if rng.random() < chance:
            values[name] = pick(rng, choices)
    return Settings(**values)


def groups(rng: Rng, sides: Sequence[np.ndarray], normals: Sequence[np.ndarray]) -> list[Group]:
    """Groups of some of the sides, vertex pairs (K, 2) with an outward normal (3,) each."""
    if rng.random() < 0.3:
        return []
    chosen = [k for k in range(len(sides)) if rng.random() < 0.7]
    if rng.random() < 0.01 and chosen:
        chosen.append(chosen[0])
    kinds = pick(rng, [["binormal"], ["binormal"], ["mirror", "binormal"], ["plane", "binormal"], list(KINDS)])
    return [_group(rng, f"side{k}", sides[k], normals[k], pick(rng, kinds)) for k in chosen]


def _group(rng: Rng, name: str, edges: np.ndarray, normal: np.ndarray, kind: str) -> Group:
    given: dict[str, object] = {}
    if kind == "binormal":
        given["tilt"] = pick(rng, [0.0, 1.57, rng.uniform(-1.5, 1.57), rng.uniform(0, 1.2), rng.uniform(0, 1.2)])
    elif kind == "twisted":
        given["m"] = pick(rng, [1.0, 0.5, -2.0, 3.0])
    elif kind == "mirror":
        given["normal"] = tuple(normal) if rng.random() < 0.9 else tuple(rng.normal(size=3))
        if rng.random() < 0.1:
            given["winding"] = pick(rng, [1.0, -1.0, 0.5, 7.0])
    elif kind == "plane":
        lean = rng.uniform(0, 1.5)
        given["normal"] = tuple(np.cos(lean) * np.asarray(normal) + np.sin(lean) * np.array([0.0, 0.0, 1.0]))
    if rng.random() < 0.02 and given:
        key = pick(rng, list(given))
        given[key] = tuple(rng.choice(ODD, 3)) if key == "normal" else pick(rng, ODD)
    return Group(name, edges, kind, given)
