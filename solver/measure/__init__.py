"""What was obtained: curvature, distortion, intersections, and the report."""

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
