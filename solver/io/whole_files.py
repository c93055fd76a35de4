"""Files that are written whole or not at all, and together or not at all: the only way to write results.

An `Outbox` takes the files of one piece of work. Each is written to a scratch folder, checked (`file_checks`), flushed
to the disk and then moved to its place; where anything fails, what was there before stays::

    with Outbox(seal=folder / "report.json") as outbox:
        outbox.write(folder / "shell.obj", b"v 0 0 0\\n")
        outbox.write(folder / "report.json", b"{}\\n")
        outbox.send()

The seal is moved last, and its predecessor is removed first: whoever finds a report finds the files that it is about.
A link stays: the file that it leads to is replaced, wherever that is, as editors do it.
Processes that write into one folder take turns (where the system can lock a folder, which Windows cannot).
"""

from __future__ import annotations

import os
import shutil
import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from ..errors import JobError
from .file_checks import check_file

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

SCRATCH = ".export-"
"""How the names of scratch folders begin."""

# Seconds after which a scratch folder that cannot be locked counts as left behind.
_OLD = 86_400.0


class Outbox:
    """Files to be moved to their places together.

    seal: the file that is moved last, the report. scratch: the folder of the scratch folder; by default the one of
    each file, so that a move never leaves the disk.
    """

    def __init__(self, seal: Path | None = None, scratch: Path | None = None) -> None:
        self.seal = seal
        self._in = scratch
        self._folders: dict[Path, Path] = {}
        self._gone: list[Path] = []
        self._stack = ExitStack()

    def __enter__(self) -> Outbox:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def at(self, target: Path) -> Path:
        """Where to write the file for now; files beside it, such as materials, are moved with it. Raises `JobError`."""
        if "\0" in str(target):
            raise JobError(f"{target} cannot be written: its name has a null character.")
        place = target.parent
        if place not in self._folders:
            self._folders[place] = self._scratch(target, self._in or place)
        return self._folders[place] / target.name

    def _scratch(self, target: Path, where: Path) -> Path:
        """A new scratch folder there, for this file."""
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            folder = Path(tempfile.mkdtemp(prefix=SCRATCH, dir=where))
        except OSError as error:
            raise cannot_write(target, error) from error
        self._stack.callback(shutil.rmtree, folder, ignore_errors=True)
        self._stack.enter_context(locked([folder]))
        return folder

    def write(self, target: Path, data: bytes) -> None:
        """Take a file with these contents. Raises `JobError`."""
        file = self.at(target)
        try:
            file.write_bytes(data)
            if file.stat().st_size != len(data):
                raise JobError(f"{target} cannot be written: the disk took a part of it only.")
        except OSError as error:
            raise cannot_write(target, error) from error

    def remove(self, target: Path) -> None:
        """Let a file of an earlier run go when the new ones come."""
        self._gone.append(target)

    def pending(self) -> dict[Path, Path]:
        """Place → scratch file of all files taken so far, the seal last."""
        found = {
            place / file.relative_to(folder): file
            for place, folder in self._folders.items()
            for file in sorted(folder.rglob("*"))
            if file.is_file()
        }
        return dict(sorted(found.items(), key=lambda item: item[0] == self.seal))

    def send(self) -> list[Path]:
        """Check and move the files, all or none; returns their places. Raises `JobError`."""
        moves = self.pending()
        for target, file in moves.items():
            check_file(file, target)
            try:
                _flush(file)
            except OSError as error:
                raise cannot_write(target, error) from error
            if target.is_dir():
                raise JobError(f"{target} cannot be written: it is a folder.")
            if target.exists() and not target.is_file():
                raise JobError(f"{target} cannot be written: it is a device or a pipe, no file.")
        places = _behind_links(moves)
        moved = {places[target]: self._near(file, places[target], target) for target, file in moves.items()}
        seal = None if self.seal is None else places.get(self.seal)
        folders = sorted({*self._folders, *(place.parent for target, place in places.items() if place != target)})
        with locked(folders):
            self._move(moved, seal)
        for folder in folders:
            _flush_folder(folder)
        return list(moves)

    def _near(self, file: Path, place: Path, target: Path) -> Path:
        """The scratch file, copied beside its place where a link leads to another folder: that may be another disk."""
        if place.parent == target.parent:
            return file
        copy = self._scratch(place, place.parent) / place.name
        try:
            shutil.copyfile(file, copy)
            _flush(copy)
        except OSError as error:
            raise cannot_write(target, error) from error
        return copy

    def _move(self, moves: dict[Path, Path], seal: Path | None) -> None:
        """Where a move fails, the files of before come back."""
        leaving = [*([] if seal is None else [seal]), *self._gone]
        kept: dict[Path, Path | None] = {}
        try:
            for number, target in enumerate(dict.fromkeys([*leaving, *moves])):
                known = moves[target].parent if target in moves else self._folders.get(target.parent)
                kept[target] = _keep(target, (known or next(iter(self._folders.values()))) / f"before-{number}")
            for target in leaving:
                target.unlink(missing_ok=True)
            for target, file in moves.items():
                target.parent.mkdir(parents=True, exist_ok=True)
                os.replace(file, target)
        except BaseException as error:
            for target, before in kept.items():
                if before is not None:
                    os.replace(before, target)
                elif target in moves and not moves[target].exists():
                    target.unlink(missing_ok=True)
            if isinstance(error, OSError):
                raise cannot_write(Path(error.filename2 or error.filename or next(iter(moves))), error) from error
            raise


def write_bytes(path: str | os.PathLike[str], data: bytes) -> None:
    """Write one file whole or not at all; missing folders are created. Raises `JobError`."""
    with Outbox() as outbox:
        outbox.write(Path(path), data)
        outbox.send()


def cannot_write(target: Path, error: OSError) -> JobError:
    return JobError(f"{target} cannot be written: {error.strerror or error}.")


def _behind_links(targets: Iterable[Path]) -> dict[Path, Path]:
    """Target → where its file goes: at the end of the links that the target may be."""
    places: dict[Path, Path] = {}
    seen: dict[str, Path] = {}
    for target in targets:
        real = os.path.realpath(target)
        places[target] = Path(real) if target.is_symlink() else target
        if places[target].is_symlink():
            raise JobError(f"{target} cannot be written: it is a link that leads to itself.")
        if real in seen:
            raise JobError(f"{seen[real]} and {target} are one file; give one of them another name.")
        seen[real] = target
    return places


def remove_stale(folders: Iterable[Path]) -> None:
    """Remove the scratch folders that interrupted runs have left in folders; those in use stay."""
    for folder in dict.fromkeys(folders):
        for scratch in list(folder.glob(f"{SCRATCH}*")):
            if scratch.is_dir() and not _in_use(scratch):
                shutil.rmtree(scratch, ignore_errors=True)


@contextmanager
def locked(folders: Iterable[Path]) -> Iterator[None]:
    """Hold folders for this process; others wait. The system lets go of them when a process ends, however it ends."""
    with ExitStack() as stack:
        for folder in folders:
            handle = _lock(folder, wait=True)
            if handle is not None:
                stack.callback(os.close, handle)
        yield


def _lock(folder: Path, wait: bool) -> int | None:
    """A handle of a locked folder; None where the system or the file system has no such locks.

    wait=False: raises `BlockingIOError` while another process has it.
    """
    if fcntl is None:
        return None
    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError:
        os.close(handle)
        raise
    except OSError:  # a network drive, say
        os.close(handle)
        return None
    return handle


def _in_use(scratch: Path) -> bool:
    try:
        handle = _lock(scratch, wait=False)
        if handle is None:
            return time.time() - scratch.stat().st_mtime < _OLD
    except OSError:
        return True
    os.close(handle)
    return False


def _keep(target: Path, before: Path) -> Path | None:
    """A second name for a file, which needs no room on the disk; a copy where the file system has none of these."""
    if not target.exists():
        return None
    try:
        os.link(target, before)
    except OSError:
        shutil.copy2(target, before)
    return before


def _flush(file: Path) -> None:
    """Wait until a file is on the disk; a disk that was full says so now at the latest."""
    handle = os.open(file, os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _flush_folder(folder: Path) -> None:
    if fcntl is None:  # Windows has no handles of folders
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError:
        pass  # some file systems cannot; the files themselves are on the disk
    finally:
        os.close(handle)
