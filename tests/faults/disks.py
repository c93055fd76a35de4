"""Disks for tests: small ones, and ones that cannot be written."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest


@contextmanager
def small_disk(folder: Path, kilobytes: int) -> Iterator[Path]:
    """A disk of so many kilobytes at a folder. Skips the test where none can be made."""
    if os.geteuid() != 0:
        pytest.skip("A small disk is mounted by root only; run as root to test a full disk.")
    folder.mkdir()
    made = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "cmc-test", folder], capture_output=True, text=True
    )
    if made.returncode:
        pytest.skip(f"No disk can be mounted here, so a full disk is not tested: {made.stderr.strip()}")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", folder], check=True)


def free(disk: Path) -> int:
    """Bytes that are left."""
    stat = os.statvfs(disk)
    return stat.f_bavail * stat.f_frsize


def fill(disk: Path, leave: int) -> None:
    """Leave so many bytes."""
    with open(disk / "filler", "wb") as file:
        file.write(bytes(max(free(disk) - leave, 0)))


@contextmanager
def read_only(disk: Path) -> Iterator[None]:
    """A mounted disk on which nothing can be written meanwhile, by root neither."""
    subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
    try:
        yield
    finally:
        subprocess.run(["mount", "-o", "remount,rw", disk], check=True)
