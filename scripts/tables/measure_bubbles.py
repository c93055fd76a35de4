"""The tables of docs/measured/bubbles.md: Wente's cylinders and tori, the honeycomb ring, two shells over one rim.

    make gallery                                           # measures, writes the tables, draws the pictures
    .venv/bin/python -m scripts.tables.measure_bubbles heights    # some of them, printed only
    .venv/bin/python -m scripts.tables.measure_bubbles --write    # all of them, into the page

Needs no Blender. The experiments are those of tests/solver, on finer meshes and with more seeds.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from scripts.tables.measured_page import Tables, measure
from solver import (
    Conditions,
    Domain,
    HarmonicSolver,
    Status,
    complete,
    conditions,
    modes_of,
    ring,
    saddle,
    shapes,
    wente,
    whole,
)
from solver.catalogue.honeycomb_ring import AROUND
from solver.catalogue.wente_heights import needed_columns, wente_height
from solver.gauss.balance import imbalance
from solver.gauss.modes import index_of, problem_of
from solver.measure import self_intersections
from tests.solver import closing_plans
from tests.solver.catalogue.test_wente_torus import curvature_error
from tests.solver.closing_plans import LENGTH, spoke_of
from tests.solver.wente_cylinders import jittered_cylinder, nearby

ROOT = Path(__file__).resolve().parents[2]

PAGE = ROOT / "docs" / "measured" / "bubbles.md"
ANGLES = (30, 45, 60, 75, 90, 105, 120, 135, 150, 165)
# Degrees → E of the whole cylinder of the continuous surface (Abresch, Walter).
ENERGIES = {120: 26.8240, 60: 25.2087}
SEEDS = 10


def line(*cells) -> str:
    return f"| {' | '.join(str(cell) for cell in cells)} |"


def table(*names) -> list[str]:
    return [line(*names), "|" + "---|" * len(names)]


def order(errors: list[float], sizes: list[float]) -> str:
    """The order between the last mesh and the one before. sizes: numbers of columns."""
    if len(errors) < 2:
        return ""
    return f"{np.log(errors[-2] / errors[-1]) / np.log(sizes[-1] / sizes[-2]):.2f}"


def family() -> list[str]:
    """One mesh for each angle, by the default start."""
    head = ("angle", "exact height", "columns needed", "columns", "steps", "height", "too high by", "E")
    rows = table(*head, "cylinders", "covers")
    for angle in ANGLES:
        needed = needed_columns(np.radians(angle))
        columns = max(24, needed)
        bubble = wente(np.radians(angle), columns)
        exact = wente_height(np.radians(angle))
        assert bubble.closing is not None
        rows.append(
            line(
                f"{angle}°", f"{exact:.6f}", needed, columns, len(bubble.closing.gaps) - 1, f"{bubble.height:.4f}",
                f"{100 * (bubble.height / exact - 1):.2f} %", f"{4 * bubble.surface.harmonic.energy:.3f}",
                bubble.cylinders, bubble.covers,
            )
        )  # fmt: skip
    return rows


def heights() -> list[str]:
    """Heights found from 10 % above the exact one."""
    rows = table("angle", "columns", "steps", "gap", "height", "error", "order", "E", "error", "order")
    for angle, meshes in {120: (16, 32, 64, 128), 60: (40, 80, 160)}.items():
        exact, sizes, off, energies = wente_height(np.radians(angle)), [], [], []
        for columns in meshes:
            bubble = wente(np.radians(angle), columns, height=1.1 * exact)
            energy = 4.0 * bubble.surface.harmonic.energy
            assert bubble.closing is not None
            sizes.append(columns)
            off.append(abs(bubble.height / exact - 1.0))
            energies.append(abs(energy / ENERGIES[angle] - 1.0))
            gaps = bubble.closing.gaps
            rows.append(
                line(
                    f"{angle}°", columns, len(gaps) - 1, f"{gaps[-1]:.0e}", f"{bubble.height:.7f}", f"{off[-1]:.1e}",
                    order(off, sizes), f"{energy:.4f}", f"{energies[-1]:.1e}", order(energies, sizes),
                )
            )  # fmt: skip
    return rows


def tori() -> list[str]:
    """The completed tori: closedness, genus, relative L² error of H, and the largest gap before welding."""
    head = ("angle", "columns", "copies", "vertices", "genus", "boundary", "largest gap", "order", "H", "order")
    rows = table(*head)
    for angle, meshes in {120: (24, 48, 96, 192), 90: (40, 80, 160)}.items():
        sizes, gaps, errors = [], [], []
        for columns in meshes:
            half = wente(np.radians(angle), columns, halved=True)
            completion = complete(half.surface, half.sides)
            mesh = completion.mesh
            torus = Domain.from_positions(mesh.vertices, mesh.faces)
            sizes.append(columns)
            gaps.append(max(gap.relative for gap in completion.gaps))
            errors.append(curvature_error(mesh))
            rows.append(
                line(
                    f"{angle}°", columns, len(completion.copies), torus.vertex_count, torus.genus,
                    len(torus.boundary_loops), f"{gaps[-1]:.1e}", order(gaps, sizes), f"{100 * errors[-1]:.2f} %",
                    order(errors, sizes),
                )
            )  # fmt: skip
    return rows


def wholes() -> list[str]:
    """The map of the whole torus, perturbed by 0.05 and recovered."""
    head = ("angle", "cylinders", "vertices", "residual at the start", "steps", "residual", "E")
    rows = table(*head, "imbalance before", "after", "index, null")
    for angle, columns in ((120, 12), (90, 14), (60, 29)):
        bubble = wente(np.radians(angle), columns)
        torus = whole(complete(bubble.surface, bubble.sides))
        solver = HarmonicSolver(torus.domain)
        problem, start = problem_of(solver, Conditions()), nearby(solver, torus.normals)
        result = saddle(solver, Conditions(), start, index=None, tolerance=1e-9)
        before, after = (np.abs(imbalance(problem, N)).max() for N in (start, result.normals))
        index, null = index_of(solver, Conditions(), result.normals)
        rows.append(
            line(
                f"{angle}°", bubble.cylinders, torus.domain.vertex_count, f"{problem.at(start).residual:.1f}",
                result.iterations, f"{result.residual:.0e}", f"{result.energy:.3f}", f"{before:.0e}", f"{after:.0e}",
                f"{index}, {null}",
            )
        )  # fmt: skip
    return rows


def seeds() -> list[str]:
    """Whole cylinders on jittered meshes, from `wente_start`."""
    head = ("angle", "columns around", "found", "steps", "index", "lowest λ", "E")
    rows = table(*head)
    for angle, columns in ((120, 64), (90, 80)):
        results, modes = [], []
        for seed in range(SEEDS):
            domain, held, start = jittered_cylinder(np.radians(angle), columns, seed)
            solver = HarmonicSolver(domain)
            result = saddle(solver, held, start)
            if result.status is Status.CONVERGED:
                results.append(result)
                modes.append(modes_of(solver, held, result.normals, tolerance=1e-3))
        steps, energies = [f.iterations for f in results], [f.energy for f in results]
        lowest = [mode.values[0] for mode in modes]
        rows.append(
            line(
                f"{angle}°", columns, f"{len(results)} of {SEEDS}", span(steps, "d"),
                span([mode.index for mode in modes], "d"), span(lowest, ".4f"), span(energies, ".3f"),
            )
        )  # fmt: skip
    return rows


def span(values: list, form: str) -> str:
    low, high = format(min(values), form), format(max(values), form)
    return low if low == high else f"{low} to {high}"


def rings() -> list[str]:
    """Three kinds of rings: their necks, and the topology of 3 × 3 of them."""
    head = ("tubes", "length", "edge", "copies", "χ", "loops", "longest period", "residual", "index", "neck", "spacing")
    rows = table(*head, "3 × 3")
    cases = [(3, length, 0.2) for length in (1.6, 2.0, 2.4, 2.8)] + [(3, 2.4, 0.1), (4, 2.4, 0.2), (6, 4.0, 0.3)]
    for tubes, length, edge in cases:
        made = ring(length, tubes=tubes, max_edge=edge)
        solver = HarmonicSolver(made.domain)
        point = problem_of(solver, made.conditions).at(made.normals)
        index, _ = index_of(solver, made.conditions, made.normals)
        nine = complete(made.piece, made.sides, around=AROUND, translations=made.lattice, repeat=3)
        crossing = self_intersections(nine.mesh.vertices, nine.mesh.faces)
        longest = np.linalg.norm(made.periods, axis=1).max()
        rows.append(
            line(
                tubes, length, edge, len(made.completion.copies), made.domain.euler_characteristic,
                len(made.domain.boundary_loops), f"{longest:.0e}", f"{point.residual:.0e}", index, f"{made.neck:.4f}",
                f"{made.spacing:.4f}", "embedded" if not len(crossing) else f"{len(crossing)} crossings",
            )
        )  # fmt: skip
    return rows


def pentagon() -> list[str]:
    """Closing from a spoke 12.5 % too long: its length, and the necks beside those of the quadrilateral."""
    rows = table("edge", "vertices", "gap", "steps", "gap after", "index", "spoke", "error", "necks", "quadrilateral")
    for edge in (0.2, 0.14, 0.1, 0.07):
        plan = closing_plans.pentagon(1.125 * LENGTH, edge)
        closing = plan.close()
        modes = modes_of(HarmonicSolver(closing.domain), closing.conditions, closing.surface.normals)
        spoke, radii = spoke_of(closing, plan), closing_plans.necks(closing, plan)
        cells = [edge, closing.domain.vertex_count, f"{closing.gaps[0]:.3f}", len(closing.gaps) - 1]
        cells += [f"{closing.gaps[-1]:.0e}", modes.index, f"{spoke:.4f}", f"{abs(spoke / LENGTH - 1):.0e}"]
        whole_ring = ring(LENGTH, max_edge=edge)
        end = next(side for side in whole_ring.sides if side.name == "end")
        same = closing_plans.neck(whole_ring.piece, np.asarray(end.edges), np.array([1.0, 0.0, 0.0]))
        cells += [", ".join(f"{radius:.4f}" for radius in radii), f"{same:.4f}"]
        rows.append(line(*cells))
    return rows


def shells() -> list[str]:
    """Two shells with the same normals along a circle; together they are a sphere of radius 2."""
    rows = table("tilt", "vertices", "shell", "steps", "degree", "exact", "E / π", "exact", "negative modes")
    for tilt in (20, 45, 70):
        part = 0.5 * (1.0 - np.sin(np.radians(tilt)))
        for n in (1500, 6000, 24000):
            disc = shapes.disc(n)
            rim = disc.domain.boundary_edges
            held = conditions.binormal(disc.domain, disc.positions, rim, tilt=np.radians(tilt))
            solver = HarmonicSolver(disc.domain)
            cap = solver.solve(held)
            bubble = solver.solve(held, degree=cap.degree - 1.0)
            for name, result, exact in (("cap", cap, part), ("bubble", bubble, part - 1.0)):
                steps = result.iterations if result.status is Status.CONVERGED else result.status.value
                index, _ = index_of(solver, held, result.normals)
                rows.append(
                    line(
                        f"{tilt}°", disc.domain.vertex_count, name, steps, f"{result.degree:.4f}", f"{exact:.4f}",
                        f"{result.energy / np.pi:.4f}", f"{4 * abs(exact):.4f}", index,
                    )
                )  # fmt: skip
    return rows


TABLES: Tables = {
    "family": family,
    "heights": heights,
    "tori": tori,
    "wholes": wholes,
    "seeds": seeds,
    "rings": rings,
    "pentagon": pentagon,
    "shells": shells,
}


if __name__ == "__main__":
    measure(PAGE, TABLES)
