"""The tables of docs/measured/approximation.md, measured: the distance of CMC surfaces from given ones.

    make gallery                                            # measures, writes the tables, draws the pictures
    .venv/bin/python -m scripts.tables.measure_approximation cmc   # some of them, printed only
    .venv/bin/python -m scripts.tables.measure_approximation --write

Needs no Blender.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from scripts.assets import surfaces
from scripts.tables.measure_fits import seconds
from scripts.tables.measured_page import Tables, measure
from solver import CmcSolver, Domain, Fit, conditions, conformal_distortion, fit_gauss_map, mean_curvature_of, shapes
from solver.fitting.closest_point import Triangles
from tests.solver.exact_surfaces import rates
from tests.solver.fitting.test_gauss_map_fit import SADDLES, cap, off, over_the_disc, size_of, unduloid

ROOT = Path(__file__).resolve().parents[2]

PAGE = ROOT / "docs" / "measured" / "approximation.md"
WEIGHTS = (1e-4, 1e-3, 1e-2)
LARGE = 20000


def drawn(make, count: int) -> tuple[Domain, np.ndarray]:
    disc = shapes.disc(count)
    given = make(disc.positions, disc.domain.faces)
    return Domain.from_positions(given.points, given.faces), given.points


def spread_of_curvature(fit: Fit) -> float:
    """Root mean square over the area of H / target - 1, measured."""
    points, faces = fit.points(), fit.surface.faces
    H = fit.sign * mean_curvature_of(points, faces, fit.surface.normals)
    a, b, c = (points[faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) * np.isfinite(H)
    return float(np.sqrt(np.average((np.nan_to_num(H) / fit.surface.mean_curvature - 1) ** 2, weights=areas)))


def distortion(domain: Domain, fit: Fit) -> tuple[float, float]:
    """½ (Q + 1/Q) - 1: the mean over the given surface, and the largest."""
    Q = conformal_distortion(domain, fit.points())
    energy = 0.5 * (Q + 1 / Q) - 1
    return float(np.average(energy, weights=domain.face_areas)), float(energy.max())


def distances(domain: Domain, points: np.ndarray, fit: Fit) -> tuple[float, float, float]:
    """Distances from the given surface in % of its diagonal: root mean square, largest, largest along the rim."""
    away = 100 * Triangles(points, domain.faces).closest(fit.points()).distances / size_of(points)
    mean = np.sqrt(np.average(away**2, weights=domain.vertex_areas))
    return float(mean), float(away.max()), float(away[domain.boundary_vertices].max())


def figure10() -> list[str]:
    """The wavy disc for three weights, and by the paper's functional."""
    domain, points = drawn(surfaces.wavy_disc, LARGE)
    rows = [
        "| λ | likeness | N - N_φ | variation of N₀ | H, deviation | distortion | largest | distance, mean | largest "
        "| evaluations |",
        "|---" * 10 + "|",
    ]
    for likeness in (0.1, 0.0):
        for weight in WEIGHTS:
            fit = fit_gauss_map(domain, points, weight, likeness=likeness)
            mean, most = distortion(domain, fit)
            near, far, _ = distances(domain, points, fit)
            rows.append(
                f"| {weight:g} | {likeness:g} | {fit.distances['Gauss map']:.3f} "
                f"| {fit.distances['smooth rim']:.2f} | {100 * spread_of_curvature(fit):.2f} % | {mean:.0e} "
                f"| {most:.0e} | {near:.1f} % | {far:.1f} % | {len(fit.history)} |"
            )
    return rows


def cmc() -> list[str]:
    """Surfaces of constant mean curvature: the distance of their approximations, λ = 0."""
    sizes = (200, 800, 3200, 12800)
    rows = [f"| surface | {' | '.join(str(n) for n in sizes)} | order |", "|---" * (len(sizes) + 2) + "|"]
    for name, make in (("cap of a sphere", cap), ("patch of an unduloid", unduloid)):
        misses = []
        for count in sizes:
            domain, points = make(count)
            misses.append(100 * off(domain, fit_gauss_map(domain, points, 0.0).points(), points))
        cells = " | ".join(f"{miss:.4f} %" for miss in misses)
        rows.append(f"| {name} | {cells} | {rates(misses).mean():.1f} |")
    return rows


def catenoid(count: int) -> tuple[Domain, np.ndarray]:
    """Between circles of radius 1 and ½."""
    ring = shapes.annulus(0.5, 1.0, count)
    x, y = ring.positions.T
    points = np.column_stack([x, y, -0.45 * np.arccosh(np.hypot(x, y) / 0.45)])
    return Domain.from_positions(points, ring.domain.faces), points


def over_the_square(count: int, height) -> tuple[Domain, np.ndarray]:
    shape = shapes.polygon([[-1, -1], [1, -1], [1, 1], [-1, 1]], max_edge=float(np.sqrt(4 / count * 2 / np.sqrt(3))))
    x, y = shape.positions.T
    points = np.column_stack([x, y, height(x, y)])
    return Domain.from_positions(points, shape.domain.faces), points


def scherk(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.log(np.cos(1.2 * y) / np.cos(1.2 * x)) / 1.2


def saddles() -> list[str]:
    """Surfaces whose mean curvature is nearly zero or changes sign."""
    rows = [
        "| surface | N - N_φ | distance, mean | largest | largest of the rim | H × diagonal | steps | time |",
        "|---" * 8 + "|",
    ]
    given = {name: over_the_disc(2000, height) for name, height in SADDLES.items()}
    given["hypar over a square"] = over_the_square(2000, lambda x, y: 0.5 * x * y)
    given["Scherk's over a square"] = over_the_square(2000, scherk)
    given["catenoid, 1 to ½"] = catenoid(2000)
    for name, (domain, points) in given.items():
        fit = fit_gauss_map(domain, points, 1e-4)
        ratio = seconds(lambda d=domain, p=points: fit_gauss_map(Domain.from_positions(p, d.faces), p, 1e-4)) / seconds(
            lambda d=domain, p=points: cold(d, p)
        )
        near, most, rim = distances(domain, points, fit)
        H = fit.sign * fit.surface.mean_curvature * size_of(points)
        rows.append(
            f"| {name} | {fit.distances['Gauss map']:.3f} | {near:.2f} % | {most:.2f} % | {rim:.3f} % | {H:.2f} "
            f"| {len(fit.history)} | {ratio:.0f} × |"
        )
    return rows


def cold(domain: Domain, points: np.ndarray) -> None:
    """One solve from nothing."""
    domain = Domain.from_positions(points, domain.faces)
    CmcSolver(domain).solve(conditions.gauss_map(domain, points, domain.boundary_edges))


def places() -> list[str]:
    """The effect of the weight of nearness."""
    rows = [
        "| surface | near | N - N_φ | distance, mean | largest | largest of the rim | H, deviation | evaluations |",
        "|---" * 8 + "|",
    ]
    for name, make in (("wavy disc", surfaces.wavy_disc), ("cultural centre", surfaces.cultural_centre)):
        domain, points = drawn(make, 5000)
        for weight in (0.0, 10.0, 100.0, 1000.0):
            fit = fit_gauss_map(domain, points, 1e-4, near=weight)
            mean, most, rim = distances(domain, points, fit)
            rows.append(
                f"| {name} | {weight:g} | {fit.distances['Gauss map']:.3f} | {mean:.2f} % | {most:.2f} % "
                f"| {rim:.2f} % | {100 * spread_of_curvature(fit):.1f} % | {len(fit.history)} |"
            )
    return rows


TABLES: Tables = {"figure10": figure10, "cmc": cmc, "saddles": saddles, "places": places}


if __name__ == "__main__":
    measure(PAGE, TABLES)
