"""Random sequences of the operators, and many solves in one Blender; the long versions are `make fuzz-blender`."""

from __future__ import annotations

import subprocess
import sys

from tests.fuzz.operators import ROOT, run_seeds

FIRST = 20261130


def test_random_sequences_finish_or_say_why_not_and_change_nothing():
    outcomes, wrong = run_seeds(list(range(FIRST, FIRST + 8)))
    assert not wrong, "\n".join(wrong)
    assert {"finished", "failed", "refused"} <= outcomes.keys(), outcomes


def test_memory_stays_flat():
    command = [sys.executable, "-m", "tests.fuzz.solves", "-n", "90"]
    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout + ran.stderr
