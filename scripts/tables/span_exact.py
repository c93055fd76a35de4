"""Exact surfaces of constant mean curvature, spanned from wrong parametrisations, for `measure_spans`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from solver import Shape, Span, shapes, span_outline
from tests.solver.exact_surfaces import disc
from tests.solver.spanned_plans import catenoid, enneper, quarter_disc, raised, ring

Array = NDArray[np.float64]
TURN = 2.0 * np.pi * np.arange(300) / 300
CIRCLE = np.column_stack([np.cos(TURN), np.sin(TURN), 0.0 * TURN])
# Clockwise, from anywhere, three times as dense on one side.
CROWDED = np.column_stack([np.cos(1.3 - TURN - 0.5 * np.sin(TURN)), np.sin(1.3 - TURN - 0.5 * np.sin(TURN)), 0 * TURN])
HALF_SPHERE = 2.0 * np.pi / 3.0
ZONE = 0.93165455511  # of a sphere through circles of radius 1 and 0.6 at the heights 0 and 0.5

@dataclass(frozen=True)
class Exact:
    """A surface that is known: span(n) with about n vertices, and the distances (V,) of its points from the surface.

    bar: the largest distance that is wanted at the last size, if one is. sizes: n.
    """

    name: str
    span: Callable[[int], Span]
    off: Callable[[Array], Array]
    bar: float | None = None
    sizes: tuple[int, ...] = (500, 2000, 8000)


def from_sphere(centre: float, radius: float) -> Callable[[Array], Array]:
    return lambda points: np.abs(np.linalg.norm(points - [0.0, 0.0, centre], axis=1) - radius)


def cap(H: float, bar: float | None = None) -> Exact:
    def span(n: int) -> Span:
        return span_outline(*disc(n), CROWDED, mean_curvature=H)

    return Exact(f"cap, H R = {H:g}", span, from_sphere(-np.sqrt(1.0 / H**2 - 1.0), 1.0 / H), bar)


def cap_of_volume(part: float, bar: float | None = None) -> Exact:
    """Of this number of half spheres."""
    roots = np.roots([np.pi / 6.0, 0.0, np.pi / 2.0, -part * HALF_SPHERE])
    height = float(roots[np.abs(roots.imag) < 1e-9].real[0])
    radius = (1.0 + height**2) / (2.0 * height)

    def span(n: int) -> Span:
        return span_outline(*disc(n), CROWDED, volume=part * HALF_SPHERE)

    return Exact(f"cap of {part:g} half spheres", span, from_sphere(height - radius, radius), bar)


def enneper_surface(radius: float, bar: float | None = None) -> Exact:
    def span(n: int) -> Span:
        return span_outline(*disc(n), enneper(radius * np.exp(1j * (0.3 - TURN))))

    return Exact(f"Enneper, r = {radius:g}", span, from_enneper, bar)


def from_enneper(points: Array) -> Array:
    """Differences (V,) in height, at the same place seen from above."""
    w = points[:, 0] + 1j * points[:, 1]
    z = w
    for _ in range(200):
        z = w + np.conj(z) ** 3 / 3
    return np.abs((z**2).real - points[:, 2])


def catenoid_between_circles(height: float, bar: float | None = None) -> Exact:
    waist, middle = catenoid(height, 0.6)

    def span(n: int) -> Span:
        domain, points = ring(n, 0.6)
        return span_outline(domain, raised(domain, points, height))

    return Exact(f"catenoid 1 → 0.6, height {height:g}", span, from_catenoid(waist, middle), bar)


def from_catenoid(waist: float, middle: float) -> Callable[[Array], Array]:
    def off(points: Array) -> Array:
        along = (points[:, 2] - middle) / waist
        return np.abs(np.linalg.norm(points[:, :2], axis=1) / np.cosh(along) - waist)

    return off


def zone(bar: float | None = None) -> Exact:
    def span(n: int) -> Span:
        domain, points = ring(n, 0.6)
        return span_outline(domain, raised(domain, points, 0.5), mean_curvature=ZONE)

    return Exact("zone of a sphere", span, from_sphere(-0.39, float(np.hypot(1.0, 0.39))), bar)


def unduloid(bar: float | None = None) -> Exact:
    """ψ'² = sin² ψ - 0.4, r = sin ψ - ψ', z = ∫ sin² ψ + cos ψ (the paper's f+), over a ring drawn with 0.5 for 1/e."""
    way = solve_ivp(
        lambda _, y: [y[1], np.sin(y[0]) * np.cos(y[0]), np.sin(y[0]) ** 2],
        (0, 1),
        [0.5 * np.pi, -np.sqrt(0.6), 0.0],
        dense_output=True,
        rtol=1e-11,
        atol=1e-12,
    )
    psi, slope, along = way.sol(np.linspace(0, 1, 4000))
    radius, height = np.sin(psi) - slope, along + np.cos(psi)

    def span(n: int) -> Span:
        domain, points = ring(n, 0.5)
        ends = [0 if np.linalg.norm(points[loop[0]]) > 0.9 else -1 for loop in domain.boundary_loops]
        lines = [CIRCLE * [radius[k], radius[k], 0] + [0, 0, height[k]] for k in ends]
        return span_outline(domain, points, lines, mean_curvature=0.5)

    def off(points: Array) -> Array:
        return np.abs(np.linalg.norm(points[:, :2], axis=1) - np.interp(points[:, 2], height, radius))

    return Exact("band of an unduloid", span, off, bar)


def walls(plan: Shape) -> list[tuple[Any, list[float]]]:
    """Mirrors along x and y of a piece in the first quadrant."""
    return [(plan.sides["side0"], [0, 1, 0]), (plan.sides[list(plan.sides)[-1]], [1, 0, 0])]


def on_circle(plan: Shape) -> Array:
    """The positions of a quarter disc, whose arc is drawn with few segments, its rim moved onto the circle."""
    radius = np.linalg.norm(plan.positions, axis=1)
    return plan.positions / np.where(radius > 0.99, radius, 1.0)[:, None]


def quarter_cap(bar: float | None = None) -> Exact:
    def span(n: int) -> Span:
        plan = quarter_disc(n)
        return span_outline(plan.domain, on_circle(plan), mean_curvature=0.8, mirrors=walls(plan))

    return Exact("quarter of a cap, H R = 0.8", span, from_sphere(-0.75, 1.25), bar, (350, 1300, 5000))


def quarter_enneper(bar: float | None = None) -> Exact:
    def span(n: int) -> Span:
        plan = quarter_disc(n)
        line = enneper(0.9 * (on_circle(plan) @ [1.0, 1.0j]))
        return span_outline(plan.domain, line, mirrors=walls(plan))

    return Exact("quarter of Enneper, r = 0.9", span, from_enneper, bar, (350, 1300, 5000))


def quarter_scherk(bar: float | None = None) -> Exact:
    def span(n: int) -> Span:
        plan = shapes.polygon([[0, 0], [1.2, 0], [1.2, 1.2], [0, 1.2]], max_edge=1.2 * np.sqrt(1.15 / n))
        x, y = plan.positions.T
        line = np.column_stack([x, y, np.log(np.cos(x) / np.cos(y))])
        return span_outline(plan.domain, line, mirrors=walls(plan))

    def off(points: Array) -> Array:
        x, y, z = points.T
        return np.abs(np.log(np.cos(x) / np.cos(y)) - z)

    return Exact("Scherk's piece between planes", span, off, bar, (350, 1300, 5000))


def strip_of_catenoid(bar: float | None = None) -> Exact:
    """A quarter of a catenoid's upper half, over a strip of the length 1.1 for 0.7486."""

    def span(n: int) -> Span:
        strip = np.array([[0.0, 0.0], [0.5 * np.pi, 0.0], [0.5 * np.pi, 1.1], [0.0, 1.1]])
        plan = shapes.polygon(strip, max_edge=1.4 / np.sqrt(n))
        t, s = plan.positions.T * [[1.0], [0.7486 / 1.1]]
        line = np.column_stack([np.cosh(s) * np.cos(t), np.cosh(s) * np.sin(t), s])
        x, y, z = np.eye(3)
        sides = [(plan.sides["side0"], z), (plan.sides["side1"], x), (plan.sides["side3"], y)]
        return span_outline(plan.domain, line, mirrors=sides)

    return Exact("quarter of a catenoid, from a strip", span, from_catenoid(1.0, 0.0), bar, (350, 1300, 5000))


# Bars: one and a half times the errors of a prototype of the method.
EXACT = [
    cap(0.1),
    cap(0.5),
    cap(0.8, 2.3e-4),
    cap(0.95),
    cap_of_volume(1.0),
    cap_of_volume(1.5),
    enneper_surface(0.9),
    catenoid_between_circles(0.4, 9.8e-5),
    catenoid_between_circles(0.7, 7.8e-4),
    zone(1.4e-4),
    unduloid(),
    quarter_cap(8.1e-5),
    quarter_enneper(5.3e-5),
    quarter_scherk(8.0e-5),
    strip_of_catenoid(3.2e-5),
]
