"""Meshes of bad quality as plans: jittered, squashed, slivers, torn, doubled, turned over, steep, closed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.spatial import Delaunay

from solver import shapes
from solver.io.obj import MeshData
from solver.shells.form import form
from solver.shells.plan import Plan

from .case import Case, Result, of_shell, pick
from .settings import groups, settings

Rng = np.random.Generator
Mesh = tuple[np.ndarray, list[list[int]]]


def grid(rng: Rng) -> Mesh:
    """Quads, or triangles, or both."""
    m, n = rng.integers(2, 12, 2)
    x, y = np.meshgrid(np.linspace(0, 1, m + 1), np.linspace(0, rng.uniform(0.2, 1), n + 1), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    first = [i * (n + 1) + j for i in range(m) for j in range(n)]
    quads = [[k, k + n + 1, k + n + 2, k + 1] for k in first]
    cut = rng.random()
    faces = [part for q in quads for part in ([q] if rng.random() < cut else [[q[0], q[1], q[2]], [q[0], q[2], q[3]]])]
    return points, faces


def disc(rng: Rng) -> Mesh:
    return _of_shape(shapes.disc(int(rng.integers(7, 250))))


def ring(rng: Rng) -> Mesh:
    return _of_shape(shapes.annulus(10.0 ** rng.uniform(-2, -0.1), 1.0, int(rng.integers(30, 250))))


def slivers(rng: Rng) -> Mesh:
    """Delaunay triangles of points at random."""
    points = rng.uniform(-1, 1, (int(rng.integers(6, 150)), 2))
    return np.column_stack([points, np.zeros(len(points))]), Delaunay(points).simplices.tolist()


def ball(rng: Rng) -> Mesh:
    """Closed: not a plan by itself."""
    return _of_shape(shapes.sphere(int(rng.integers(12, 200))))


def ngon(rng: Rng) -> Mesh:
    """A polygon of many corners, fans around it."""
    count = int(rng.integers(3, 60))
    angle = 2 * np.pi * np.arange(count) / count
    circle = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    k, after = np.arange(count), (np.arange(count) + 1) % count
    sides = np.column_stack([k + count, after + count, after, k])
    return np.concatenate([circle, 2 * circle]), [k.tolist(), *sides.tolist()]


BASES: list[Callable[[Rng], Mesh]] = [grid, grid, grid, disc, disc, disc, ring, ring, slivers, ngon, ball]


def _of_shape(shape: shapes.Shape) -> Mesh:
    points = np.asarray(shape.positions)
    flat = points if points.shape[1] == 3 else np.column_stack([points, np.zeros(len(points))])
    return flat, shape.domain.faces.tolist()


def jitter(rng: Rng, points: np.ndarray, faces: list) -> Mesh:
    return points + 10.0 ** rng.uniform(-3, -1) * rng.normal(size=points.shape) * [1, 1, pick(rng, [0, 1])], faces


def squash(rng: Rng, points: np.ndarray, faces: list) -> Mesh:
    return points * [1.0, 10.0 ** rng.uniform(-8, 0), 1.0], faces


def lift(rng: Rng, points: np.ndarray, faces: list) -> Mesh:
    """A dome, a saddle, a steep roof, a wall."""
    x, y, z = points.T
    height = pick(rng, [1 - x**2 - y**2, x * y, np.abs(x), 1e3 * x, np.sin(9 * x), x + y])
    height = height * pick(rng, [1, -1, 0.01, 100])
    return (np.column_stack([x, height, y]) if rng.random() < 0.2 else np.column_stack([x, y, z + height])), faces


def pinch(rng: Rng, points: np.ndarray, faces: list) -> Mesh:
    """Two neighbours nearly, or quite, in one place."""
    points = points.copy()
    for _ in range(rng.integers(1, 5)):
        a, b = pick(rng, faces)[:2]
        points[a] = points[b] + pick(rng, [0.0, 1e-12, 1e-5, 1e-4, 1e-3]) * rng.normal(size=3)
    return points, faces


def tear(rng: Rng, points: np.ndarray, faces: list) -> Mesh:
    """Faces left out: holes, and parts that touch at a vertex."""
    chance = pick(rng, [0.02, 0.3])
    kept = [face for face in faces if rng.random() > chance]
    return points, kept


def double(rng: Rng, points: np.ndarray, faces: list) -> Mesh:
    """A face twice, or turned over, or on a new vertex in an old place."""
    face = pick(rng, faces)
    if (way := rng.integers(3)) == 0:
        return points, [*faces, face]
    if way == 1:
        return points, [f[::-1] if f is face else f for f in faces]
    return np.concatenate([points, points[face[:1]]]), [[len(points), *f[1:]] if f is face else f for f in faces]


def mistake(rng: Rng, points: np.ndarray, faces: list) -> Mesh:
    """An index out of range, a number that is none, a face of two corners, a corner twice, nothing at all."""
    k, faces, points = int(rng.integers(len(faces))), list(faces), points.copy()
    if (way := rng.integers(6)) == 0:
        faces[k] = [*faces[k][:-1], pick(rng, [-1, len(points), 2**31 - 1])]
    elif way == 1:
        points[faces[k][0]] = pick(rng, [np.nan, np.inf, 1e300, 1e200])
    elif way == 2:
        faces[k] = faces[k][:2]
    elif way == 3:
        faces[k] = [*faces[k], faces[k][0]]
    elif way == 4:
        faces = faces[:1]
    else:
        faces = []
    return points, faces


def place(rng: Rng, points: np.ndarray, faces: list) -> Mesh:
    """Tiny, huge, far away."""
    with np.errstate(all="ignore"):
        return points * 10.0 ** rng.uniform(-6, 6) + pick(rng, [0.0, 1e6]) * rng.normal(size=3), faces


HARMS = [jitter, jitter, squash, lift, lift, lift, pinch, tear, double, mistake, place, place, place]


def case(rng: np.random.Generator, folder: Path) -> Case:
    base = pick(rng, BASES)
    points, faces = base(rng)
    harms = []
    for _ in range(rng.integers(1, 3)):
        if faces:
            harms.append(harm := pick(rng, HARMS))
            points, faces = harm(rng, points, faces)
    own = np.random.default_rng(rng.integers(2**32))

    def run() -> Result:
        plan = Plan.from_mesh(MeshData(points, [np.array(face, dtype=np.int32) for face in faces]))
        with np.errstate(all="ignore"):
            size = float(np.ptp(points, axis=0).max()) if len(points) else 1.0
        sides = _parts_of_rim(plan)
        plan.groups = groups(own, sides, [own.normal(size=3) for _ in sides])
        return of_shell(form(plan, settings(own, size if np.isfinite(size) and size > 0 else 1.0)))

    how = ", ".join(harm.__name__ for harm in harms)
    return Case(f"{base.__name__}, {how}; {len(points)} vertices, {len(faces)} faces", run)


def _parts_of_rim(plan: Plan) -> list[np.ndarray]:
    """The edges of one triangle only, in up to three parts."""
    tails, heads = plan.triangles.ravel(), np.roll(plan.triangles, -1, axis=1).ravel()
    pairs = set(zip(tails.tolist(), heads.tolist(), strict=True))
    rim = np.array(sorted((a, b) for a, b in pairs if (b, a) not in pairs), dtype=np.int64).reshape(-1, 2)
    return [part for part in np.array_split(rim, 3) if len(part)]
