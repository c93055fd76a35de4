"""The Gauss image beside the shell: the normals of the existing shell as points of a sphere.

Solve makes it, too, where it is wanted, around the middle of the plan, and keeps it up to date wherever it is.
"""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Vector
from numpy.typing import NDArray

from ...solver.errors import CmcError
from ...solver.surface.placement import rim_weights
from ..bridges.colour_bridge import surface_of
from ..bridges.mesh_bridge import PlanMesh, read_plan
from ..properties.links import result_of
from . import colours
from .objects import Writer, world_box, write_report

# Distance of the image from the shell, in radii.
_APART = 0.35
# A view whose left is nearly vertical, as after a roll, has no level direction to the left.
_LEVEL = 0.1


def is_shown(plan: bpy.types.Object) -> bool:
    image = result_of(plan, "GAUSS")
    return image is not None and not image.hide_viewport


def hide(plan: bpy.types.Object) -> None:
    """Hide the image; solves still keep it up to date."""
    image = result_of(plan, "GAUSS")
    plan.cmc.want_gauss = False
    if image is not None:
        image.cmc.parked = image.hide_viewport = image.hide_render = True


def show(context: bpy.types.Context, plan: bpy.types.Object) -> bpy.types.Object:
    """Show the image beside the shell; make it if it does not exist. If the user has moved it, it stays where it is.

    Raises `CmcError` where the plan has no shell or the shell cannot be read.
    """
    shell = result_of(plan, plan.cmc.sheet)
    if shell is None:
        raise CmcError(f"'{plan.name}' has no shell yet; solve it first.")
    image = result_of(plan, "GAUSS") or _make(context, plan, shell)
    plan.cmc.want_gauss = True
    image.cmc.parked = image.hide_viewport = image.hide_render = False
    context.view_layer.update()
    if np.allclose(image.location, image.cmc.placed_at, atol=1e-6):
        sideways = left_of(context.space_data)
        image.location += sideways * _beside(shell, image, sideways)
    colours.repaint(plan)
    return image


def _make(context: bpy.types.Context, plan: bpy.types.Object, shell: bpy.types.Object) -> bpy.types.Object:
    if shell.data.is_editmode:
        raise CmcError(f"The result '{shell.name}' is in edit mode; leave it (Tab) first.")
    if "cmc_mean_curvature" not in shell:
        raise CmcError(f"'{shell.name}' has no report; solve again.")
    H = float(shell["cmc_mean_curvature"])
    radius = 0.5 / abs(H) if H else 1.0  # as the solver has it
    towards = surface_of(shell.data, H)[2] * (1.0 if plan.cmc.sheet == "F_PLUS" else -1.0)
    mesh = read_plan(plan)
    writer = Writer(context, plan, None, mesh, None)
    image = writer.write_alike("GAUSS", shell, _middle(mesh) + radius * towards, towards)
    write_report(image, {"plan": plan.name})
    if "cmc_report" in shell:
        image["cmc_report"] = shell["cmc_report"]
    return image


def _middle(mesh: PlanMesh) -> NDArray[np.float64]:
    """The centre of the image that Solve uses: the mean of the plan's rim, or of all vertices of a closed plan."""
    if not mesh.boundary.any():
        return mesh.positions.mean(axis=0)
    rim, weights = rim_weights(mesh.positions, mesh.edges[mesh.boundary])
    return np.average(mesh.positions[rim], axis=0, weights=weights)


def left_of(space: bpy.types.Space | None) -> Vector:
    """The level direction to the left of the viewer: the image is not in front of the shell then, nor behind the
    sidebar; -X without a view."""
    if space is None or space.type != "VIEW_3D":
        return Vector((-1.0, 0.0, 0.0))
    left = space.region_3d.view_rotation @ Vector((-1.0, 0.0, 0.0))
    left.z = 0.0
    return left.normalized() if left.length > _LEVEL else Vector((-1.0, 0.0, 0.0))


def _beside(shell: bpy.types.Object, image: bpy.types.Object, sideways: Vector) -> float:
    """How far to move the image sideways to clear the shell."""
    far, near = (side(world_box(ob) @ np.array(sideways)) for ob, side in ((shell, np.max), (image, np.min)))
    return float(far - near) + _APART * 0.5 * max(image.dimensions)
