"""Write the surfaces of `surfaces.py` that jobs approximate into assets/jobs/, in metres, plan coordinates as UVs.

.venv/bin/python scripts/make_surfaces.py
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import surfaces

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
from solver import shapes  # noqa: E402
from solver.files import MeshData, write_mesh  # noqa: E402

COUNT = 900


def main() -> None:
    disc = shapes.disc(COUNT)
    made = surfaces.cultural_centre(disc.positions, disc.domain.faces)
    faces = list(made.faces)
    mesh = MeshData(np.round(made.points, 4), faces, uvs=np.round(made.plan, 4), uv_corners=faces)
    write_mesh(ROOT / "assets" / "jobs" / "centre.obj", mesh)


if __name__ == "__main__":
    main()
