"""Mesh files with damage: bytes flipped, cut, put in; numbers and indices changed; read as a plan."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from solver import shapes
from solver.io.mesh_files import write_mesh
from solver.io.obj import MeshData
from solver.shells.plan import plan_domain, read_plan

from .case import Case, Result, pick

Rng = np.random.Generator

_NUMBERS = b"0 -1 1e400 nan inf 2147483648 18446744073709551616 1e-320 x 7/ 1//2 0x10 999999999".split()
_STRAYS = (b"\0", b"\n", b"\xff\xfe", b"\\\n", b"\r", b"#")
_FOUR = (b"\xff\xff\xff\xff", b"\0\0\0\0", b"\0\0\xc0\x7f", b"\0\0\x80\x7f", b"\xff\xff\xff\x7f")
_ASCII_STL = (
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n"
)


def case(rng: np.random.Generator, folder: Path) -> Case:
    suffix = pick(rng, [".obj", ".obj", ".ply", ".ply", ".stl", ".glb", ".glb"])
    file = folder / f"plan{suffix}"
    data, what = _whole(rng, file), []
    for _ in range(rng.integers(0, 3)):
        harm = pick(rng, [flip, cut, repeat, put_in, number, number, word])
        data = harm(rng, data)
        what.append(harm.__name__)
    file.write_bytes(data)
    up = pick(rng, [None, None, "y", "z"])

    def run() -> Result:
        plan = read_plan(file, up=up)
        plan_domain(plan)
        return Result(numbers={"positions": plan.positions})

    return Case(f"{suffix} of {len(data)} bytes: {', '.join(what) or 'whole'}", run)


def _whole(rng: Rng, file: Path) -> bytes:
    """A good file: what this program writes, and what others do."""
    shape = pick(rng, [shapes.disc(19), shapes.strip(2, 1, 3), shapes.annulus(0.4, 1, 40)])
    flat = np.column_stack([shape.positions, np.zeros(len(shape.positions))])
    faces = list(shape.domain.faces)
    rim = shape.domain.edges[shape.domain.boundary_edges].astype(np.int32)
    mesh = MeshData(flat, faces, uvs=shape.positions, uv_corners=faces, edge_groups={"rim": rim})
    if file.suffix == ".stl" and rng.random() < 0.3:
        return _ASCII_STL.encode()
    if file.suffix == ".ply" and rng.random() < 0.5:
        lines = [
            "ply",
            "format ascii 1.0",
            f"element vertex {len(flat)}",
            *(f"property float {axis}" for axis in "xyz"),
        ]
        lines += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
        rows = [*flat.tolist(), *([3, *face.tolist()] for face in faces)]
        return "\n".join([*lines, *(" ".join(map(str, row)) for row in rows), ""]).encode()
    write_mesh(file, mesh)
    return file.read_bytes()


def flip(rng: Rng, data: bytes) -> bytes:
    """Some bits, near the start as often as anywhere."""
    array = bytearray(data)
    for _ in range(rng.integers(1, 6)):
        if array:
            array[int(rng.integers(min(len(array), pick(rng, [200, len(array)]))))] ^= 1 << int(rng.integers(8))
    return bytes(array)


def cut(rng: Rng, data: bytes) -> bytes:
    a, b = sorted(rng.integers(0, len(data) + 1, 2))
    return pick(rng, [data[:a], data[a:], data[:a] + data[b:]])


def repeat(rng: Rng, data: bytes) -> bytes:
    a, b = sorted(rng.integers(0, len(data) + 1, 2))
    return data[:b] + data[a:]


def put_in(rng: Rng, data: bytes) -> bytes:
    a = int(rng.integers(0, len(data) + 1))
    return data[:a] + pick(rng, [rng.bytes(int(rng.integers(1, 40))), *_STRAYS]) + data[a:]


def number(rng: Rng, data: bytes) -> bytes:
    """A number of a text, or four bytes of a binary file, that is another one."""
    found = list(re.finditer(rb"-?\d+(\.\d+)?(e-?\d+)?", data[:4000]))
    if found and rng.random() < 0.8:
        one = pick(rng, found)
        return data[: one.start()] + pick(rng, _NUMBERS) + data[one.end() :]
    a = int(rng.integers(0, max(len(data) - 3, 1)))
    return data[:a] + pick(rng, _FOUR) + data[a + 4 :]


def word(rng: Rng, data: bytes) -> bytes:
    """A word that is another one of the file."""
    found = list(re.finditer(rb"[A-Za-z_]{1,20}", data[:4000]))
    if len(found) < 2:
        return data
    one, other = pick(rng, found), pick(rng, found)
    return data[: one.start()] + other.group() + data[one.end() :]
