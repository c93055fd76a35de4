"""The [close] table of a job: the changes allowed to close the shell around the holes of its plan."""

from __future__ import annotations

from ..closing.holes import MOTIONS
from ..errors import CmcError, suggestion
from ..shells.closing_options import MOVING, WAYS, ClosingOptions
from .tables import Table

KEYS = ("by", "weight", "move", "holes", "max_steps")
# Keys that go with these ways only.
_FOR = {"weight": ("both",), "move": MOVING, "holes": MOVING}


def read_close(root: Table) -> ClosingOptions:
    """The options of a job's [close]. Raises `JobError`."""
    table = root.table("close")
    if "fit" in root:
        raise table.fail("a fit closes its shell by itself; take [fit] or [close] out.")
    table.known.extend(KEYS)
    by = table.text("by", "normals", among=list(WAYS))
    for key, ways in _FOR.items():
        if key in table and by not in ways:
            fitting = " or ".join(f'"{way}"' for way in ways)
            raise table.fail(f'"{key}" goes with by = {fitting}, not with "{by}".')
    values: dict[str, object] = {"by": by}
    if "weight" in table:
        values["weight"] = table.number("weight")
    if "max_steps" in table:
        values["max_steps"] = table.integer("max_steps")
    if "move" in table:
        values["move"] = _motions(table)
    if "holes" in table:
        values["holes"] = tuple(table.integers("holes"))
    table.finish()
    try:
        return ClosingOptions(**values)  # type: ignore[arg-type]
    except CmcError as error:
        raise table.fail(str(error)) from error


def _motions(table: Table) -> tuple[str, ...] | dict[int, tuple[str, ...]]:
    """The motions of all holes, or those of each: `move = { 1 = ["x", "y"], 2 = ["size"] }`."""
    if not isinstance(table.data["move"], dict):
        return _names(table, "move")
    each = table.table("move")
    numbers = [key for key in each.data if key.isascii() and key.isdecimal() and len(key) < 10]
    motions = {int(key): _names(each, key) for key in numbers}
    for key in each.data:
        if key not in numbers:
            raise each.fail(f'the keys are numbers of holes, 1 being the one with the longest rim, not "{key}".')
    return motions


def _names(table: Table, key: str) -> tuple[str, ...]:
    names = table.texts(key)
    for name in names:
        if name not in MOTIONS:
            raise table.fail(f'there is no motion "{name}" of a hole{suggestion(name, MOTIONS)}')
    return tuple(dict.fromkeys(names))
