"""The [fit] table of a job: the outline, anchors or mesh that the shell comes near to."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..errors import ConditionError, MeshError
from ..fitting.gauss_map import GaussMapOptions
from ..fitting.goals import HEIGHT_PARAMETERS, OutlineOptions
from ..io.obj import MeshData
from ..limits import COUNT, NOT_NEGATIVE, NUMBERS, POSITIVE
from ..shells.fit import FitOptions
from ..shells.rim_curves import check_count, read_curves
from ..surface.cmc_surface import SHEETS
from .tables import INTEGERS, Table

Array = NDArray[np.float64]
Anchors = tuple[NDArray[np.integer], Array, Array]
Readers = dict[str, Callable[[Table, str], object]]


def read_fit(root: Table, domain: Domain, mesh: MeshData, folder: Path, up: str | None) -> FitOptions:
    """The options of a job's [fit]. Raises `JobError`."""
    table = root.table("fit")
    given = [key for key in _RESULTS if key in root]
    if given:
        raise table.fail(f"a fit finds the conditions, size and place by itself; take {' and '.join(given)} out.")
    table.known.extend(KEYS)
    if table.flag("approximate"):
        options = _approximation(table)
    else:
        for key, instead in _INSTEAD.items():
            if key in table:
                raise table.fail(f'"{key}" goes with "approximate"; {instead}.')
        options = _outline(table, domain, mesh, folder, up)
    table.finish()
    return options


def _approximation(table: Table) -> GaussMapOptions:
    others = [key for key in table.data if key in KEYS and key not in ("approximate", *_APPROXIMATE)]
    if others:
        raise table.fail(f'an approximated mesh leaves no choice of "{others[0]}"; take it out.')
    return GaussMapOptions(**_values(table, _APPROXIMATE))


def _outline(table: Table, domain: Domain, mesh: MeshData, folder: Path, up: str | None) -> OutlineOptions:
    anchors = _anchors(table, mesh)
    height_parameters = [name for name in HEIGHT_PARAMETERS if name in table]
    if len(height_parameters) > 1:
        raise table.fail(f"give one of {', '.join(HEIGHT_PARAMETERS)}, not {' and '.join(height_parameters)}.")
    drawn = table.data.get("outline", anchors is None)
    curves = None
    if not isinstance(drawn, bool):
        if not isinstance(drawn, str):
            raise table.fail('"outline" must be true, false or an OBJ file.')
        curves = read_curves(folder / table.text("outline"), up)
        try:
            check_count(domain, curves)
        except ConditionError as error:
            raise table.fail(f"{drawn}: {error}") from error
    elif not drawn and anchors is None:
        raise table.fail('there is nothing to fit to: give "outline", "approximate" or [[fit.anchors]].')
    return OutlineOptions(curve=curves, on_curve=bool(drawn), anchors=anchors, **_values(table, _OUTLINE))


def _values(table: Table, readers: Readers) -> dict:
    """The keys that the table has; the others are left to their defaults."""
    return {key: read(table, key) for key, read in readers.items() if key in table}


def _tilt(table: Table, key: str) -> tuple[float, float]:
    """The least and the greatest tilt of the rim, in radians."""
    least, most = table.vector(key, (0.0, 0.0))
    if not -90.0 <= least < most <= 90.0:
        raise table.fail(f'"{key}" must be two angles from -90 to 90, smaller one first, not [{least:g}, {most:g}].')
    return table.radians(key, least), table.radians(key, most)


def _anchors(table: Table, mesh: MeshData) -> Anchors | None:
    """All [[fit.anchors]] in a row: vertices (k,), places (k, 3), weights (k,)."""
    parts = [_anchor(anchor, mesh) for anchor in table.tables("anchors")]
    if not parts:
        return None
    vertices, places, weights = zip(*parts, strict=True)
    return np.concatenate(vertices), np.concatenate(places), np.concatenate(weights)


def _anchor(table: Table, mesh: MeshData) -> Anchors:
    """One table: a vertex and a place, or vertices and as many places."""
    table.where = table.where.replace("[[anchors]]", "[[fit.anchors]]")
    one, many = ("vertex" in table, "place" in table), ("vertices" in table, "places" in table)
    if not (one == (True, True) and many == (False, False)) and not (many == (True, True) and one == (False, False)):
        raise table.fail('an anchor needs "vertex" and "place", or "vertices" and "places".')
    if all(one):
        vertices, places = [table.integer("vertex")], np.array([table.vector("place", (0.0, 0.0, 0.0))])
    else:
        vertices, places = _vertices(table, "vertices"), table.rows("places", 3, "places, [[0, 0, 0]]")
    if len(vertices) != len(places):
        raise table.fail(f"{len(vertices)} vertices cannot be at {len(places)} places.")
    try:
        vertices = mesh.from_file(vertices)
    except MeshError as error:
        raise table.fail(str(error)) from error
    weight = table.number("weight", 1.0, POSITIVE)
    table.known.extend(ANCHOR_KEYS)
    table.finish()
    return vertices, places, np.full(len(vertices), weight)


def _vertices(table: Table, key: str) -> list[int]:
    values = table.data[key]
    if not isinstance(values, list) or not all(value in INTEGERS for value in values) or not values:
        raise table.fail(f'"{key}" must be a list of vertices, [0, 1, 2].')
    return values


_positive, _weight = partial(Table.number, within=POSITIVE), partial(Table.number, within=NOT_NEGATIVE)
_evaluations = partial(Table.integer, within=COUNT)
_OUTLINE: Readers = {
    **dict.fromkeys(HEIGHT_PARAMETERS, _positive),
    "mean_curvature": partial(Table.number, within=NUMBERS),
    "free_heights": Table.flag,
    "tilt": _tilt,
    "smooth": _weight,
    "sheet": partial(Table.text, among=SHEETS),
    "max_evaluations": _evaluations,
}
_WEIGHTS: Readers = dict.fromkeys(("regularisation", "likeness", "near"), _weight)
_APPROXIMATE: Readers = {**_WEIGHTS, "max_evaluations": _evaluations}
KEYS = tuple(dict.fromkeys(("outline", "anchors", "approximate", *_OUTLINE, *_APPROXIMATE)))
ANCHOR_KEYS = ("vertex", "vertices", "place", "places", "weight")
# Keys that go with "approximate" only, and what an outline has in their place.
_INSTEAD = {
    "regularisation": 'the rim of an outline has "smooth"',
    "likeness": "an outline says what the shell looks like",
    "near": "an outline says where the shell is",
}
# Tables whose content is the result of a fit.
_RESULTS = ("conditions", "default", "size", "solver")
