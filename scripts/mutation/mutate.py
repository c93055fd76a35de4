"""How many small faults in a room do its tests notice? The mutation score, and the faults that survive.

    python -m scripts.mutation.mutate [--sample 30] [--seed 1] [--again] [room …]

For each room a sample of mutants is drawn; each is run in a copy of the checkout, with the tests that run the line at
fault, the nearest and quickest first, until one fails or twenty seconds of tests have passed. A mutant that takes three
times as long as its tests is noticed, too; one in a line that no test runs survives. `--again` tries only those that
survived last time, by build/mutation/, with the tests as they are now. One process at a time; seconds of its processor.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict
from itertools import accumulate
from pathlib import Path

from scripts.mutation.mutants import Mutant, mutants_of

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / "build" / "mutation"
ROOMS = ("solver/gauss", "solver/surface", "solver/fitting", "cmc_addon/tasks")
# To start Python and import what the tests need, in seconds of a processor.
_START = 20.0
_TIMES = 3.0
# Real time that a processor shared with others may take for a second of its own.
_SHARED = 15.0
# Processor time, in seconds, of the tests tried with one mutant.
_LONGEST = 20.0
# Tests of what is installed elsewhere, not of the checkout.
_IGNORED = "--ignore=tests/blender/test_extension.py"


def suite_of(room: str) -> str:
    """The tests that may run a room: those of the add-on need a process of their own."""
    return "tests/blender" if room.startswith("cmc_addon") else "tests/solver"


def sample(root: Path, room: str, count: int, seed: int) -> list[Mutant]:
    """Mutants drawn from all those of a room, in the order of its lines."""
    files = sorted(file.relative_to(root).as_posix() for file in (root / room).glob("*.py"))
    mutants = [mutant for file in files for mutant in mutants_of(file, root)]
    chosen = random.Random(f"{room} {seed}").sample(range(len(mutants)), min(count, len(mutants)))
    return [mutants[k] for k in sorted(chosen)]


def run_pytest(folder: Path, arguments: list[str], seconds: float | None = None, **variables: str) -> int | None:
    """Exit code of pytest in a folder, None if it takes longer."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"} | variables
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *arguments]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    if seconds is not None:
        command = ["prlimit", f"--cpu={math.ceil(seconds)}", *command]
    timeout = None if seconds is None else _SHARED * seconds
    try:
        return subprocess.run(command, cwd=folder, env=environment, timeout=timeout, check=False, **quiet).returncode
    except subprocess.TimeoutExpired:
        return None


def line_map(copy: Path, suite: str, rooms: list[str]) -> dict[str, dict]:
    """The lines that each test of a suite runs in the rooms; see `line_map.py`."""
    out = copy / "lines.json"
    arguments = ["-p", "scripts.mutation.line_map", _IGNORED, suite]
    run_pytest(copy, arguments, CMC_LINES_OF=",".join(rooms), CMC_LINES_IN=str(out))
    return json.loads(out.read_text())


def tests_of(root: Path, mutant: Mutant, known: dict[str, dict], folder: str) -> list[str]:
    """Tests that run the mutant's line, those in the room's own folder first, then the quickest, as long as allowed."""
    lines = set(range(mutant.lines[0], mutant.lines[1] + 1)) - {0}
    if not lines and mutant.name:
        text = (root / mutant.file).read_text().splitlines()
        named = re.compile(rf"\b{mutant.name}\b")
        lines = {k for k, line in enumerate(text, 1) if named.search(line) and k != mutant.line}
    of_file = {test: lines_of for test, one in known.items() if (lines_of := one["lines"].get(mutant.file))}
    tests = [test for test, lines_of in of_file.items() if lines.intersection(lines_of)]
    if not tests and mutant.lines == (0, 0):
        tests = list(of_file)
    tests.sort(key=lambda test: (not test.startswith(folder), known[test]["seconds"]))
    total = list(accumulate(known[test]["seconds"] for test in tests))
    return [test for test, seconds in zip(tests, total, strict=True) if seconds <= _LONGEST] or tests[:1]


def survives(copy: Path, mutant: Mutant, tests: list[str], seconds: float) -> bool:
    file = copy / mutant.file
    source = file.read_bytes()
    shutil.rmtree(file.parent / "__pycache__", ignore_errors=True)
    file.write_bytes(mutant.applied(source))
    try:
        return not tests or run_pytest(copy, ["-x", *tests], _START + _TIMES * seconds) == 0
    finally:
        file.write_bytes(source)
        shutil.rmtree(file.parent / "__pycache__", ignore_errors=True)


def copy_of_checkout(folder: Path) -> Path:
    """All files that git knows, or would."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, check=True)
    copy = folder / "checkout"
    for name in listed.stdout.decode().split("\0"):
        if name and (ROOT / name).is_file() and not (ROOT / name).is_symlink():
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, copy / name)
    return copy


def score(room: str, copy: Path, mutants: list[Mutant], known: dict[str, dict]) -> list[Mutant]:
    """The mutants of a room that survive; prints each as it is known."""
    survivors, folder = [], f"{suite_of(room)}/{Path(room).name}/"
    for mutant in mutants:
        tests, start = tests_of(copy, mutant, known, folder), time.perf_counter()
        if survives(copy, mutant, tests, sum(known[test]["seconds"] for test in tests)):
            survivors.append(mutant)
            print(f"  survives {len(tests)} tests: {mutant} [{time.perf_counter() - start:.0f} s]", flush=True)
        else:
            print(f"  {mutant.file}:{mutant.line} [{time.perf_counter() - start:.0f} s]", file=sys.stderr, flush=True)
    return survivors


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("rooms", nargs="*", default=ROOMS)
    parser.add_argument("--sample", type=int, default=30, help="mutants a room")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--again", action="store_true", help="only those that survived last time")
    options = parser.parse_args(arguments)
    OUT.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="cmc-mutation-") as folder:
        copy, known = copy_of_checkout(Path(folder)), {}
        for room in options.rooms:
            suite = suite_of(room)
            if suite not in known:
                known[suite] = line_map(copy, suite, [one for one in options.rooms if suite_of(one) == suite])
            file = OUT / f"{room.replace('/', '-')}.json"
            if options.again:
                last = json.loads(file.read_text())
                mutants, total = [Mutant(**one) for one in last["survivors"]], last["sample"]
            else:
                mutants = sample(copy, room, options.sample, options.seed)
                total = len(mutants)
            survivors = score(room, copy, mutants, known[suite])
            file.write_text(json.dumps({"sample": total, "survivors": [asdict(one) for one in survivors]}, indent=1))
            print(f"{room}: {total - len(survivors)} of {total} noticed", flush=True)


if __name__ == "__main__":
    main()
