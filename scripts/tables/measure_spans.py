"""The tables of docs/measured/spanning.md, measured: surfaces through lines, against exact ones and their own checks.

    make gallery                                        # measures, writes the tables, draws the pictures
    .venv/bin/python -m scripts.tables.measure_spans necks   # some of them, printed only
    .venv/bin/python -m scripts.tables.measure_spans --write # all of them, into the page; a quarter of an hour

Needs no Blender.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scripts.tables.measure_fits import cold, seconds
from scripts.tables.measured_page import Tables, measure
from scripts.tables.span_cases import LEANS, Drawn, Leaning, plans, random_line
from scripts.tables.span_exact import EXACT, Exact
from solver import CmcError, Domain, Shape, Span, mean_curvature_of, span_outline
from solver.fitting.curves import Curve
from solver.measure.arrays import face_areas_in_space
from tests.solver.spanned_plans import catenoid, inside_curvature, raised, ring

PAGE = Path(__file__).resolve().parents[2] / "docs" / "measured" / "spanning.md"
Array = NDArray[np.float64]

COUNT = 2000
RISES = (0.05, 0.15, 0.25, 0.35, 0.45)
PARTS = (-0.9, -0.5, 0.0, 0.5, 0.9)
STEPS = 41
SEEDS = 200
# What leans may take, in cold solves, by their steepest angle; how far they may be off at the larger size, degrees.
QUICK, SLOW = 6.0, 10.0
LEAN = 0.5
# Far beyond the largest mean curvature of any line here, times the extent of the line.
BEYOND = 16.0


def ruled(*cells: str) -> list[str]:
    """The first two lines of a table."""
    return [row(*cells), "|---" * len(cells) + "|"]


def row(*cells: object) -> str:
    return f"| {' | '.join(map(str, cells))} |"


# --- exact surfaces --------------------------------------------------------------------------------------------------


def exact() -> list[str]:
    """Largest distance from the surface at three sizes, with rates; in the mean square, its rate."""
    rows = ruled("surface", "vertices", "largest distance", "rate", "mean square", "rate", "wanted", "back-solves")
    return rows + [exact_row(case) for case in EXACT]


def exact_row(case: Exact) -> str:
    largest, mean, counts = [], [], []
    for n in case.sizes:
        span = case.span(n)
        assert span.ok, span.message
        off, areas = case.off(span.points), span.domain.vertex_areas
        largest.append(float(off.max()))
        mean.append(float(np.sqrt(areas @ off**2 / areas.sum())))
        counts.append(len(span.points))
    wanted = "" if case.bar is None else f"{case.bar:.1e}{'' if largest[-1] <= case.bar else ', missed'}"
    cells = [", ".join(f"{value:.1e}" for value in values) for values in (largest, mean)]
    rates = [f"{rate(values, counts):.2f}" for values in (largest, mean)]
    rates[0] += "" if rate(largest, counts) >= 1.7 else ", missed"
    sizes = ", ".join(str(count) for count in counts)
    return row(case.name, sizes, cells[0], rates[0], cells[1], rates[1], wanted, span.history[-1].solves)


def rate(errors: list[float], counts: list[int]) -> float:
    """Order in the edge length, from the first to the last size."""
    return float(2.0 * np.log(errors[0] / errors[-1]) / np.log(counts[-1] / counts[0]))


# --- eight plans -----------------------------------------------------------------------------------------------------


def rises() -> list[str]:
    """H off by the balance of the area, by the normals inside, and distortion; and how far rims are off their lines."""
    wishes = [{"rise": rise} for rise in RISES]
    return plan_rows([f"rise {100 * rise:.0f} %" for rise in RISES], lambda _: wishes)


def curvatures() -> list[str]:
    """The same, at parts of the turning value."""
    return plan_rows([f"{part:g}" for part in PARTS], lambda drawn: turning_wishes(drawn, PARTS))


def turning_wishes(drawn: Drawn, parts: tuple[float, ...]) -> list[dict[str, float]]:
    turns = {up: largest(drawn, up) for up in (-1.0, 1.0)}
    return [{"mean_curvature": part * turns[float(np.copysign(1.0, part))]} for part in parts]


def largest(drawn: Drawn, up: float = 1.0) -> float:
    """The turning value of |H| of domes (up = 1) or of hanging surfaces."""
    beyond = BEYOND / float(np.ptp(drawn.points[:, :2], axis=0).min())
    return abs(span_outline(drawn.plan, drawn.points, mean_curvature=up * beyond).mean_curvature)


def plan_rows(labels: list[str], wishes: Callable[[Drawn], list[dict[str, float]]]) -> list[str]:
    rows = ruled("plan", "vertices", *labels, "rim off")
    for drawn in plans(COUNT):
        cells, off = [], []
        for wish in wishes(drawn):
            try:
                span = span_outline(drawn.plan, drawn.points, **wish)
            except CmcError:
                cells.append("refused")
                continue
            cells.append(plan_cell(span))
            off.append(rim_off(span, drawn) / drawn.size)
        rows.append(row(drawn.name, len(drawn.points), *cells, f"{max(off):.0e}" if off else ""))
    return rows


def plan_cell(span: Span) -> str:
    if not span.ok:
        return span.status.value
    checks = span.checks
    by_area = abs(checks.mean_curvature - checks.multiplier) / checks.curvature_scale
    by_normals = abs(inside_mean(span) - checks.multiplier) / checks.curvature_scale
    return f"{100 * by_area:.2f}, {100 * by_normals:.2f} %, {checks.distortion:.0e}"


def inside_mean(span: Span) -> float:
    """The mean of H by the normals over the faces that do not touch the rim."""
    H, areas = mean_curvature_of(span.points, span.faces, span.normals), face_areas_in_space(span.points, span.faces)
    inside = ~np.isin(span.faces, span.domain.boundary_vertices).any(axis=1)
    return float(areas[inside] @ H[inside] / areas[inside].sum())


def rim_off(span: Span, drawn: Drawn) -> float:
    """The largest distance of a rim vertex from the exact lines."""
    rim = span.points[span.domain.boundary_vertices]
    off = [np.linalg.norm(Curve(line, closed=True).closest(rim).points - rim, axis=1) for line in drawn.lines]
    return float(np.min(off, axis=0).max())


# --- sides that lean -------------------------------------------------------------------------------------------------


def leans() -> list[str]:
    """Each case at two sizes."""
    rows = ruled(
        "plan and sides",
        "vertices",
        "angles asked",
        "off: median, worst",
        "heights",
        "H, by area, by normals",
        "crossings",
        "upright",
        "back-solves",
        "cold solves",
    )
    return rows + [lean_row(case, count) for case in LEANS for count in (1600, 6000)]


def lean_row(case: Leaning, count: int) -> str:
    plan = case.plan(count)
    points = case.raised(plan.positions)
    sides = [(side, np.radians(angle)) for side, angle in case.leans]
    asked = ", ".join(f"{angle:g}°" for _, angle in case.leans)
    found: list[Span] = []

    def work() -> None:
        domain = Domain.from_positions(points, plan.domain.faces)
        edges = [(plan.sides[side], angle) for side, angle in sides]
        found.append(span_outline(domain, points, rise=case.rise, leans=edges))

    try:
        time = seconds(work) / cold(Shape(Domain.from_positions(points, plan.domain.faces), points, plan.sides))
    except CmcError as error:
        return row(case.name, len(points), asked, f"refused: {error}", *[""] * 6)
    span = found[-1]
    if not span.ok:
        return row(case.name, len(points), asked, span.status.value, *[""] * 6)
    checks = span.checks
    off = "; ".join(
        f"{abs(np.degrees(lean.measured - lean.asked)):.2f}°, {np.degrees(lean.off):.1f}°" for lean in checks.leans
    )
    heights = "; ".join(f"{lean.lowest:.2f} … {lean.highest:.2f}" for lean in checks.leans)
    H = f"{span.mean_curvature:.4f}, {checks.mean_curvature:.4f}, {np.median(inside_curvature(span)):.4f}"
    steepest = min(angle for _, angle in case.leans)
    if count > COUNT and steepest >= 35 and max(lean.off for lean in checks.leans) > np.radians(LEAN):
        off += ", missed"
    cost = f"{time:.1f}{', missed' if time > (QUICK if steepest >= 45 else SLOW) else ''}"
    stands = len(span.kept.upright)
    solves = span.history[-1].solves
    return row(case.name, len(points), asked, off, heights, H, checks.crossings, stands, solves, cost)


# --- necks, a slider, random lines -----------------------------------------------------------------------------------


def necks() -> list[str]:
    """Circles of radius 1 and 0.6: the waist, or the sentence."""
    rows = ruled("height", "waist of the catenoid", "1,000 vertices", "2,000 vertices", "4,000 vertices")
    for height in (0.9, 1.0, 1.05, 1.3):
        cells = []
        for count in (1000, 2000, 4000):
            domain, points = ring(count, 0.6)
            span = span_outline(domain, raised(domain, points, height))
            waist = float(np.linalg.norm(span.points[:, :2], axis=1).min())
            cells.append(f"{waist:.4f}, D / area - 1 {span.checks.distortion:.0e}" if span.ok else neck_cell(span))
        rows.append(row(f"{height:g}", f"{catenoid(height, 0.6)[0]:.4f}" if height < 1.01 else "none", *cells))
    return rows


def neck_cell(span: Span) -> str:
    return "refused: the neck closes" if "neck between them closes" in span.message else span.status.value


def slider() -> list[str]:
    """H from -1/R to 1/R, R the radius of the sphere around the line, each span from the last."""
    rows = ruled(
        "line", "vertices", "1/R by the largest H", "failures", "largest step by the median one", "back-solves a step"
    )
    for drawn in plans(COUNT):
        if drawn.plan.domain.boundary_loops[1:]:
            continue
        top = 1.0 / enclosing_radius(drawn.points[drawn.plan.domain.boundary_vertices])
        spans: list[Span] = []
        for H in np.linspace(-top, top, STEPS).tolist():
            before = spans[-1] if spans and spans[-1].ok else None
            spans.append(span_outline(drawn.plan, drawn.points, mean_curvature=H, initial=before))
        failures = sum(not span.ok for span in spans)
        moves = [float(np.linalg.norm(b.points - a.points, axis=1).max()) for a, b in pairwise(spans)]
        ratio = max(moves) / float(np.median(moves))
        share = top / largest(drawn)
        solves = float(np.median([span.history[-1].solves for span in spans[1:]]))
        rows.append(row(drawn.name, len(drawn.points), f"{share:.2f}", failures, f"{ratio:.1f}", f"{solves:.0f}"))
    return rows


def enclosing_radius(points: Array) -> float:
    """Of the smallest ball around points (n, 3), to a thousandth: a centre that walks to the farthest point
    (Badoiu and Clarkson)."""
    centre = points.mean(axis=0)
    for k in range(1, 4000):
        centre = centre + (points[np.linalg.norm(points - centre, axis=1).argmax()] - centre) / (k + 1.0)
    return float(np.linalg.norm(points - centre, axis=1).max())


def random_lines() -> list[str]:
    """How many of random lines have a surface at H = 0 and at half of the turning value, and what the others say."""
    rows = ruled("H", "lines", "solved", "with warnings", "distortion: median, largest", "the others")
    found: dict[str, list[Span]] = {"0": [], "half of the turning value": []}
    for seed in range(SEEDS):
        drawn = random_line(seed)
        half = 0.5 * largest(drawn)
        for name, H in zip(found, (0.0, half), strict=True):
            found[name].append(span_outline(drawn.plan, drawn.points, mean_curvature=H))
    for name, spans in found.items():
        solved = [span for span in spans if span.ok]
        off = [span.checks.distortion for span in solved]
        said = sorted({span.message for span in spans if not span.ok})
        warned = sum(bool(span.warnings) for span in solved)
        spread = f"{np.median(off):.0e}, {max(off):.0e}"
        rows.append(row(name, len(spans), len(solved), warned, spread, "; ".join(said) or "none"))
    return rows


TABLES: Tables = {
    "exact": exact,
    "rises": rises,
    "curvatures": curvatures,
    "leans": leans,
    "necks": necks,
    "slider": slider,
    "random_lines": random_lines,
}


if __name__ == "__main__":
    measure(PAGE, TABLES)
