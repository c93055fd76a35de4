"""Folders of outputs: one for each input and, in it, one for each plan, with names that no file system confuses.

**Plans.** A folder has the name of its plan. Where file systems do not take that name as it is (Hall/1, trailing dots,
very long names), or take two names for one (hall and Hall, two spellings of é), a hyphen and six digits made from the
name follow: Hall_1-3f2a9c. A plan so keeps its folder from run to run, whatever plans are beside it.

**Inputs.** A folder has the name of its input without the ending. Inputs of equal names are told apart by their
folders, as they lie below the folder that they have in common, and then by their endings.
"""

from __future__ import annotations

import hashlib
import os
import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path, PurePosixPath

from ...solver.errors import JobError

_NOT_IN_NAMES = re.compile(r'[\\/:*?"<>|\x00-\x1f\x7f]')
_DEVICES = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)
_LONGEST = 60


def folder_names(names: Iterable[str], taken: Iterable[str] = ()) -> dict[str, str]:
    """Plan → name of its folder; taken: names that are not free."""
    listed = list(dict.fromkeys(names))
    known = Counter(_alike(name) for name in listed) + Counter(_alike(name) for name in taken)
    plain = {name for name in listed if _clean(name) == name and known[_alike(name)] == 1}
    marked = {name: _marked(name) for name in listed if name not in plain}
    used = {_alike(folder) for folder in marked.values()}
    return {
        name: marked[name] if name in marked else _marked(name) if _alike(name) in used else name for name in listed
    }


def input_folders(paths: Sequence[Path]) -> Mapping[Path, Path]:
    """Input → its folder below the output. Raises `JobError` where two inputs cannot be told apart."""
    listed = list(dict.fromkeys(paths))
    if not listed:
        return {}
    common = Path(os.path.commonpath([path.parent for path in listed])) if _one_drive(listed) else None
    ways = [
        lambda path: PurePosixPath(_safe(path.stem)),
        lambda path: _below(path, common) / _safe(path.stem),
        lambda path: _below(path, common) / _safe(path.name),
    ]
    level = dict.fromkeys(listed, 0)
    while True:
        folders = {path: ways[level[path]](path) for path in listed}
        confused = _confused(folders)
        if not confused:
            return {path: Path(folder) for path, folder in folders.items()}
        if all(level[path] == len(ways) - 1 for path in confused):
            name = confused[0].name
            raise JobError(f'Several inputs are called "{name}"; run them one by one into different folders.')
        for path in confused:
            level[path] = min(level[path] + 1, len(ways) - 1)


def _confused(folders: Mapping[Path, PurePosixPath]) -> list[Path]:
    """The inputs whose folders are one, or one in the other."""
    alike = {path: tuple(_alike(part) for part in folder.parts) for path, folder in folders.items()}
    known = Counter(alike.values())
    above = {parts[:k] for parts in alike.values() for k in range(1, len(parts))}
    return [path for path, parts in alike.items() if known[parts] > 1 or parts in above]


def _below(path: Path, common: Path | None) -> PurePosixPath:
    parts = path.parent.relative_to(common).parts if common is not None else path.parent.parts[1:]
    return PurePosixPath(*[_safe(part) for part in parts])


def _one_drive(paths: Sequence[Path]) -> bool:
    return len({path.drive for path in paths}) == 1


def _safe(name: str) -> str:
    return name if _clean(name) == name else _marked(name)


def _clean(name: str) -> str:
    """The name as all file systems take it."""
    text = _NOT_IN_NAMES.sub("_", name)[:_LONGEST].rstrip(". ").lstrip(".")
    return f"_{text}" if not text or _DEVICES.fullmatch(text) else text


def _marked(name: str) -> str:
    digits = hashlib.sha256(name.encode("utf-8", "surrogateescape")).hexdigest()[:6]
    return f"{_clean(name)}-{digits}"


def _alike(name: str) -> str:
    """Equal for names that a file system may take for one."""
    return unicodedata.normalize("NFD", unicodedata.normalize("NFD", name).casefold())
