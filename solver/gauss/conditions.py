"""Boundary conditions: prescribed tangent planes, mirrors and free edges along the boundary.

A condition fixes the normals N at some sites, or holds them in a plane with normal ν (a mirror, N · ν = 0; paper, Sec.
5.1.1). Conditions are combined with `+`. Where kinds meet at a site, fixed goes before mirror before free: two normals
that fix it blend to their normalised sum, as a normal does with its reflection; two mirrors leave N = ±ν₁ × ν₂. Sites
without a condition are free: there the natural condition ∂N/∂ν = 0 holds by itself (paper, Sec. 5.1).

`line` and `lean` say where the rim is, and nothing about normals: such surfaces are spanned (`span_outline`, `form`),
with mirrors beside them if wanted, and no map is solved for them.

Every condition takes a domain or a shape. `edges` are indices into `domain.edges`, (K, 2) vertex pairs or, of a shape,
the name of a side or a list of names; a shape brings its positions, too, so they may be left out:
`binormal(shape, "outer", tilt=0.6)`. Angles are radians.

Conditions along boundary edges serve every kind of site. With normals at vertices they hold at the vertices of the
edges. With normals at faces an edge fixes the normal of the face behind it, to the value in the middle of the edge:
half a triangle too far inside (paper, Fig. 7, bottom). The shell is then that of a narrower plan, a first-order error,
and a rough one where the triangles are irregular. With "faces_and_rim" the condition holds in the middle of the edge
itself, half-way between the face and its mirror image, and the face is free.
"""

from __future__ import annotations

from .boundary_data import Conditions
from .held import balanced, corner, fixed, fixed_at, fixed_at_faces, free, mirror
from .kinds import KINDS, Kind, Parameter, build
from .lines import lean, line
from .rim_normals import AGAINST, binormal, gauss_map, twisted

__all__ = [
    "AGAINST",
    "KINDS",
    "Conditions",
    "Kind",
    "Parameter",
    "balanced",
    "binormal",
    "build",
    "corner",
    "fixed",
    "fixed_at",
    "fixed_at_faces",
    "free",
    "gauss_map",
    "lean",
    "line",
    "mirror",
    "twisted",
]


def __dir__() -> list[str]:
    """The public names only."""
    return list(__all__)
