"""Mirrors and planes along the sides of a surface, the copies they generate, and how copies are welded."""
