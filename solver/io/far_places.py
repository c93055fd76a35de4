"""Meshes far from the origin, as in geographic coordinates, in formats of single precision.

GLB, PLY and STL store coordinates with 24 bits: half a metre apart at 5,400 km. Where this would show, a GLB has its
points around a node that stands in their middle, a PLY has doubles, and an STL is written as text. Nothing is rounded
then, and other programs read all three. A file that comes in rounded is read with a warning.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..notes import Note

Array = NDArray[np.float64]

# Steps of single precision that show, as a part of the diagonal of the points: in what is written, which costs nothing,
# and in what is read, which takes a warning.
_WRITTEN, _READ = 1e-6, 1e-5
_LARGEST = 1e38


def step_of(points: Array) -> float:
    """The distance between neighbouring numbers of single precision at the farthest of points (n, 3)."""
    far = float(np.abs(points).max()) if points.size else 0.0
    return float(np.spacing(np.float32(min(far, _LARGEST))))


def is_far(points: Array) -> bool:
    """Whether single precision would show in points (n, 3)."""
    return step_of(points) > _WRITTEN * _diagonal(points)


def far_bytes(mesh: Any, suffix: str) -> bytes:
    """The contents of a file with a far `trimesh.Trimesh`, nothing rounded. suffix: ".glb", ".ply" or ".stl"."""
    if suffix == ".glb":
        return _glb(mesh)
    return _ply(mesh) if suffix == ".ply" else str(mesh.export(file_type="stl_ascii")).encode()


def rounding_note(name: str, points: Array) -> Note | None:
    """A warning of the rounding in a file of this name that has its points (n, 3) in single precision, if it shows."""
    step, size = step_of(points), _diagonal(points)
    if not (size > 0.0 and step > _READ * size):
        return None
    return Note(
        "far",
        f"{name} has its coordinates in single precision, and so far from the origin that they are rounded to steps of "
        f"{step:g}, {step / size:.1g} of the mesh's size; export it nearer to the origin, or as OBJ.",
    )


def _diagonal(points: Array) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0))) if points.size else 0.0


def _glb(mesh: Any) -> bytes:
    import trimesh

    low, high = mesh.bounds
    origin = np.float32(0.5 * (low + high)).astype(np.float64)  # which programs of single precision keep, too
    options = {"vertex_normals": mesh.vertex_normals} if _has_normals(mesh) else {}
    near = trimesh.Trimesh(mesh.vertices - origin, mesh.faces, visual=mesh.visual, process=False, **options)
    scene: Any = trimesh.Scene()
    scene.add_geometry(near, transform=trimesh.transformations.translation_matrix(origin))
    return scene.export(file_type="glb")


def _has_normals(mesh: Any) -> bool:
    """Whether normals were given; asking for them makes them."""
    return "vertex_normals" in mesh._cache


def _ply(mesh: Any) -> bytes:
    columns = {"xyz"[k]: mesh.vertices[:, k] for k in range(3)}
    if _has_normals(mesh):
        columns |= {"n" + "xyz"[k]: mesh.vertex_normals[:, k] for k in range(3)}
    vertices = np.column_stack(list(columns.values())).astype("<f8")
    faces = np.empty(len(mesh.faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, mesh.faces
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(vertices)}",
        *(f"property double {name}" for name in columns),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    return ("\n".join(header) + "\n").encode() + vertices.tobytes() + faces.tobytes()
