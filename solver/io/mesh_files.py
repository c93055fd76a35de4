"""Reading and writing mesh files: OBJ with polygons and UVs by our own reader, other formats by trimesh.

In this project z is up. Formats in which y is up (glTF by definition, many OBJ by custom) are turned when read and
turned back when written.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from dataclasses import replace
from difflib import get_close_matches
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import JobError, MeshError
from ..notes import Note
from .clean import clean
from .far_places import far_bytes, is_far, rounding_note
from .obj import MeshData, obj_text, read_obj
from .polygons import triangulate_polygons
from .whole_files import write_bytes

Array = NDArray[np.float64]
Int = NDArray[np.int32]

FORMATS = (".obj", ".ply", ".stl", ".glb")
_WELDED = (".stl", ".glb")
_BESIDE = 1000

_Y_TO_Z = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])

__all__ = ["FORMATS", "MeshData", "mesh_bytes", "read_mesh", "triangulate_polygons", "write_mesh"]


def read_mesh(path: str | os.PathLike[str], *, up: str | None = None) -> MeshData:
    """Read a mesh file. `up` is the file's own up, "y" or "z"; None means y for GLB, z for the rest.

    STL and GLB store a vertex once for each of its faces; coinciding ones are merged. In OBJ and PLY they are merged
    where they join parts (see `clean`, also for unused vertices). Raises `JobError` if the file or its format cannot be
    read, and `MeshError` if it holds no mesh, or one with numbers out of range.
    """
    file = Path(path)
    suffix = _format(file)
    if "\0" in str(file) or not file.is_file():
        raise JobError(f"There is no file {file}{_meant(file) or '.'}")
    try:
        mesh = read_obj(file) if suffix == ".obj" else _read_by_trimesh(file)
    except OSError as error:
        raise JobError(f"{file} cannot be read: {error.strerror or error}.") from error
    if not mesh.polygons:
        raise MeshError(f"{file} has no faces.")
    try:
        mesh = clean(mesh, weld=suffix in _WELDED)
        if suffix in _WELDED:  # such a file has no numbers of its own, but one for each corner
            mesh = replace(mesh, vertex_of=mesh.vertex_of[:0])
    except MeshError as error:
        raise MeshError(f"{file}: {error}") from error
    if not mesh.polygons:
        raise MeshError(f"{file} has no face with an area.")
    return replace(mesh, positions=mesh.positions @ _Y_TO_Z.T) if _up(file, up) == "y" else mesh


def _meant(missing: Path) -> str:
    """"; did you mean …?" where a mesh file beside a missing one has nearly its name, else nothing."""
    try:
        beside = [file for file in islice(missing.parent.iterdir(), _BESIDE) if file.suffix.lower() in FORMATS]
    except (OSError, ValueError):
        return ""
    names = {file.stem.casefold(): file.name for file in beside}
    near = get_close_matches(missing.stem.casefold(), names, n=1)
    return f'; did you mean "{names[near[0]]}"?' if near else ""


def oriented(points: Array, up: str) -> Array:
    """Points (n, 3) of a file whose up is "y" or "z", turned so that z is up."""
    return points @ _Y_TO_Z.T if up == "y" else points


def write_mesh(
    path: str | os.PathLike[str], mesh: MeshData, *, normals: Array | None = None, up: str | None = None
) -> None:
    """Write a mesh file: OBJ with all that `mesh` carries, PLY and STL as triangles, GLB with UVs as well.

    normals (V, 3) go into GLB and PLY. The file is written whole or not at all; missing folders are created. Raises
    `JobError` if that fails.
    """
    write_bytes(path, mesh_bytes(Path(path), mesh, normals=normals, up=up))


def mesh_bytes(file: Path, mesh: MeshData, *, normals: Array | None = None, up: str | None = None) -> bytes:
    """The contents of a mesh file of this name, as `write_mesh` writes it. Raises `JobError` on another format."""
    suffix = _format(file)
    if _up(file, up) == "y":
        mesh = replace(mesh, positions=mesh.positions @ _Y_TO_Z)
        normals = None if normals is None else normals @ _Y_TO_Z
    if suffix == ".obj":
        return obj_text(mesh, file.parent).encode("utf-8", "surrogateescape")
    return _trimesh_bytes(mesh, normals, suffix)


def _format(file: Path) -> str:
    suffix = file.suffix.lower()
    if suffix not in FORMATS:
        raise JobError(f'{file} has no format known here ("{suffix}"); use one of {", ".join(FORMATS)}.')
    return suffix


def _up(file: Path, up: str | None) -> str:
    if up not in (None, "y", "z"):
        raise JobError(f'The up axis is "y" or "z", not "{up}".')
    return up or ("y" if file.suffix.lower() == ".glb" else "z")


def _read_by_trimesh(file: Path) -> MeshData:
    import trimesh  # takes half a second, which a job with OBJ files saves

    try:
        with warnings.catch_warnings():  # numpy's about text that is no number; what comes of it is checked
            warnings.simplefilter("ignore")
            scene: Any = trimesh.load_scene(file, process=False)
            loaded = scene.to_mesh()
        positions = np.asarray(loaded.vertices, dtype=np.float64).reshape(-1, 3)
        faces = np.asarray(loaded.faces, dtype=np.int64).reshape(-1, 3)
    except OSError:
        raise
    except Exception as error:  # a broken file surfaces as whatever its parser stumbled over
        why = "it is damaged, or of another format; export it again"
        raise MeshError(f"{file} cannot be read as {file.suffix[1:].upper()}: {why}.") from error
    rounded: list[Any] = [note for part in scene.geometry.values() if (note := _rounding(file, part)) is not None]
    return MeshData(positions, list(faces), notes=rounded[:1])


def _rounding(file: Path, part: Any) -> Note | None:
    """A warning where a mesh of the file is in single precision and its points are rounded so that it shows."""
    data = part.metadata.get("_ply_raw", {}).get("vertex", {}).get("properties", {})
    is_text = file.suffix.lower() == ".stl" and not _is_binary_stl(file)
    if is_text or any(np.dtype(data[axis]).itemsize > 4 for axis in "xyz" if axis in data):
        return None
    return rounding_note(file.name, np.asarray(part.vertices, dtype=np.float64))


def _is_binary_stl(file: Path) -> bool:
    """Whether the size of an STL is that of a binary one with the number of faces in its header."""
    with open(file, "rb") as stream:
        count = int.from_bytes(stream.read(84)[80:], "little")
    return file.stat().st_size == 84 + 50 * count


def _trimesh_bytes(mesh: MeshData, normals: Array | None, suffix: str) -> bytes:
    import trimesh
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial

    triangles, polygon = _triangles(mesh)
    positions, uv = mesh.positions, None
    if suffix == ".glb" and len(mesh.uvs) and all(len(rows) for rows in mesh.uv_corners):
        rows = corner_rows(mesh.polygons, mesh.uv_corners, triangles, polygon)
        # glTF has one UV a vertex: a vertex on a seam is written once for each of its UVs.
        pairs, index = np.unique(np.column_stack([triangles.ravel(), rows.ravel()]), axis=0, return_inverse=True)
        triangles, positions, uv = index.reshape(-1, 3), positions[pairs[:, 0]], mesh.uvs[pairs[:, 1]]
        normals = None if normals is None else normals[pairs[:, 0]]
    options: dict[str, Any] = {} if normals is None else {"vertex_normals": normals}
    if suffix == ".glb":  # a shell is seen from below, too
        options["visual"] = TextureVisuals(uv=uv, material=PBRMaterial(name="shell", doubleSided=True))
    made = trimesh.Trimesh(positions, triangles, process=False, **options)
    if is_far(positions):
        return far_bytes(made, suffix)
    data = made.export(file_type=suffix[1:])
    return data if isinstance(data, bytes) else str(data).encode()


def _triangles(mesh: MeshData) -> tuple[Int, Int]:
    """Triangles (T, 3) of a mesh and the polygon (T,) of each, whatever their shape: a folded sheet is written, too.

    A polygon that cannot be triangulated (it crosses itself, or has no area) becomes a fan.
    """
    if all(len(polygon) == 3 for polygon in mesh.polygons):
        return np.array(mesh.polygons, dtype=np.int32), np.arange(len(mesh.polygons), dtype=np.int32)
    try:
        return triangulate_polygons(mesh.positions, mesh.polygons)
    except MeshError:
        parts = [_one_polygon(mesh.positions, polygon) for polygon in mesh.polygons]
    return np.concatenate(parts), np.repeat(np.arange(len(parts), dtype=np.int32), [len(part) for part in parts])


def _one_polygon(positions: Array, polygon: Int) -> Int:
    """(k - 2, 3) triangles of a polygon of k corners."""
    corners = np.asarray(polygon, dtype=np.int32)
    try:
        return corners[triangulate_polygons(positions[corners], [np.arange(len(corners))])[0]]
    except MeshError:
        first = np.full(max(len(corners) - 2, 0), corners[0])
        return np.column_stack([first, corners[1:-1], corners[2:]])


def corner_rows(
    polygons: Sequence[Int], uv_corners: Sequence[Int], triangles: NDArray[np.integer], owners: NDArray[np.integer]
) -> Int:
    """(T, 3) UV rows of the triangles' corners, -1 where their polygon has none; a polygon visits a vertex once.

    triangles (T, 3), owners (T,): the polygon of each.
    """
    rows = np.full(triangles.shape, -1, dtype=np.int32)
    maps = [dict(zip(p.tolist(), t.tolist(), strict=False)) for p, t in zip(polygons, uv_corners, strict=True)]
    for index, (corners, owner) in enumerate(zip(triangles.tolist(), owners.tolist(), strict=True)):
        rows[index] = [maps[owner].get(vertex, -1) for vertex in corners]
    return rows
