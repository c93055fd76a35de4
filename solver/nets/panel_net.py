"""Nets of panels on a surface: the door to this room."""

from __future__ import annotations

from ..fitting.fit import Fit
from ..signatures import checked
from ..surface.cmc_surface import SurfaceLike
from ..symmetry.completion import Completion
from .assembly import net_of_count
from .completed import completed_net
from .field import line_field
from .net import Net
from .planarise import planarise
from .sheets import PlacedSurface


@checked
def panel_net(
    surface: SurfaceLike | PlacedSurface | Fit | Completion,
    spacing: float | None = None,
    *,
    count: int | None = None,
    kind: str = "principal",
    sheet: str = "f+",
    planar: bool = False,
) -> Net:
    """A net of panels along the curvature lines of a surface of constant mean curvature, or along their diagonals.

    Lines of whole numbers of w = ∫ √Q dz, Q the Hopf differential 4 <f_z, N_z>: they close around umbilics and loops.
    The mesh is that of the lines' crossings. Inner panels have four corners, and 4 + 2 n around umbilics of order n;
    at the rim panels are clipped, the smallest ones joined to their neighbours.

    surface: a `CmcSurface`, `Span`, `Fit` or `Shell`, or a `Completion`: then the net goes on across the mirrors, and
    `sheet` is that of the completion. spacing: the wanted side of a panel in model length, its median over the net;
    sides vary as 1 / √(k1 - k2). count: or the number of panels, about. kind: "principal", or "diagonal": the lines of
    normal curvature H at 45° to these, at H = 0 the asymptotic lines. sheet: "f+", "f-" or "g". planar: make the panels
    flat, as `planarise` does.

    Raises `MeshError` on surfaces with handles and on meshes too coarse; `ConditionError` on spheres and planes, which
    have no curvature lines, and on a spacing too large for the surface.
    """
    if isinstance(surface, Completion):
        net = completed_net(surface, spacing, count, kind)
    else:
        net = net_of_count(line_field(surface, spacing, count, kind, sheet), count)
    return planarise(net) if planar else net
