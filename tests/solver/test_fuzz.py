"""Random plans, meshes, jobs and files (tests/fuzz): three hundred new ones, and all that ended badly once."""

from __future__ import annotations

from collections import Counter

import pytest

from tests.fuzz.found import found
from tests.fuzz.generators import GENERATORS, cases
from tests.fuzz.judge import Outcome
from tests.fuzz.pool import run_all

# Fits take seconds each.
QUICK = [name for name in GENERATORS if name != "fits"]
HERE = 20261130


def bad(outcomes: list[Outcome]) -> list[str]:
    return [f"{outcome.case} {outcome.kind}: {outcome.text}" for outcome in outcomes if not outcome.is_good]


@pytest.mark.parametrize("name", QUICK)
def test_what_is_drawn_at_random_ends_in_a_shell_or_a_sentence(name):
    outcomes = list(run_all(cases(300 // len(QUICK), HERE, [name]), 1))
    assert not bad(outcomes)
    assert len(Counter(outcome.kind for outcome in outcomes)) > 1, "some are refused, some are not"


def test_what_ended_badly_once_does_not_again():
    outcomes = list(run_all(found(), 1))
    assert outcomes and not bad(outcomes)
