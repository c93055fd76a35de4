"""Surfaces to approximate, the call, and what it reports."""

from __future__ import annotations

import json
from types import SimpleNamespace

import bpy

# isort: split
import numpy as np

from .scenes import activate, positions, quad_disc

FINISHED, CANCELLED = {"FINISHED"}, {"CANCELLED"}


def approximated(surface, **settings) -> np.ndarray:
    activate(surface)
    assert bpy.ops.cmc.approximate_surface(**settings) == FINISHED
    return positions(surface.cmc.nearest)


def report(plan) -> dict:
    return json.loads(plan.cmc.design_report)


def cap(name="Cap", rings=8, columns=32, radius=4.0, ball=5.0):
    """A piece of a sphere over a disc."""
    ob = quad_disc(name, rings=rings, columns=columns, radius=radius)
    for vertex in ob.data.vertices:
        vertex.co.z = np.sqrt(ball**2 - vertex.co.x**2 - vertex.co.y**2)
    return ob


def wavy(name="Wavy"):
    ob = quad_disc(name, rings=8, columns=32, rise=1.5)
    for vertex in ob.data.vertices:
        vertex.co.z += 0.15 * np.sin(3 * vertex.co.x) * np.cos(2 * vertex.co.y)
    ob.location = (30.0, -20.0, 5.0)
    return ob


def hand_for(operators):
    """Stands in for Blender's operator; the test calls its ticks."""
    operator = operators.CMC_OT_approximate_surface

    class Hand(operators.PreviewOperator):
        bl_label, read_task = operator.bl_label, operator.read_task
        properties = SimpleNamespace(is_property_set=lambda name: False)

        def __init__(self):
            self.reports = []
            self._work = self.steps(bpy.context, 0.01)

        def report(self, kind, text):
            self.reports.append((kind, text))

        def tick(self, kind="TIMER", value="NOTHING"):
            return self.modal(bpy.context, SimpleNamespace(type=kind, value=value))

    return Hand()
