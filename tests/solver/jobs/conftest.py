"""The folder of a job, with a plan of quads in it."""

from __future__ import annotations

from pathlib import Path

import pytest

from solver.io.mesh_files import write_mesh
from tests.solver.job_files import quad_plan


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_mesh(tmp_path / "plan.obj", quad_plan())
    return tmp_path
