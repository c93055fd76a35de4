"""kill -9 at random moments of a batch: `python -m tests.faults.kill --plans 50 --kills 20`.

The batch is started again and again with --resume and killed each time; the last run goes to its end. After each kill
no file is half written, and every plan that was announced as done is there; the last run skips those and does the rest
only.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from random import Random

from .batches import Batch, faults, finished, make_batch, scratch


def kill_often(batch: Batch, kills: int, seed: int, *options: str, say=lambda text: None) -> list[str]:
    """Kill a batch this often, then let it end; what was wrong."""
    random, wrong, done = Random(seed), [], set()
    per_run = max(len(batch.jobs) // (kills + 1), 1)
    for number in range(kills):
        run = batch.start("--resume", *options)
        run.after(len(done) + random.randint(0, 2 * per_run - 1), random.uniform(0.0, 0.3))
        run.kill()
        there = finished(batch.output) if batch.output.exists() else set()
        lost = (done | run.formed) - there
        say(f"kill {number + 1}: {len(run.formed)} done in this run, {len(there)} on the disk")
        wrong += [f"kill {number + 1}: lost {sorted(lost)}"] * bool(lost)
        wrong += [f"kill {number + 1}: {fault}" for fault in faults(batch.output)]
        wrong += [f"kill {number + 1}: a traceback: {run.stderr[-2000:]}"] * ("Traceback" in run.stderr)
        done = there
    run = batch.run("--resume", *options)
    say(f"the rest: {len(run.skipped)} skipped, {len(run.formed)} done, exit code {run.code}")
    every = {job.stem for job in batch.jobs}
    # with --jobs, the other processes have ended the plan that they were at
    if run.code or not done <= run.skipped or run.formed != every - run.skipped:
        wrong.append(f"exit code {run.code}; {sorted(done)} were done, skipped are {sorted(run.skipped)}")
    if finished(batch.output) != every:
        wrong.append(f"{sorted(every - finished(batch.output))} are missing")
    left = [f"{path} is left, with {[file.name for file in path.iterdir()]}" for path in scratch(batch.output)]
    return wrong + faults(batch.output) + left


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--plans", type=int, default=50)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--commands", nargs="+", choices=("solver", "blender"), default=("solver", "blender"))
    options = parser.parse_args()
    wrong = []
    for command in options.commands:
        print(command, flush=True)
        with tempfile.TemporaryDirectory(prefix="cmc-faults-") as folder:
            batch = make_batch(Path(folder), options.plans, command, columns=24)
            wrong += kill_often(batch, options.kills, options.seed, say=lambda text: print(f"  {text}", flush=True))
    print("\n".join(wrong) or "No plan was lost, no file was half written, and only the rest was done again.")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
