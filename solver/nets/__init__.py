"""Nets: curvature lines and panels."""
