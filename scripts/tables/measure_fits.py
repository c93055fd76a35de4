"""The tables of docs/measured/fitting.md, measured: the distance of shells from an outline, and the work it takes.

Ratios are of processor time, to one cold solve of the same plan in the same run.

    make gallery                                       # measures, writes the tables, draws the pictures
    .venv/bin/python -m scripts.tables.measure_fits outlines  # some of them, printed only
    .venv/bin/python -m scripts.tables.measure_fits --write   # all of them, into the page

Needs no Blender.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scripts.tables.measured_page import Tables, measure
from scripts.tables.mixed_plans import MixedPlan, mixed_plans
from solver import (
    CmcSolver,
    ConditionError,
    Domain,
    Fit,
    Settings,
    Shell,
    conditions,
    fit_outline,
    form,
    mean_curvature_of,
    shapes,
)
from solver.fitting.curves import Curve
from solver.measure.intersections import self_intersections
from solver.shells.plan import plan_domain
from solver.shells.update import update
from tests.mixed_plans import MIXED_PLANS
from tests.solver.shells.test_mixed_plans import plan_of

ROOT = Path(__file__).resolve().parents[2]

Array = NDArray[np.float64]

PAGE = ROOT / "docs" / "measured" / "fitting.md"
RISES = (0.05, 0.15, 0.25, 0.35, 0.45)
SIZES = (2000, 5000, 20000)
# an outline, the radius of its corners, its area
OUTLINES = {
    "square": ([[0, 0], [2, 0], [2, 2], [0, 2]], 0.2, 4.0),
    "rectangle 3 : 1": ([[0, 0], [3, 0], [3, 1], [0, 1]], 0.3, 3.0),
    "L": ([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], 0.3, 3.0),
}
CIRCLE = np.linspace(0, 2 * np.pi, 200, endpoint=False)
HEAD = " | ".join(f"rise {100 * rise:.0f} %" for rise in RISES)


def plan(name: str, vertices: int) -> shapes.Shape:
    outline, radius, area = OUTLINES[name]
    edge = np.sqrt(area / vertices * 2 / np.sqrt(3))
    return shapes.polygon(outline, max_edge=edge, corner_radius=radius)


def seconds(work: Callable[[], object]) -> float:
    """Processor time; the least of three."""
    times = []
    for _ in range(3):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def cold(shape: shapes.Shape) -> float:
    """Processor time of one solve of a plan from nothing."""

    def solve() -> None:
        domain = Domain.from_positions(shape.positions, shape.domain.faces)
        CmcSolver(domain).solve(conditions.binormal(domain, shape.positions, domain.boundary_edges, 0.6))

    return seconds(solve)


def timed(shape: shapes.Shape, **goals: Any) -> tuple[Fit, float]:
    """A fit over the plan made from its positions, and its time in cold solves."""

    def work() -> Fit:
        return fit_outline(Domain.from_positions(shape.positions, shape.domain.faces), shape.positions, **goals)

    return work(), seconds(work) / cold(shape)


def work() -> list[str]:
    """Evaluations and time at about 5000 vertices: lines, and goals that start a search from them."""
    rows = [
        "| outline | lines, rise 5 % | rise 25 % | rise 45 % | tilts from 60°, heights free, rise 25 % "
        "| smoother rim, rise 25 % |",
        "|---" * 6 + "|",
    ]
    for name in OUTLINES:
        shape = plan(name, 5000)
        goals: list[dict[str, Any]] = [{"rise": rise} for rise in (0.05, 0.25, 0.45)]
        goals += [{"rise": 0.25, "free_heights": True, "tilt": np.radians([60, 90])}, {"rise": 0.25, "smooth": 1e-6}]
        fits = [timed(shape, **goal) for goal in goals]
        rows.append(f"| {name} | {' | '.join(f'{len(fit.history)}, {ratio:.1f} ×' for fit, ratio in fits)} |")
    return rows


def size_of(points: Array) -> float:
    return float(np.linalg.norm(np.ptp(points[:, :2], axis=0)))


def outlines() -> list[str]:
    """Largest distance between rim and drawn line, everywhere and away from the corners, in % of the span."""
    rows = [f"| outline | vertices | {HEAD} |", "|---|---|" + "---|" * len(RISES)]
    for name in OUTLINES:
        for vertices in SIZES:
            shape = plan(name, vertices)
            fits = [fit_outline(shape.domain, shape.positions, rise=rise) for rise in RISES]
            cells = [cell(name, shape.positions, fit) for fit in fits]
            rows.append(f"| {name} | {len(shape.positions)} | {' | '.join(cells)} |")
    return rows


def cell(name: str, points: Array, fit: Fit) -> str:
    size = size_of(points)
    far = 100 * fit.distances["rim on curve"] / size
    evaluations = len(fit.history)
    return f"{far:.2f}, {100 * away_from_corners(name, points, fit) / size:.2f} ({evaluations})"


def away_from_corners(name: str, points: Array, fit: Fit) -> float:
    """Largest distance of rim vertices from the line, more than two radii away from the sharp corners."""
    outline, radius, _ = OUTLINES[name]
    rim = fit.points()[fit.surface.domain.boundary_loops[0]]
    corners = np.array(outline, dtype=np.float64)
    near = np.linalg.norm(rim[:, None, :2] - corners, axis=2).min(axis=1) < 2 * radius
    line = points[fit.surface.domain.boundary_loops[0]]
    line = np.column_stack([line[:, :2], np.zeros(len(line))])
    off = np.linalg.norm(rim - Curve(line, closed=True).closest(rim).points, axis=1)
    return float(off[~near].max())


def height_parameters() -> list[str]:
    """Relative errors of height and volume, and for circles the distance from the spherical cap."""
    rows = [f"| goal | vertices | {HEAD} |", "|---|---|" + "---|" * len(RISES)]
    for name in OUTLINES:
        shape = plan(name, 5000)
        fits = [fit_outline(shape.domain, shape.positions, rise=rise) for rise in RISES]
        half = 0.5 * np.ptp(shape.positions, axis=0).min()
        cells = [f"{f.distances['crown height'] / (rise * half):.0e}" for f, rise in zip(fits, RISES, strict=True)]
        rows.append(f"| height, {name} | {len(shape.positions)} | {' | '.join(cells)} |")
    for vertices in (800, 3200, 12800):
        disc = shapes.disc(vertices)
        caps = [cap(disc, rise) for rise in RISES]
        label = f"| {{}} | {disc.domain.vertex_count} |"
        rows.append(f"{label.format('volume, circle')} {' | '.join(f'{c[0]:.0e}' for c in caps)} |")
        rows.append(f"{label.format('distance from the exact cap')} {' | '.join(f'{c[1]:.0e}' for c in caps)} |")
    return rows


def cap(disc: shapes.Shape, rise: float) -> tuple[float, float]:
    """Relative error of the volume, and the largest distance from the sphere over a disc of radius 1."""
    volume = np.pi * rise * (3 + rise**2) / 6
    fit = fit_outline(disc.domain, disc.positions, volume=volume)
    radius = (1 + rise**2) / (2 * rise)
    exact = fit_outline(disc.domain, disc.positions, rise=rise).points() - [0, 0, rise - radius]
    return fit.distances["volume"] / volume, float(np.abs(np.linalg.norm(exact, axis=1) - radius).max())


def raised() -> list[str]:
    """A circle whose heights rise and fall twice by 20 % of its span: distance in % of the span, or the reason."""
    line = np.column_stack([np.cos(CIRCLE), np.sin(CIRCLE), 0.2 * np.cos(2 * CIRCLE)])
    rows = [f"| vertices | {HEAD} |", "|---|" + "---|" * len(RISES)]
    for vertices in SIZES:
        disc = shapes.disc(vertices)
        cells = [raised_cell(disc, line, rise) for rise in RISES]
        rows.append(f"| {disc.domain.vertex_count} | {' | '.join(cells)} |")
    return rows


def raised_cell(disc: shapes.Shape, line: Array, rise: float) -> str:
    try:
        fit = fit_outline(disc.domain, disc.positions, line, rise=rise)
    except ConditionError:
        return "refused"
    return f"{50 * fit.distances['rim on curve']:.3f}{'' if fit.is_met else ', not met'}"


def courtyards() -> list[str]:
    """Plans with holes: largest distance of the rims from their lines in % of the span, and the steps."""
    circle = np.column_stack([np.cos(CIRCLE), np.sin(CIRCLE)])[::4]
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    plans = {
        "circle off the centre of a circle": shapes.polygon(circle, holes=[0.4 * circle + [0.15, 0.1]], max_edge=0.04),
        "square in a square": shapes.polygon(square, holes=[0.4 * square + 0.1], max_edge=0.05, corner_radius=0.15),
    }
    rises = (0.05, 0.15, 0.3, 0.45)
    rows = [
        f"| plan | vertices | {' | '.join(f'rise {100 * rise:g} %' for rise in rises)} |",
        "|---|---|" + "---|" * len(rises),
    ]
    for name, shape in plans.items():
        fits = [fit_outline(shape.domain, shape.positions, rise=rise) for rise in rises]
        size = size_of(shape.positions)
        cells = [f"{off(f, size):.3f} ({len(f.history)})" if f.is_met else f.message for f in fits]
        rows.append(f"| {name} | {len(shape.positions)} | {' | '.join(cells)} |")
    return rows


def off(fit: Fit, size: float) -> float:
    return 100 * fit.distances["rim on curve"] / size


def mixed() -> list[str]:
    """Lines along some sides, given normals along others: what each misses, and the work."""
    rows = [
        "| plan | vertices | lines off | over their line: off, angle | given normals off | their rim drifts "
        "| H, measured | crossings | evaluations, time |",
        "|---" * 9 + "|",
    ]
    for plan in mixed_plans():
        start = time.process_time()
        fit = mixed_fit(plan)
        spent = (time.process_time() - start) / cold(plan.shape)
        count = len(plan.positions)
        rows.append(f"| {plan.name} | {count} | {mixed_cells(plan, fit)} | {len(fit.history)}, {spent:.0f} × |")
    return rows


def mixed_fit(plan: MixedPlan, by: float = 0.0, **more: Any) -> Fit:
    """The fit of a plan whose lean is changed by some degrees."""
    return fit_outline(plan.shape, plan.positions, **plan.goals(plan.angle + by), **more)


def mixed_cells(plan: MixedPlan, fit: Fit) -> str:
    size = size_of(plan.positions)

    def far(kind: str) -> float:
        return max((100 * side.distance / size for side in fit.sides if side.kind == kind), default=np.nan)

    def angle(kind: str) -> float:
        return max((np.degrees(side.angle) for side in fit.sides if side.kind == kind), default=np.nan)

    H = mean_curvature_of(fit.points(), fit.surface.faces, fit.surface.normals)
    cells = [
        f"{far('line'):.2f} %{'' if fit.is_met else ', not met'}",
        f"{far('lean'):.2f} %, {angle('lean'):.1f}°" if not np.isnan(far("lean")) else "",
        f"{angle('held'):.1g}°" if not np.isnan(far("held")) else "",
        f"{far('held'):.1f} %" if not np.isnan(far("held")) else "",
        f"{fit.surface.mean_curvature:.4f}, {np.nanmedian(H):.4f}",
        f"{len(self_intersections(fit.points(), fit.surface.faces))}",
    ]
    return " | ".join(cells)


def restarts() -> list[str]:
    """A lean changed by 1°: the least work, the whole fit, and how far it is from that from nothing."""
    rows = [
        "| plan | one step: time, lines off | to the end: evaluations, time, lines off | moved by "
        "| away from the fit from nothing |",
        "|---" * 5 + "|",
    ]
    for plan in [plan for plan in mixed_plans() if plan.angle and "mirror" not in plan.name][:6]:
        unit, first, fresh = cold(plan.shape), mixed_fit(plan), mixed_fit(plan, 1.0)
        quick, quick_time = restarted(plan, first, unit, max_evaluations=1)
        whole, whole_time = restarted(plan, first, unit)
        size = size_of(plan.positions)
        moved, apart = (100 * np.abs(whole.points() - other.points()).max() / size for other in (first, fresh))
        lines = [max(100 * s.distance / size for s in fit.sides if s.kind == "line") for fit in (quick, whole)]
        rows.append(
            f"| {plan.name} | {quick_time:.1f} ×, {lines[0]:.2f} % | {len(whole.history)}, {whole_time:.0f} ×, "
            f"{lines[1]:.2f} % | {moved:.1f} % | {apart:.1f} % |"
        )
    return rows


def restarted(plan: MixedPlan, first: Fit, unit: float, **more: Any) -> tuple[Fit, float]:
    start = time.process_time()
    fit = mixed_fit(plan, 1.0, initial=first, **more)
    return fit, (time.process_time() - start) / unit


def eight() -> list[str]:
    """The shells of `tests.mixed_plans` by the door of all shells, and one whose first side is dragged by 1°."""
    rows = [
        "| plan | vertices | lines off | leans off: median, most | time | dragged by 1°: time, away from rest |",
        "|---" * 6 + "|",
    ]
    for mixed in MIXED_PLANS:
        plan, pairs = plan_of(mixed)
        settings = Settings(default_kind="line", size="rise", value=mixed.rise)
        size, unit = size_of(plan.positions), cold(shapes.Shape(plan_domain(plan), plan.positions, {}))
        start = time.process_time()
        shell = form(plan, settings, intersections=False)
        spent = (time.process_time() - start) / unit
        off = 100 * mixed.off_line(shell.points(), plan.positions, plan.triangles, pairs)
        cells = [mixed.name, str(len(plan.positions)), f"{off:.2f} %", leans_off(shell), f"{spent:.0f} ×"]
        further = plan_of(mixed.turned(1.0))[0]
        start = time.process_time()
        dragged = update(further, settings, shell.solver, shell.span or shell.fit)
        spent = (time.process_time() - start) / unit
        rest = form(further, settings, intersections=False).points()
        apart = 100 * np.abs(dragged.placed["f+"] - rest).max() / size
        cells.append(f"{spent:.1f} ×, {apart:.1g} %" if "lean" in mixed.name or mixed.is_fitted else "")
        rows.append(f"| {' | '.join(cells)} |")
    return rows


def leans_off(shell: Shell) -> str:
    """Degrees, away from the ends of sides; of fits the most."""
    found = [(abs(lean.measured - lean.asked), lean.off) for lean in shell.span.checks.leans] if shell.span else []
    if shell.fit:
        found = [(np.nan, side.angle) for side in shell.fit.sides if side.kind == "lean"]
    each = (f"{np.degrees(median):.2f}°, {np.degrees(most):.2f}°" for median, most in found)
    return "; ".join(each).replace("nan°, ", "")


TABLES: Tables = {
    "outlines": outlines,
    "work": work,
    "height_parameters": height_parameters,
    "raised": raised,
    "courtyards": courtyards,
    "mixed": mixed,
    "restarts": restarts,
    "eight": eight,
}


if __name__ == "__main__":
    measure(PAGE, TABLES)
