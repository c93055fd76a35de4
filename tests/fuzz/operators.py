"""Random sequences of our operators in a Blender without a window: `python -m tests.fuzz.operators --calls 1000`.

One seed is one sequence: a small random scene, then calls of our operators with random properties, and between them
what a hand does (`blend_scenes`): other modes, selections and objects, things hidden, shared and deleted, undo. After
each call:

- it has finished, or it says in a sentence why not; there is no traceback, neither raised nor printed;
- where it has not finished, every data-block is as it was before;
- every bounding box is that of its points, and no result has a coordinate that is no number;
- undo restores what was before, redo what was after.

A sequence that ends Blender, or takes longer than the limit, counts as a failure too. `--only SEED` runs and tells one.
"""

from __future__ import annotations

import argparse
import faulthandler
import json
import os
import select
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from random import Random

ROOT = Path(__file__).resolve().parents[2]
CALLS = 8
"""Calls in a sequence, those not counted that `poll` refuses."""
SECONDS = 60.0
"""A sequence that takes longer has failed."""
MEMORY = 2000.0
"""Megabytes that the process of some sequences may take."""


def sequence(seed: int, folder: Path, say=lambda text: None) -> tuple[Counter, list[str]]:
    """Run the sequence of a seed in an enabled add-on: how its calls ended, and what was wrong."""
    from .blend_scenes import act, new_scene
    from .operator_calls import random_call

    random, outcomes = Random(seed), Counter()
    new_scene(random, folder)
    wrong: list[str] = []
    for _ in range(3 * CALLS):
        for _ in range(random.choice((0, 1, 1, 2, 3))):
            say(f"  {act(random)}")
        call = random_call(random, folder)
        say(f"{call}")
        outcome, faults = _checked(call, and_undo=random.random() < 0.4)
        say(f"  -> {outcome}")
        outcomes[outcome.split(":")[0]] += 1
        wrong += [f"seed {seed}: {call}: {fault}" for fault in faults]
        if wrong or sum(outcomes.values()) - outcomes["refused"] >= CALLS:
            break
    return outcomes, wrong


def _checked(call, and_undo: bool) -> tuple[str, list[str]]:
    import bpy

    from .blend_checks import not_finite, wrong_bounds
    from .blend_digest import differences, digest
    from .blend_scenes import may_undo
    from .operator_calls import is_sentence

    # in other modes undo is that of the mode alone
    and_undo = and_undo and call.has_undo and bpy.context.mode == "OBJECT" and may_undo()
    before, boxes = digest(), set(wrong_bounds())
    try:
        outcome, text = call.run()
    except Exception as error:
        return "error", [f"{type(error).__name__}: {error}"]
    after = digest()
    faults = []
    if outcome != "finished":
        if outcome == "failed" and not is_sentence(text):
            faults.append(text)
        changed = differences(before, after)
        if changed:
            faults.append(f"{outcome} ({text.strip()}), and changed {len(changed)}: {'; '.join(changed[:6])}")
    else:
        faults += [box for box in wrong_bounds() if box not in boxes] + not_finite()
        if and_undo and not faults:
            faults += _undone(before, after)
    return f"{outcome}: {text.strip()}", faults


def _undone(before: dict, after: dict) -> list[str]:
    import bpy

    from .blend_digest import differences, digest

    faults = []
    for what, wanted in (("undo", before), ("redo", after)):
        getattr(bpy.ops.ed, what)()
        left = differences(wanted, digest(), but=_MODES)
        if left:
            faults.append(f"{what} leaves {len(left)}: {'; '.join(left[:6])}")
            break
    return faults


# Undo leaves the modes of objects that are not active.
_MODES = ("mode", "is_editmode", "total_edge_sel", "total_face_sel", "total_vert_sel")


# --- a process for some sequences ----------------------------------------------------------

class Printed:
    """What Blender and the add-on print, kept off the process's own output."""

    def __init__(self) -> None:
        self.own = os.fdopen(os.dup(1), "w")
        self.file = tempfile.TemporaryFile()  # noqa: SIM115  open as long as the process
        sys.stdout.flush()
        for stream in (1, 2):
            os.dup2(self.file.fileno(), stream)
        self.read = 0

    def new(self) -> str:
        sys.stdout.flush()
        sys.stderr.flush()
        text = os.pread(self.file.fileno(), 10**7, self.read)
        self.read += len(text)
        return text.decode(errors="replace")


def work(seeds: list[int], tell: bool) -> None:
    """Run sequences, and print a line of JSON before and after each."""
    import resource

    from tests.blender.conftest import PACKAGE

    printed = Printed()
    faulthandler.enable(printed.own)
    sys.excepthook = lambda *error: traceback.print_exception(*error, file=printed.own)
    import bpy

    # isort: split
    import addon_utils  # is on the path once bpy is imported

    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert addon_utils.enable(PACKAGE, default_set=True)

    def say(text: str) -> None:
        if tell:
            print(json.dumps({"say": text}), file=printed.own, flush=True)

    for seed in seeds:
        print(json.dumps({"seed": seed}), file=printed.own, flush=True)
        with tempfile.TemporaryDirectory(prefix="cmc-fuzz-") as folder:
            os.chdir(folder)
            outcomes, wrong = sequence(seed, Path(folder), say)
            os.chdir("/")
        text = printed.new()
        if "Traceback" in text:
            wrong.append(f"seed {seed}: printed {text[text.index('Traceback'):][-3000:]}")
        megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        if megabytes > MEMORY:
            wrong.append(f"seed {seed}: the process takes {megabytes:.0f} MB")
        print(json.dumps({"seed": seed, "outcomes": outcomes, "wrong": wrong}), file=printed.own, flush=True)


def run_seeds(seeds: list[int], tell: bool = False) -> tuple[Counter, list[str]]:
    """Run sequences in processes of their own; one that ends or stalls is replaced by the next."""
    outcomes, wrong, left = Counter(), [], list(seeds)
    while left:
        done, outcome, faults = _one_process(left, tell)
        outcomes += outcome
        wrong += faults
        for fault in faults:
            print(fault, flush=True)
        left = left[done:]
    return outcomes, wrong


def _one_process(seeds: list[int], tell: bool) -> tuple[int, Counter, list[str]]:
    """Run sequences until the process ends; how many were begun, how their calls ended, and what was wrong."""
    command = [sys.executable, "-m", "tests.fuzz.operators", *(["--tell"] if tell else [])]
    command += ["--worker", *map(str, seeds)]
    outcomes, wrong, done, running, noise = Counter(), [], 0, None, []
    with subprocess.Popen(command, stdout=subprocess.PIPE, cwd=ROOT) as process:
        for line in _lines(process):
            try:
                news = json.loads(line)
            except ValueError:
                noise.append(line)  # of a crash
                continue
            if "say" in news:
                print(news["say"], flush=True)
            elif "outcomes" in news:
                outcomes += Counter(news["outcomes"])
                wrong += news["wrong"]
                done, running = done + 1, None
            else:
                running = news["seed"]
    if done < len(seeds):
        seed = seeds[done] if running is None else running
        wrong.append(f"seed {seed}: Blender ended with {process.returncode}: {_trace(noise)}")
        done += 1
    return done, outcomes, wrong


def _trace(noise: list[str]) -> str:
    """The part of a crash's message that says where it happened."""
    return "\n".join(line for line in noise if not line.startswith("Extension modules"))[-2000:]


def _lines(process: subprocess.Popen) -> Iterator[str]:
    """The lines that a process prints; it is ended when it prints none for too long."""
    assert process.stdout is not None
    rest = b""
    while True:
        if not select.select([process.stdout], [], [], SECONDS)[0]:
            process.kill()
            yield f"no end after {SECONDS:.0f} s"
            return
        news = os.read(process.stdout.fileno(), 1 << 16)
        if not news:
            return
        *lines, rest = (rest + news).split(b"\n")
        yield from (line.decode(errors="replace") for line in lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--calls", type=int, default=1000, help="about how many calls of operators (1000)")
    parser.add_argument("--seed", type=int, default=0, help="the first seed (0)")
    parser.add_argument("--only", type=int, nargs="+", metavar="SEED", help="run and tell these sequences")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1, help="how many at a time")
    parser.add_argument("--worker", type=int, nargs="+", help=argparse.SUPPRESS)
    parser.add_argument("--tell", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.worker:
        work(arguments.worker, arguments.tell)
        return 0
    started = time.monotonic()
    seeds = arguments.only or list(range(arguments.seed, arguments.seed + -(-arguments.calls // CALLS)))
    count = 1 if arguments.only else max(1, min(arguments.processes, len(seeds)))
    with ThreadPoolExecutor(count) as pool:
        ends = list(pool.map(lambda k: run_seeds(seeds[k::count], bool(arguments.only)), range(count)))
    outcomes = sum((outcome for outcome, _ in ends), Counter())
    wrong = [fault for _, faults in ends for fault in faults]
    print(f"\n{len(seeds)} sequences, {sum(outcomes.values())} calls in {time.monotonic() - started:.0f} s")
    for outcome, number in sorted(outcomes.items()):
        print(f"{outcome:12}{number:8}")
    print(f"{'wrong':12}{len(wrong):8}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
