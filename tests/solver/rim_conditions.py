"""Conditions along the whole rim of a plan."""

from __future__ import annotations

from solver import conditions


def rim(domain, points, tilt=0.0):
    return conditions.binormal(domain, points, domain.boundary_edges, tilt=tilt)


def once_twisted(domain, points):
    return conditions.twisted(domain, points, domain.boundary_edges, 1)
