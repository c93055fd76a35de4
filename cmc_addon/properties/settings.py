"""How a plan is solved: the settings that `Object.cmc`, the operators that solve, and the panels share.

Enums come from the solver's registries. What an energy is defined on is known to the solver; here the energy is kept
fitting to the sites.
"""

from functools import partial
from types import SimpleNamespace

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty

from ...solver.domain.sites import SITES
from ...solver.errors import JobError
from ...solver.gauss.energies import ENERGIES
from ...solver.gauss.methods import METHODS
from ...solver.shells.plan import usual_sheet
from ...solver.surface.averaging import AVERAGINGS
from ...solver.surface.cmc_surface import COMBINATORICS
from ...solver.surface.placement import GROUNDS, SIZES
from .changes import telling

SIZE_PROPERTY = {
    "MATCH_PLAN": None,
    "SPAN": "span",
    "RISE": "rise",
    "RADIUS": "radius",
    "MEAN_CURVATURE": "mean_curvature",
}
"""Size mode -> the one setting it needs (for drawing and for the solve)."""

_TEXTS = {
    "match_plan": "Move and scale the shell until its rim is nearest to the drawn outline",
    "span": "The longest horizontal extent of the shell",
    "rise": "The height of the shell from its lowest to its highest point",
    "radius": "The radius of mean curvature 1/H, the same everywhere on the shell",
    "mean_curvature": "The mean curvature H itself, one over a length",
    "lowest": "The lowest point of the shell lies on the plan's plane",
    "rim": "The rim of the shell lies, on average, on the plan's plane",
}


def _items(registry: dict[str, str]) -> list[tuple[str, str, str]]:
    return [(name.upper(), label, _TEXTS.get(name, label)) for name, label in registry.items()]


_SHEETS = [
    ("F_PLUS", "f+", "The shell g + N"),
    ("F_MINUS", "f-", "Its twin g - N, a single point where the shell is a sphere"),
]


def _registered(registry) -> list[tuple[str, str, str]]:
    """(identifier, label, description) of what a registry of the solver has."""
    return [(name.upper(), entry.label, entry.description) for name, entry in registry.items()]


def energies_on(sites: str) -> list[str]:
    """Identifiers of the energies that are defined on a kind of site (an identifier), the usual one first."""
    return [name.upper() for name, energy in ENERGIES.items() if sites.lower() in energy.sites]


SIDES = {"FRONT": +1, "BACK": -1}
"""Side as an identifier -> as the solver has it."""

_SHELLS = [
    ("FIRST", "First Found", "The shell that a solve comes to, usually the smallest"),
    ("BUBBLE", "Large Bubble", "The other shell over the same rim, as the large part of a sphere is beside its cap; "
     "it is f-, turned to follow the outline"),
    ("DEGREE", "Of Degree", "A shell whose normals cover the sphere so many times"),
]
_SIDES = [
    ("FRONT", "Front", "The shell is on the side to which the plan's faces look"),
    ("BACK", "Back", "The shell is on the other side"),
]


def shown_sheet(shell: str) -> str:
    """Identifier of the sheet that is worth showing of a shell (an identifier)."""
    return {"f+": "F_PLUS", "f-": "F_MINUS"}[usual_sheet(shell.lower())]


def _keep_sheet_fitting(owner, _context) -> None:
    """Of the large bubble the sheet that is one. What nobody has set yet is left to the solve."""
    if owner.is_property_set("sheet") or not isinstance(owner, bpy.types.OperatorProperties):
        owner.sheet = shown_sheet(owner.shell)


def _keep_energy_fitting(owner, _context) -> None:
    """Where the normals go, an energy goes that is defined there. What nobody has set yet is left to the solve."""
    if owner.energy not in energies_on(owner.sites) and (
        owner.is_property_set("energy") or not isinstance(owner, bpy.types.OperatorProperties)
    ):
        owner.energy = energies_on(owner.sites)[0]


def fitted_settings(values: dict, given=()) -> SimpleNamespace:
    """Settings of a solve that fit each other: the energy the sites, the sheet a shell and the shell a degree that are
    `given` for this solve alone.

    Raises `JobError` where the energy is one of those given and does not fit.
    """
    if "degree" in given and "shell" not in given:
        values = {**values, "shell": "DEGREE"}
    if "shell" in given and "sheet" not in given:
        values = {**values, "sheet": shown_sheet(values["shell"])}
    fitting = energies_on(values["sites"])
    if values["energy"] in fitting:
        return SimpleNamespace(**values)
    # the usual energy on vertices stands for the usual one on faces
    if "energy" in given and values["energy"] != energies_on("VERTICES")[0]:
        label = ENERGIES[values["energy"].lower()].label
        raise JobError(
            f"The energy {label} is not defined for normals on {values['sites'].lower()}; choose "
            f"{' or '.join(ENERGIES[name.lower()].label for name in fitting)}, or other sites."
        )
    return SimpleNamespace(**{**values, "energy": fitting[0]})


_SETTINGS = {
    "size": partial(
        EnumProperty, name="Size", description="What says how large the shell is",
        items=_items(SIZES), default="MATCH_PLAN"),
    "span": partial(
        FloatProperty, name="Span", description=_TEXTS["span"],
        default=10.0, min=1e-6, soft_min=0.01, subtype="DISTANCE"),
    "rise": partial(
        FloatProperty, name="Rise", description=_TEXTS["rise"],
        default=3.0, min=1e-6, soft_min=0.01, subtype="DISTANCE"),
    "radius": partial(
        FloatProperty, name="Radius", description="Radius of mean curvature, 1/H",
        default=5.0, min=1e-6, soft_min=0.01, subtype="DISTANCE"),
    "mean_curvature": partial(
        FloatProperty, name="H",
        description="Mean curvature, one over a length: 0.2 on a sphere of radius 5",
        default=0.2, min=1e-9, soft_min=1e-3, precision=4),
    "blend": partial(
        FloatProperty, name="Blend Angles",
        description="Length of rim over which the angles of neighbouring groups flow into each other; "
        "where they jump instead, the shell gets a sharp notch",
        default=0.0, min=0.0, subtype="DISTANCE"),
    "shell": partial(
        EnumProperty, name="Shell", description="Which of the shells over one rim is made",
        items=_SHELLS, default="FIRST", update=_keep_sheet_fitting),
    "degree": partial(
        FloatProperty, name="Degree",
        description="How many times the normals cover the sphere, counted with their sense: a hemisphere is a half",
        default=0.5, soft_min=-3.0, soft_max=3.0, step=100),
    "side": partial(
        EnumProperty, name="Side", description="Where two shells are equally good, and at corners between mirrors",
        items=_SIDES, default="FRONT"),
    "ground": partial(
        EnumProperty, name="Ground", description="What of the shell lies on the plane of the plan",
        items=_items(GROUNDS), default="LOWEST"),
    "sheet": partial(
        EnumProperty, name="Sheet",
        description="Which of the two surfaces is the shell: it is placed and shown",
        items=_SHEETS, default="F_PLUS"),
    "flip": partial(
        BoolProperty, name="Flip",
        description="Mirror the shell in the plan's plane: hanging instead of standing"),
    "rotate": partial(
        BoolProperty, name="Allow Rotation",
        description="Match Plan may also rotate about the vertical, which turns the prescribed planes"),
    "apply_modifiers": partial(
        BoolProperty, name="Apply Modifiers", description="Solve on the plan as its modifiers show it"),
    "want_twin": partial(BoolProperty, name="Twin", description="Also make the other sheet (f- beside f+)"),
    "want_g": partial(
        BoolProperty, name="K-Surface g", description="Also make the surface between the two sheets"),
    "want_gauss": partial(
        BoolProperty, name="Gauss Image", description="Also make the normals as points of a sphere"),
    "sites": partial(
        EnumProperty, name="Normals On", description="Where the normals live that are solved for",
        items=_registered(SITES), default="VERTICES", update=_keep_energy_fitting),
    "energy": partial(
        EnumProperty, name="Energy", description="How the bending between neighbouring normals is counted",
        items=_registered(ENERGIES), default="COTAN"),
    "method": partial(
        EnumProperty, name="Method",
        description="How the normals are found; the last two also come to shells that are no minimum",
        items=_registered(METHODS), default="NEWTON"),
    "delaunay": partial(
        BoolProperty, name="Intrinsic Delaunay",
        description="Solve on the best triangles that the plan's vertices have; the shell keeps the plan's faces"),
    "combinatorics": partial(
        EnumProperty, name="Result Mesh", description="Which faces the results have",
        items=_registered(COMBINATORICS), default="PRIMAL"),
    "averaging": partial(
        EnumProperty, name="Averaging", description="How points of the surface are found at the vertices",
        items=_registered(AVERAGINGS), default="GALERKIN"),
    "tolerance": partial(
        FloatProperty, name="Tolerance", description="The solve stops at this residual",
        default=1e-6, min=1e-12, max=1e-2, precision=8),
    "intersections": partial(
        BoolProperty, name="Self-Intersections", default=True,
        description="Also report faces that go through each other; on large plans the slowest of the measures"),
    "count_modes": partial(
        BoolProperty, name="Unstable Modes",
        description="Also count the unstable modes of the normals, which takes two sparse factorisations"),
}
SETTINGS = tuple(_SETTINGS)
"""Names of the settings shared by `Object.cmc` and the operators that solve."""


def setting_annotations(options=frozenset()) -> dict:
    """The settings of a solve as property annotations; operators pass {'SKIP_SAVE'}, so that
    the values of the last call on another plan are not taken over in silence."""
    return {name: make(options=set(options)) for name, make in _SETTINGS.items()}


def stored_setting_annotations() -> dict:
    """The same for `Object.cmc`, telling of changes."""
    return {name: telling(make) for name, make in _SETTINGS.items()}
