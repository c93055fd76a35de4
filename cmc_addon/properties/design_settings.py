"""Settings of Approximate Surface and Fit to Outline: on `Object.cmc` of a plan, on the operators, in the panel.

Knobs come from the solver's registry: one added there appears here, and needs the property it reads.
"""

import math
from functools import partial
from types import SimpleNamespace

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, PointerProperty, StringProperty

from ...solver.errors import CmcError
from ...solver.fitting.goals import HEIGHT_PARAMETERS
from .changes import tell, telling

HEIGHT_PROPERTY = {name.upper(): f"fit_{name}" for name in HEIGHT_PARAMETERS}
"""Knob (an enum identifier) -> the setting with its number."""

_FIT_TO = [
    ("OUTLINE", "Outline", "The rim of the shell lies on the rim of the plan as it is drawn"),
    ("CURVE", "Curve", "The rim of the shell lies on another closed curve, which may rise and fall"),
    ("ANCHORS", "Anchors", "The shell goes through empties, and its rim runs free between them"),
]

_MATCH = [
    ("TANGENT_PLANES", "Tangent Planes", "The tangent planes turn as little as can be"),
    ("POSITION", "Position", "The shell also comes near to where the surface is"),
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
        description="Weight λ of smooth boundary normals against nearness to the surface: more irons out waves of "
        "the rim",
    ),
    "match": partial(
        EnumProperty, name="Match", description="What of the surface the shell comes near to", items=_MATCH
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
        description="Weight of the distance from the surface against the turning of its tangent planes; with 100 a "
        "hundredth of its size counts as much as 6°",
    ),
}
_FIT = {
    "fit_to": partial(EnumProperty, name="Fit to", description="What the shell is fitted to", items=_FIT_TO),
    "height_parameter": partial(
        EnumProperty,
        name="Choose by",
        description="The number that chooses among the shells with this rim",
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
        description="The rim lies over the outline as seen from above, and may rise and fall",
    ),
    "limit_tilt": partial(
        BoolProperty,
        name="Limit Tilt",
        description="Bounds on the angle by which the shell leaves its rim; where they do not go together with the "
        "line, the nearest shell is made",
    ),
    "tilt_min": partial(
        FloatProperty,
        name="Least",
        description="0° is a vertical wall, 90° lies flat, less than 0° leans out",
        default=0.0,
        min=-0.5 * math.pi,
        max=0.5 * math.pi,
        subtype="ANGLE",
        step=100,
    ),
    "tilt_max": partial(
        FloatProperty,
        name="Greatest",
        description="0° is a vertical wall, 90° lies flat",
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
        StringProperty, name="Curve", description="Name of the closed curve, or mesh, on which the rim is to lie"
    ),
    "anchors": partial(
        StringProperty,
        name="Anchors",
        description="Name of a collection of empties through which the shell goes; none: those that are selected",
    ),
}
POINTERS = {"curve": "fit_curve", "anchors": "fit_anchors"}
"""Objects to fit to: on an operator by their name, on `Object.cmc` a link."""


def approximate_annotations(options=frozenset()) -> dict:
    return {name: make(options=set(options)) for name, make in _APPROXIMATE.items()}


def fit_annotations(options=frozenset()) -> dict:
    return {name: make(options=set(options)) for name, make in (_FIT | _NAMES).items()}


def _can_be_curve(owner, ob) -> bool:
    return ob.type in {"MESH", "CURVE"} and ob.cmc.role == "NONE" and ob != owner.id_data


def stored_design_annotations() -> dict:
    """The settings of both operators, for `Object.cmc`."""
    stored = {name: make() for name, make in _APPROXIMATE.items()}
    stored |= {name: telling(make) for name, make in _FIT.items()}
    stored["follow"] = BoolProperty(
        name="Follow", description="The fitted shell follows while the settings above are changed", update=tell
    )
    stored["fit_curve"] = PointerProperty(
        name="Curve",
        description="The closed curve, or mesh, on which the rim is to lie",
        type=bpy.types.Object,
        poll=_can_be_curve,
    )
    stored["fit_anchors"] = PointerProperty(
        name="Anchors",
        description="Empties through which the shell goes; none chosen: those that are selected",
        type=bpy.types.Collection,
    )
    return stored


def take_settings(operator, stored, names: tuple[str, ...]) -> SimpleNamespace:
    """What the call says, and where it says nothing what is stored; the redo panel then shows all of it."""
    for name in names:
        if not operator.properties.is_property_set(name):
            setattr(operator, name, getattr(stored, name))
    return SimpleNamespace(**{name: getattr(operator, name) for name in names})


def stored_settings(stored, names: tuple[str, ...]) -> SimpleNamespace:
    return SimpleNamespace(**{name: getattr(stored, name) for name in names})


def take_targets(operator, stored) -> dict[str, bpy.types.ID | None]:
    """Data-blocks of `curve` and `anchors`. One that the call names is what is fitted to, if it says nothing else.

    To be called before `take_settings`. Raises `CmcError` where there is none of that name.
    """
    found = {}
    for name, among in (("curve", bpy.data.objects), ("anchors", bpy.data.collections)):
        linked = getattr(stored, POINTERS[name])
        if operator.properties.is_property_set(name):
            wanted = getattr(operator, name)
            linked = among.get(wanted) if wanted else None
            if wanted and linked is None:
                what = "object" if name == "curve" else "collection"
                raise CmcError(f"There is no {what} '{wanted}' to fit to; choose another.")
            if wanted and not operator.properties.is_property_set("fit_to"):
                operator.fit_to = name.upper()
        else:
            setattr(operator, name, linked.name if linked is not None else "")
        found[name] = linked
    return found
