"""`blender --command cmc`: files in, results and reports out, exit codes."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import bpy

# isort: split
import numpy as np
import pytest
from cmc_formfinding.cmc_addon.headless import cli
from cmc_formfinding.cmc_addon.properties.links import results_of
from cmc_formfinding.solver.io.mesh_files import read_mesh
from numpy.testing import assert_allclose

from .conftest import ROOT
from .scenes import activate, add_group, boundary_edges, jittered, mesh_object, positions, quad_disc

JOBS = ROOT / "assets" / "jobs"


def save(path: Path) -> Path:
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


def report(path: Path) -> dict:
    return json.loads((path / "report.json").read_text())


@pytest.fixture
def hall(tmp_path) -> Path:
    """A file with two plans, one with a group, and a mesh that is no plan."""
    disc = jittered(quad_disc("Disc", rings=6))
    disc.data.materials.append(bpy.data.materials.new("Glass"))
    disc.data.uv_layers.new(name="Map")
    add_group(disc, "rim", boundary_edges(disc.data), "BINORMAL", tilt=0.3)
    other = quad_disc("Other", rings=5, radius=2.0)
    other.location.x = 10.0
    add_group(other, "some", boundary_edges(other.data)[:5], "PLANE", normal=(0.3, 0.0, 1.0))
    mesh_object("Tree", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    return save(tmp_path / "hall.blend")


def test_all_plans_of_a_file(hall, tmp_path, capsys):
    assert cli.run([str(hall), "--output", str(tmp_path / "out"), "--format", "blend", "glb", "obj"]) == 0
    folder = tmp_path / "out" / "hall"
    files = sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())
    expected = [f"{plan}/{name}" for plan in ("Disc", "Other") for name in ("report.json", "shell.glb", "shell.obj")]
    assert [f for f in files if not f.endswith(".mtl")] == [*expected, "hall.blend", "plans.json"]
    for name in ("Disc", "Other"):
        assert report(folder / name)["converged"] is True
        assert report(folder / name)["plan"] == name
    shown = capsys.readouterr().out
    assert "Disc" in shown and f"report → {folder / 'Disc' / 'report.json'}" in shown
    bpy.ops.wm.open_mainfile(filepath=str(folder / "hall.blend"))
    disc = bpy.data.objects["Disc"]
    assert set(results_of(disc)) == {"F_PLUS"}
    assert set(results_of(bpy.data.objects["Other"])) == {"F_PLUS"}
    assert not results_of(bpy.data.objects["Tree"])
    placed = positions(disc.cmc.f_plus)
    for suffix, tolerance in ((".obj", 1e-5), (".glb", 1e-5)):
        mesh = read_mesh(folder / "Disc" / f"shell{suffix}")
        assert_allclose(np.sort(mesh.positions, axis=0), np.sort(placed, axis=0), rtol=0, atol=tolerance)
    assert {len(p) for p in read_mesh(folder / "Disc" / "shell.obj").polygons} == {3, 4}
    assert read_mesh(folder / "Disc" / "shell.obj").materials[0] == "Glass"


def test_settings_override_those_of_the_plan(hall, tmp_path):
    arguments = ["--output", str(tmp_path), "--plan", "Disc", "--span", "12", "--ground", "rim", "--flip", "--want-g"]
    assert cli.run([str(hall), *arguments]) == 0
    assert_allclose(report(tmp_path / "hall" / "Disc")["sheets"]["f+"]["span"], 12, rtol=1e-6)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "hall" / "hall.blend"))
    disc = bpy.data.objects["Disc"]
    assert set(results_of(disc)) == {"F_PLUS", "G"}
    assert (disc.cmc.size, disc.cmc.ground, disc.cmc.flip) == ("SPAN", "RIM", True)
    assert positions(disc.cmc.f_plus)[:, 2].min() < -1
    assert not results_of(bpy.data.objects["Other"])


def test_sites_energy_and_faces(hall, tmp_path):
    """Given on the command line, and kept with the plan; in OBJ files polygons, in GLB triangles."""
    arguments = ["--sites", "faces", "--energy", "mobius", "--method", "newton", "--delaunay"]
    arguments += ["--combinatorics", "dual"]
    out = ["--output", str(tmp_path / "out"), "--plan", "Disc", "--format", "blend", "obj", "glb"]
    assert cli.run([str(hall), *arguments, *out]) == 0
    shell = read_mesh(tmp_path / "out" / "hall" / "Disc" / "shell.obj")
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out" / "hall" / "hall.blend"))
    disc = bpy.data.objects["Disc"]
    choice = (disc.cmc.sites, disc.cmc.energy, disc.cmc.method, disc.cmc.delaunay, disc.cmc.combinatorics)
    assert choice == ("FACES", "MOBIUS", "NEWTON", True, "DUAL")
    assert len(shell.polygons) == len(disc.data.vertices) == len(disc.cmc.f_plus.data.polygons)
    assert len(shell.uvs) and set(shell.materials) == {"Glass"}
    assert {len(p) for p in read_mesh(tmp_path / "out" / "hall" / "Disc" / "shell.glb").polygons} == {3}


def test_an_energy_that_does_not_fit_the_plan(hall, tmp_path, capsys):
    """The file's own sites are vertices."""
    arguments = [str(hall), "--energy", "tan", "--output", str(tmp_path / "out"), "--plan", "Disc"]
    assert cli.run(arguments) == 2
    message = "The energy Tangent is not defined for normals on vertices; choose Cotangent, or other sites."
    assert message in capsys.readouterr().err
    assert report(tmp_path / "out" / "hall" / "Disc")["error"] == message
    assert cli.run([*arguments, "--sites", "faces", "--delaunay"]) == 0


def test_choices_of_a_job_are_those_of_the_plan(tmp_path):
    text = (JOBS / "canopy.toml").read_text() + '\ncombinatorics = "corner"\n'
    text += '\n[solver]\nsites = "faces"\nmethod = "flow"\ndelaunay = true\n'
    shutil.copytree(JOBS, tmp_path / "jobs")
    (tmp_path / "jobs" / "canopy.toml").write_text(text)
    assert cli.run([str(tmp_path / "jobs" / "canopy.toml"), "--output", str(tmp_path / "out")]) == 0
    plan = bpy.data.objects["canopy"]
    choice = (plan.cmc.sites, plan.cmc.energy, plan.cmc.method, plan.cmc.delaunay, plan.cmc.combinatorics)
    assert choice == ("FACES", "DUAL_COTAN", "FLOW", True, "CORNER")
    shell = plan.cmc.f_plus.data
    assert len(shell.polygons) > 3 * len(plan.data.polygons)
    assert len(shell.uv_layers) == 1 and [m.name for m in shell.materials] == ["steel", "glass"]


def test_the_input_is_not_written(hall, tmp_path):
    before = hall.read_bytes()
    assert cli.run([str(hall), "--output", str(tmp_path)]) == 0
    assert hall.read_bytes() == before


def test_one_failure_does_not_stop_the_rest(tmp_path, capsys):
    bad = quad_disc("Bad", rings=4)
    edges = boundary_edges(bad.data)
    add_group(bad, "up", edges[:1], "PLANE", normal=(0.0, 0.0, 1.0))
    add_group(bad, "down", edges[1:2], "PLANE", normal=(0.0, 0.0, -1.0))
    good = quad_disc("Good", rings=4)
    add_group(good, "rim", boundary_edges(good.data), "BINORMAL", tilt=0.2)
    file = save(tmp_path / "two.blend")
    missing, broken = tmp_path / "missing.blend", tmp_path / "broken.blend"
    broken.write_bytes(b"not a blend file")
    inputs = [str(missing), str(broken), str(file)]
    assert cli.run([*inputs, "--output", str(tmp_path / "out"), "--format", "glb"]) == 2
    out = tmp_path / "out"
    assert report(out / "two" / "Good")["converged"] is True
    assert (out / "two" / "Good" / "shell.glb").exists()
    assert not (out / "two" / "Bad" / "shell.glb").exists()
    assert report(out / "two" / "Bad")["plan"] == "Bad"
    assert "opposite" in report(out / "two" / "Bad")["error"]
    assert "There is no file" in report(out / "missing")["error"]
    assert "broken.blend cannot be opened" in report(out / "broken")["error"]
    lines = capsys.readouterr().err.splitlines()
    assert sum(line.startswith(f"{file}, Bad: ") for line in lines) == 1


def test_a_job_file(tmp_path):
    shutil.copytree(JOBS, tmp_path / "jobs")
    assert cli.run([str(tmp_path / "jobs" / "canopy.toml"), "--output", str(tmp_path / "out")]) == 0
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out" / "canopy" / "canopy.blend"))
    plan = bpy.data.objects["canopy"]
    groups = {group.name: group for group in plan.data.cmc.groups}
    assert set(groups) == {"platform", "street", "Rest"}
    assert_allclose(np.degrees([groups[name].tilt for name in ("platform", "street", "Rest")]), [55, 25, 40], rtol=1e-6)
    assert (plan.cmc.size, plan.cmc.span) == ("SPAN", 40.0)
    shell = plan.cmc.f_plus
    assert [slot.name for slot in shell.material_slots] == ["steel", "glass"]
    assert len(shell.data.uv_layers) == 1
    assert {len(p.vertices) for p in shell.data.polygons} == {4}
    rise = np.ptp(positions(shell)[:, 2])
    assert_allclose(rise, report(tmp_path / "out" / "canopy" / "canopy")["sheets"]["f+"]["rise"], rtol=1e-5)


def test_the_same_job_gives_the_same_shell_without_blender(tmp_path):
    """Single precision in Blender, double without."""
    from cmc_formfinding.solver.jobs.job import load_job, run_job

    shutil.copytree(JOBS, tmp_path / "assets" / "jobs")
    shell = run_job(load_job(tmp_path / "assets" / "jobs" / "canopy.toml"))
    assert cli.run([str(tmp_path / "assets" / "jobs" / "canopy.toml"), "--output", str(tmp_path / "out")]) == 0
    assert_allclose(positions(bpy.data.objects["canopy"].cmc.f_plus), shell.placed["f+"], rtol=0, atol=2e-4)


def test_a_mesh_file_with_conditions(tmp_path):
    shutil.copy(JOBS / "canopy.obj", tmp_path / "roof.obj")
    conditions = ["--condition", 'group = "platform", tilt = 30', "--condition", "vertices = [0, 41], kind = 'free'"]
    assert cli.run([str(tmp_path / "roof.obj"), *conditions, "--output", str(tmp_path), "--format", "obj"]) == 0
    groups = bpy.data.objects["roof"].data.cmc.groups
    assert [group.name for group in groups] == ["platform", "vertices of [[conditions]] 2", "street"]
    assert_allclose([groups["platform"].tilt, groups["street"].tilt], [np.radians(30), 0.0], rtol=1e-6)
    assert [group.kind for group in groups] == ["BINORMAL", "FREE", "BINORMAL"]
    assert len(read_mesh(tmp_path / "roof" / "roof" / "shell.obj").polygons) == 480
    assert not (tmp_path / "roof" / "roof.blend").exists()


def test_the_file_that_is_open(hall, tmp_path):
    bpy.ops.wm.open_mainfile(filepath=str(hall))
    assert cli.run(["--output", str(tmp_path / "out"), "--plan", "Disc"]) == 0
    assert report(tmp_path / "out" / "hall" / "Disc")["converged"] is True


def test_a_single_mesh_without_groups_is_a_plan(tmp_path):
    quad_disc("Only", rings=5)
    assert cli.run([str(save(tmp_path / "one.blend")), "--output", str(tmp_path)]) == 0
    assert report(tmp_path / "one" / "Only")["converged"] is True


def test_a_surface_with_a_gap_is_written_and_is_a_failure(tmp_path, capsys):
    from .scenes import quad_ring

    ring = quad_ring()
    add_group(ring, "rim", boundary_edges(ring.data)[:24], "PLANE", normal=(0.6, 0.0, 0.8))
    assert cli.run([str(save(tmp_path / "ring.blend")), "--output", str(tmp_path), "--format", "glb"]) == 1
    written = report(tmp_path / "ring" / "Ring")
    assert written["status"] == "gap"
    assert any(warning["code"] == "gap" for warning in written["warnings"])
    assert (tmp_path / "ring" / "Ring" / "shell.glb").exists()
    assert "gap" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "There is nothing to solve"),
        (["a.blend", "--rse", "5"], "unrecognized arguments: --rse"),
        (["a.blend", "--format", "dxf"], "dxf"),
        (["a.blend", "--size", "large"], "LARGE"),
        (["a.blend", "--sites", "edges"], "invalid choice: 'EDGES'"),
        (["a.blend", "--sites", "vertices", "--energy", "mobius"], "Möbius is not defined for normals on vertices"),
        (["a.blend", "--span", "3", "--rise", "1"], "Give one size, not span and rise"),
        (["a.obj", "--condition", "group: street"], "is not valid TOML"),
        (["a.blend", "--span", "-7"], "The span is a number from 1e-06 to"),
        (["a.blend", "--near", "0"], "from 0.001 to 1e+06 in Blender, not 0."),
        (["a.blend", "--complete-repeat", "1", "1", "99999999999"], "from 1 to 1000 in Blender, not 1e+11."),
        (["a.blend", "--span", "wide"], "it is a number, not 'wide'"),
        (["a.blend", "--tolerance", "nan"], "not nan."),
    ],
)
def test_bad_arguments(arguments, message, capsys):
    assert cli.run(arguments) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("table", "message"), [("[size]\nspan = 1e-9", "The span"), ("[solver]\ntolerance = 1e-15", "The tolerance")]
)
def test_a_job_beyond_what_properties_take_is_refused(tmp_path, table, message, capsys):
    file = tmp_path / "small.toml"
    file.write_text(f'[shape]\nkind = "disc"\nn = 60\n[default]\ntilt = 20\n{table}\n')
    assert cli.run([str(file), "-o", str(tmp_path / "out"), "-f", "obj"]) == 2
    error = capsys.readouterr().err
    assert message in error and "in Blender, not 1e-" in error
    assert not list(tmp_path.rglob("shell.obj"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--plan", "Nosuch"], "There is no object 'Nosuch'"),
        ([], "none of the 2 meshes of the scene has boundary groups"),
    ],
)
def test_a_file_without_plans(tmp_path, arguments, message, capsys):
    quad_disc("A")
    activate(quad_disc("B"))
    file = save(tmp_path / "none.blend")
    assert cli.run([str(file), "--output", str(tmp_path), *arguments]) == 2
    assert message in capsys.readouterr().err
    assert message in report(tmp_path / "none")["error"]


def test_an_output_that_cannot_be_written(hall, tmp_path, capsys):
    (tmp_path / "taken").write_text("")
    assert cli.run([str(hall), "--output", str(tmp_path / "taken")]) == 1
    assert "cannot be" in capsys.readouterr().err


def test_help(capsys):
    assert cli.run(["--help"]) == 0
    shown = capsys.readouterr().out
    assert "blender --command cmc" in shown
    assert "--mean-curvature" in shown
    assert "match_plan|span" in shown


def test_nothing_is_left_over(hall, tmp_path):
    assert cli.run([str(hall), "--output", str(tmp_path / "out"), "--format", "blend", "glb", "obj"]) == 0
    assert list((tmp_path / "out").rglob(".*")) == []


def test_the_command_is_registered_with_the_add_on(addon):
    import addon_utils

    assert len(cli._handles) == 1
    addon_utils.disable(addon.__name__)
    assert cli._handles == []
    addon_utils.enable(addon.__name__)
    assert len(cli._handles) == 1
