"""Reading and writing Wavefront OBJ: polygons with texture coordinates, groups, materials and named polylines."""

from __future__ import annotations

import codecs
import io
import math
import os
import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError, plural
from ..notes import Note

Array = NDArray[np.float64]
Int = NDArray[np.int32]

_NO_INDICES = np.empty(0, dtype=np.int32)


@dataclass(frozen=True, eq=False)
class MeshData:
    """A polygon mesh with UVs and names; lists are parallel to `polygons`, with "" for no name.

    positions (V, 3); polygons: vertex indices of each; uvs (T, 2) and uv_corners: rows of `uvs` for the corners of each
    polygon (an empty array for none); objects, groups, materials: names; edge_groups: (K, 2) vertex pairs of the
    polylines under each group name; libraries: material files.
    vertex_of: the vertex here of each vertex of a file, -1 for one that no face uses; polygon_numbers: the number in
    the file of each polygon; both empty where nothing was left out or merged. notes: what was, a sentence each.
    """

    positions: Array
    polygons: list[Int]
    uvs: Array = field(default_factory=lambda: np.empty((0, 2)))
    uv_corners: list[Int] = field(default_factory=list)
    objects: list[str] = field(default_factory=list)
    groups: list[str] = field(default_factory=list)
    materials: list[str] = field(default_factory=list)
    edge_groups: dict[str, Int] = field(default_factory=dict)
    libraries: list[Path] = field(default_factory=list)
    vertex_of: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    polygon_numbers: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    notes: list[Note] = field(default_factory=list)

    @property
    def vertex_numbers(self) -> NDArray[np.int64]:
        """The number in the file of each vertex, the first one of those that were merged."""
        if not len(self.vertex_of):
            return np.arange(len(self.positions))
        vertices, first = np.unique(self.vertex_of, return_index=True)
        return first[vertices >= 0]

    def from_file(self, given: Sequence[int] | NDArray[np.integer]) -> NDArray[np.int64]:
        """The vertices with these numbers in the file; raises `MeshError` on one that is not there or in no face."""
        numbers = np.asarray(given)
        count = len(self.vertex_of) or len(self.positions)
        outside = numbers[(numbers < 0) | (numbers >= count)]
        if outside.size:
            raise MeshError(f"there is no vertex {outside.flat[0]}; the mesh has {count}, counted from 0.")
        numbers = numbers.astype(np.int64)
        vertices = self.vertex_of[numbers] if len(self.vertex_of) else numbers
        loose = numbers[vertices < 0]
        if loose.size:
            raise MeshError(f"no face of the mesh has {plural('vertex', loose.ravel())}.")
        return vertices


def decoded(data: bytes) -> str:
    """A text file, whatever program wrote it: UTF-8 or UTF-16 as its first bytes say, else UTF-8, else Windows'."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16", "replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", "replace")


def same_name(name: str) -> str:
    """A name as it is compared: letters with accents are one character, however they are stored (NFC)."""
    return unicodedata.normalize("NFC", name)


class _Reader:
    """Reads an OBJ line by line; the method `_keyword` takes the rest of a line after that keyword."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.line = 0
        self.positions: list[list[float]] = []
        self.uvs: list[list[float]] = []
        self.polygons: list[Int] = []
        self.uv_corners: list[Int] = []
        self.names: list[tuple[str, str, str]] = []
        self.edges: dict[str, list[tuple[int, int]]] = {}
        self.libraries: list[Path] = []
        self.object = self.group = self.material = ""

    def read(self) -> MeshData:
        for number, keyword, rest in _lines(decoded(self.path.read_bytes())):
            self.line = number
            if "\0" in rest:
                raise self._fail("a null character has no place in an OBJ; save it as a text in UTF-8.")
            if keyword in _KEYWORDS:
                getattr(self, f"_{keyword}")(rest)
        return self._mesh()

    def _mesh(self) -> MeshData:
        return MeshData(
            positions=np.array(self.positions, dtype=np.float64).reshape(-1, 3),
            polygons=self.polygons,
            uvs=np.array(self.uvs, dtype=np.float64).reshape(-1, 2),
            uv_corners=self.uv_corners,
            objects=[names[0] for names in self.names],
            groups=[names[1] for names in self.names],
            materials=[names[2] for names in self.names],
            edge_groups={name: np.array(pairs, dtype=np.int32) for name, pairs in self.edges.items()},
            libraries=self.libraries,
        )

    def _fail(self, what: str) -> MeshError:
        return MeshError(f"{self.path.name}, line {self.line}: {what}")

    def _numbers(self, rest: str, count: int, what: str) -> list[float]:
        try:
            numbers = [float(word) for word in rest.split()[:count]]
        except ValueError:
            raise self._fail(f'"{rest}" is not {what}.') from None
        if len(numbers) < count:
            raise self._fail(f'"{rest}" is not {what}; it takes {count} numbers.')
        if not all(map(math.isfinite, numbers)):
            raise self._fail(f'"{rest}" is not {what}; its numbers must be finite.')
        return numbers

    def _index(self, word: str, count: int, what: str) -> int:
        """Index of a number in the file: OBJ counts from 1, or backwards from the latest with negative numbers."""
        try:
            number = int(word)
        except ValueError:
            raise self._fail(f'"{word}" is not the number of a {what}.') from None
        index = number - 1 if number > 0 else count + number
        if number == 0 or not 0 <= index < count:
            raise self._fail(f"there is no {what} {number}; {count} are defined above this line.")
        return index

    def _v(self, rest: str) -> None:
        self.positions.append(self._numbers(rest, 3, "a position"))

    def _vt(self, rest: str) -> None:
        self.uvs.append(self._numbers(rest, 2, "a texture coordinate"))

    def _f(self, rest: str) -> None:
        corners = [word.split("/") for word in rest.split()]
        if len(corners) < 3:
            raise self._fail(f"a face needs three vertices or more, not {len(corners)}.")
        self.polygons.append(
            np.array([self._index(c[0], len(self.positions), "vertex") for c in corners], dtype=np.int32)
        )
        mapped = [c[1] for c in corners if len(c) > 1 and c[1]]
        if mapped and len(mapped) < len(corners):
            raise self._fail("some corners of the face have a texture coordinate and others none.")
        rows = [self._index(word, len(self.uvs), "texture coordinate") for word in mapped]
        self.uv_corners.append(np.array(rows, dtype=np.int32) if rows else _NO_INDICES)
        self.names.append((self.object, self.group, self.material))

    def _l(self, rest: str) -> None:
        vertices = [self._index(word.split("/")[0], len(self.positions), "vertex") for word in rest.split()]
        name = self.group or self.object
        self.edges.setdefault(name, []).extend(pairwise(vertices))

    def _o(self, rest: str) -> None:
        self.object, self.group = same_name(rest), ""

    def _g(self, rest: str) -> None:
        self.group = same_name(rest)

    def _usemtl(self, rest: str) -> None:
        self.material = same_name(rest)

    def _mtllib(self, rest: str) -> None:
        self.libraries.append((self.path.parent / rest).resolve())


_NAMING = {"o", "g", "usemtl", "mtllib"}
_KEYWORDS = {"v", "vt", "f", "l"} | _NAMING


def _lines(text: str) -> Iterator[tuple[int, str, str]]:
    """Number, keyword and rest of each line, continued ones joined; a name may contain "#", numbers end at it."""
    pending = ""
    for number, line in enumerate(io.StringIO(text, newline=None), start=1):
        line = pending + line.strip()
        if _split(line)[0] not in _NAMING:
            line = line.split("#", 1)[0].rstrip()
        pending = line[:-1] + " " if line.endswith("\\") else ""
        if not pending:
            yield number, *_split(line)


def _split(line: str) -> tuple[str, str]:
    """The keyword of a line and the rest, with any white space between them."""
    words = line.split(None, 1)
    return (words[0] if words else "", words[1].rstrip() if len(words) > 1 else "")


def read_obj(path: str | os.PathLike[str]) -> MeshData:
    """Read polygons, UVs, `o`, `g`, `usemtl` and polylines (`l`) of an OBJ; other keywords are skipped.

    A polyline belongs to the group, else the object, above it. Raises `MeshError` naming file and line.
    """
    return _Reader(Path(path)).read()


def obj_text(mesh: MeshData, directory: Path | None = None) -> str:
    """The text of an OBJ; material files are named relative to `directory`. Numbers have full precision."""
    lines = [f"mtllib {_relative(library, directory)}" for library in mesh.libraries]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.positions.tolist()]
    lines += [f"vt {u!r} {v!r}" for u, v in mesh.uvs.tolist()]
    count = len(mesh.polygons)
    state = {"o": "", "g": "", "usemtl": ""}
    columns = {"o": mesh.objects, "g": mesh.groups, "usemtl": mesh.materials}
    for index in range(count):
        for keyword, names in columns.items():
            name = names[index] if index < len(names) else ""
            if name != state[keyword]:
                lines.append(f"{keyword} {name}".rstrip())
                state[keyword] = name
                if keyword == "o":
                    state["g"] = ""
        corners = (mesh.polygons[index] + 1).tolist()
        uvs = mesh.uv_corners[index] if index < len(mesh.uv_corners) else _NO_INDICES
        words = (
            [f"{v}/{t}" for v, t in zip(corners, (uvs + 1).tolist(), strict=True)] if len(uvs) else map(str, corners)
        )
        lines.append("f " + " ".join(words))
    for name, pairs in mesh.edge_groups.items():
        lines.append(f"g {name}".rstrip())
        lines += [f"l {i} {j}" for i, j in (pairs + 1).tolist()]
    return "\n".join(lines) + "\n"


def _relative(library: Path, directory: Path | None) -> str:
    if directory is None:
        return library.name
    return Path(os.path.relpath(library, directory.resolve())).as_posix()
