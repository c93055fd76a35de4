"""The time of a surface through a line, as a multiple of one cold solve of the same plan in the same run.

`make bench` prints the ratios; rounds are interleaved and the median is quoted, as in bench_solve.py.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from benchmarks.bench_fit import OUTLINES, VERTICES
from benchmarks.bench_solve import ratios
from solver import CmcSolver, Domain, Shape, Span, conditions, shapes, span_outline

# By the number that chooses the surface; volumes in those of half a sphere over a circle of the plan's area.
CHOICES = [("mean_curvature", 0.0), ("mean_curvature", 0.6), ("volume", 0.5), ("volume", 1.5), ("rise", 0.45)]
# Steps of a slider, from one number to the next.
WARM = [("mean_curvature", 0.5, 0.55), ("rise", 0.3, 0.32), ("volume", 0.5, 0.55)]
LARGE = 46_000
HALL = ([[0, 0], [18, 0], [18, 12], [0, 12]], 1.5, 216.0)


def plan(outline: list[list[float]], radius: float, area: float, vertices: int) -> Shape:
    edge = np.sqrt(area / vertices * 2 / np.sqrt(3))
    return shapes.polygon(outline, max_edge=edge, corner_radius=radius)


def number(name: str, value: float, area: float) -> dict[str, float]:
    half_sphere = 2 / 3 * np.pi * (area / np.pi) ** 1.5
    return {name: value * half_sphere if name == "volume" else value}


def cold(shape: Shape) -> Callable[[], object]:
    """One solve of the same plan, from positions."""

    def solve() -> None:
        domain = Domain.from_positions(shape.positions, shape.domain.faces)
        CmcSolver(domain).solve(conditions.binormal(domain, shape.positions, domain.boundary_edges, 0.6))

    return solve


def spanned(shape: Shape, **wanted: object) -> Callable[[], Span]:
    """A span from positions; it has to be found."""

    def span() -> Span:
        domain = Domain.from_positions(shape.positions, shape.domain.faces)
        found = span_outline(domain, shape.positions, **wanted)
        assert found.ok, found.message
        return found

    return span


def moved(shape: Shape, first: dict[str, float], then: dict[str, float]) -> Callable[[], Span]:
    """A step of a slider: the span with the second number, from that with the first."""
    before = span_outline(shape.domain, shape.positions, **first)
    return lambda: span_outline(shape.domain, shape.positions, initial=before, **then)


def show(capsys: pytest.CaptureFixture[str], title: str, works: dict[str, Callable[[], object]], shape: Shape) -> None:
    solves = {label: span.history[-1].solves for label, work in works.items() if isinstance(span := work(), Span)}
    unit, measured = ratios(works, cold(shape))
    with capsys.disabled():
        print(f"\n{title}, {len(shape.positions)} vertices; one cold solve {unit:.3f} s")
        for label, ratio in measured.items():
            print(f"  {label:<34s} {ratio:5.1f} x, {solves[label]:4d} back-solves")


@pytest.mark.parametrize("corners", ["round", "sharp"])
@pytest.mark.parametrize("name", OUTLINES)
def test_a_surface_through_a_line(name, corners, capsys):
    outline, radius, area = OUTLINES[name]
    shape = plan(outline, radius if corners == "round" else 0.0, area, VERTICES)
    works = {f"{knob} {value:g}": spanned(shape, **number(knob, value, area)) for knob, value in CHOICES}
    for knob, first, then in WARM:
        works[f"{knob} {first:g} to {then:g}, from the last"] = moved(
            shape, number(knob, first, area), number(knob, then, area)
        )
    show(capsys, f"{name}, {corners} corners", works, shape)


@pytest.mark.parametrize("name", ["square", "rectangle 3 : 1"])
def test_large_plans(name, capsys):
    outline, radius, area = OUTLINES[name]
    shape = plan(outline, radius, area, LARGE)
    choices = [("mean_curvature", 0.6), ("volume", 0.5), ("rise", 0.45)]
    show(capsys, name, {f"{k} {value:g}": spanned(shape, **number(k, value, area)) for k, value in choices}, shape)


@pytest.mark.parametrize("vertices", [1_600, 6_000])
def test_a_side_leans(vertices, capsys):
    shape = plan(*HALL, vertices)
    ends = shape.positions[shape.domain.edges[shape.domain.boundary_edges]]
    sides = [shape.domain.boundary_edges[(np.abs(ends[:, :, 1] - y) < 1e-6).all(axis=1)] for y in (0.0, 12.0)]
    works = {}
    for angles in ([35], [45], [60], [85], [120], [60, 70]):
        leans = [(side, np.radians(angle)) for side, angle in zip(sides, angles, strict=False)]
        named = " and ".join(f"{angle}°" for angle in angles)
        works[f"lean {named}, rise 0.35"] = spanned(shape, rise=0.35, leans=leans)
    show(capsys, "hall", works, shape)
