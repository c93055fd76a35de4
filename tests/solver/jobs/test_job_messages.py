"""Messages of a job: angles are degrees, and known keys are listed once."""

from __future__ import annotations

from pathlib import Path

import pytest

from solver.errors import JobError
from solver.jobs.job import load_job, run_job

DISC = "[shape]\nkind = 'disc'\nn = 100\n"


@pytest.mark.parametrize("text", ["[default]\ntilt = {}\n", "[[conditions]]\nside = 'outer'\ntilt = {}\n"])
@pytest.mark.parametrize("tilt", [200, -400])
def test_more_than_half_a_turn_is_refused_in_degrees(tmp_path: Path, text: str, tilt: int):
    path = tmp_path / "job.toml"
    path.write_text(DISC + text.format(tilt))
    with pytest.raises(JobError, match=rf'"tilt" must be an angle from -180 to 180 degrees, not {tilt}\.'):
        load_job(path)


def test_half_a_turn_is_an_angle(tmp_path: Path):
    path = tmp_path / "job.toml"
    path.write_text(DISC + "[default]\ntilt = -180\n")
    assert run_job(load_job(path)).ok


def test_known_keys_are_listed_once(tmp_path: Path):
    path = tmp_path / "job.toml"
    path.write_text(DISC + "zzz = 3\n")
    with pytest.raises(JobError, match=r'unknown key "zzz"; known are kind, scale, n\.$'):
        load_job(path)
