"""Run by test_extension.py in each clean Blender: install the zip, enable, solve, disable.

    python install_and_solve.py ZIP FACTS.json

Nothing is asserted here, since exit codes of Blender say little: the facts go into a file, which the
test reads. Only bpy and its own dependencies are here, so this file imports nothing else.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import json
import sys
from pathlib import Path

import bpy

# isort: split
import addon_utils  # is on the path once bpy is imported

MODULE = "bl_ext.user_default.cmc_formfinding"
BUNDLED = ("scipy", "trimesh", "cholespy")


def versions() -> dict:
    return {"blender": bpy.app.version_string, "python": sys.version.split()[0]}


def install(archive: str) -> dict:
    """Install and enable the zip; bundled packages installed before, and the state of the add-on."""
    before = [name for name in BUNDLED if importlib.util.find_spec(name)]
    bpy.ops.extensions.package_install_files(
        filepath=archive, repo="user_default", enable_on_install=True, overwrite=True
    )
    enabled = addon_utils.check(MODULE)
    return {"bundled packages before": before, "enabled": list(enabled)}


def solve() -> dict:
    """A square plan of quads with the default settings."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable(MODULE, default_set=True)
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=8, y_subdivisions=8, size=2.0)
    plan = bpy.context.object
    finished = bpy.ops.cmc.solve()
    shells = [ob for ob in bpy.data.objects if ob is not plan and ob.type == "MESH"]
    return {
        "solve": list(finished),
        "shells": [[len(ob.data.vertices), len(ob.data.polygons), *size(ob)] for ob in shells],
        "attributes": sorted({attribute.name for ob in shells for attribute in ob.data.attributes}),
    }


def solve_on_delaunay() -> dict:
    """A sheared grid of needles, solved on its intrinsic Delaunay triangulation; weights of both, status, size.

    And whether there is a libigl, which could do the flipping.
    """
    solver = importlib.import_module(f"{MODULE}.solver")
    points = [[i + 2.5 * j, j] for i in range(5) for j in range(5)]
    corners = [5 * i + j for i in range(4) for j in range(4)]
    faces = [[k, k + 5, k + 6] for k in corners] + [[k, k + 6, k + 1] for k in corners]
    domain = solver.Domain.from_positions(points, faces)
    rim = solver.conditions.binormal(domain, points, domain.boundary_edges, tilt=0.8)
    surface = solver.solve_cmc(domain, rim, delaunay=True)
    weights = [float(mesh.cotan_weights[mesh.interior_edges].min()) for mesh in (domain, surface.graph.domain)]
    return {
        "weights": weights,
        "delaunay": [surface.status.value, len(surface.f_plus), len(surface.faces)],
        "libigl": importlib.util.find_spec("igl") is not None,
    }


def command(folder: Path) -> dict:
    """`blender --command cmc` on the scene as a file; what it answered and wrote."""
    plan = folder / "plan.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(plan))
    cli = importlib.import_module(f"{MODULE}.cmc_addon.headless.cli")
    code = cli.run([str(plan), "--output", str(folder / "out"), "--format", "glb"])
    return {"command": code, "written": sorted(path.name for path in (folder / "out").rglob("*.*"))}


def size(ob: bpy.types.Object) -> list[float]:
    """Width, depth and height, in the object's own axes."""
    columns = zip(*(vertex.co for vertex in ob.data.vertices), strict=True)
    return [max(column) - min(column) for column in columns]


def origins() -> dict:
    """The file each bundled package was imported from, and its version."""
    files = {name: importlib.import_module(name).__file__ for name in BUNDLED}
    return {"origins": {name: [file, importlib.metadata.version(name)] for name, file in files.items()}}


def disable() -> dict:
    """Disable it; its remains in Blender."""
    addon_utils.disable(MODULE, default_set=True)
    left = [name for name in dir(bpy.types) if name.startswith("CMC_")]
    left += [f"{kind.__name__}.cmc" for kind in (bpy.types.Mesh, bpy.types.Object) if hasattr(kind, "cmc")]
    return {"disabled": not any(addon_utils.check(MODULE)), "left": left}


def main(archive: str, output: str) -> None:
    facts = versions()
    folder = Path(output).parent
    for step in (lambda: install(archive), solve, solve_on_delaunay, lambda: command(folder), origins, disable):
        facts |= step()
        Path(output).write_text(json.dumps(facts), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
