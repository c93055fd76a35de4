"""Design by target: fits to the Gauss map of a surface."""

import numpy as np
import pytest

from solver import ConditionError, Domain, shapes
from solver.design import fit_gauss_map
from tests.solver.exact import rates


def test_a_cmc_surface_comes_back():
    """A cap of the sphere is CMC: its Gauss map is kept and it lies over itself, better the finer the mesh."""
    misses = []
    for n in (300, 1200, 4800):
        shape = shapes.disc(n)
        points = np.column_stack([shape.positions[:, :2], np.sqrt(2 - np.sum(shape.positions[:, :2] ** 2, axis=1))])
        found = fit_gauss_map(Domain.from_positions(points, shape.domain.faces), points, 0.0, max_evaluations=60)
        misses.append(np.sqrt(np.mean((found.points() - points) ** 2)))
        assert found.sheet == "f+" and found.sign == 1.0
    assert rates(misses).min() > 1.5
    bowl = fit_gauss_map(Domain.from_positions(points * [1, 1, -1], shape.domain.faces), points * [1, 1, -1], 0.0)
    assert bowl.sign == -1.0 and np.abs(bowl.points() - points * [1, 1, -1]).max() < 0.01


def test_boundary_normals_vary_less_the_larger_the_regularisation():
    shape = shapes.disc(800)
    x, y = shape.positions[:, :2].T
    points = np.column_stack([x, y, 0.25 * (1 - x**2 - y**2) + 0.06 * (x**4 - 6 * x**2 * y**2 + y**4)])
    domain = Domain.from_positions(points, shape.domain.faces)
    fits = [fit_gauss_map(domain, points, weight) for weight in (1e-4, 1e-3, 1e-2)]
    variation = [f.distances["smooth rim"] for f in fits]
    deviation = [f.distances["Gauss map"] for f in fits]
    assert variation == sorted(variation, reverse=True) and deviation == sorted(deviation)


def test_a_negative_regularisation_is_refused():
    shape = shapes.disc(100)
    with pytest.raises(ConditionError, match="regularisation"):
        fit_gauss_map(shape.domain, np.column_stack([shape.positions[:, :2], shape.positions[:, 0] ** 2]), -1.0)
