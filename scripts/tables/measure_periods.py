"""The tables of docs/measured/periods.md, measured: two ways to compute a period, and the work to close it.

    make gallery                                         # measures, writes the tables, draws the pictures
    .venv/bin/python -m scripts.tables.measure_periods planes   # some of them, printed only
    .venv/bin/python -m scripts.tables.measure_periods --write  # all of them, into the page

Needs no Blender. Times are processor times, the least of three.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scripts.tables.measured_page import Tables, measure
from solver import CmcSolver, Domain, HarmonicSolver, close_periods, mean_curvature_of, shapes, side_plane
from solver.closing.close import ClosingResult
from solver.closing.holes import hole
from solver.closing.moduli import tube
from solver.domain.topology import Homology
from solver.surface.periods import harmonic_forms, integrals
from tests.solver.closing.test_closing import rows_from, seams
from tests.solver.closing_plans import courtyard, half_tube
from tests.solver.fundamental_pieces import unduloid_period
from tests.solver.surface.test_periods import CASES, C, forms_of, tau_of

ROOT = Path(__file__).resolve().parents[2]

Array = NDArray[np.float64]

PAGE = ROOT / "docs" / "measured" / "periods.md"


def around(shape: shapes.Shape) -> dict:
    return {"by": "moduli", "moduli": hole(shape.domain, shape.positions, 1)}


WAYS: dict[str, Callable[[shapes.Shape], dict]] = {
    "normals": lambda shape: {},
    "tilts only": lambda shape: {"positions": shape.positions},
    "the hole's place and twist": around,
    "both, κ = 100": lambda shape: around(shape) | {"by": "both", "weight": 100.0},
    "both, κ = 1": lambda shape: around(shape) | {"by": "both"},
    "both, κ = 0.01": lambda shape: around(shape) | {"by": "both", "weight": 0.01},
}


def agreement() -> list[str]:
    """Differences of loop sums and integrals, as parts of the longest period; for tori also from the exact one."""
    rows = ["| domain | vertices | edge form | P1 form | from the exact period |", "|---|---|---|---|---|"]
    for name, (make, _) in CASES.items():
        for n in (14, 28, 56):
            domain, N = make(n)
            homology, eta = forms_of(domain)
            tau = tau_of(domain, N)
            loops = homology.loops.T @ tau
            longest = np.linalg.norm(loops, axis=1).max()
            edge, p1 = np.abs(eta.T @ tau - loops).max(), np.abs(integrals(domain, N, eta) - loops).max()
            exact = abs(longest / unduloid_period(C) - 1) if "torus" in name else None
            cells = [f"{edge / longest:.0e}", f"{p1 / longest:.1e}", "" if exact is None else f"{exact:.1e}"]
            rows.append(f"| {name} | {domain.vertex_count} | {' | '.join(cells)} |")
    return rows


def courtyards() -> list[str]:
    """One courtyard closed in every way: relative gaps, changes, area, time in cold solves."""
    rows = [
        "| by | vertices | steps | gap: loop form | P1 form | largest / rms turn | hole: x, y, twist | area | time |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for way, options in WAYS.items():
        for edge in (0.05, 0.0157):
            rows.append(courtyard_row(way, options, edge))
    return rows


def courtyard_row(way: str, options: Callable[[shapes.Shape], dict], edge: float) -> str:
    shape, held = courtyard(edge)
    solve = least_time(lambda: CmcSolver(fresh(shape)).solve(held))
    given = options(shape)
    closing = close_periods(fresh(shape), held, **given)
    seconds = least_time(lambda: close_periods(fresh(shape), held, **given))
    turned = np.degrees(closing.turned)
    cells = [
        str(len(closing.gaps) - 1),
        f"{closing.gaps[0]:.2f} → {closing.gaps[-1]:.0e}",
        f"{p1_gap(closing):.1e}",
        f"{turned.max():.1f}° / {np.sqrt(np.mean(turned**2)):.1f}°" if turned.any() else "",
        ", ".join(f"{q:+.3f}" for q in closing.moduli),
        f"{closing.area_ratio:.3f}",
        f"{seconds / solve:.1f}",
    ]
    return f"| {way} | {shape.domain.vertex_count} | {' | '.join(cells)} |"


def fresh(shape: shapes.Shape) -> Domain:
    """A copy of the domain without its caches."""
    return Domain.from_positions(shape.positions, shape.domain.faces)


def least_time(run: Callable[[], object]) -> float:
    times = []
    for _ in range(3):
        start = time.process_time()
        run()
        times.append(time.process_time() - start)
    return min(times)


def p1_gap(closing: ClosingResult) -> float:
    """The longest period as an integral, as a part of the size."""
    eta = harmonic_forms(Homology.of(closing.domain), HarmonicSolver(closing.domain).dirichlet)
    vectors = closing.surface.scale * integrals(closing.domain, closing.surface.harmonic.normals, eta)
    return float(np.linalg.norm(vectors, axis=1).max()) / size_of(closing.surface.f_plus)


def size_of(points: Array) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def seam() -> list[str]:
    """Root mean square error of H in %, along six cuts of the closed courtyard and in the rows beside them."""
    rows = ["| by | vertices | at the seam | beside it | ratio |", "|---|---|---|---|---|"]
    for way in ("normals", "the hole's place and twist", "both, κ = 1"):
        for edge in (0.05, 0.025):
            shape, held = courtyard(edge)
            surface = close_periods(shape.domain, held, **WAYS[way](shape)).surface
            H = mean_curvature_of(surface.f_plus, surface.faces, surface.normals)
            inside = rows_from(shape.domain, shape.domain.boundary_vertices) >= 1
            squares = np.zeros((2, 2))
            for cut in seams(shape):
                far = rows_from(shape.domain, cut)
                for k, rows_there in enumerate((far <= 1, (far > 2) & (far <= 10))):
                    errors = H[inside & rows_there] - 0.5
                    squares[k] += errors @ errors, len(errors)
            at, beside = 200 * np.sqrt(squares[:, 0] / squares[:, 1])
            rows.append(f"| {way} | {shape.domain.vertex_count} | {at:.2f} | {beside:.2f} | {at / beside:.2f} |")
    return rows


def holes() -> list[str]:
    """A plan with three holes: relative lengths of its periods, and closing by normals."""
    rows = ["| by | vertices | periods | steps | largest / rms turn | area |", "|---|---|---|---|---|---|"]
    for way in ("normals", "tilts only"):
        for edge in (0.08, 0.03):
            shape, held = courtyard(edge, "three holes")
            before = CmcSolver(shape.domain).solve(held)
            lengths = np.sort(np.linalg.norm(before.periods, axis=1)) / size_of(before.f_plus)
            closing = close_periods(shape.domain, held, **WAYS[way](shape))
            turned = np.degrees(closing.turned)
            steps = f"{len(closing.gaps) - 1}" if closing.closed else closing.status.value
            cells = [", ".join(f"{p:.2f}" for p in lengths), steps]
            cells += [f"{turned.max():.0f}° / {np.sqrt(np.mean(turned**2)):.0f}°", f"{closing.area_ratio:.2f}"]
            rows.append(f"| {way} | {shape.domain.vertex_count} | {' | '.join(cells)} |")
    return rows


def planes() -> list[str]:
    """Two sides on one mirror: their relative distance before and after, and the error of the stretch."""
    rows = ["| columns | distance before | after | steps | error of the stretch |", "|---|---|---|---|---|"]
    for columns in (8, 16, 32, 64):
        plan = half_tube(columns)
        sides = [plan.left, plan.right]
        length = tube(plan.domain, plan.corners, plan.tube, (1, 0))
        closing = close_periods(plan.domain, plan.held, by="moduli", moduli=length, coplanar=[sides])
        offsets = [side_plane(closing.surface, side).offset for side in sides]
        after = abs(offsets[0] - offsets[1]) / size_of(closing.surface.f_plus)
        error = abs(np.exp(closing.moduli[0]) * 1.35 - 1)
        rows.append(f"| {columns} | {closing.gaps[0]:.3f} | {after:.0e} | {len(closing.gaps) - 1} | {error:.0e} |")
    return rows


TABLES: Tables = {"agreement": agreement, "courtyards": courtyards, "seam": seam, "holes": holes, "planes": planes}


if __name__ == "__main__":
    measure(PAGE, TABLES)
