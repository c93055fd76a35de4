"""Inverse problems: the boundary normals whose surface comes nearest to what is wanted."""
