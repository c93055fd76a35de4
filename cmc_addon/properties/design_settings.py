"""Settings of Approximate Surface and Fit to Outline, for `Object.cmc` and for the operators.

Height parameters come from the solver's registry: one added there appears here, and needs its property.
"""

import math
from collections.abc import Iterable
from functools import partial
from types import SimpleNamespace
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, PointerProperty, StringProperty

from ...solver.errors import CmcError
from ...solver.fitting.goals import HEIGHT_PARAMETERS
from .changes import notify, notifying

HEIGHT_PROPERTY = {name.upper(): f"fit_{name}" for name in HEIGHT_PARAMETERS}
"""Height parameter (an enum identifier) -> the setting with its value."""

_FIT_TO = [
    ("OUTLINE", "Outline", "The rim of the shell lies on the outline of the plan"),
    ("CURVE", "Curve", "The rim of the shell lies on another closed curve, which may rise and fall"),
    ("ANCHORS", "Anchors", "The shell passes through empties; its rim is free between them"),
]

_MATCH = [
    ("TANGENT_PLANES", "Tangent Planes", "The shell keeps the tangent planes of the surface as far as it can"),
    ("POSITION", "Position", "The shell also stays near the surface"),
]

_APPROXIMATE = {
    "smoothness": partial(
        FloatProperty,
        name="Smoothness",
        default=1e-3,
        min=0.0,
        soft_max=0.1,
        max=1e3,
        precision=5,
        step=0.1,
        description="Weight λ of smooth boundary normals against nearness to the surface; a larger one smooths out "
        "waves of the rim",
    ),
    "match": partial(
        EnumProperty, name="Match", description="Property of the surface that the shell matches", items=_MATCH
    ),
    "near": partial(
        FloatProperty,
        name="Nearness",
        default=100.0,
        min=1e-3,
        soft_max=1e4,
        max=1e6,
        precision=1,
        step=1000,
        description="Weight of the distance from the surface against the turn of its tangent planes; at 100 a "
        "hundredth of its size counts as much as 6°",
    ),
}
_FIT = {
    "fit_to": partial(EnumProperty, name="Fit To", description="Where the rim of the shell should lie", items=_FIT_TO),
    "height_parameter": partial(
        EnumProperty,
        name="Choose By",
        description="Quantity that selects one of the shells with this rim",
        items=[(name.upper(), known.label, known.description) for name, known in HEIGHT_PARAMETERS.items()],
        default="RISE",
    ),
    "fit_rise": partial(
        FloatProperty,
        name="Rise",
        description=HEIGHT_PARAMETERS["rise"].description,
        default=0.5,
        min=0.01,
        max=2.0,
        soft_max=1.0,
        subtype="FACTOR",
    ),
    "fit_height": partial(
        FloatProperty,
        name="Height",
        description=HEIGHT_PARAMETERS["height"].description,
        default=3.0,
        min=1e-6,
        soft_min=0.01,
        subtype="DISTANCE",
    ),
    "fit_volume": partial(
        FloatProperty,
        name="Volume",
        description=HEIGHT_PARAMETERS["volume"].description,
        default=100.0,
        min=1e-9,
        soft_min=0.01,
        unit="VOLUME",
    ),
    "fit_mean_curvature": partial(
        FloatProperty,
        name="H",
        description=HEIGHT_PARAMETERS["mean_curvature"].description,
        default=0.2,
        min=1e-9,
        soft_min=1e-3,
        precision=4,
    ),
    "free_heights": partial(
        BoolProperty,
        name="Free Heights",
        description="The rim follows the outline in plan only, and may rise and fall",
    ),
    "limit_tilt": partial(
        BoolProperty,
        name="Limit Lean",
        description="Bound the lean of the shell at its rim; where the bounds contradict the outline, the nearest "
        "shell is made",
    ),
    "tilt_min": partial(
        FloatProperty,
        name="Least",
        description="0° stands upright, 90° lies flat, below 0° leans outwards",
        default=0.0,
        min=-0.5 * math.pi,
        max=0.5 * math.pi,
        subtype="ANGLE",
        step=100,
    ),
    "tilt_max": partial(
        FloatProperty,
        name="Greatest",
        description="0° stands upright, 90° lies flat",
        default=0.5 * math.pi,
        min=-0.5 * math.pi,
        max=0.5 * math.pi,
        subtype="ANGLE",
        step=100,
    ),
    "hanging": partial(
        BoolProperty, name="Hanging", description="The shell hangs below its rim instead of standing above it"
    ),
}
APPROXIMATE_SETTINGS, FIT_SETTINGS = tuple(_APPROXIMATE), tuple(_FIT)
"""Names of the settings shared by `Object.cmc` and the operator."""

_NAMES = {
    "curve": partial(
        StringProperty, name="Curve", description="Name of a closed curve or mesh for the rim"
    ),
    "anchors": partial(
        StringProperty,
        name="Anchors",
        description="Name of a collection of empties for the shell to pass through; none: the selected empties",
    ),
}
POINTERS = {"curve": "fit_curve", "anchors": "fit_anchors"}
"""Objects to fit to: names on an operator, links on `Object.cmc`."""


def approximate_annotations(options: Iterable[str] = ()) -> dict:
    return {name: make(options=set(options)) for name, make in _APPROXIMATE.items()}


def fit_annotations(options: Iterable[str] = ()) -> dict:
    return {name: make(options=set(options)) for name, make in (_FIT | _NAMES).items()}


def _can_be_curve(owner, ob) -> bool:
    return ob.type in {"MESH", "CURVE"} and ob.cmc.role == "NONE" and ob != owner.id_data


def stored_design_annotations() -> dict:
    """The settings of both operators, for `Object.cmc`."""
    stored = {name: make() for name, make in _APPROXIMATE.items()}
    stored |= {name: notifying(make) for name, make in _FIT.items()}
    stored["follow"] = BoolProperty(
        name="Follow", description="The fitted shell follows while you change the settings above", update=notify
    )
    stored["fit_curve"] = PointerProperty(
        name="Curve",
        description="Closed curve or mesh for the rim",
        type=bpy.types.Object,
        poll=_can_be_curve,
    )
    stored["fit_anchors"] = PointerProperty(
        name="Anchors",
        description="Collection of empties for the shell to pass through; none: the selected empties",
        type=bpy.types.Collection,
    )
    return stored


def take_settings(operator, stored, names: tuple[str, ...]) -> SimpleNamespace:
    """The arguments of the call, and the stored settings for the others; the redo panel then shows them all."""
    for name in names:
        if not operator.properties.is_property_set(name):
            setattr(operator, name, getattr(stored, name))
    return SimpleNamespace(**{name: getattr(operator, name) for name in names})


def stored_settings(stored, names: tuple[str, ...]) -> SimpleNamespace:
    return SimpleNamespace(**{name: getattr(stored, name) for name in names})


def take_targets(operator, stored) -> dict[str, Any]:
    """Data-blocks of `curve` and `anchors`. One named in the call also sets `fit_to`, unless the call does.

    Call it before `take_settings`. Raises `CmcError` if no data-block has that name.
    """
    targets = {}
    for name, among in (("curve", bpy.data.objects), ("anchors", bpy.data.collections)):
        linked = getattr(stored, POINTERS[name])
        if operator.properties.is_property_set(name):
            wanted = getattr(operator, name)
            linked = among.get(wanted) if wanted else None
            if wanted and linked is None:
                what = "object" if name == "curve" else "collection"
                raise CmcError(f"No {what} is called '{wanted}'; choose another to fit to.")
            if wanted and not operator.properties.is_property_set("fit_to"):
                operator.fit_to = name.upper()
        else:
            setattr(operator, name, linked.name if linked is not None else "")
        targets[name] = linked
    return targets
