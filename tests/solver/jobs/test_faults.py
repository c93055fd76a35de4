"""What may happen to a batch of jobs from outside: killed, interrupted, disks full or read-only, two at once."""

from __future__ import annotations

import pytest

from tests.faults import cases


@pytest.mark.parametrize("options", [(), ("--jobs", "2")])
def test_killed(tmp_path, options):
    cases.killed(tmp_path, "solver", *options)


@pytest.mark.parametrize("options", [(), ("--jobs", "2")])
def test_interrupted(tmp_path, options):
    cases.interrupted(tmp_path, "solver", *options)


def test_a_full_disk(tmp_path):
    cases.full_disk(tmp_path, "solver")


def test_a_disk_that_cannot_be_written(tmp_path):
    cases.read_only_disk(tmp_path, "solver")


def test_two_at_once(tmp_path):
    cases.two_at_once(tmp_path, "solver")


def test_a_pipe_that_ends(tmp_path):
    cases.a_pipe_that_ends(tmp_path, "solver")
