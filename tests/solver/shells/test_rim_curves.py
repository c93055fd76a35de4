"""Curves from OBJ files, and which of them is for which loop of the plan."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import Domain, shapes
from solver.errors import ConditionError, JobError
from solver.shells.rim_curves import curves_of_loops, read_curves


def ring(radius: float, centre: tuple[float, float, float] = (0.0, 0.0, 0.0), count: int = 40) -> np.ndarray:
    t = 2 * np.pi * np.arange(count) / count
    return np.column_stack([radius * np.cos(t), radius * np.sin(t), 0 * t]) + centre


@pytest.fixture(scope="module", params=[1, -1], ids=["outer first", "outer last"])
def plan(request):
    """A square of side 20 with two holes, at x = 5 and at x = 15; the outer loop is the first one or the last."""
    square = [[0, 0], [20, 0], [20, 20], [0, 20]]
    holes = [ring(2.0, (x, 10.0, 0.0), 24)[:, :2].tolist() for x in (5.0, 15.0)]
    shape = shapes.polygon(square, holes, 2.0)
    points = np.column_stack([shape.positions, np.zeros(len(shape.positions))])
    if request.param == 1:
        return shape.domain, points
    return Domain.from_positions(points[::-1], len(points) - 1 - shape.domain.faces), points[::-1]


def loops(plan) -> tuple[int, int, int]:
    """Numbers of the outer loop, of the left hole and of the right one."""
    domain, points = plan
    outer = int(np.argmax([np.ptp(points[loop, 0]) for loop in domain.boundary_loops]))
    middles = [points[loop, 0].mean() for loop in domain.boundary_loops]
    left, right = sorted({0, 1, 2} - {outer}, key=lambda k: middles[k])
    return outer, left, right


@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (300.0, -70.0, 8.0)])
def test_each_curve_goes_to_the_nearest_hole(plan, shift):
    """Wherever the curves lie together, and in whichever order they come."""
    domain, points = plan
    outer, left, right = (ring(r, c) + shift for r, c in ((14, (10, 10, 0)), (1, (6, 9, 2)), (3, (13, 10, 1))))
    lines = curves_of_loops(domain, points, [right, outer, left])
    for number, line in zip(loops(plan), (outer, left, right), strict=True):
        assert_array_equal(lines[number], line)


def test_no_two_curves_share_a_hole(plan):
    """Both are nearer to the left one; the nearer of them has it."""
    domain, points = plan
    near, far = ring(1, (5, 10, 0)), ring(1, (9, 10, 0))
    lines = curves_of_loops(domain, points, [far, ring(14, (10, 10, 0)), near])
    _, left, right = loops(plan)
    assert_array_equal(lines[left], near)
    assert_array_equal(lines[right], far)


def test_holes_without_a_curve_keep_their_line(plan):
    domain, points = plan
    outer, small = ring(14, (-290, 10, 3)), ring(1, (-286, 10, 3))
    one = curves_of_loops(domain, points, [outer])
    two = curves_of_loops(domain, points, [small, outer])
    rim, left, right = loops(plan)
    for lines in (one, two):
        assert_array_equal(lines[rim], outer)
        assert_array_equal(lines[left], points[domain.boundary_loops[left]])
    assert_array_equal(one[right], points[domain.boundary_loops[right]])
    assert_array_equal(two[right], small)


def test_more_curves_than_loops(plan):
    domain, points = plan
    with pytest.raises(ConditionError, match="4 curves, but the plan's boundary has 3 loops; remove some"):
        curves_of_loops(domain, points, [ring(1.0)] * 4)


# --- files ---------------------------------------------------------------------------------


def obj(folder: Path, *loops: np.ndarray) -> Path:
    """A file with these closed polylines."""
    lines, first = [], 1
    for loop in loops:
        lines += [f"v {x} {y} {z}" for x, y, z in loop.tolist()]
        lines.append("l " + " ".join(str(first + k) for k in [*range(len(loop)), 0]))
        first += len(loop)
    (folder / "curves.obj").write_text("\n".join(lines) + "\n")
    return folder / "curves.obj"


def test_all_closed_polylines_of_a_file(tmp_path):
    loops = [ring(3.0, (1, 2, 3), 7), ring(1.0, (0, 0, 5), 5)]
    found = read_curves(obj(tmp_path, *loops))
    assert len(found) == 2
    for line, loop in zip(found, loops, strict=True):
        again = line if np.allclose(line[1], loop[1]) else np.roll(line[::-1], 1, axis=0)
        assert_allclose(again, loop, rtol=0, atol=1e-12)


def test_a_curve_whose_up_is_y(tmp_path):
    file = obj(tmp_path, ring(3.0, (1, 2, 5), 9))
    (points,), (turned,) = read_curves(file), read_curves(file, up="y")
    assert_allclose(turned, np.column_stack([points[:, 0], -points[:, 2], points[:, 1]]))
    assert_allclose(points[:, 2], 5.0)


def test_a_curve_whose_last_point_repeats_the_first(tmp_path):
    (tmp_path / "closed.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 0\ng a\nl 1 2 3 4\n")
    (loop,) = read_curves(tmp_path / "closed.obj")
    assert_allclose(loop, [[0, 0, 0], [1, 0, 0], [1, 1, 0]])


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("l 1 2 3", "no closed polyline .* Its vertex 0 has 1 segments"),
        ("l 1 2 3 1\nl 4 5 6", "no closed polyline .* Its vertex 3 has 1 segments"),
        ("f 1 2 3", "no closed polyline"),
        ("l 1 2 9", r"line 7: there is no vertex 9"),
    ],
)
def test_curves_that_are_none(tmp_path, lines, message):
    (tmp_path / "bad.obj").write_text("".join(f"v {k} {k * k} 0\n" for k in range(6)) + lines + "\n")
    with pytest.raises(JobError, match=message):
        read_curves(tmp_path / "bad.obj")
