"""The tables [default], [size] and [solver] of a job: the settings of its solve and of its place."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from functools import partial

from ..domain.sites import SITES
from ..errors import CmcError, ConditionError
from ..gauss.conditions import AGAINST, KINDS
from ..gauss.energies import ENERGIES, energy_on
from ..gauss.methods import METHODS
from ..gauss.options import DEGREE
from ..limits import NOT_NEGATIVE, TOLERANCE
from ..shells.plan import SHELLS, Settings, usual_sheet
from ..spanning.outline import CORNERS, HOLES
from ..surface.averaging import AVERAGINGS
from ..surface.cmc_surface import SHEETS
from ..surface.placement import GROUNDS, SIZES, size_range
from .tables import Table


def read_settings(root: Table, combinatorics: str, first: Mapping[str, object]) -> Settings:
    """The settings of a job, on top of the `first` ones of its shape. Raises `JobError` that names the table."""
    settings = Settings(combinatorics=combinatorics, **first)  # type: ignore[arg-type]
    for key, read in (("default", _default), ("solver", _solver), ("size", _size)):
        table = root.table(key)
        values = read(table, settings)
        table.finish()
        try:
            settings = replace(settings, **values)
        except CmcError as error:
            raise table.fail(str(error)) from error
    return settings


def _default(table: Table, settings: Settings) -> dict[str, object]:
    table.known.append("flipped_corners")
    return {
        "default_kind": table.text("kind", settings.default_kind, among=list(KINDS)),
        "default_tilt": table.angle("tilt"),
        "against": table.text("against", settings.against, among=list(AGAINST)),
        "blend": table.number("blend", within=NOT_NEGATIVE),
    }


def _size(table: Table, settings: Settings) -> dict[str, object]:
    sizes = {name: name for name in SIZES if name != "match_plan"} | {"curvature": "mean_curvature"}
    chosen = [name for name in sizes if name in table]
    if len(chosen) > 1:
        raise table.fail(f"give one size, not {' and '.join(chosen)}.")
    values: dict[str, object] = {}
    for name in chosen:
        values = {"size": sizes[name], "value": table.number(name, 1.0, size_range(sizes[name]))}
    table.known.extend(sizes)
    values["ground"] = table.text("ground", settings.ground, among=list(GROUNDS))
    values["sheet"] = table.text("sheet", usual_sheet(settings.shell), among=SHEETS)
    return values | {name: table.flag(name) for name in ("rotate", "flip")}


def _solver(table: Table, settings: Settings) -> dict[str, object]:
    readers: dict[str, Callable[[Table, str], object]] = {
        "sites": partial(Table.text, among=list(SITES)),
        "energy": partial(Table.text, among=list(ENERGIES)),
        "method": partial(Table.text, among=list(METHODS)),
        "delaunay": Table.flag,
        "averaging": partial(Table.text, among=list(AVERAGINGS)),
        "tolerance": partial(Table.number, within=TOLERANCE),
        "period_tolerance": partial(Table.number, within=NOT_NEGATIVE),
        "side": Table.integer,
        "degree": partial(Table.number, within=DEGREE),
        "shell": partial(Table.text, among=list(SHELLS)),
        "count_modes": Table.flag,
        "holes": partial(Table.text, among=list(HOLES)),
        "corners": partial(Table.text, among=list(CORNERS)),
    }
    assert set(readers) <= {option.name for option in fields(Settings)}
    values = {name: read(table, name) for name, read in readers.items() if name in table}
    table.known.extend(readers)
    if "degree" in values and values.get("shell", "first") != "first":
        raise table.fail('"degree" already chooses the shell; leave it out, or "shell".')
    try:
        energy_on(str(values.get("energy", "cotan")), str(values.get("sites", "vertices")))
    except ConditionError as error:
        raise table.fail(f'"energy" and "sites" do not fit: {error}') from error
    return values
