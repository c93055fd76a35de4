"""Moulds: which whole panels of a net fit one curved surface, by a rigid motion, within a tolerance.

In the middle of its sides a panel of a principal net departs from the sphere of radius 1 / |H| by L² (k1 - k2) / 16 =
w² / 16, the same for all (`Net.sphere_gap`): from that tolerance on one spherical mould serves. Below it, k1 alone
tells panels apart at first (k1 + k2 = 2H), but not how the curvature changes over them; so every panel is laid on its
mould.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from ..errors import ConditionError, Interrupted, Progress
from ..limits import POSITIVE, check_number
from ..signatures import checked
from .net import Net
from .patches import frames, height, local, quads, quartic, samples, sphere_quartic

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Panels tried as a mould in each round; the panels around, whose points continue it, and the weight of these points.
_TRIED, _AROUND, _BESIDE = 6, 9, 0.02
# A panel whose curvature lets it depart from a mould by more than this many tolerances is not laid on it.
_HOPELESS = 2.0
# Steps of Gauss and Newton that lay a panel on a mould.
_STEPS = 4


@checked
def moulds(net: Net, tolerance: float, *, progress: Progress | None = None) -> NDArray[np.int64]:
    """The mould (P,) of each whole four-sided panel, -1 for the others, which are bent or cut to measure.

    Mould 0 serves most panels. Each panel, 5 × 5 points of its curved surface, lies within `tolerance`, in model
    length, of its mould after a rigid motion; panels are not turned over. Moulds are spheres of radius 1 / |H| or
    surfaces of panels, continued; the least number of moulds may be smaller than the one found.

    progress: called with the number of moulds so far and the part of the panels without one; when it returns False
    `Interrupted` is raised. Raises `ConditionError` on nets on g and on a tolerance that is no positive number.
    """
    return covered(net, tolerance, progress)[0]


def covered(net: Net, tolerance: float, progress: Progress | None = None) -> tuple[NDArray[np.int64], Array]:
    """Moulds (P,) as `moulds`, and how far each panel is from its mould (P,), nan for those without."""
    check_number(tolerance, "tolerance of moulds", POSITIVE)
    if net.sheet == "g":
        raise ConditionError("Moulds are for panels of the sheets f+ and f-; make the net on one of them.")
    numbers, off = np.full(len(net.polygons), -1), np.full(len(net.polygons), np.nan)
    panels = quads(net)
    if not len(panels):
        return numbers, off
    points = samples(net, panels)
    centres, axes = frames(net, panels, points)
    shapes = local(points, centres, axes)
    near = KDTree(centres).query(centres, min(_AROUND, len(panels)))[1].reshape(len(panels), -1)
    weights = np.repeat([1.0] + [_BESIDE] * (near.shape[1] - 1), points.shape[1])
    k1, squares = net.curvature[panels], net.area[panels]
    order = np.argsort(k1)
    left = np.ones(len(panels), dtype=bool)
    mould = 0
    while left.any():
        if progress is not None and progress(mould, float(left.mean())) is False:
            raise Interrupted
        waiting = order[left[order]]
        gaps = []
        for k in waiting[np.unique(np.linspace(0, len(waiting) - 1, _TRIED).astype(np.int64))]:
            surface = quartic(local(points[near[k]].reshape(1, -1, 3), centres[[k]], axes[[k]])[0], weights)
            # the departure of panels of one H with other curvatures is L² |Δk1| / 8 in the middle of their sides
            hopeful = squares[waiting] * np.abs(k1[waiting] - k1[k]) / 8.0 <= _HOPELESS * tolerance
            gaps.append(np.where(waiting == k, 0.0, np.inf))
            gaps[-1][hopeful] = np.minimum(gaps[-1][hopeful], _laid(surface, shapes[waiting[hopeful]]))
        if net.mean_curvature and mould == 0 and net.sphere_gap < _HOPELESS * tolerance:
            gaps.append(_laid(sphere_quartic(net.mean_curvature), shapes[waiting]))
        fits = np.array(gaps) <= tolerance
        best = int(np.argmax(fits.sum(axis=1)))
        mine = fits[best]
        numbers[panels[waiting[mine]]] = mould
        off[panels[waiting[mine]]] = gaps[best][mine]
        left[waiting[mine]] = False
        mould += 1
    return numbers, off


def _laid(surface: Array, shapes: Array) -> Array:
    """The largest distance (p,) of points (p, n, 3) from a surface z(x, y) after the best rigid motion.

    Two starts: as the frames are, and turned by 180° about the normal.
    """
    found = []
    for turn in (1.0, -1.0):
        moved = shapes * [turn, turn, 1.0]
        best = np.full(len(shapes), np.inf)
        for step in range(_STEPS + 1):
            z, zx, zy = height(surface, moved[..., 0], moved[..., 1])
            normal = np.stack([-zx, -zy, np.ones_like(z)], axis=2)
            normal /= np.linalg.norm(normal, axis=2, keepdims=True)
            off = (moved[..., 2] - z) * normal[..., 2]
            best = np.minimum(best, np.abs(off).max(axis=1))
            if step < _STEPS:
                moved = _stepped(moved, normal, off)
        found.append(best)
    return np.minimum(*found)


def _stepped(points: Array, normal: Array, off: Array) -> Array:
    """Points after the small rigid motion that brings them nearest to their tangent planes.

    Motions along a sphere change nothing; they are held by a little weight.
    """
    J = np.concatenate([np.cross(points, normal), normal], axis=2)
    size = np.abs(points).max(axis=(1, 2))
    J[..., :3] /= size[:, None, None]
    A = np.einsum("pni,pnj->pij", J, J) + 1e-6 * points.shape[1] * np.eye(6)
    d = -np.linalg.solve(A, np.einsum("pni,pn->pi", J, off)[..., None])[..., 0]
    angle = d[:, :3] / size[:, None]
    length = np.linalg.norm(angle, axis=1)
    axis = angle / np.maximum(length, 1e-300)[:, None]
    cos, sin = np.cos(length)[:, None, None], np.sin(length)[:, None, None]
    along = np.einsum("pi,pni->pn", axis, points)[..., None] * axis[:, None]
    turned = cos * points + sin * np.cross(axis[:, None], points) + (1.0 - cos) * along
    return turned + d[:, None, 3:]
