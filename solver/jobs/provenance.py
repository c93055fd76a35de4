"""Where a result comes from: the table `made` of every report, of jobs, of Blender and of its batches.

Its `key` is equal for equal inputs, settings, conditions and versions of the program; `is_done` compares it with the
one that is wanted, and the files with those that were written.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import time
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from ..errors import JobError
from ..measure.report import to_plain
from ..version import PROGRAM

_CHUNK = 1 << 20


def provenance(
    inputs: Mapping[str, str],
    settings: Mapping[str, object],
    conditions: Sequence[object],
    *,
    started: float,
    blender: str = "",
) -> dict[str, Any]:
    """The table `made`. inputs: name of a file or a plan → its hash. started: `time.time()` when the work began."""
    made = {
        "program": PROGRAM,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        **({"blender": blender} if blender else {}),
        "input": dict(inputs),
        "settings": _plain(settings),
        "conditions": _plain(conditions),
        "key": key_of(inputs, settings, conditions),
        "time": datetime.now(UTC).isoformat(timespec="seconds").replace("+00:00", "Z"),
        "seconds": round(time.time() - started, 3),
    }
    return made


def key_of(inputs: Mapping[str, str], settings: Mapping[str, object], conditions: Sequence[object]) -> str:
    """Equal for runs with equal results."""
    parts = [PROGRAM, sorted(inputs.values()), _plain(settings), _plain(conditions)]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def hash_of(file: Path) -> str:
    """The SHA-256 of a file. Raises `JobError` where it cannot be read."""
    digest = hashlib.sha256()
    try:
        with open(file, "rb") as stream:
            while part := stream.read(_CHUNK):
                digest.update(part)
    except OSError as error:
        raise JobError(f"{file} cannot be read: {error.strerror or error}.") from error
    return digest.hexdigest()


def file_sizes(files: Mapping[Path, Path], folder: Path) -> dict[str, int]:
    """The entry `files` of `made`: path from the folder of the report → bytes. files: place → where it is now."""
    return {relative(place, folder): file.stat().st_size for place, file in files.items()}


def relative(path: Path, folder: Path) -> str:
    try:
        return Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:  # another drive
        return path.as_posix()


def read_made(report: Path) -> dict[str, Any]:
    """The table `made` of a report on disk; empty where there is none."""
    try:
        made = json.loads(report.read_text(encoding="utf-8"))["made"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return {}
    return made if isinstance(made, dict) and isinstance(made.get("files", {}), dict) else {}


def is_done(report: Path, key: str, wanted: Sequence[Path]) -> dict[str, Any] | None:
    """The `made` of a finished run with this key whose files are all there as they were written; else None."""
    made = read_made(report)
    files = made.get("files", {})
    if made.get("key") != key or "code" not in made:
        return None
    if not {relative(place, report.parent) for place in wanted} <= set(files):
        return None
    present = all(_size(report.parent / name) == size for name, size in files.items())
    return made if present else None


def _size(file: Path) -> int:
    try:
        return file.stat().st_size
    except OSError:
        return -1


def _plain(value: object) -> Any:
    """As JSON gives it back."""
    return json.loads(json.dumps(to_plain(value), default=str))
