"""What may happen to a batch from outside, for both command lines: the tests of tests/solver and tests/blender."""

from __future__ import annotations

import json
import signal
import subprocess
from pathlib import Path
from random import Random

from .batches import Batch, disc, faults, finished, make_batch, reports, scratch, span_of, write_job
from .disks import fill, read_only, small_disk
from .kill import kill_often

SEED = 20261130


def killed(folder: Path, command: str, *options: str) -> None:
    wrong = kill_often(make_batch(folder, 6, command), 2, SEED, *options)
    assert not wrong, "\n".join(wrong)


def interrupted(folder: Path, command: str, *options: str) -> None:
    """Ctrl-C: 130, one sentence, nothing left behind; --resume does the rest."""
    batch, random = make_batch(folder, 8, command, columns=24), Random(SEED)
    run = batch.start(*options)
    run.after(random.randint(1, 3), random.uniform(0.0, 0.1))
    run.kill(signal.SIGINT)
    assert run.code == 130, (run.code, run.stderr)
    assert "Interrupted; what was finished is written" in run.stderr and "Traceback" not in run.stderr, run.stderr
    done = finished(batch.output)
    assert run.formed <= done and not faults(batch.output) and not scratch(batch.output)
    run = batch.run("--resume")
    assert (run.code, run.skipped, len(run.formed)) == (0, done, 8 - len(done))


def full_disk(folder: Path, command: str) -> None:
    """Where the disk is full, 1 and a sentence; the files of before stay."""
    batch = make_batch(folder, 2, command)
    with small_disk(batch.output, 4000):
        assert batch.run().code == 0
        before = contents(batch.output)
        (folder / "plan.obj").write_text(disc(96))
        fill(batch.output, leave=60_000)
        run = batch.run()
        _failed(run, "No space left on device", "the disk may be full")
        (batch.output / "filler").unlink()
        assert contents(batch.output) == before and not scratch(batch.output)
        assert batch.run("--resume").formed == {"hall00", "hall01"} and not faults(batch.output)


def read_only_disk(folder: Path, command: str) -> None:
    batch = make_batch(folder, 2, command)
    with small_disk(batch.output, 4000):
        assert batch.run().code == 0
        before = contents(batch.output)
        (folder / "plan.obj").write_text(disc(16))
        with read_only(batch.output):
            _failed(batch.run(), "Read-only file system")
        assert contents(batch.output) == before and not scratch(batch.output)


def two_at_once(folder: Path, command: str) -> None:
    """Two processes with other sizes in one folder: each report is that of the files beside it."""
    ours, theirs = ([], [])
    for span, jobs in ((6.0, ours), (14.0, theirs)):
        place = folder / f"span{span:.0f}"
        place.mkdir()
        (place / "plan.obj").write_text(disc(12))
        (place / "out").symlink_to(folder / "out", target_is_directory=True)
        jobs += [write_job(place, f"hall{k}", 20.0, span) for k in range(6)]
    (folder / "out").mkdir()
    runs = [Batch(folder, command, jobs).start() for jobs in (ours, theirs)]
    assert [run.wait() for run in runs] == [0, 0], [run.stderr for run in runs]
    assert len(finished(folder / "out")) == 6
    assert not faults(folder / "out") and not scratch(folder / "out")
    for report in reports(folder / "out"):
        span = json.loads(report.read_text())["sheets"]["f+"]["span"]
        assert abs(span_of(report.parent / "shell.obj") - span) < 1e-3, report


def contents(output: Path) -> dict[Path, bytes]:
    """Every file of the plans below a folder."""
    return {file: file.read_bytes() for report in reports(output) for file in sorted(report.parent.iterdir())}


def a_pipe_that_ends(folder: Path, command: str) -> None:
    """`| head`: the reader leaves, the work goes on."""
    batch = make_batch(folder, 3, command)
    reader = subprocess.Popen(["head", "-n", "1"], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)
    process = subprocess.Popen(batch.arguments(), stdout=reader.stdin, stderr=subprocess.PIPE, text=True, cwd=_ROOT)
    assert reader.stdin is not None
    reader.stdin.close()
    stderr = process.communicate(timeout=200)[1]
    reader.wait()
    assert process.returncode == 0 and "Traceback" not in stderr and "BrokenPipe" not in stderr, stderr
    assert len(finished(batch.output)) == 3


_ROOT = Path(__file__).resolve().parents[2]


def _failed(run, *reasons: str) -> None:
    """Every plan has failed, with exit code 1 and a sentence that says why."""
    assert run.code == 1, (run.code, run.stderr)
    assert not run.formed and run.outcomes and "Traceback" not in run.stderr, run
    for outcome in run.outcomes:
        assert any(reason in outcome["message"] for reason in reasons), run.outcomes
