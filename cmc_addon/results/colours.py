"""The colours of results: by which quantity, over which range, and when they are painted again.

The results of Solve and their copies share one range, fitted to the shown sheet; the Gauss image and g have the
colours of the shell, point by point. Fitted and nearest shells have a range of their own. Every task that writes
results ends with `repaint`; changing a setting never solves.
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

# Width, relative to the size, of the coloured band along a rim when only the rim has values.
_RIM = 0.05
# Least widths of ranges, so that rounding errors show no pattern: relative to H, Q and the size.
_LEAST_H, _LEAST_Q, _LEAST_PART = 0.02, 0.02, 1e-4


def wanted_measures(plan: bpy.types.Object) -> tuple[str, ...]:
    """Names of the quantities that a solve of this plan measures."""
    return USUAL if plan.cmc.curvature_lines == "NONE" else (*USUAL, DIRECTION)


def shown_measures(plan: bpy.types.Object) -> tuple[str, ...]:
    """Names of the quantities on screen: the only ones to measure while a shell is dragged."""
    quantity = QUANTITIES.get(plan.cmc.colour_by)
    names = {attribute: name for name, attribute in ATTRIBUTES.items()}
    shown = () if quantity is None else (names[quantity.attribute],)
    return shown if plan.cmc.curvature_lines == "NONE" else (*shown, DIRECTION)


# --- painting ------------------------------------------------------------------------------

def repaint(plan: bpy.types.Object, sheet: str = "", target: float | None = None) -> None:
    """Colour the results of a plan as its settings say, or remove the colours; see `families`.

    target: the mean curvature that the shell of Solve has now, where its report is of an older one.
    """
    quantity = QUANTITIES.get(plan.cmc.colour_by)
    for family in families(plan, sheet):
        for member in family.members():
            if quantity is None and member.data.is_editable and not member.data.is_editmode:
                unpaint(member.data)
        if quantity is not None:
            _paint(plan.cmc, family, target if family.shell.cmc.role in ROLES else None)


def _paint(settings, family: Family, target: float | None) -> None:
    """Paint a family. An image with other vertices than the shell, and a result in edit mode or linked, stay as is."""
    attribute = QUANTITIES[settings.colour_by].attribute
    values = None if family.shell.data.is_editmode else measure(family.shell.data, attribute, _reported(family.shell))
    stretched = None if values is None else range_of(settings, family.shell, values, target)
    for member in family.members():
        mesh = member.data
        if mesh.is_editmode or not mesh.is_editable:
            continue
        is_same = member in family.images or member is family.shell
        own = values if is_same else measure(mesh, attribute, _reported(member))
        if stretched is None or own is None or len(own) != len(mesh.vertices):
            paint(mesh, Range(0.0, 1.0).linear_colours(np.full(len(mesh.vertices), np.nan)))
            member.cmc.colour_range = (0.0,) * 6
            continue
        paint(mesh, stretched.faded_colours(own, points_of(mesh), _RIM * max(member.dimensions)))
        member.cmc.colour_range = _stored(stretched)


def target_of(shell: bpy.types.Object, values: Array) -> float:
    """The target mean curvature of a shell: from its report, else the median on it."""
    reported = shell.get("cmc_mean_curvature")
    return float(reported) if isinstance(reported, (int, float)) else float(np.nanmedian(values))


def _reported(ob: bpy.types.Object) -> float:
    """The target mean curvature of a result by its report; without one any positive number, as for a dome."""
    reported = ob.get("cmc_mean_curvature")
    return float(reported) if isinstance(reported, (int, float)) else 1.0


def range_of(settings, shell: bpy.types.Object, values: Array, target: float | None = None) -> Range:
    """The range of a shell's colours: fitted, or as the settings say."""
    by = settings.colour_by
    H = target_of(shell, values) if target is None else target
    centre = {"MEAN_CURVATURE": H, "GAUSS_CURVATURE": 0.0}.get(by)
    if not settings.colour_fit:
        inside = centre is not None and settings.colour_min <= centre <= settings.colour_max
        return fixed_range(values, settings.colour_min, settings.colour_max, centre if inside else None)
    if by == "MEAN_CURVATURE" and centre is not None:
        return fit_about(values, centre, _LEAST_H * max(abs(centre), 1.0 / (max(shell.dimensions) or 1.0)))
    if by == "GAUSS_CURVATURE":
        return fit_around_zero(values)
    if by == "DISTORTION":
        return fit_from(values, 1.0, _LEAST_Q)
    return fit_from(values, 0.0, _LEAST_PART * (max(shell.dimensions) or 1.0))


def _stored(span: Range) -> tuple[float, ...]:
    return span.low, span.high, span.centre or 0.0, span.centre is not None, span.below, span.above


# --- when a setting changes ----------------------------------------------------------------

def changed(plan: bpy.types.Object, context: bpy.types.Context, name: str) -> None:
    """A setting of this plan has changed."""
    settings = plan.cmc
    if name in ("colour_min", "colour_max") and settings.colour_fit:
        return
    if name == "colour_by" and not settings.colour_fit:
        settings.colour_fit = True  # the range of another quantity does not fit; this calls `changed` again
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
    """Start the user's range from the fitted one."""
    ranges = (stored_range(family.shell) for family in families(plan))
    first = next((span for span in ranges if span is not None), None)
    if first is not None:
        plan.cmc.colour_min, plan.cmc.colour_max = first.low, first.high


def _measure_lines(plan: bpy.types.Object) -> None:
    """If curvature lines are shown now, write their directions on the results."""
    if plan.cmc.curvature_lines == "NONE":
        return
    for family in families(plan):
        for member in (family.shell, *family.others):
            if not member.data.is_editmode and member.data.is_editable:
                put_measure(member.data, ATTRIBUTES[DIRECTION], _reported(member))


def register() -> None:
    watchers.append(changed)


def unregister() -> None:
    if changed in watchers:
        watchers.remove(changed)
