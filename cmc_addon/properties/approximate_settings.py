"""Settings of Approximate Surface, for `Object.cmc` and for the operator."""

from collections.abc import Iterable
from functools import partial
from types import SimpleNamespace

from bpy.props import EnumProperty, FloatProperty

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
APPROXIMATE_SETTINGS = tuple(_APPROXIMATE)
"""Names of the settings shared by `Object.cmc` and the operator."""


def approximate_annotations(options: Iterable[str] = ()) -> dict:
    return {name: make(options=set(options)) for name, make in _APPROXIMATE.items()}


def take_settings(operator, stored, names: tuple[str, ...]) -> SimpleNamespace:
    """The arguments of the call, and the stored settings for the others; the redo panel then shows them all."""
    for name in names:
        if not operator.properties.is_property_set(name):
            setattr(operator, name, getattr(stored, name))
    return stored_settings(operator, names)


def stored_settings(stored, names: tuple[str, ...]) -> SimpleNamespace:
    return SimpleNamespace(**{name: getattr(stored, name) for name in names})
