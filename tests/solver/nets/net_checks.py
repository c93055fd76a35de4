"""What holds for every net."""

from __future__ import annotations

import numpy as np

from solver import Net


def faults(net: Net) -> list[str]:
    """What is wrong with the topology, the orientation or the directions of a net; empty where it is right."""
    found = []
    if net.counted != net.euler_characteristic:
        found.append(f"V - E + F is {net.counted}, not {net.euler_characteristic}")
    if len(np.unique(np.sort(net.edges, axis=1), axis=0)) != len(net.edges):
        found.append("an edge is there twice")
    if len(net.flipped):
        found.append(f"{len(net.flipped)} panels look the other way")
    corners = np.array([len(polygon) for polygon in net.polygons])
    wrong = corners[net.inner] != 4 + 2 * net.orders[net.inner]
    if wrong.any():
        found.append(f"{wrong.sum()} inner panels have not 4 + 2 Σ orders corners")
    if np.degrees(net.deviation) > 5.0:
        found.append(f"the lines are {np.degrees(net.deviation):.1f}° off")
    valence = np.bincount(net.edges.ravel(), minlength=len(net.vertices))
    rim = np.zeros(len(net.vertices), dtype=bool)
    rim[net.edges[net.family < 0]] = True
    merged = np.zeros(len(net.vertices), dtype=bool)
    for panel in np.flatnonzero(net.clipped):
        merged[net.polygons[panel]] = True
    if (valence[~rim & ~merged] != 4).any():
        found.append("an inner node has not four edges")
    return found


def gaps(net: Net) -> np.ndarray:
    """The planarity of whole panels as parts of their diagonals."""
    return net.planarity[net.inner] / net.diagonal[net.inner]
