"""The tables of docs/measured/combinatorics.md, measured: convergence, and robustness to poor triangles.

    make gallery                                                # measures, writes the tables, draws the pictures
    .venv/bin/python -m scripts.tables.measure_faces recovery needles  # some of them, printed only
    .venv/bin/python -m scripts.tables.measure_faces --write           # all of them, into the page

Needs no Blender. The experiments are those of tests/solver, on larger meshes.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from scripts.tables.measured_page import Tables, measure
from solver import Domain, conditions, shapes, solve_cmc
from tests.solver import figure20, meshes
from tests.solver.exact_surfaces import disc, hemisphere, rates
from tests.solver.surface.test_convergence import immersed_sheet, jittered_but_at_the_rim, solved
from tests.solver.surface.test_figure19 import dome
from tests.solver.surface_errors import Errors, errors_of, hausdorff

ROOT = Path(__file__).resolve().parents[2]

PAGE = ROOT / "docs" / "measured" / "combinatorics.md"
SIZES = (600, 2400, 9600, 38400)
KINDS = {
    "vertices, cotangent": ("vertices", "cotan"),
    "faces, dual cotangent": ("faces", "dual_cotan"),
    "faces, Möbius": ("faces", "mobius"),
    "faces and rim, Möbius": ("faces_and_rim", "mobius"),
}
# irregular discs: how to make one, and whether to use its Delaunay triangulation
IRREGULAR = {
    "inside, Delaunay": (jittered_but_at_the_rim, True),
    "to the rim, Delaunay": (lambda n: disc(n, jitter=0.2), True),
    "inside, as it is": (jittered_but_at_the_rim, False),
}


def recovery() -> list[str]:
    """Paper, Figure 20: mean angle to the identity of the sphere, for all energies on faces."""
    rows = ["| aspect ratio | vertices | not Delaunay | Möbius | dual cotangent | shell | tangent |", "|---" * 7 + "|"]
    for aspect in figure20.ASPECTS:
        mesh = figure20.sphere(1200, aspect)
        recoveries = [figure20.recover(*mesh, energy) for energy in ("mobius", "dual_cotan", "shell", "tan")]
        share = recoveries[0].not_delaunay
        cells = [f"{aspect}", f"{len(mesh[0])}", f"{100 * share:.0f} %", *map(in_words, recoveries)]
        rows.append(f"| {' | '.join(cells)} |")
    return rows


def in_words(recovery: figure20.Recovery) -> str:
    return f"{recovery.error:.1f}°" if recovery.harmonic.ok else "lost"


def discs() -> list[str]:
    """Paper, Section 6: errors on regular discs, averaged over m = 1, 2, 3 as in Figure 17."""
    rows = header("normals", "error", SIZES)
    for name, kind in KINDS.items():
        each = [[errors(disc(n, jitter=0.0), m, *kind) for n in SIZES] for m in (1, 2, 3)]
        means = np.mean([[(e.l2, e.linf, e.distortion) for e in row] for row in each], axis=0)
        for k, what in enumerate(("H, L²", "H, L∞", "distortion")):
            rows.append(row(name, what, means[:, k]))
    return rows


def irregular() -> list[str]:
    """Errors of H for m = 1 on discs of irregular triangles."""
    first, last = SIZES[0], SIZES[2]
    rows = [f"| irregular | normals | L², {first} | {last} | order | L∞, {first} | {last} | order |", "|---" * 8 + "|"]
    for where, (make, delaunay) in IRREGULAR.items():
        for name, kind in KINDS.items():
            if delaunay or kind[1] != "dual_cotan":  # elsewhere it has no minimum
                measured = [errors(make(n), 1, *kind, delaunay=delaunay) for n in SIZES[:3]]
                cells = [f"| {where} | {name}"]
                for values in ([e.l2 for e in measured], [e.linf for e in measured]):
                    cells.append(f"{values[0]:.1e} | {values[-1]:.1e} | {rates(values).mean():.1f}")
                rows.append(" | ".join(cells) + " |")
    return rows


def header(first: str, second: str, sizes) -> list[str]:
    head = " | ".join(f"{n}" for n in sizes)
    return [f"| {first} | {second} | {head} | order |", "|---|---|" + "---|" * (len(sizes) + 1)]


def row(first: str, second: str, values) -> str:
    """Errors on finer and finer meshes, and the order of the last refinement."""
    return f"| {first} | {second} | {' | '.join(f'{x:.1e}' for x in values)} | {rates(list(values))[-1]:.1f} |"


def errors(mesh, m: int, sites: str, energy: str, **options) -> Errors:
    surface = solved(*mesh, m, sites, energy, **options)
    return errors_of(surface, immersed_sheet(surface, m))


def averages() -> list[str]:
    """Consistency of averages on irregular Delaunay discs: H for m = 1, positions for the hemisphere (m = 0)."""
    rows = header("normals, average", "error", SIZES[:3])
    for sites, energy, names in (
        ("vertices", "cotan", ("galerkin", "linear", "area")),
        ("faces_and_rim", "mobius", ("linear", "area")),
    ):
        for name in names:
            plans = [disc(n, jitter=0.2) for n in SIZES[:3]]
            options = dict(averaging=name, delaunay=True)
            measured = [errors(plan, 1, sites, energy, **options).l2 for plan in plans]
            rows.append(row(f"{sites}, `{name}`", "H of f+ on triangles", measured))
            for combinatorics in ("primal", "dual"):
                measured = [
                    off_the_hemisphere(plan, combinatorics, sites=sites, energy=energy, **options) for plan in plans
                ]
                rows.append(row(f"{sites}, `{name}`", f"f+, {combinatorics}", measured))
    return rows


def off_the_hemisphere(plan, combinatorics: str, **options) -> float:
    """Root mean square error of f+ over the unit disc; it lies on the sphere of radius 2."""
    domain, points = plan
    mesh = solve_cmc(domain, conditions.binormal(domain, points, domain.boundary_edges), **options).as_mesh(
        "f+", combinatorics
    )
    places = np.einsum("nk,nkx->nx", mesh.barycentric, points[mesh.anchors])
    away = mesh.vertices - 2.0 * hemisphere(places)
    away = away[np.linalg.norm(places, axis=1) < 0.999]  # points on boundary edges lie on chords of the circle
    return float(np.sqrt(np.mean(np.sum((away - away.mean(axis=0)) ** 2, axis=1))))


def needles() -> list[str]:
    """Paper, Figure 19: Hausdorff distance to the surface of a regular disc, as a part of its diagonal."""
    plan = shapes.disc(12_000)
    regular = dome(plan.positions, plan.domain.faces)
    diagonal = np.linalg.norm(np.ptp(regular[0], axis=0))
    rows = [
        "| stretch | vertices | smallest angle | median | not Delaunay | as it is | with *Delaunay* |",
        "|---|---|---|---|---|---|---|",
    ]
    for n, stretch in ((3000, 4.0), (3000, 8.0), (6000, 10.0), (6000, 20.0)):
        points, faces = meshes.needles(n, stretch)
        angles = np.degrees(meshes.smallest_angle(points, faces))
        bad = np.mean(Domain.from_positions(points, faces).cotan_weights < 0)
        far = [hausdorff(*dome(points, faces, delaunay=on), *regular) / diagonal for on in (False, True)]
        rows.append(
            f"| {stretch:.0f} | {len(points)} | {angles.min():.1f}° | {np.median(angles):.1f}° "
            f"| {100 * bad:.0f} % of edges | {100 * far[0]:.2f} % | {100 * far[1]:.2f} % |"
        )
    return rows


TABLES: Tables = {
    "recovery": recovery,
    "discs": discs,
    "irregular": irregular,
    "averages": averages,
    "needles": needles,
}


if __name__ == "__main__":
    measure(PAGE, TABLES)
