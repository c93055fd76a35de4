"""The colours of results: what a plan's results are coloured by, over which range, and when that is done again.

The results of Solve, and what is completed from them, share one range, fitted to the sheet that is shown; the Gauss
image and g have the colours of the shell, point by point. Fitted and nearest shells have a range of their own. Every
operator that writes results ends with `repaint`; changing a setting never solves.
"""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.shells.vertex_measures import DIRECTION
from ..bridges.colour_bridge import measure, paint, points_of, put_measure, unpaint
from ..drawing import shading
from ..properties.attributes import ATTRIBUTES, USUAL
from ..properties.colour_maps import Range, fit_about, fit_around_zero, fit_from, fixed_range
from ..properties.colour_range import stored_range
from ..properties.colour_settings import QUANTITIES, watchers
from ..properties.links import Family, families
from ..properties.stored import ROLES

Array = NDArray[np.float64]

# Width, as a part of the size, of the band by which a rim that alone has numbers shows them.
_RIM = 0.05
# Least widths of ranges, so that rounding is not made to look like something: parts of H, of Q, of the size.
_LEAST_H, _LEAST_Q, _LEAST_PART = 0.02, 0.02, 1e-4


def wanted_measures(plan: bpy.types.Object) -> tuple[str, ...]:
    """Names of what a solve of this plan measures."""
    return USUAL if plan.cmc.curvature_lines == "NONE" else (*USUAL, DIRECTION)


def shown_measures(plan: bpy.types.Object) -> tuple[str, ...]:
    """Names of what can be seen now: all that has to be measured while a shell is dragged."""
    quantity = QUANTITIES.get(plan.cmc.colour_by)
    names = {attribute: name for name, attribute in ATTRIBUTES.items()}
    shown = () if quantity is None else (names[quantity.attribute],)
    return shown if plan.cmc.curvature_lines == "NONE" else (*shown, DIRECTION)


# --- what belongs together -----------------------------------------------------------------

# --- painting ------------------------------------------------------------------------------

def repaint(plan: bpy.types.Object, sheet: str = "", target: float | None = None) -> None:
    """Colour the results of a plan as its settings say, or take the colours away; see `families`.

    target: the mean curvature that the shell of Solve is to have now, where its report is of an older one.
    """
    quantity = QUANTITIES.get(plan.cmc.colour_by)
    for family in families(plan, sheet):
        for member in family.members():
            if quantity is None and member.data.is_editable and not member.data.is_editmode:
                unpaint(member.data)
        if quantity is not None:
            _paint(plan.cmc, family, target if family.shell.cmc.role in ROLES else None)


def _paint(settings, family: Family, target: float | None) -> None:
    """An image of another size than the shell, a result in edit mode or of another file is left as it is."""
    attribute = QUANTITIES[settings.colour_by].attribute
    values = None if family.shell.data.is_editmode else measure(family.shell.data, attribute)
    stretched = None if values is None else range_of(settings, family.shell, values, target)
    for member in family.members():
        mesh = member.data
        if mesh.is_editmode or not mesh.is_editable:
            continue
        own = values if member in family.images or member is family.shell else measure(mesh, attribute)
        if stretched is None or own is None or len(own) != len(mesh.vertices):
            paint(mesh, Range(0.0, 1.0).linear_colours(np.full(len(mesh.vertices), np.nan)))
            member.cmc.colour_range = (0.0,) * 6
            continue
        paint(mesh, stretched.faded_colours(own, points_of(mesh), _RIM * max(member.dimensions)))
        member.cmc.colour_range = _stored(stretched)


def target_of(shell: bpy.types.Object, values: Array) -> float:
    """The mean curvature that a shell is to have: of its report, else the usual one on it."""
    told = shell.get("cmc_mean_curvature")
    return float(told) if isinstance(told, (int, float)) else float(np.nanmedian(values))


def range_of(settings, shell: bpy.types.Object, values: Array, target: float | None = None) -> Range:
    """The range of a shell's colours: fitted, or as the settings say."""
    by = settings.colour_by
    centre = {"MEAN_CURVATURE": target or target_of(shell, values), "GAUSS_CURVATURE": 0.0}.get(by)
    if not settings.colour_fit:
        inside = centre is not None and settings.colour_min <= centre <= settings.colour_max
        return fixed_range(values, settings.colour_min, settings.colour_max, centre if inside else None)
    if by == "MEAN_CURVATURE":
        return fit_about(values, centre, _LEAST_H * abs(centre))
    if by == "GAUSS_CURVATURE":
        return fit_around_zero(values)
    if by == "DISTORTION":
        return fit_from(values, 1.0, _LEAST_Q)
    return fit_from(values, 0.0, _LEAST_PART * (max(shell.dimensions) or 1.0))


def _stored(found: Range) -> tuple[float, ...]:
    return (
        found.low, found.high, found.centre or 0.0, found.centre is not None, found.below, found.above
    )


# --- when a setting changes ----------------------------------------------------------------

def changed(plan: bpy.types.Object, context: bpy.types.Context, name: str) -> None:
    """A setting of this plan has changed."""
    settings = plan.cmc
    if name in ("colour_min", "colour_max") and settings.colour_fit:
        return
    if name == "colour_by" and not settings.colour_fit:
        settings.colour_fit = True  # numbers of another quantity say nothing of this one; comes back here
        return
    if name == "colour_fit" and not settings.colour_fit:
        _start_from_fitted(plan)
    if name.startswith("curvature_line"):
        _measure_lines(plan)
    else:
        repaint(plan)
    if name == "colour_by":
        shading.follow(context)


def _start_from_fitted(plan: bpy.types.Object) -> None:
    """The user's range begins with the one that was fitted."""
    known = [stored_range(family.shell) for family in families(plan)]
    first = next((found for found in known if found is not None), None)
    if first is not None:
        plan.cmc.colour_min, plan.cmc.colour_max = first.low, first.high


def _measure_lines(plan: bpy.types.Object) -> None:
    """Where strokes are shown from now on, results get their lines of curvature."""
    if plan.cmc.curvature_lines == "NONE":
        return
    for family in families(plan):
        for member in (family.shell, *family.others):
            if not member.data.is_editmode and member.data.is_editable:
                put_measure(member.data, ATTRIBUTES[DIRECTION])


def register() -> None:
    watchers.append(changed)


def unregister() -> None:
    if changed in watchers:
        watchers.remove(changed)
