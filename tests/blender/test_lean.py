"""The lean of the rim on plans that curve: against the horizon, or against the drawn surface."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from .scenes import activate, mesh_object, values
from .solved_plans import solved


def dome(degrees: float, rows: int = 12, columns: int = 36, radius: float = 6.0):
    """A cap of a sphere up to this angle from its pole; the last `columns` vertices are its rim."""
    theta, phi = np.radians(degrees) * np.arange(1, rows + 1) / rows, 2 * np.pi * np.arange(columns) / columns
    points = [(0.0, 0.0, radius)]
    points += [tuple(radius * np.array([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)]))
               for t in theta for p in phi]
    around = [(j, (j + 1) % columns) for j in range(columns)]
    faces = [(0, 1 + j, 1 + k) for j, k in around]
    faces += [tuple(1 + i * columns + v for v in (j, columns + j, columns + k, k))
              for i in range(rows - 1) for j, k in around]
    return mesh_object("Dome", points, faces)


def rim_normals(plan) -> np.ndarray:
    return np.array(values(plan.cmc.f_plus.data.attributes["cmc_normal"]))[-36:]


@pytest.mark.parametrize("degrees", [30, 60, 90])
def test_the_rim_over_a_drawn_cap_stands_upright(degrees):
    plan = dome(degrees)
    solved(plan)
    assert_allclose(rim_normals(plan)[:, 2], 0.0, rtol=0, atol=1e-6)


def test_against_the_drawn_surface_it_is_at_right_angles_to_its_faces():
    plan = dome(60)
    plan.cmc.against = "SURFACE"
    solved(plan)
    assert rim_normals(plan)[:, 2].mean() == pytest.approx(-np.sin(np.radians(57.5)), abs=5e-3)  # of the last row


def test_the_overlay_shows_the_normals_of_the_solve(addon):
    """Beyond a hemisphere the faces along the rim look down, and the whole plan looks up."""
    from cmc_formfinding.cmc_addon.drawing.rim import Drawn, Leaning, prescribed_rim

    plan = dome(120)
    mesh = addon.cmc_addon.bridges.mesh_bridge.read_plan(activate(plan) or plan)
    for against in ("horizon", "surface"):
        plan.cmc.against = against.upper()
        solved(plan)
        rim = prescribed_rim(Drawn.of(mesh, ()), (), Leaning(against=against))
        (walk,) = rim.walks
        order = np.argmin(np.linalg.norm(walk.points[:-1, None] - mesh.positions[-36:], axis=2), axis=1)
        assert_allclose(walk.normals[:-1], rim_normals(plan)[order], rtol=0, atol=1e-6)
