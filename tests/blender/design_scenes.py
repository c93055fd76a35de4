"""Plans, curves and surfaces to fit to, the calls of both fits, and measures of the results."""

from __future__ import annotations

import json
from types import SimpleNamespace

import bpy

# isort: split
import numpy as np

from .scenes import activate, boundary_edges, mesh_object, positions, quad_disc

FINISHED, CANCELLED = {"FINISHED"}, {"CANCELLED"}


def rim_of(plan) -> np.ndarray:
    return np.unique([tuple(plan.data.edges[e].vertices) for e in boundary_edges(plan.data)])


def fitted(plan, **settings) -> np.ndarray:
    """World points of the result of Fit to Outline."""
    activate(plan)
    assert bpy.ops.cmc.fit_outline(**settings) == FINISHED
    return positions(plan.cmc.fit)


def approximated(surface, **settings) -> np.ndarray:
    activate(surface)
    assert bpy.ops.cmc.approximate_surface(**settings) == FINISHED
    return positions(surface.cmc.nearest)


def report(plan) -> dict:
    return json.loads(plan.cmc.design_report)


def off_line(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Distances of points from a closed polyline."""
    a, d = line, np.roll(line, -1, axis=0) - line
    t = np.einsum("nmi,mi->nm", points[:, None] - a, d) / np.einsum("mi,mi->m", d, d)
    return np.linalg.norm(points[:, None] - a - t.clip(0, 1)[..., None] * d, axis=2).min(axis=1)


def small_disc(name="Disc", **options):
    return quad_disc(name, rings=5, columns=24, **options)


def cap(name="Cap", rings=8, columns=32, radius=4.0, ball=5.0):
    """A piece of a sphere over a disc."""
    ob = quad_disc(name, rings=rings, columns=columns, radius=radius)
    for vertex in ob.data.vertices:
        vertex.co.z = np.sqrt(ball**2 - vertex.co.x**2 - vertex.co.y**2)
    return ob


def raised_loop(name="Curve", count=48, radius=4.0, lift=0.5):
    t = 2 * np.pi * np.arange(count) / count
    points = np.column_stack([radius * np.cos(t), radius * np.sin(t), 1.0 + lift * np.cos(2 * t)])
    return mesh_object(name, points, [], edges=[(k, (k + 1) % count) for k in range(count)]), points


def empties(places, collection=None):
    found = []
    for k, place in enumerate(places):
        ob = bpy.data.objects.new(f"Anchor {k}", None)
        ob.location = place
        (collection or bpy.context.scene.collection).objects.link(ob)
        found.append(ob)
    return found


def nearest(points, place) -> float:
    return np.linalg.norm(points - place, axis=1).min()


def wavy(name="Wavy"):
    ob = quad_disc(name, rings=8, columns=32, rise=1.5)
    for vertex in ob.data.vertices:
        vertex.co.z += 0.15 * np.sin(3 * vertex.co.x) * np.cos(2 * vertex.co.y)
    ob.location = (30.0, -20.0, 5.0)
    return ob


def hand_for(design, operator):
    """Stands in for Blender's operator; the test calls its ticks."""

    class Hand(design.DesignOperator):
        bl_label, read_task = "Fit to Outline", operator.read_task
        properties = SimpleNamespace(is_property_set=lambda name: False)

        def __init__(self):
            self.reports = []
            self._work = self.steps(bpy.context, 0.01)

        def report(self, kind, text):
            self.reports.append((kind, text))

        def tick(self, kind="TIMER", value="NOTHING"):
            return self.modal(bpy.context, SimpleNamespace(type=kind, value=value))

    return Hand()


FEET = [(4.0, 0.0, 0.0), (0.0, 4.0, 0.4), (-4.0, 0.0, 0.0), (0.0, -4.0, 0.4)]
