"""The volume in reports: exact caps, the sign, holes, and the same number as a fit to a volume."""

from __future__ import annotations

import numpy as np
import pytest

from solver import fit_outline, report, shapes
from solver.domain.domain import Domain
from solver.measure.volume import sheet_volume, volume_over

UP = np.array([0.0, 0.0, 1.0])


def cap(radius: float, rim: float):
    """A disc lifted to a cap of the sphere around (0, 0, 7)."""
    disc = shapes.disc(4000)
    xy = rim * disc.positions
    z = 7.0 + np.sqrt(radius**2 - (xy**2).sum(axis=1))
    return disc.domain, np.column_stack([xy, z])


def test_a_cap_whatever_its_direction_and_its_height():
    domain, points = cap(5.0, 3.0)
    exact = np.pi * (5.0 - 4.0) ** 2 * (3 * 5.0 - 1.0) / 3.0
    assert sheet_volume(domain, points, domain.faces, UP) == pytest.approx(exact, rel=3e-3)
    assert sheet_volume(domain, points, domain.faces, -UP) == pytest.approx(-exact, rel=3e-3)
    turned = sheet_volume(domain, np.roll(points, 1, axis=1), domain.faces, np.roll(UP, 1))
    assert turned == pytest.approx(exact, rel=3e-3)


def test_the_level_is_that_of_the_outer_rim():
    """A flat ring whose hole stands on a higher rim."""
    ring = shapes.annulus(0.5, 1.0, 600)
    r = np.linalg.norm(ring.positions, axis=1)
    points = np.column_stack([ring.positions, 1.0 - r])
    exact = np.pi * ((1 - 0.25) - 2 / 3 * (1 - 0.125))
    assert sheet_volume(ring.domain, points, ring.domain.faces, UP) == pytest.approx(exact, rel=1e-2)


def test_a_closed_surface_has_the_volume_inside():
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], dtype=np.int32)
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) + 50.0
    domain = Domain.from_positions(points, faces)
    assert sheet_volume(domain, points, faces, UP) == pytest.approx(1 / 6, rel=1e-9)
    assert abs(volume_over(points, faces, UP)) == pytest.approx(1 / 6, rel=1e-9)


def test_a_fit_to_a_volume_reports_it():
    disc = shapes.disc(400)
    found = fit_outline(disc.domain, np.column_stack([disc.positions, np.full(len(disc.positions), 3.0)]), volume=1.2)
    assert found.is_met, found.message
    assert report(found.surface, intersections=False).shown.volume == pytest.approx(1.2, rel=5e-3)
