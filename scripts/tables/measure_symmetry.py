"""The tables of docs/measured/symmetry.md, measured: surfaces between mirrors and planes, and their completions.

    make gallery                                               # measures, writes the tables, draws the pictures
    .venv/bin/python -m scripts.tables.measure_symmetry vaults gaps   # some of them, printed only
    .venv/bin/python -m scripts.tables.measure_symmetry --write       # all of them, into the page

Needs no Blender. The experiments are those of tests/solver, on finer meshes.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.sparse.linalg import spsolve

from scripts.tables.measured_page import Tables, measure
from solver import HarmonicSolver, complete, conditions, mean_curvature_of, side_plane
from solver.catalogue import modules
from solver.domain.gluing import doubled as double
from solver.measure import self_intersections
from tests.solver import fundamental_pieces as pieces
from tests.solver.exact_surfaces import rates
from tests.solver.mirror_images import half_disc
from tests.solver.surface import test_figure9
from tests.solver.symmetry import test_capital
from tests.solver.symmetry.test_symmetry import radii
from tests.solver.symmetry.test_symmetry_modules import HEXAGON, NODE, neck, wrong_angle

ROOT = Path(__file__).resolve().parents[2]

PAGE = ROOT / "docs" / "measured" / "symmetry.md"
COLUMNS = (24, 48, 96)
NODOIDS = (0.1, 0.2, 0.5, 1.0, 2.0, 4.0)
UNDULOIDS = (-0.9, -0.7, -0.5, -0.3, -0.1)
EDGES = (0.16, 0.08, 0.04)
LENGTHS = (1.5, 1.9, 2.3, 2.7, 3.1)


def order(errors) -> str:
    """The mean order of convergence; each mesh is twice as fine as the one before."""
    return f"{rates(list(errors)).mean():.1f}"


def line(*cells) -> str:
    return f"| {' | '.join(str(cell) for cell in cells)} |"


def table(*names) -> list[str]:
    return [line(*names), "|" + "---|" * len(names)]


def crossings(mesh) -> str:
    count = len(self_intersections(mesh.vertices, mesh.faces))
    return "no" if count == 0 else f"{count} pairs of faces"


def curvature(points, faces, normals, keep) -> float:
    """Relative L² error of H, in per cent, on the faces to `keep`."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)[keep]
    H = mean_curvature_of(points, faces, normals)[keep]
    return 200.0 * float(np.sqrt(np.average((H - 0.5) ** 2, weights=areas)))


def delaunay(make, axis: int, wanted) -> tuple[list[float], list[float]]:
    """Exact neck, belly and period, and the largest of their errors for each number of columns."""
    errors = []
    for columns in COLUMNS:
        piece = make(columns)
        whole = complete(piece.surface, piece.sides)
        around = radii(whole.mesh.vertices, axis)
        measured = [around.min(), around.max(), np.linalg.norm(whole.lattice)]
        errors.append(float(np.abs(np.array(measured) - wanted).max()))
    return list(wanted), errors


def nodoids() -> list[str]:
    """Nodoids: normals ±e₁ at the ends of a cylinder, f+ and f- glued (paper, Figure 14)."""
    rows = table("c", "height", "neck", "belly", "period", *(f"error, {n} columns" for n in COLUMNS), "order")
    for c in NODOIDS:
        root = np.sqrt(1 + c)
        exact = root - 1, root + 1, 2 * pieces.nodoid_length(c)
        wanted, errors = delaunay(lambda n, c=c: pieces.nodoid(c, n), 0, exact)
        sizes = (f"{x:.4f}" for x in (pieces.nodoid_height(c), *wanted))
        rows.append(line(c, *sizes, *(f"{e:.1e}" for e in errors), order(errors)))
    return rows


def unduloids() -> list[str]:
    """Unduloids between two mirrors at latitude circles, and half of each from a mirror to a free side."""
    head = ("c", "neck", "belly", "period", "sides", *(f"error, {n} columns" for n in COLUMNS), "order")
    rows = table(*head)
    for c in UNDULOIDS:
        root = np.sqrt(1 + c)
        for free in (False, True):
            exact = 1 - root, 1 + root, pieces.unduloid_period(c)
            wanted, errors = delaunay(lambda n, c=c, free=free: pieces.unduloid(c, n, free), 2, exact)
            sides = "mirror, free" if free else "two mirrors"
            rows.append(line(c, *(f"{x:.4f}" for x in wanted), sides, *(f"{e:.1e}" for e in errors), order(errors)))
    return rows


def modulus(module, start: str, end: str) -> float:
    """Extremal distance in the plan between two of its sides: 1 / ∫ |∇u|², u = 0 along one, 1 along the other."""
    domain = module.shape.domain
    u = np.full(domain.vertex_count, np.nan)
    for value, name in ((0.0, start), (1.0, end)):
        u[domain.edges[module.shape.sides[name]].ravel()] = value
    inside = np.flatnonzero(np.isnan(u))
    known = np.where(np.isnan(u), 0.0, u)
    L = domain.laplacian.tocsr()
    known[inside] = spsolve(L[inside][:, inside].tocsc(), -(L @ known)[inside])
    return float(1.0 / (known @ (L @ known)))


def honeycombs() -> list[str]:
    """Modules of three tubes at a node (paper, Figure 16), for five moduli."""
    rows = table(
        "length", "modulus", "neck", "between nodes", *(f"H, edge {h}" for h in EDGES), "order", "neck, order",
        "largest gap", "off plane", "ring of 72", "3 × 3 cells",
    )  # fmt: skip
    for length in LENGTHS:
        errors, necks = [], []
        for h in EDGES:
            module = modules.node(3, length, max_edge=h)
            piece = pieces.between_mirrors(module)
            node = complete(piece.surface, piece.sides, around=[NODE])
            keep = ~np.isin(node.mesh.faces, node.mesh.rim).any(axis=1)
            errors.append(curvature(node.mesh.vertices, node.mesh.faces, node.mesh.normals, keep))
            necks.append(neck(node).max())
        cell = complete(piece.surface, piece.sides)
        coarse = pieces.between_mirrors(modules.node(3, length, max_edge=EDGES[0]))
        ring = complete(coarse.surface, coarse.sides, around=[NODE, HEXAGON]).mesh
        patch = complete(coarse.surface, coarse.sides, repeat=3).mesh
        spacing = np.linalg.norm(cell.lattice[0]) / np.sqrt(3)
        rows.append(line(
            length, f"{modulus(module, 'bisector', 'end'):.3f}", f"{necks[-1]:.3f}", f"{spacing:.3f}",
            *(f"{e:.2f} %" for e in errors), order(errors), order(np.abs(np.diff(necks))),
            f"{cell.mesh.largest_gap:.0e}", f"{max(p.relative for p in cell.planes):.0e}",
            "embedded" if crossings(ring) == "no" else crossings(ring),
            "embedded" if crossings(patch) == "no" else crossings(patch),
        ))  # fmt: skip
    return rows


def corners() -> list[str]:
    """Plans with 60° and 90° at the node: errors of H on a node, and on the faces at its top."""
    rows = table(
        "corner", "copies go around", *(f"H, edge {h}" for h in EDGES), "order", *(f"at the top, {h}" for h in EDGES)
    )
    for angle, make in ((60, lambda h: modules.node(3, 2.2, max_edge=h)), (90, wrong_angle)):
        errors, tops = [], []
        for h in EDGES:
            piece = pieces.between_mirrors(make(h))
            node = complete(piece.surface, piece.sides, around=[NODE])
            mesh = node.mesh
            at = next(corner for corner in node.corners if set(corner.sides) == {"bisector", "axis"})
            keep = ~np.isin(mesh.faces, mesh.rim).any(axis=1)
            errors.append(curvature(mesh.vertices, mesh.faces, mesh.normals, keep))
            top = np.isin(mesh.source[mesh.faces], at.vertex).any(axis=1)
            tops.append(curvature(mesh.vertices, mesh.faces, mesh.normals, top))
        cells = (f"{e:.2f} %" for e in errors)
        rows.append(line(f"{angle}°", f"{at.turns:.2f} ×", *cells, order(errors), *(f"{e:.1f} %" for e in tops)))
    return rows


def gap(whole) -> float:
    return whole.mesh.largest_gap


def gaps() -> list[str]:
    """Largest distance of vertices before they are welded, as a part of the size."""
    rows = table("piece", "sides", "coarse", "", "fine", "order")
    for name, sides, make, sizes in (
        ("nodoid, c = ½, 32 to 128 columns", "two tangent", lambda n: pieces.nodoid(0.5, n), (32, 64, 128)),
        ("eighth of a sphere, 8 to 32 edges an arc", "normals given", pieces.sphere_eighth, (8, 16, 32)),
        ("half an unduloid, 32 to 128", "mirror, free", lambda n: pieces.unduloid(-0.5, n, True), (32, 64, 128)),
        ("honeycomb", "mirrors", lambda h: pieces.between_mirrors(modules.node(3, 2.3, max_edge=h)), EDGES),
    ):  # fmt: skip
        gaps = [gap(complete(piece.surface, piece.sides)) for piece in map(make, sizes)]
        exact = max(gaps) < 1e-8
        cells = ("rounding",) * 3 if exact else (f"{x:.1e}" for x in gaps)
        rows.append(line(name, sides, *cells, "" if exact else order(gaps)))
    return rows


def free() -> list[str]:
    """Spread of g along a free side, and of f+ about the sphere around it, in units of 1/(2H)."""
    rows = table("piece", "largest, of g from its mean", "", "", "order", "of f+ from the sphere", "", "", "order")
    tube = lambda n: (pieces.unduloid(-0.5, n, True), "top")  # noqa: E731
    eye = lambda h: (  # noqa: E731
        pieces.between_mirrors(modules.capital(0.4, oculus=0.2, eighth=True, max_edge=h), {"oculus": "free"}),
        "oculus",
    )
    for name, make, sizes in (
        ("half an unduloid, 32, 64, 128 columns", tube, (32, 64, 128)),
        ("capital, edges of 0.04, 0.02, 0.01", eye, (0.04, 0.02, 0.01)),
    ):
        pairs = []
        for piece, side in map(make, sizes):
            plane = side_plane(piece.surface, next(s for s in piece.sides if s.name == side))
            away = np.linalg.norm(piece.surface.f_plus[plane.cut_vertices] - plane.point, axis=1)
            pairs.append([plane.error, np.abs(away - 1.0).max()])
        points, spheres = np.transpose(pairs)
        cells = [f"{x:.1e}" for x in points], [f"{x:.1e}" for x in spheres]
        rows.append(line(name, *cells[0], order(points), *cells[1], order(spheres)))
    return rows


def doubled() -> list[str]:
    """Minimisers on half a disc with a mirror along its diameter, and on the disc glued from it and its image.

    The second starts from the normals of the first, perturbed at random.
    """
    random = np.random.default_rng(4)
    rows = table("vertices", "tilt of the arc", "largest difference of normals", "of energies")
    for n, tilt in ((600, 0.4), (2400, 0.4), (2400, -0.6)):
        domain, points, arc, flat = half_disc(n)
        plan = np.column_stack([points, np.zeros(len(points))])
        given = conditions.binormal(domain, plan, arc, tilt=tilt) + conditions.mirror(domain, flat, (0, -1, 0))
        half = HarmonicSolver(domain).solve(given, tolerance=1e-12)
        whole = double(domain, flat)
        rim = np.unique(domain.edges[arc])
        other = whole.vertex_count - domain.vertex_count
        off = np.setdiff1d(np.arange(domain.vertex_count), np.unique(domain.edges[flat]))
        image = np.arange(domain.vertex_count)
        image[off] = domain.vertex_count + np.arange(other)
        normals = half.normals[rim]
        sites, first = np.unique(np.concatenate([rim, image[rim]]), return_index=True)
        known = np.concatenate([normals, normals * [1, -1, 1]])[first]
        start = np.concatenate([half.normals, half.normals[off] * [1, -1, 1]])
        start += random.uniform(-0.3, 0.3, start.shape)
        given = conditions.fixed_at(whole, sites, known)
        start[sites] = known
        start /= np.linalg.norm(start, axis=1, keepdims=True)
        result = HarmonicSolver(whole).solve(given, initial=start, tolerance=1e-12)
        difference = np.abs(result.normals[: domain.vertex_count] - half.normals).max()
        energies = abs(result.energy - 2 * half.energy)
        rows.append(line(whole.vertex_count, f"{np.degrees(tilt):.0f}°", f"{difference:.0e}", f"{energies:.0e}"))
    return rows


def vaults() -> list[str]:
    """Paper, Figure 9: vaults that touch walls, with feet orthogonal to the floor; three meshes each."""
    rows = table("plan", "edge", "vertices", "off plane", "H", "away from the rim", "at it", "wall", "feet differ by")
    for label, openings, foot, length in (
        ("three walls", 3, 0.6, 1.0), ("four walls", 4, 0.5, 1.0), ("four, 1.6 × as long", 4, 0.4, 1.6),
        ("five walls", 5, 0.3, 1.0),
    ):  # fmt: skip
        walls, errors = [], []
        for h in (0.16, 0.08, 0.04):
            piece = test_figure9.vault(openings, foot, h, length=length)
            surface = piece.surface
            planes = [side_plane(surface, side) for side in piece.sides]
            errors.append([200.0 * e / 2.0 for e in test_figure9.curvature_errors(surface)])
            walls.append(np.mean([p.offset for p in planes if p.kind == "tangent"]))
            feet = np.ptp([p.offset for p in planes if p.kind == "mirror"])
            everywhere, rim, inside = errors[-1]
            rows.append(line(
                label, h, surface.domain.vertex_count, f"{max(p.relative for p in planes):.0e}",
                *(f"{e:.2f} %" for e in (everywhere, inside, rim)), f"{walls[-1]:.4f}", f"{feet:.0e}",
            ))  # fmt: skip
        by_part = [order(e) for e in np.transpose(errors)]
        rows.append(line("", "order", "", "", by_part[0], by_part[2], by_part[1], order(np.abs(np.diff(walls))), ""))
    return rows


def capitals() -> list[str]:
    """Capitals with a mirror in the floor at the column, for each condition in the middle of the bay."""
    rows = table(
        "foot", "radius", "middle", "its radius", "bay", "height", "foot's ring", "tension / pressure", "grid crosses"
    )
    cases = [("mirror", r, "", 0.0) for r in (0.15, 0.2, 0.4, 0.6, 0.8, 0.9)]
    cases += [("mirror", r, "tangent", o) for r, o in ((0.4, 0.4), (0.2, 0.7), (0.6, 0.6), (0.4, 0.8))]
    cases += [("mirror", r, "free", o) for r, o in ((0.4, 0.2), (0.4, 0.4), (0.4, 0.6))]
    cases += [("tangent", r, "", 0.0) for r in (0.05, 0.1, 0.2)]
    for foot, radius, kind, oculus in cases:
        module = modules.capital(radius, oculus=oculus, eighth=True, max_edge=0.0125 if radius < 0.2 else 0.02)
        piece = pieces.between_mirrors(module, {"column": foot} | ({"oculus": kind} if oculus else {}))
        bays = test_capital.hall(piece)
        area = test_capital.bay_area(bays)
        length, ring = test_capital.ring(bays, piece, "column")
        opening = test_capital.ring(bays, piece, "oculus")[1] if oculus else 0.0
        balance = f"{length / (area - ring - opening):.3f}" if foot == "mirror" and kind != "free" else ""
        rows.append(line(
            foot, radius, kind or "closed", oculus or "", f"{np.sqrt(area):.3f}",
            f"{np.ptp(piece.surface.f_plus[:, 2]):.3f}", f"{np.sqrt(ring / np.pi):.3f}", balance, crossings(bays.mesh),
        ))  # fmt: skip
    return rows


TABLES: Tables = {
    "nodoids": nodoids,
    "unduloids": unduloids,
    "honeycombs": honeycombs,
    "corners": corners,
    "gaps": gaps,
    "free": free,
    "doubled": doubled,
    "vaults": vaults,
    "capitals": capitals,
}


if __name__ == "__main__":
    measure(PAGE, TABLES)
