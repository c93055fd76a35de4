"""One case: an input that a seed makes, and what came of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from solver.shells.shell import Shell


@dataclass(frozen=True)
class Result:
    """What a case gave where it raised nothing.

    ok: the status of a solve, True where nothing is solved. numbers: what must be finite. off: by how much the measured
    mean curvature of a converged shell is off its target, as a part of it.
    """

    ok: bool = True
    warnings: Sequence[str] = ()
    numbers: Mapping[str, ArrayLike] = field(default_factory=dict)
    off: float = 0.0


@dataclass(frozen=True)
class Case:
    """text: the input for a person. run: gives it to the program, through a public door."""

    text: str
    run: Callable[[], Result]


Generator = Callable[[np.random.Generator, Path], Case]
"""Makes a case from random numbers alone; files go into the folder, which is empty and thrown away."""


def of_shell(shell: Shell) -> Result:
    """The result of a shell: every number that someone sees or goes on with."""
    report, shown = shell.report, shell.report.shown
    measured = [report.mean_curvature, report.degree, shown.area]
    measured += [report.scale] if report.mean_curvature else []  # infinite where H = 0
    if shell.ok:  # the energy between opposite normals is infinite, and the status says that they are
        measured += [report.energy, report.residual]
    measured += [shown.span, shown.rise, shown.boundary_length, *shown.bounding_box[0], *shown.bounding_box[1]]
    H = shown.mean_curvature
    if H is not None:
        measured += [H.mean, H.relative_l2 if H.target else H.l2]
    numbers = {"report": measured, "mean curvature": shell.mean_curvature}
    numbers |= {f"points of {name}": points for name, points in shell.placed.items()}
    numbers |= {f"normals of {name}": normals for name, normals in shell.normals.items()}
    off = H.relative_l2 if shell.ok and H is not None and H.target else 0.0
    return Result(shell.ok, shell.warnings, numbers, off)


def pick(rng: np.random.Generator, among: Sequence):
    """One of a list, whatever its items are."""
    return among[int(rng.integers(len(among)))]
