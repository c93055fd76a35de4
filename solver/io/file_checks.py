"""Whether a file was written whole, as far as its format says: sizes in its head, its last bytes.

A full disk is not always an error: some writers go on and say that they have finished.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

from ..errors import JobError

_TAIL = 4096


def check_file(file: Path, target: Path | None = None) -> None:
    """Raise `JobError` where a file is not whole; `target` is the name to tell."""
    with open(file, "rb") as stream:
        head = stream.read(_TAIL)
        size = file.stat().st_size
        stream.seek(max(size - _TAIL, 0))
        tail = stream.read()
    check = _CHECKS.get((target or file).suffix.lower())
    if size == 0 or (check is not None and not check(head, tail, size)):
        raise JobError(f"{target or file} cannot be written: only a part of it was; the disk may be full.")


def _glb(head: bytes, tail: bytes, size: int) -> bool:
    return head[:4] == b"glTF" and len(head) >= 12 and struct.unpack("<I", head[8:12])[0] == size


def _stl(head: bytes, tail: bytes, size: int) -> bool:
    if head[:5] == b"solid" and b"endsolid" in tail[-256:]:
        return True
    return len(head) >= 84 and 84 + 50 * struct.unpack("<I", head[80:84])[0] == size


def _ply(head: bytes, tail: bytes, size: int) -> bool:
    return head[:3] == b"ply" and b"end_header" in head


def _lines(head: bytes, tail: bytes, size: int) -> bool:
    return tail.endswith(b"\n")


def _blend(head: bytes, tail: bytes, size: int) -> bool:
    """Its last block is called ENDB; a compressed file ends with the number of the table of its frames."""
    if head[:7] == b"BLENDER":
        return b"ENDB" in tail[-64:]
    return head[:4] == b"\x28\xb5\x2f\xfd" and tail[-4:] == b"\xb1\xea\x92\x8f"


_CHECKS: dict[str, Callable[[bytes, bytes, int], bool]] = {
    ".glb": _glb, ".stl": _stl, ".ply": _ply, ".obj": _lines, ".mtl": _lines, ".json": _lines, ".blend": _blend,
}
