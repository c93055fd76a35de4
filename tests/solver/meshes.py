"""Triangle meshes for tests and figures: spheres twisted into slivers, a torus, genus two, a disc of needles.

Each function gives points (V, 2|3) and counter-clockwise (outward) faces (F, 3); nothing here knows the solver.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, Delaunay

Points = NDArray[np.float64]
Faces = NDArray[np.int64]


# --- spheres -------------------------------------------------------------------------------


def sphere(n: int, jitter: float = 0.0, seed: int = 1) -> tuple[Points, Faces]:
    """Points of the unit sphere, evenly spread along a spiral, moved by up to `jitter` of their distance; the faces
    are those of the convex hull, so every edge is Delaunay."""
    k = np.arange(n) + 0.5
    z, turn = 1.0 - 2.0 * k / n, np.pi * (1.0 + np.sqrt(5.0)) * k
    across = np.sqrt(1.0 - z**2)
    points = np.column_stack([across * np.cos(turn), across * np.sin(turn), z])
    random = np.random.default_rng(seed)
    points += jitter * np.sqrt(4.0 * np.pi / n) * random.uniform(-1.0, 1.0, points.shape)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    faces = ConvexHull(points).simplices.astype(np.int64)
    return points, outward(points, faces)


def outward(points: Points, faces: Faces) -> Faces:
    """The faces of a surface that is star-shaped about the origin, turned to run counter-clockwise from outside."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    inside_out = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) < 0.0
    return np.where(inside_out[:, None], faces[:, ::-1], faces)


def twisted(points: Points, stretch: float) -> Points:
    """Points of the unit sphere turned about the axis by t z: a shear, of t cos² (latitude), that keeps areas.

    On the equator the longest stretch over the shortest is `stretch` = ((t + sqrt(t² + 4)) / 2)²; there it makes
    slivers of that aspect ratio out of equilateral triangles.
    """
    angle = (np.sqrt(stretch) - 1.0 / np.sqrt(stretch)) * points[:, 2]
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = points.T
    return np.column_stack([c * x - s * y, s * x + c * y, z])


def rings(n: int, aspect: float, jitter: float = 0.0, seed: int = 1) -> tuple[Points, Faces]:
    """About n points of the unit sphere on an even number of parallels, which lie `aspect` times as far apart as their
    points; the faces, those of the convex hull, are as slender. Then points move by up to `jitter` of their distance.

    Half turns about the three axes map the mesh to itself. So they do with a harmonic map that is computed from a
    start with the same symmetry: rotations and other Möbius transformations, which it could drift along, have none.
    """
    random = np.random.default_rng(seed)
    rows = 2 * max(2, round(np.sqrt(np.pi * n / aspect) / 4)) + 1
    height = np.pi / rows
    quarter = []
    for k in range(1, (rows + 1) // 2):
        z, across = np.cos(k * height), np.sin(k * height)
        count = max(3, round(np.pi * across / height * aspect))
        turn = (np.arange(count) + random.random()) * np.pi / count
        quarter.append(np.column_stack([across * np.cos(turn), across * np.sin(turn), np.full(count, z)]))
    points = np.concatenate(quarter)
    faces = ConvexHull(four_times(points)).simplices.astype(np.int64)
    faces = outward(four_times(points), faces)
    points = points + jitter * height / aspect * random.uniform(-1.0, 1.0, points.shape)
    return four_times(points / np.linalg.norm(points, axis=1, keepdims=True)), faces


def four_times(quarter: Points) -> Points:
    """Points together with their images under half turns about the axes, and the poles."""
    turns = [[1, 1, 1], [-1, -1, 1], [1, -1, -1], [-1, 1, -1]]
    return np.concatenate([quarter * turn for turn in turns] + [np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])])


# --- torus and genus two -------------------------------------------------------------------


def torus(columns: int, rows: int, jitter: float = 0.2, seed: int = 1) -> tuple[Points, Faces]:
    """A torus of radii 2 and 0.8, its grid jittered and its diagonals at random."""
    random = np.random.default_rng(seed)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    u = (i + jitter * random.uniform(-1, 1, len(i))) * 2 * np.pi / columns
    v = (j + jitter * random.uniform(-1, 1, len(i))) * 2 * np.pi / rows
    across = 2.0 + 0.8 * np.cos(v)
    points = np.column_stack([across * np.cos(u), across * np.sin(u), 0.8 * np.sin(v)])
    corner = lambda di, dj: (i + di) % columns * rows + (j + dj) % rows  # noqa: E731
    quads = np.column_stack([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)])
    return points, split(quads, random)


def genus_two(cells: int = 2, jitter: float = 0.12, seed: int = 1) -> tuple[Points, Faces]:
    """A block of 5 × 3 × 1 cubes with two tunnels, `cells` voxels to a cube; smoothed, jittered, diagonals random."""
    block = np.ones((5, 3, 1), dtype=bool)
    block[1, 1], block[3, 1] = False, False
    random = np.random.default_rng(seed)
    points, quads = voxel_boundary(block.repeat(cells, 0).repeat(cells, 1).repeat(cells, 2))
    faces = split(quads, random)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    for _ in range(6):
        total, count = np.zeros_like(points), np.zeros(len(points))
        np.add.at(total, edges[:, 0], points[edges[:, 1]])
        np.add.at(count, edges[:, 0], 1.0)
        points = 0.5 * (points + total / count[:, None])
    return points + jitter * random.uniform(-1.0, 1.0, points.shape), faces


def voxel_boundary(solid: NDArray[np.bool_]) -> tuple[Points, Faces]:
    """Corners and outward quads of the surface of a set of voxels; no two voxels may share just an edge."""
    padded = np.pad(solid, 1)
    quads = []
    for axis in range(3):
        step = np.eye(3, dtype=int)[axis]
        side, up = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
        for sign in (1, -1):
            outside = ~np.roll(padded, -sign, axis)
            at = np.argwhere(padded & outside) + (step if sign > 0 else 0)
            ring = [at, at + side, at + side + up, at + up]
            quads.append(np.stack(ring if sign > 0 else ring[::-1], axis=1))
    corners = np.concatenate(quads)
    points, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return points.astype(float), index.reshape(-1, 4)


def split(quads: Faces, random: np.random.Generator) -> Faces:
    """Two triangles a quad, along a random diagonal."""
    a, b, c, d = quads.T
    turned = (random.random(len(quads)) < 0.5)[:, None]
    first = np.where(turned, np.column_stack([a, b, d]), np.column_stack([a, b, c]))
    second = np.where(turned, np.column_stack([b, c, d]), np.column_stack([a, c, d]))
    return np.concatenate([first, second])


# --- a disc of needles ---------------------------------------------------------------------


def needles(n: int, stretch: float, seed: int = 1) -> tuple[Points, Faces]:
    """The unit disc with about n vertices, irregular triangles that are `stretch` times as long in x as in y.

    A random triangulation of an ellipse, flattened: its vertices on the circle lie close at (±1, 0), far at (0, ±1).
    """
    random = np.random.default_rng(seed)
    step = np.sqrt(np.pi * stretch / (np.sqrt(0.75) * n))
    fine = 2.0 * np.pi * np.arange(200_000) / 200_000
    walked = np.cumsum(np.hypot(np.sin(fine), stretch * np.cos(fine)))
    count = 4 * round(walked[-1] * (fine[1] - fine[0]) / step / 4)
    rim = fine[np.searchsorted(walked, walked[-1] * np.arange(count) / count)]
    rows = np.arange(-stretch, stretch, np.sqrt(0.75) * step)
    x, y = np.meshgrid(np.arange(-1.0 - step, 1.0 + step, step), rows)
    x = x + 0.5 * step * (np.arange(len(rows)) % 2)[:, None]
    inside = np.column_stack([x.ravel(), y.ravel()]) + 0.35 * step * random.uniform(-1, 1, (x.size, 2))
    circle = np.column_stack([np.cos(rim), np.sin(rim)])
    inside = inside[far_from(circle * [1.0, stretch], inside, 0.6 * step, stretch)]
    points = np.concatenate([circle, inside / [1.0, stretch]])
    faces = Delaunay(points * [1.0, stretch]).simplices.astype(np.int64)
    a, b, c = (points[faces[:, k]] for k in range(3))
    turn = np.cross(b - a, c - a)
    return points, np.where(turn[:, None] < 0.0, faces[:, ::-1], faces)


def far_from(rim: Points, points: Points, distance: float, stretch: float) -> NDArray[np.bool_]:
    """Which points lie inside the ellipse and not within `distance` of its vertices."""
    within = np.hypot(points[:, 0], points[:, 1] / stretch) < 1.0
    nearest = np.full(len(points), np.inf)
    for place in np.array_split(rim, max(1, len(rim) // 100)):
        nearest = np.minimum(nearest, np.linalg.norm(points[:, None] - place[None], axis=2).min(axis=1))
    return within & (nearest > distance)


# --- measures ------------------------------------------------------------------------------


def smallest_angle(points: Points, faces: Faces) -> NDArray[np.float64]:
    """The smallest angle of each face (F,), in radians."""
    corners = points[faces]
    angles = []
    for k in range(3):
        u, v = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        lengths = np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1)
        angles.append(np.arccos(np.clip(np.einsum("ij,ij->i", u, v) / lengths, -1.0, 1.0)))
    return np.min(angles, axis=0)


def face_normals(points: Points, faces: Faces) -> Points:
    """Unit normals (F, 3)."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)
