"""Surfaces of constant mean curvature from discrete harmonic maps.

The Gauss map of such a surface is harmonic, and the surface follows from it. The rooms follow the mathematics: a
`Domain` has triangles and edge lengths (domain, from plans by meshing); `conditions` prescribe tangent planes along its
boundary and `HarmonicSolver` finds the unit normals N (gauss); `solve_cmc` integrates them to a conjugate surface g and
returns f± = g ± N (surface); `report` measures what came of it (measure). Then surfaces are completed by mirrors
(symmetry) and closed around holes (closing); others span given lines (spanning) or are fitted to goals (fitting); some
are ready-made (catalogue). `panel_net` makes curvature lines and panels of them (nets). `form` makes a shell over a
drawn `Plan`, sized and placed (shells), from Python or from a job file (jobs). Each room opens with such a page::

    import numpy as np
    from solver import conditions, report, shapes, solve_cmc

    plan = shapes.polygon(np.array([(0, 0), (4, 0), (4, 3), (0, 3)]), max_edge=0.25, corner_radius=0.6)
    rim = conditions.binormal(plan, "outer", tilt=np.radians(40))
    surface = solve_cmc(plan, rim, mean_curvature=0.2)
    assert surface.ok, surface.message
    surface.save("shell.obj")
    text = report(surface).summary("m")
"""

from . import interrupts as interrupts  # first: the others take a second, in which Ctrl-C may come
from .catalogue import modules, shapes
from .catalogue.honeycomb_ring import ring
from .catalogue.wente import wente, wente_start
from .catalogue.wente_heights import wente_height
from .closing.close import ClosingResult, close_periods
from .closing.holes import hole
from .closing.moduli import tube
from .domain.domain import Domain
from .domain.shape import Shape
from .errors import CmcError, ConditionError, JobError, MeshError, Status
from .fitting.fit import Fit, fit
from .fitting.gauss_map import fit_gauss_map
from .fitting.outline import fit_outline
from .gauss import conditions
from .gauss.boundary_data import Conditions
from .gauss.harmonic import HarmonicMap, HarmonicSolver
from .gauss.modes import modes_of, saddle
from .measure import (
    Report,
    conformal_distortion,
    gauss_curvature_of,
    mean_curvature_of,
    principal_curvatures,
    report,
    vertex_principal_curvatures,
)
from .nets.field import NetPreview, preview_net
from .nets.lines import Line, curvature_lines, isothermic_coordinates
from .nets.moulds import moulds
from .nets.net import Net
from .nets.panel_net import panel_net
from .nets.planarise import planarise
from .shells.closing_options import ClosingOptions
from .shells.form import form
from .shells.plan import Group, Plan, Settings, read_plan
from .shells.shell import Shell
from .spanning.outline import span_outline
from .spanning.span import Span
from .surface.cmc_surface import CmcSurface
from .surface.periods import periods
from .surface.solve import CmcSolver, solve_cmc
from .symmetry.complete import complete
from .symmetry.completion import Completion
from .symmetry.glued_map import whole
from .symmetry.sides import Side, side_plane
from .version import __version__ as __version__

__all__ = [
    "ClosingOptions",
    "ClosingResult",
    "CmcError",
    "CmcSolver",
    "CmcSurface",
    "Completion",
    "ConditionError",
    "Conditions",
    "Domain",
    "Fit",
    "Group",
    "HarmonicMap",
    "HarmonicSolver",
    "JobError",
    "Line",
    "MeshError",
    "Net",
    "NetPreview",
    "Plan",
    "Report",
    "Settings",
    "Shape",
    "Shell",
    "Side",
    "Span",
    "Status",
    "close_periods",
    "complete",
    "conditions",
    "conformal_distortion",
    "curvature_lines",
    "fit",
    "fit_gauss_map",
    "fit_outline",
    "form",
    "gauss_curvature_of",
    "hole",
    "isothermic_coordinates",
    "mean_curvature_of",
    "modes_of",
    "modules",
    "moulds",
    "panel_net",
    "periods",
    "planarise",
    "preview_net",
    "principal_curvatures",
    "read_plan",
    "report",
    "ring",
    "saddle",
    "shapes",
    "side_plane",
    "solve_cmc",
    "span_outline",
    "tube",
    "vertex_principal_curvatures",
    "wente",
    "wente_height",
    "wente_start",
    "whole",
]


def __dir__() -> list[str]:
    """The public names; rooms are imported by their full names."""
    return list(__all__)
