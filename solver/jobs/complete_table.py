"""The [complete] table of a job: the copies of the shell across its groups, and the files to write."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import CmcError, suggestion
from ..io.mesh_files import FORMATS
from ..shells.complete import CopySelection
from ..shells.plan import Group
from ..shells.plan_sides import check_sides
from ..symmetry.complete import COPIES
from .tables import Table

KEYS = ("sides", "copies", "box", "around", "repeat", "mesh", "instances")


@dataclass(frozen=True, eq=False)
class CompleteOptions:
    """The copies of a completed shell, and its files (None: do not write)."""

    copies: CopySelection
    mesh: Path | None = None
    instances: Path | None = None

    @property
    def named(self) -> dict[str, Path]:
        """Key of the table → its file."""
        named = {"mesh": self.mesh, "instances": self.instances}
        return {name: file for name, file in named.items() if file is not None}

    @property
    def files(self) -> dict[str, Path]:
        """Name of a result → its file."""
        return {{"mesh": "completed"}.get(name, name): file for name, file in self.named.items()}


def read_complete(root: Table, groups: Sequence[Group], folder: Path) -> CompleteOptions:
    """The options of a job's [complete]. Raises `JobError`."""
    table = root.table("complete")
    if "fit" in root:
        raise table.fail("a fitted shell has no sides to continue across; take [fit] or [complete] out.")
    table.known.extend(KEYS)
    if ("mesh" in table) + ("instances" in table) == 0:
        raise table.fail('name a file: "mesh" for one welded mesh, "instances" for a list of transforms.')
    options = CompleteOptions(
        _copies(table, groups),
        _file(table, "mesh", folder, FORMATS),
        _file(table, "instances", folder, (".json",)),
    )
    table.finish()
    return options


def _copies(table: Table, groups: Sequence[Group]) -> CopySelection:
    chosen = [key for key in ("copies", "box", "around") if key in table]
    if len(chosen) > 1:
        raise table.fail(f"give one of copies, box and around, not {' and '.join(chosen)}.")
    if "repeat" in table and chosen and chosen[0] != "around":
        raise table.fail(f'"repeat" goes with the unit cell or with "around", not with "{chosen[0]}".')
    sides = _group_names(table, "sides", table.texts("sides"), groups) if "sides" in table else None
    try:
        check_sides(groups, sides)
    except CmcError as error:
        raise table.fail(str(error)) from error
    return CopySelection(
        sides=sides,
        copies=table.integer("copies", within=COPIES) if "copies" in table else None,
        box=_box(table) if "box" in table else None,
        around=_around(table, groups) if "around" in table else (),
        repeat=_repeat(table) if "repeat" in table else 1,
    )


def _group_names(table: Table, key: str, names: Sequence[str], groups: Sequence[Group]) -> list[str]:
    """Names as the conditions have them; "left" means "side left"."""
    full = {group.name: group.name for group in groups}
    known = {name.split(" ", 1)[-1]: name for name in full} | full
    for name in names:
        if name not in known:
            raise table.fail(f'"{key}": no condition is on "{name}"{suggestion(name, known)}')
    return [known[name] for name in names]


def _box(table: Table) -> np.ndarray:
    box = table.rows("box", 3, "two corners, [[0, 0, 0], [1, 1, 1]]")
    if len(box) != 2 or not (box[0] < box[1]).all():
        raise table.fail('"box" must be two corners, the lowest one first, [[0, 0, 0], [1, 1, 1]].')
    return box


def _around(table: Table, groups: Sequence[Group]) -> list[list[str]]:
    rings = table.data["around"]
    if not isinstance(rings, list) or not rings or not all(isinstance(ring, list) and ring for ring in rings):
        raise table.fail('"around" must be a list of lists of sides, [["left", "floor"]].')
    return [
        _group_names(table, "around", Table({"around": ring}, table.where).texts("around"), groups) for ring in rings
    ]


def _repeat(table: Table) -> int | list[int]:
    value = table.data["repeat"]
    times = value if isinstance(value, list) else [value]
    if not times or len(times) > 3 or not all(n in COPIES for n in times):
        raise table.fail(f'"repeat" must be {COPIES}, or up to three of them, [3, 3].')
    return times if isinstance(value, list) else int(value)


def _file(table: Table, key: str, folder: Path, formats: Sequence[str]) -> Path | None:
    if key not in table:
        return None
    path = Path(os.path.normpath(folder / table.text(key)))
    if path.suffix.lower() not in formats:
        raise table.fail(f'"{key}" has no format known here ("{path.suffix}"); use {", ".join(formats)}.')
    return path
