"""What was obtained: curvature, distortion, intersections, and the report."""

from .curvature import (
    PrincipalCurvatures,
    face_frames,
    gauss_curvature_of,
    mean_curvature_of,
    principal_curvatures,
    shape_operator,
    vertex_mean_curvature,
)
from .distortion import conformal_distortion, distortion_energy, distortion_of_layout
from .extent import boundary_sides, face_normals, leans, overhanging_faces
from .intersections import self_intersections
from .report import Report, report
from .sheet import (
    CurvatureReport,
    DistortionReport,
    IntersectionReport,
    OutlineReport,
    OverhangReport,
    SheetReport,
)

__all__ = [
    "CurvatureReport",
    "DistortionReport",
    "IntersectionReport",
    "OutlineReport",
    "OverhangReport",
    "PrincipalCurvatures",
    "Report",
    "SheetReport",
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
    "vertex_mean_curvature",
]
