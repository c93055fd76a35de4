"""Random plans, meshes, jobs and files: does each end as it should?

    python -m tests.fuzz [-n 10000] [--seed 1] [--workers 2] [--only plans …]   # a table of outcomes
    python -m tests.fuzz plans:1000123 …                                        # these cases, here, with tracebacks

A good case converges, warns or is refused in a sentence. Bad ones are listed, each kind once with the number of its
cases, and end the run with exit code 1; all outcomes are in build/fuzz/outcomes.jsonl.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import re
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from .generators import GENERATORS, cases
from .judge import BAD, GOOD, Outcome, judge, make_case
from .pool import ROOT, run_all

OUT = ROOT / "build" / "fuzz"


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("cases", nargs="*", help="single cases, generator:seed")
    parser.add_argument("-n", type=int, default=10_000, help="cases (10000)")
    parser.add_argument("--seed", type=int, default=1, help="another seed, other cases (1)")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--only", nargs="*", default=[], choices=list(GENERATORS), help="these generators")
    options = parser.parse_args()
    return show(options.cases) if options.cases else run(options)


def show(names: list[str]) -> int:
    """Say what each case is and what came of it; errors that are no refusals end it with their traceback."""
    good = True
    for name in names:
        with tempfile.TemporaryDirectory(prefix="cmc-fuzz-") as folder:
            print(f"{name}: {make_case(name, Path(folder)).text}")
        outcome = judge(name)
        print(f"  {outcome.kind}: {outcome.text}")
        good &= outcome.is_good
        if outcome.kind in ("traceback", "over memory"):
            with tempfile.TemporaryDirectory(prefix="cmc-fuzz-") as folder:
                make_case(name, Path(folder)).run()
    return 0 if good else 1


def run(options: argparse.Namespace) -> int:
    start, outcomes = time.perf_counter(), []
    OUT.mkdir(parents=True, exist_ok=True)
    with (OUT / "outcomes.jsonl").open("w", buffering=1) as file:
        for outcome in run_all(cases(options.n, options.seed, options.only), options.workers):
            outcomes.append(outcome)
            file.write(json.dumps(dataclasses.asdict(outcome), ensure_ascii=False) + "\n")
            if len(outcomes) % 500 == 0:
                print(f"{len(outcomes)} cases, {time.perf_counter() - start:.0f} s", file=sys.stderr)
    print(table(outcomes))
    print(f"\n{len(outcomes)} cases in {time.perf_counter() - start:.0f} s; {kinds(outcomes)}")
    return 0 if all(outcome.is_good for outcome in outcomes) else 1


def table(outcomes: list[Outcome]) -> str:
    """Outcomes by generator."""
    counts = Counter((outcome.case.split(":")[0], outcome.kind) for outcome in outcomes)
    names = [name for name in GENERATORS if any(name == generator for generator, _ in counts)]
    lines = ["| |" + "".join(f" {name} |" for name in (*names, "all")), "|---|" + "---|" * (len(names) + 1)]
    for kind in (*GOOD, *BAD):
        row = [counts[name, kind] for name in names]
        lines.append(f"| {kind} |" + "".join(f" {number} |" for number in (*row, sum(row))))
    return "\n".join(lines)


def kinds(outcomes: list[Outcome]) -> str:
    """Bad cases, alike ones together."""
    bad: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        if not outcome.is_good:
            alike = re.sub(r"\[[^]]*\]|[-+]?\d[\d.e+-]*(?![^(]*\))", "…", outcome.text)
            where = "" if outcome.kind == "H off in silence" else alike
            bad.setdefault(f"{outcome.kind}: {where}", []).append(outcome)
    if not bad:
        return "all of them ended as they should."
    lines = [f"{sum(map(len, bad.values()))} did not end as they should:"]
    for alike, group in sorted(bad.items(), key=lambda item: -len(item[1])):
        lines.append(f"{len(group):5}  {alike[:300]}  [{', '.join(one.case for one in group[:4])}]")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
