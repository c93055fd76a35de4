"""What may happen to a batch in Blender from outside: killed, interrupted, disks full or read-only, two at once."""

from __future__ import annotations

import pytest

from tests.faults import cases


def test_killed(tmp_path):
    cases.killed(tmp_path, "blender")


@pytest.mark.parametrize("options", [(), ("--jobs", "2")])
def test_interrupted(tmp_path, options):
    cases.interrupted(tmp_path, "blender", *options)


def test_a_full_disk(tmp_path):
    cases.full_disk(tmp_path, "blender")


def test_a_disk_that_cannot_be_written(tmp_path):
    cases.read_only_disk(tmp_path, "blender")


def test_two_at_once(tmp_path):
    cases.two_at_once(tmp_path, "blender")


def test_a_pipe_that_ends(tmp_path):
    cases.a_pipe_that_ends(tmp_path, "blender")
