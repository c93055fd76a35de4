"""Settings of a boundary group: its kind and the parameters of that kind, for the group and for operators.

Kinds come from the solver's registry of boundary conditions: a kind added there appears here.
"""

import math
from collections.abc import Iterable

from bpy.props import EnumProperty, FloatProperty, FloatVectorProperty

from ...solver.gauss.conditions import KINDS

_STORED = ("binormal", "plane", "twisted", "gauss_map", "mirror", "free", "line", "lean")
"""The kinds in the order of their numbers in files."""


def kind_items() -> list[tuple[str, str, str, str, int]]:
    """(identifier, label, description, icon, number) of every boundary condition, for an EnumProperty."""
    return [(name.upper(), kind.label, kind.description, "NONE", _STORED.index(name)) for name, kind in KINDS.items()]


def kind_parameters(kind: str) -> tuple[str, ...]:
    """Names of the parameters of a kind (an enum identifier)."""
    return tuple(parameter.name for parameter in KINDS[kind.lower()].parameters)


def parameter_values(kind: str, owner) -> dict:
    """The numbers and vectors of a kind, read from a group or an operator, as the solver takes them."""
    values = {}
    for name in kind_parameters(kind):
        value = getattr(owner, name)
        values[name] = value if isinstance(value, (int, float)) else tuple(value)
    return values


def _parameter_property(parameter, options: set, more: dict):
    texts = {**more, "name": parameter.label, "description": parameter.description, "options": options}
    if isinstance(parameter.default, (tuple, list)):
        return FloatVectorProperty(**texts, size=3, default=parameter.default, subtype="DIRECTION")
    if parameter.unit in ("radians", "rad", "angle", "degrees"):
        # Beyond half a turn the solver takes a number for degrees.
        return FloatProperty(
            **texts, default=parameter.default, min=-math.pi, max=math.pi, subtype="ANGLE", step=100)
    return FloatProperty(**texts, default=parameter.default)


def condition_annotations(options: Iterable[str] = (), kind_of_new: str = "BINORMAL", **more) -> dict:
    """`kind` and the parameters of every kind, for a group or an operator; `more` is passed to each property."""
    options = set(options)
    annotations = {"kind": EnumProperty(
        name="Kind", description="Boundary condition of the shell along these edges",
        items=kind_items(), default=kind_of_new, options=options, **more)}
    for kind in KINDS.values():
        for parameter in kind.parameters:
            annotations[parameter.name] = _parameter_property(parameter, options, more)
    return annotations
