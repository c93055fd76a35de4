"""The [fit] table of a job: what the shell shall come near to."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .design.outline import KNOBS
from .domain.domain import Domain
from .errors import JobError, MeshError
from .files import oriented
from .fitting import Anchors, Wish
from .obj import read_obj
from .plan import SHEETS
from .tables import Table

Array = NDArray[np.float64]

ANCHOR_KEYS = ("vertex", "vertices", "place", "places", "weight")
KEYS = (
    *("outline", "anchors", *KNOBS, "free_heights", "smooth", "sheet"),
    *("approximate", "regularisation", "max_evaluations"),
)
# What a fit finds by itself.
_FOUND = ("conditions", "default", "size", "solver")


def read_fit(root: Table, domain: Domain, folder: Path, up: str | None) -> Wish | None:
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
        others = [key for key in table.data if key in KEYS and key not in ("approximate", "regularisation")]
        others = [key for key in others if key != "max_evaluations"]
        if others:
            raise table.fail(f'a mesh that is approximated leaves no choice of "{others[0]}"; take it out.')
        wish = Wish(approximate=True, regularisation=_weight(table, "regularisation", 1e-3), max_evaluations=limit)
    elif "regularisation" in table:
        raise table.fail('"regularisation" goes with "approximate"; the rim of an outline has "smooth".')
    else:
        wish = _outline(table, domain, folder, up, limit)
    table.finish()
    return wish


def _outline(table: Table, domain: Domain, folder: Path, up: str | None, limit: int | None) -> Wish:
    anchors = _anchors(table, domain)
    knobs = [name for name in KNOBS if name in table]
    if len(knobs) > 1:
        raise table.fail(f"give one of {', '.join(KNOBS)}, not {' and '.join(knobs)}.")
    drawn = table.data.get("outline", anchors is None)
    curve = None
    if not isinstance(drawn, bool):
        if not isinstance(drawn, str):
            raise table.fail('"outline" must be true, false or an OBJ file.')
        curve = read_curve(folder / drawn, up)
    elif not drawn and anchors is None:
        raise table.fail('there is nothing to fit to: give "outline", "approximate" or [[fit.anchors]].')
    return Wish(
        on_curve=bool(drawn),
        curve=curve,
        knob=knobs[0] if knobs else None,
        value=_positive(table, knobs[0]) if knobs else 0.0,
        free_heights=table.flag("free_heights"),
        anchors=anchors,
        smooth=_weight(table, "smooth", 1e-7),
        sheet=table.text("sheet", "f+", among=SHEETS),
        max_evaluations=limit,
    )


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


def read_curve(file: Path, up: str | None = None) -> Array:
    """The points (m, 3) of the one closed polyline (`l`) of an OBJ, in order, without a repeated last one.

    Raises `JobError` where the file cannot be read, or its polylines are not one closed curve.
    """
    if file.suffix.lower() != ".obj":
        raise JobError(f"{file} is no OBJ file, from which a curve is read.")
    try:
        mesh = read_obj(file)
    except OSError as error:
        raise JobError(f"{file} cannot be read: {error.strerror or error}.") from error
    except MeshError as error:
        raise JobError(f"{file} has no curve that can be read: {error}") from error
    pairs = np.concatenate([np.empty((0, 2), dtype=np.int64), *mesh.edge_groups.values()])
    loop = _walk(_merged(mesh.positions, pairs), file)
    return oriented(mesh.positions[loop], up or "z")


def _merged(positions: Array, pairs: NDArray[np.integer]) -> NDArray[np.integer]:
    """Vertex pairs with vertices at one place made one, as of a polyline whose last point repeats the first."""
    if not len(pairs):
        return pairs
    _, first, index = np.unique(positions, axis=0, return_index=True, return_inverse=True)
    pairs = first[index.ravel()][pairs]
    return np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0)


def _walk(pairs: NDArray[np.integer], file: Path) -> list[int]:
    """The vertices of one closed polyline in order, from its first one on."""
    ends: dict[int, list[int]] = {}
    for a, b in pairs.tolist():
        ends.setdefault(a, []).append(b)
        ends.setdefault(b, []).append(a)
    odd = [vertex for vertex, others in ends.items() if len(others) != 2]
    if len(ends) < 3 or odd:
        where = f" Its vertex {odd[0]} has {len(ends[odd[0]])} segments." if odd else ""
        raise JobError(f"{file} has no closed polyline (l 1 2 3 1); one is needed.{where}")
    start = min(ends)
    loop, before, at = [start], start, ends[start][0]
    while at != start:
        loop.append(at)
        one, other = ends[at]
        before, at = at, other if one == before else one
    if len(loop) != len(ends):
        raise JobError(f"{file} has more than one closed polyline; leave one of them.")
    return loop
