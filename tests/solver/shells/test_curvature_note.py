"""A shell whose mean curvature misses its target says so, why, and what to do; and the command line ends with 1."""

from __future__ import annotations

import json

import numpy as np
import pytest

from solver.__main__ import main
from solver.catalogue import shapes
from solver.jobs.outcomes import FAILED, OK
from solver.measure.curvature_fault import boundary_corners, curvature_note
from solver.shells.form import form
from solver.shells.plan import Group, Plan
from solver.shells.shell import Shell

HALL = [(0, 0), (10, 0), (10, 6), (0, 6)]
ELL = [(0, 0), (12, 0), (12, 5), (5, 5), (5, 12), (0, 12)]

BOX = """\
mesh = "box.obj"
[default]
tilt = 30
against = "surface"
[output]
report = "report.json"
"""


def open_box() -> str:
    """A cube without its floor as an OBJ, four squares a side."""
    ring = [(-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0)]
    vertices = [(x, y, z) for z in (-1, 0, 1) for x, y in ring] + [(0, 0, 1)]
    walls = [(8 * z + k, 8 * z + (k + 1) % 8, 8 * z + 8 + (k + 1) % 8, 8 * z + 8 + k) for z in (0, 1) for k in range(8)]
    roof = [(16 + k, 16 + (k + 1) % 8, 24, 16 + (k - 1) % 8) for k in (0, 2, 4, 6)]
    lines = [f"v {x} {y} {z}" for x, y, z in vertices]
    return "\n".join(lines + ["f " + " ".join(str(v + 1) for v in face) for face in walls + roof]) + "\n"


def shell_over(outline, tilts, max_edge: float) -> Shell:
    shape = shapes.polygon(np.array(outline, dtype=float), max_edge=max_edge)
    edges = shape.domain.edges
    groups = [
        Group(f"side{k}", edges[shape.sides[f"side{k}"]], "binormal", {"tilt": np.radians(tilt)})
        for k, tilt in enumerate(tilts)
    ]
    plan = Plan(np.column_stack([shape.positions, np.zeros(len(shape.positions))]), shape.domain.faces, groups=groups)
    return form(plan)


def codes(shell: Shell) -> list[str]:
    return [note.code for note in shell.warnings]


def test_sharp_inner_corners_are_named_by_their_place() -> None:
    shell = shell_over(ELL, (20,) * 6, 1.0)
    note = shell.warnings[codes(shell).index("curvature")]
    assert "corners" in note and "(5, 5)" in note and "round them" in note
    assert shell.report.shown.mean_curvature.relative_l2 > 0.1
    assert shell.message == note.split(",")[0].replace("Mean curvature", "Curvature") + "."
    assert shell.ok, "it did converge"


@pytest.mark.parametrize("tilts", [(20,) * 4, (60, 0, 60, 0)])
def test_a_fine_shell_has_no_such_warning(tilts) -> None:
    shell = shell_over(HALL, tilts, 0.7)
    assert "curvature" not in codes(shell) and shell.message.startswith("Done.")


def test_a_coarse_mesh_is_to_be_refined() -> None:
    shell = shell_over(HALL, (45,) * 4, 3.0)
    note = shell.warnings[codes(shell).index("curvature")]
    assert "too coarse" in note and "halve its edge length" in note


def test_an_open_box_is_no_shell_of_constant_curvature(tmp_path, capsys) -> None:
    (tmp_path / "box.obj").write_text(open_box())
    (tmp_path / "box.toml").write_text(BOX)
    assert main([str(tmp_path / "box.toml")]) == FAILED
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["status"] == "converged", "the harmonic map itself was found"
    assert [warning["code"] for warning in report["warnings"]].count("not-cmc") == 1
    error = capsys.readouterr().err
    assert "times its target" in error or "% of its target" in error


def test_a_coarse_court_ends_well_all_the_same(tmp_path) -> None:
    (tmp_path / "ell.toml").write_text(
        f'[shape]\nkind = "polygon"\noutline = {[list(point) for point in ELL]}\nmax_edge = 1.0\n[default]\ntilt = 20\n'
    )
    assert main(["-q", str(tmp_path / "ell.toml")]) == OK


def test_corners_are_where_the_boundary_turns() -> None:
    square = shapes.polygon(np.array(HALL, dtype=float), max_edge=1.0)
    at = square.positions[boundary_corners(square.domain, square.positions)]
    assert sorted(map(tuple, np.round(at, 9).tolist())) == sorted((float(x), float(y)) for x, y in HALL)
    disc = shapes.disc(400)
    assert not len(boundary_corners(disc.domain, disc.positions))


def test_the_note_knows_where_the_error_is() -> None:
    """The same measured sheet with normals spoiled in the middle has its error there, not at the corners."""
    shell = shell_over(ELL, (20,) * 6, 1.0)
    N = -np.asarray(shell.normals["f+"])
    note = curvature_note(
        shell.report.shown, shell.surface.domain, np.zeros((len(N), 3)), shell.points(), shell.faces, N
    )
    assert note is not None and "corners" not in note, "a plan without corners"
