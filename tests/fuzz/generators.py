"""The generators by name, and the share of each in a run: fits take seconds, the others hundredths of one."""

from __future__ import annotations

from collections.abc import Iterator

from . import files, fits, jobs, mesher, meshes, plans
from .case import Generator

GENERATORS: dict[str, tuple[Generator, int]] = {
    "plans": (plans.case, 30),
    "meshes": (meshes.case, 22),
    "mesher": (mesher.case, 12),
    "jobs": (jobs.case, 18),
    "files": (files.case, 15),
    "fits": (fits.case, 3),
}
"""Name → the function that makes a case, and how many of a hundred cases it makes."""


def cases(count: int, seed: int, only: list[str]) -> Iterator[str]:
    """The names of cases, "generator:seed", in the order in which they run."""
    shares = {name: share for name, (_, share) in GENERATORS.items() if name in (only or GENERATORS)}
    owed = dict.fromkeys(shares, 0.0)
    for number in range(count):
        for name, share in shares.items():
            owed[name] += share / sum(shares.values())
        chosen = max(owed, key=lambda name: owed[name])
        owed[chosen] -= 1.0
        yield f"{chosen}:{seed * 1_000_000 + number}"
