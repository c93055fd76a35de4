"""The files of a job: what it reads stays as it is, and no two of its results are one file."""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Iterable, Mapping
from pathlib import Path

from ..errors import JobError

Named = tuple[str, Path]


def named_inputs(data: Mapping[str, object]) -> dict[str, str]:
    """The files that a job with these tables reads: what messages call each → its path as written."""
    fit, conditions = data.get("fit"), data.get("conditions")
    named = {'"mesh"': data.get("mesh"), '"start"': data.get("start")}
    if isinstance(fit, Mapping):
        named['"outline" of [fit]'] = fit.get("outline")
    for number, table in enumerate(conditions if isinstance(conditions, list) else (), start=1):
        if isinstance(table, Mapping):
            named[f'"curve" of [[conditions]] {number}'] = table.get("curve")
    return {what: path for what, path in named.items() if isinstance(path, str) and path}


def check_paths(job: Path, reads: Iterable[Named], writes: Iterable[Named]) -> None:
    """Raise `JobError`, naming both, where a result is a file that the job reads, or another result, or is a folder.

    Files are what they are called by (`"mesh"`), and their path. Two spellings of one path are one file, also where
    they differ in capitals only: on many systems these do not count.
    """
    taken = {_key(job): "the job itself"} | {_key(path): name for name, path in reads}
    read = set(taken)
    for name, path in writes:
        key = _key(path)
        if os.path.isdir(path):  # False, too, for a name that is too long, which writing then says
            raise JobError(f"{job}: {name} is a folder, {path}; name a file in it.")
        if key in read:
            raise JobError(f"{job}: {name} would overwrite {taken[key]}, {path}; choose another file.")
        if key in taken:
            raise JobError(f"{job}: {taken[key]} and {name} are one file, {path}; choose another for one of them.")
        taken[key] = name


def _key(path: Path) -> str:
    return unicodedata.normalize("NFC", os.path.realpath(path)).casefold()
