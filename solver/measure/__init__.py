"""Measures of a surface: curvature, distortion, overhang, intersections, and the report of all of them.

Curvature comes from the normals at the vertices: `curvature` has the Regge shape operator of each face, with mean,
Gauss and principal curvatures (`PrincipalCurvatures`), `directions` those at the vertices (`VertexCurvatures`).
`distortion` compares triangles in space with the domain, `outline` a boundary with a drawn line, `planes` a side with
its plane; `extent` finds overhangs, `intersections` faces that cross, with boxes in a tree (`aabb_tree`), `volume` what
is under a sheet, `steiner` the mean curvature of the flat panels of the corner complex, `curvature_fault` where and why
H is off. Measures take plain arrays and return one value for each face or vertex. A `SheetReport` sums up one sheet, a
`Report` a solve and its sheets, as numbers, JSON, or a few lines of text (`summary`)::

    from solver import conditions, mean_curvature_of, report, shapes, solve_cmc

    disc = shapes.disc(300)
    surface = solve_cmc(disc, conditions.binormal(disc, "outer", tilt=0.4))
    H = mean_curvature_of(surface.f_plus, surface.faces, surface.normals)
    assert abs(H - 0.5).max() < 0.02
    result = report(surface, intersections=False)
    assert result.message.startswith("Done. Curvature is even to")
    assert result.shown.rise > 0.0
"""

from .arrays import vertex_means
from .curvature import (
    PrincipalCurvatures,
    face_frames,
    gauss_curvature_of,
    mean_curvature_of,
    principal_curvatures,
    shape_operator,
    vertex_gauss_curvature,
    vertex_mean_curvature,
)
from .directions import VertexCurvatures, vertex_principal_curvatures
from .distortion import conformal_distortion, distortion_energy, distortion_of_layout
from .extent import boundary_sides, face_normals, leans, overhanging_faces
from .intersections import self_intersections
from .report import Report, report
from .sheet import CurvatureReport, DistortionReport, IntersectionReport, OutlineReport, OverhangReport, SheetReport

__all__ = [
    "CurvatureReport",
    "DistortionReport",
    "IntersectionReport",
    "OutlineReport",
    "OverhangReport",
    "PrincipalCurvatures",
    "Report",
    "SheetReport",
    "VertexCurvatures",
    "boundary_sides",
    "conformal_distortion",
    "distortion_energy",
    "distortion_of_layout",
    "face_frames",
    "face_normals",
    "gauss_curvature_of",
    "leans",
    "mean_curvature_of",
    "overhanging_faces",
    "principal_curvatures",
    "report",
    "self_intersections",
    "shape_operator",
    "vertex_gauss_curvature",
    "vertex_mean_curvature",
    "vertex_means",
    "vertex_principal_curvatures",
]
