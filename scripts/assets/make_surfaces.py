"""Write the surfaces that jobs approximate into assets/jobs/, in metres, with plan coordinates as UVs.

.venv/bin/python -m scripts.assets.make_surfaces
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from scripts.assets import surfaces
from solver import shapes
from solver.io.mesh_files import write_mesh
from solver.io.obj import MeshData

ROOT = Path(__file__).resolve().parents[2]

COUNT = 900


def main() -> None:
    disc = shapes.disc(COUNT)
    made = surfaces.cultural_centre(disc.positions, disc.domain.faces)
    faces = list(made.faces)
    mesh = MeshData(np.round(made.points, 4), faces, uvs=np.round(made.plan, 4), uv_corners=faces)
    write_mesh(ROOT / "assets" / "jobs" / "centre.obj", mesh)


if __name__ == "__main__":
    main()
