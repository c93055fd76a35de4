"""The [fit] table of a job: what the shell shall come near to."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..errors import ConditionError
from ..fitting.goals import HEIGHT_PARAMETERS
from ..shells.fit import Anchors, Goal
from ..shells.rim_curves import check_count, read_curves
from ..surface.cmc_surface import SHEETS
from .tables import Table

Array = NDArray[np.float64]

ANCHOR_KEYS = ("vertex", "vertices", "place", "places", "weight")
KEYS = (
    *("outline", "anchors", *HEIGHT_PARAMETERS, "free_heights", "tilt", "smooth", "sheet"),
    *("approximate", "regularisation", "near", "max_evaluations"),
)
# Keys that go with "approximate", and what takes their place elsewhere.
_APPROXIMATE = {"regularisation": 'the rim of an outline has "smooth"', "near": "an outline says where the shell is"}
# What a fit finds by itself.
_FOUND = ("conditions", "default", "size", "solver")


def read_fit(root: Table, domain: Domain, folder: Path, up: str | None) -> Goal | None:
    """The wish of a job's [fit], None without one. Raises `JobError`."""
    if "fit" not in root:
        return None
    table = root.table("fit")
    found = [key for key in _FOUND if key in root]
    if found:
        raise table.fail(f"a fit finds the conditions, size and place by itself; take {' and '.join(found)} out.")
    limit = _positive_integer(table, "max_evaluations") if "max_evaluations" in table else None
    table.known.extend(KEYS)
    if table.flag("approximate"):
        wish = _approximation(table, limit)
    else:
        for key, instead in _APPROXIMATE.items():
            if key in table:
                raise table.fail(f'"{key}" goes with "approximate"; {instead}.')
        wish = _outline(table, domain, folder, up, limit)
    table.finish()
    return wish


def _approximation(table: Table, limit: int | None) -> Goal:
    kept = ("approximate", *_APPROXIMATE, "max_evaluations")
    others = [key for key in table.data if key in KEYS and key not in kept]
    if others:
        raise table.fail(f'a mesh that is approximated leaves no choice of "{others[0]}"; take it out.')
    return Goal(
        approximate=True,
        regularisation=_weight(table, "regularisation", 1e-3),
        near=_weight(table, "near", 0.0),
        max_evaluations=limit,
    )


def _outline(table: Table, domain: Domain, folder: Path, up: str | None, limit: int | None) -> Goal:
    anchors = _anchors(table, domain)
    height_parameters = [name for name in HEIGHT_PARAMETERS if name in table]
    if len(height_parameters) > 1:
        raise table.fail(f"give one of {', '.join(HEIGHT_PARAMETERS)}, not {' and '.join(height_parameters)}.")
    drawn = table.data.get("outline", anchors is None)
    curves = None
    if not isinstance(drawn, bool):
        if not isinstance(drawn, str):
            raise table.fail('"outline" must be true, false or an OBJ file.')
        curves = read_curves(folder / drawn, up)
        try:
            check_count(domain, curves)
        except ConditionError as error:
            raise table.fail(f"{drawn}: {error}") from error
    elif not drawn and anchors is None:
        raise table.fail('there is nothing to fit to: give "outline", "approximate" or [[fit.anchors]].')
    return Goal(
        on_curve=bool(drawn),
        curves=curves,
        height_parameter=height_parameters[0] if height_parameters else None,
        value=_positive(table, height_parameters[0]) if height_parameters else 0.0,
        free_heights=table.flag("free_heights"),
        anchors=anchors,
        tilt=_tilt(table) if "tilt" in table else None,
        smooth=_weight(table, "smooth", 1e-7),
        sheet=table.text("sheet", "f+", among=SHEETS),
        max_evaluations=limit,
    )


def _tilt(table: Table) -> tuple[float, float]:
    """The least and the greatest tilt of the rim, in radians."""
    least, most = table.vector("tilt", (0.0, 0.0))
    if not -90.0 <= least < most <= 90.0:
        raise table.fail(f'"tilt" must be two angles from -90 to 90, the smaller one first, not [{least:g}, {most:g}].')
    return float(np.radians(least)), float(np.radians(most))


def _anchors(table: Table, domain: Domain) -> Anchors | None:
    """All [[fit.anchors]], one after the other: vertices (k,), places (k, 3), weights (k,)."""
    parts = [_anchor(anchor, domain) for anchor in table.tables("anchors")]
    if not parts:
        return None
    vertices, places, weights = zip(*parts, strict=True)
    return np.concatenate(vertices), np.concatenate(places), np.concatenate(weights)


def _anchor(table: Table, domain: Domain) -> Anchors:
    """One table: a vertex and a place, or vertices and as many places."""
    table.where = table.where.replace("[[anchors]]", "[[fit.anchors]]")
    one, many = ("vertex" in table, "place" in table), ("vertices" in table, "places" in table)
    if not (one == (True, True) and many == (False, False)) and not (many == (True, True) and one == (False, False)):
        raise table.fail('an anchor needs "vertex" and "place", or "vertices" and "places".')
    if all(one):
        vertices, places = [table.integer("vertex")], np.array([table.vector("place", (0.0, 0.0, 0.0))])
    else:
        vertices, places = _integers(table, "vertices"), table.rows("places", 3, "places, [[0, 0, 0]]")
    if len(vertices) != len(places):
        raise table.fail(f"{len(vertices)} vertices cannot be at {len(places)} places.")
    wrong = [vertex for vertex in vertices if not 0 <= vertex < domain.vertex_count]
    if wrong:
        raise table.fail(f"there is no vertex {wrong[0]}; the mesh has {domain.vertex_count}, counted from 0.")
    weight = _positive(table, "weight", 1.0)
    table.known.extend(ANCHOR_KEYS)
    table.finish()
    return np.array(vertices), places, np.full(len(vertices), weight)


def _integers(table: Table, key: str) -> list[int]:
    values = table.data[key]
    if not isinstance(values, list) or not all(type(value) is int for value in values) or not values:
        raise table.fail(f'"{key}" must be a list of vertices, [0, 1, 2].')
    return values


def _positive_integer(table: Table, key: str) -> int:
    value = table.integer(key)
    if value < 1:
        raise table.fail(f'"{key}" must be 1 or more, not {value}.')
    return value


def _positive(table: Table, key: str, default: float = 0.0) -> float:
    value = table.number(key, default)
    if not value > 0.0:
        raise table.fail(f'"{key}" must be positive, not {value:g}.')
    return value


def _weight(table: Table, key: str, default: float) -> float:
    value = table.number(key, default)
    if value < 0.0:
        raise table.fail(f'"{key}" must be zero or more, not {value:g}.')
    return value
