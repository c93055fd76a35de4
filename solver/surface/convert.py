"""Meshes handed on: to a file, or to another package. Plain arrays in, so that every result can use it."""

from __future__ import annotations

import importlib
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import CmcError
from ..io.mesh_files import write_mesh
from ..io.obj import MeshData

if TYPE_CHECKING:
    import trimesh

Array = NDArray[np.float64]
Faces = NDArray[np.integer]


def save_mesh(path: str | os.PathLike[str], vertices: Array, polygons: Sequence[Faces] | Faces, normals: Array) -> None:
    """Write vertices (n, 3), polygons and unit normals (n, 3) as OBJ, PLY, STL or GLB, by the suffix of `path`.

    GLB has its y up, the others z. Normals are in PLY and GLB. Raises `JobError` on another suffix and where the file
    cannot be written.
    """
    faces = [np.asarray(polygon, dtype=np.int32) for polygon in polygons]
    write_mesh(path, MeshData(np.asarray(vertices, dtype=np.float64), faces), normals=normals)


def to_trimesh(vertices: Array, faces: Faces, normals: Array) -> trimesh.Trimesh:
    """A `trimesh.Trimesh` of vertices (n, 3), triangles (F, 3) and vertex normals (n, 3); nothing is merged."""
    import trimesh  # half a second

    return trimesh.Trimesh(vertices, faces, vertex_normals=normals, process=False)


def to_pyvista(vertices: Array, faces: Faces, normals: Array) -> Any:
    """A `pyvista.PolyData` with the point data "Normals"; raises `CmcError` where pyvista is not installed."""
    pyvista = _package("pyvista")
    cells = np.column_stack([np.full(len(faces), 3), faces]).ravel()
    mesh = pyvista.PolyData(np.array(vertices), cells)
    mesh.point_data["Normals"] = np.array(normals)
    mesh.point_data.active_normals_name = "Normals"
    return mesh


def to_meshio(vertices: Array, faces: Faces, normals: Array) -> Any:
    """A `meshio.Mesh` with the point data "normals"; raises `CmcError` where meshio is not installed."""
    meshio = _package("meshio")
    return meshio.Mesh(np.array(vertices), [("triangle", np.array(faces))], point_data={"normals": np.array(normals)})


def _package(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise CmcError(
            f"This needs the package {name}, which is not installed; install it with: pip install {name}"
        ) from error
