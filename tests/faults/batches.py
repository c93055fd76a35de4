"""Batches of small plans for both command lines, and whether what lies on the disk is whole.

Nothing here knows the solver: files are judged as any other program would.
"""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
SCRATCH = ".export-"

# Blender's command needs Blender; this starts the same handler in the bpy module.
_BLENDER = """
import sys
from tests.blender.conftest import PACKAGE
import bpy
import addon_utils
bpy.ops.wm.read_factory_settings(use_empty=True)
assert addon_utils.enable(PACKAGE, default_set=True)
from importlib import import_module
sys.exit(import_module(f"{PACKAGE}.cmc_addon.headless.cli").run(sys.argv[1:]))
"""


@dataclass(frozen=True)
class Batch:
    """Plans as job files, and how to run them. command: "solver" or "blender"."""

    folder: Path
    command: str
    jobs: list[Path]

    @property
    def output(self) -> Path:
        return self.folder / "out"

    def arguments(self, *options: str, jobs: Sequence[Path] = ()) -> list[str]:
        named = [str(path) for path in jobs or self.jobs]
        if self.command == "solver":
            return [sys.executable, "-m", "solver", *named, *options]
        return [sys.executable, "-c", _BLENDER, *named, "-o", str(self.output), "-f", "obj", "glb", *map(str, options)]

    def start(self, *options: str, jobs: Sequence[Path] = ()) -> Run:
        return Run(self.arguments("--json", *options, jobs=jobs), self.folder / "tmp")

    def run(self, *options: str, jobs: Sequence[Path] = ()) -> Run:
        run = self.start(*options, jobs=jobs)
        run.wait()
        return run


def make_batch(folder: Path, count: int, command: str, columns: int = 12) -> Batch:
    """Discs with one tilt each, so that no two shells are alike; columns: edges around them."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "plan.obj").write_text(disc(columns))
    jobs = [write_job(folder, f"hall{k:02}", 10.0 + k) for k in range(count)]
    return Batch(folder, command, jobs)


def write_job(folder: Path, name: str, tilt: float, span: float = 10.0, outputs: str = "") -> Path:
    """A job with outputs in the folder out/<name>, or in another one."""
    where = f"out/{outputs or name}"
    job = folder / f"{name}.toml"
    job.write_text(
        f'mesh = "plan.obj"\n[default]\ntilt = {tilt}\n[size]\nspan = {span}\n'
        f'[output]\nf_plus = "{where}/shell.obj"\ng = "{where}/g.glb"\nreport = "{where}/report.json"\n'
    )
    return job


def disc(columns: int) -> str:
    """A round plan as an OBJ file: rings around a middle."""
    rings = max(columns // 4, 2)
    lines, faces = ["v 0 0 0"], []
    for ring in range(1, rings + 1):
        for k in range(columns):
            turn = 2 * math.pi * (k + 0.5 * (ring % 2)) / columns
            lines.append(f"v {5 * ring / rings * math.cos(turn):.6f} {5 * ring / rings * math.sin(turn):.6f} 0")
    at = lambda ring, k: 2 + (ring - 1) * columns + k % columns  # noqa: E731
    faces += [(1, at(1, k), at(1, k + 1)) for k in range(columns)]
    for ring in range(1, rings):
        faces += [(at(ring, k), at(ring + 1, k), at(ring + 1, k + 1), at(ring, k + 1)) for k in range(columns)]
    return "\n".join([*lines, *(f"f {' '.join(map(str, face))}" for face in faces), ""])


@dataclass
class Run:
    """A process of a command line, whose lines of JSON are read as they come."""

    arguments: list[str]
    temporary: Path
    outcomes: list[dict[str, Any]] = field(default_factory=list)
    other: list[str] = field(default_factory=list)
    code: int = 0
    stderr: str = ""

    def __post_init__(self) -> None:
        self.temporary.mkdir(exist_ok=True)  # what a killed process leaves there goes with the test
        environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "TMPDIR": str(self.temporary)}
        self.process = subprocess.Popen(
            self.arguments, cwd=ROOT, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            start_new_session=True,
        )  # fmt: skip
        self._readers = [threading.Thread(target=self._read), threading.Thread(target=self._listen)]
        for reader in self._readers:
            reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            try:
                self.outcomes.append(json.loads(line))
            except ValueError:
                self.other.append(line)

    def _listen(self) -> None:
        assert self.process.stderr is not None
        self.stderr = self.process.stderr.read()

    def after(self, outcomes: int, seconds: float) -> None:
        """Wait for so many outcomes and then so long, or until the end."""
        while len(self.outcomes) < outcomes and self.process.poll() is None:
            time.sleep(0.005)
        time.sleep(seconds)

    def kill(self, how: signal.Signals = signal.SIGKILL) -> None:
        """To the process and those that it has started, as the end of a session does; Ctrl-C to the process alone."""
        if self.process.poll() is None:
            if how == signal.SIGINT:
                self.process.send_signal(how)
            else:
                os.killpg(self.process.pid, how)
        self.wait()

    def wait(self) -> int:
        self.code = self.process.wait(300)
        for reader in self._readers:
            reader.join(60)
        for stream in (self.process.stdout, self.process.stderr):
            if stream is not None:
                stream.close()
        return self.code

    @property
    def formed(self) -> set[str]:
        """The job files whose plans this run has announced as done."""
        return {Path(outcome["input"]).stem for outcome in self.outcomes if outcome["formed"]}

    @property
    def skipped(self) -> set[str]:
        return {Path(outcome["input"]).stem for outcome in self.outcomes if outcome["skipped"]}


def span_of(obj: Path) -> float:
    """The largest horizontal distance between two points of an OBJ file with z up."""
    rows = [line.split() for line in obj.read_text().splitlines() if line.startswith("v ")]
    points = [(float(row[1]), float(row[2])) for row in rows]
    return max(math.dist(a, b) for a in points for b in points)


# --- what lies on the disk -----------------------------------------------------------------

def reports(output: Path) -> list[Path]:
    """The reports of plans; Blender's command has one more for each input."""
    found = (file for file in output.rglob("*.json") if not _is_scratch(file))
    return sorted(file for file in found if "made" in json.loads(file.read_text()) and "message" in file.read_text())


def finished(output: Path) -> set[str]:
    """The first folders of the plans whose report is there."""
    return {file.relative_to(output).parts[0] for file in reports(output)}


def faults(output: Path) -> list[str]:
    """Half files, and reports whose files are missing or others."""
    wrong = []
    for file in sorted(output.rglob("*")):
        if file.is_file() and not _is_scratch(file):
            try:
                _CHECKS.get(file.suffix, lambda data: None)(file.read_bytes())
            except (ValueError, KeyError, IndexError, AssertionError) as error:
                wrong.append(f"{file} is not whole: {error!r}")
    for report in reports(output):
        for name, size in json.loads(report.read_text())["made"]["files"].items():
            file = report.parent / name
            if not file.is_file() or file.stat().st_size != size:
                wrong.append(f"{report} tells of {name} with {size} bytes, which is not there")
    return wrong


def scratch(output: Path) -> list[Path]:
    """The scratch folders that are left."""
    return [path for path in output.rglob(f"{SCRATCH}*") if path.is_dir()]


def _is_scratch(file: Path) -> bool:
    return any(part.startswith(SCRATCH) for part in file.parts)


def _check_obj(data: bytes) -> None:
    lines = data.decode().splitlines()
    count = sum(line.startswith("v ") for line in lines)
    faces = [line.split()[1:] for line in lines if line.startswith("f ")]
    assert data.endswith(b"\n") and count and faces, "no vertices, no faces, or no end"
    assert all(0 < int(corner.split("/")[0]) <= count for face in faces for corner in face), "index out of range"


def _check_glb(data: bytes) -> None:
    assert data[:4] == b"glTF" and int.from_bytes(data[8:12], "little") == len(data), "cut off"
    json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])


_CHECKS = {".obj": _check_obj, ".glb": _check_glb, ".json": lambda data: json.loads(data)}
