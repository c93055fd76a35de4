"""The start of a job: a .npz file with the normals to start from, and edge lengths in place of the drawn ones."""

from __future__ import annotations

import io
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import CmcError, JobError
from ..io.obj import MeshData
from ..io.whole_files import write_bytes
from ..shells.plan import Plan
from ..shells.plan_metric import side_lengths, start_map
from .tables import Table

Array = NDArray[np.float64]
Int = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Start:
    """normals (V, 3), or None; lengths (E,) of the edges (E, 2), vertex pairs, or None."""

    normals: Array | None = None
    edges: Int | None = None
    lengths: Array | None = None


def read_start_key(root: Table, plan: Plan, mesh: MeshData, folder: Path) -> None:
    """Give a plan the start of `start = "file.npz"`, whose vertices are those of the file of the mesh.

    Raises `JobError` where it does not fit the plan.
    """
    name = root.text("start")
    if not name:
        return
    try:
        start = _in_plan(read_start(folder / name), mesh)
        if start.normals is not None:
            plan.initial = start_map(start.normals, len(plan.positions))
        if start.edges is not None and start.lengths is not None:
            plan.lengths = side_lengths(plan.triangles, start.edges, start.lengths)
    except CmcError as error:
        raise root.fail(f'"start": {error}') from error


def _in_plan(start: Start, mesh: MeshData) -> Start:
    """The start on the vertices of the plan, where these are not all of the file's."""
    count = len(mesh.vertex_of) or len(mesh.positions)
    normals, edges, lengths = start.normals, start.edges, start.lengths
    if edges is not None and edges.size and (edges.min() < 0 or edges.max() >= count):
        raise JobError(f"an edge has a vertex that is not there; the mesh has {count}, counted from 0.")
    if not len(mesh.vertex_of):
        return start
    if normals is not None and len(normals) == count:
        normals = normals[mesh.vertex_numbers]
    if edges is not None and lengths is not None:
        edges = mesh.vertex_of[edges]
        within = (edges >= 0).all(axis=1)
        edges, lengths = edges[within], np.ravel(lengths)[within]
    return Start(normals, edges, lengths)


def read_start(path: str | os.PathLike[str]) -> Start:
    """The arrays `normals` (V, 3), `edges` (E, 2) and `lengths` (E,) of a .npz file, each of them optional.

    Raises `JobError` where the file cannot be read or has none of them, or edges without lengths.
    """
    file = Path(path)
    try:
        with np.load(file, allow_pickle=False) as data:
            arrays = {name: data[name] for name in ("normals", "edges", "lengths") if name in data}
    except OSError as error:
        raise JobError(f"{file} cannot be read: {error.strerror or error}.") from error
    except Exception as error:  # a damaged file surfaces as whatever its parsers stumbled over
        raise JobError(f"{file} cannot be read: it is damaged, or no .npz file; write it with write_start.") from error
    for name, array in arrays.items():
        if array.dtype.kind not in ("iu" if name == "edges" else "iuf"):
            what = "vertex numbers" if name == "edges" else "numbers"
            raise JobError(f'The array "{name}" of {file} must hold {what}, not {array.dtype}.')
    if not arrays or ("edges" in arrays) != ("lengths" in arrays):
        raise JobError(f'{file} must have the arrays "normals", or "edges" and "lengths", or all three.')
    lengths = arrays.get("lengths")
    if lengths is not None and np.shape(arrays["edges"]) != (np.size(lengths), 2):
        raise JobError(f'{file} has "edges" of shape {np.shape(arrays["edges"])} for {np.size(lengths)} "lengths".')
    return Start(arrays.get("normals"), arrays.get("edges"), lengths)


def write_start(
    path: str | os.PathLike[str],
    normals: Array | None = None,
    edges: Int | None = None,
    lengths: Array | None = None,
) -> None:
    """Write a file for `read_start`; edges and lengths go together. Raises `JobError` where it cannot be written."""
    arrays = {"normals": normals, "edges": edges, "lengths": lengths}
    data = io.BytesIO()
    np.savez_compressed(data, **{name: np.asarray(array) for name, array in arrays.items() if array is not None})
    write_bytes(path, data.getvalue())
