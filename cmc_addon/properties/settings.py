"""Settings of a solve, for `Object.cmc` and for the operators that solve.

Enums come from the solver's registries, which also say where an energy is defined; an update callback keeps energy and
sites consistent.
"""

from collections.abc import Iterable
from functools import partial
from types import SimpleNamespace

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty

from ...solver.domain.sites import SITES
from ...solver.errors import JobError
from ...solver.gauss.conditions import AGAINST
from ...solver.gauss.energies import ENERGIES
from ...solver.gauss.methods import METHODS
from ...solver.shells.plan import usual_sheet
from ...solver.spanning.outline import CORNERS, HOLES
from ...solver.surface.averaging import AVERAGINGS
from ...solver.surface.cmc_surface import COMBINATORICS
from ...solver.surface.placement import GROUNDS, RISES, SIZES
from .changes import notifying
from .closing_settings import CLOSING
from .group_settings import kind_items

SIZE_PROPERTY = {name.upper(): None if name == "match_plan" else name for name in SIZES}
"""Way to set the size -> the setting with its value."""

_TEXTS = {
    "match_plan": "Move and scale the shell so that its rim is nearest to the outline; on lines, which say where it "
    "is, a usual height, or a soap film where the lines rise and fall",
    "span": "Longest horizontal extent of the shell",
    "height": "Height of the shell from its lowest to its highest point; on lines, of its crown over them",
    "rise": "Height as a part of half the outline's smaller extent: 0 flat, 1 a hemisphere over a circle",
    "volume": "Volume under a shell on lines, over the mean height of its outer rim",
    "radius": "Radius of mean curvature 1/H, the same everywhere on the shell",
    "mean_curvature": "Mean curvature H, one over a length; on lines also 0, a soap film, or negative, hanging",
    "lowest": "The lowest point of the shell touches the plane of the plan",
    "rim": "The mean height of the rim is that of the plane of the plan",
}


def _items(registry: dict[str, str]) -> list[tuple[str, str, str]]:
    return [(name.upper(), label, _TEXTS.get(name, label)) for name, label in registry.items()]


_SHEETS = [
    ("F_PLUS", "Shell", "The surface f+ = g + N over the plan"),
    ("F_MINUS", "Twin", "The surface f- = g - N, a single point if the shell is a sphere"),
]


def _registered(registry) -> list[tuple[str, str, str]]:
    """(identifier, label, description) of every entry in a registry of the solver."""
    return [(name.upper(), entry.label, entry.description) for name, entry in registry.items()]


def energies_on(sites: str) -> list[str]:
    """Identifiers of the energies defined on a kind of site (an identifier), the default first."""
    return [name.upper() for name, energy in ENERGIES.items() if sites.lower() in energy.sites]


SIDES = {"FRONT": +1, "BACK": -1}
"""Side (an identifier) -> the solver's number."""

_SHELLS = [
    ("FIRST", "First Found", "The shell that the solve finds, usually the smallest"),
    ("BUBBLE", "Large Bubble", "The other shell over the same rim, as a cap of a sphere has the rest of the sphere; "
     "it is the twin, turned to follow the outline"),
    ("DEGREE", "By Degree", "The shell whose normals cover the sphere a given number of times"),
]
_SIDES = [
    ("FRONT", "Front", "The shell is in front of the plan's faces"),
    ("BACK", "Back", "The shell is behind the plan's faces"),
]


def shown_sheet(shell: str) -> str:
    """Identifier of the sheet to show for a choice of shell (an identifier)."""
    return {"f+": "F_PLUS", "f-": "F_MINUS"}[usual_sheet(shell.lower())]


def _keep_sheet_fitting(owner, _context) -> None:
    """Show the sheet that is the large bubble. A setting not yet made is left to the solve."""
    if owner.is_property_set("sheet") or not isinstance(owner, bpy.types.OperatorProperties):
        owner.sheet = shown_sheet(owner.shell)


def _keep_energy_fitting(owner, _context) -> None:
    """Choose an energy defined on the sites. A setting not yet made is left to the solve."""
    if owner.energy not in energies_on(owner.sites) and (
        owner.is_property_set("energy") or not isinstance(owner, bpy.types.OperatorProperties)
    ):
        owner.energy = energies_on(owner.sites)[0]


def fitted_settings(values: dict, given=()) -> SimpleNamespace:
    """Settings of a solve made consistent: the energy with the sites; with the names `given` for this solve alone, the
    sheet with the shell and the shell with the degree.

    Raises `JobError` if the energy is given and is not defined on the sites.
    """
    if "degree" in given and "shell" not in given:
        values = {**values, "shell": "DEGREE"}
    if "shell" in given and "sheet" not in given:
        values = {**values, "sheet": shown_sheet(values["shell"])}
    fitting = energies_on(values["sites"])
    if values["energy"] in fitting:
        return SimpleNamespace(**values)
    # the default energy on vertices stands for the default one on faces
    if "energy" in given and values["energy"] != energies_on("VERTICES")[0]:
        label = ENERGIES[values["energy"].lower()].label
        raise JobError(
            f"The energy {label} is not defined for normals on {values['sites'].lower()}; choose "
            f"{' or '.join(ENERGIES[name.lower()].label for name in fitting)}, or other sites."
        )
    return SimpleNamespace(**{**values, "energy": fitting[0]})


_SETTINGS = {
    "size": partial(
        EnumProperty, name="Size", description="How the shell's size is set",
        items=_items(SIZES), default="MATCH_PLAN"),
    "span": partial(
        FloatProperty, name="Span", description=_TEXTS["span"],
        default=10.0, min=1e-6, soft_min=0.01, subtype="DISTANCE"),
    "height": partial(
        FloatProperty, name="Height", description=_TEXTS["height"] + "; negative hangs",
        default=3.0, soft_min=0.01, subtype="DISTANCE"),
    "rise": partial(
        FloatProperty, name="Rise", description=_TEXTS["rise"] + "; negative hangs",
        default=0.35, min=RISES.least, max=RISES.most, soft_min=-1.0, soft_max=1.0, step=1),
    "volume": partial(
        FloatProperty, name="Volume", description=_TEXTS["volume"] + "; negative hangs",
        default=100.0, unit="VOLUME"),
    "radius": partial(
        FloatProperty, name="Radius", description="Radius of mean curvature 1/H",
        default=5.0, min=1e-6, soft_min=0.01, subtype="DISTANCE"),
    "mean_curvature": partial(
        FloatProperty, name="H",
        description="Mean curvature, one over a length: 0.2 on a sphere of radius 5; on lines also 0, a soap film, or "
        "negative, hanging",
        default=0.2, step=1, precision=4),
    "default_kind": partial(
        EnumProperty, name="Other Edges", description="What the shell does along edges in no group",
        items=[item for item in kind_items() if item[0] in ("LINE", "BINORMAL")], default="LINE"),
    "holes": partial(
        EnumProperty, name="Holes", description="Of a shell on lines: how it closes around holes",
        items=[(name.upper(), *texts) for name, texts in HOLES.items()], default="ADAPT"),
    "corners": partial(
        EnumProperty, name="Corners", description="Of a shell on lines: what becomes of corners",
        items=[(name.upper(), *texts) for name, texts in CORNERS.items()], default="SHARP"),
    **CLOSING,
    "blend": partial(
        FloatProperty, name="Blend Angles",
        description="Length of rim over which the angles of neighbouring groups blend; at 0 they jump, and the "
        "shell gets a sharp notch",
        default=0.0, min=0.0, subtype="DISTANCE"),
    "against": partial(
        EnumProperty, name="Lean Against", description="What the lean of the rim is measured against",
        items=[(name.upper(), *texts) for name, texts in AGAINST.items()], default="HORIZON"),
    "shell": partial(
        EnumProperty, name="Shell", description="Which of the shells over the same rim to make",
        items=_SHELLS, default="FIRST", update=_keep_sheet_fitting),
    "degree": partial(
        FloatProperty, name="Degree",
        description="How many times the normals cover the sphere, counted with sign: 0.5 for a hemisphere",
        default=0.5, soft_min=-3.0, soft_max=3.0, step=100),
    "side": partial(
        EnumProperty, name="Side",
        description="Side of the plan for the shell where both are possible, and at corners of mirrors",
        items=_SIDES, default="FRONT"),
    "ground": partial(
        EnumProperty, name="Ground", description="Which part of the shell touches the plane of the plan",
        items=_items(GROUNDS), default="LOWEST"),
    "sheet": partial(
        EnumProperty, name="Sheet",
        description="Which of the two surfaces to place and show",
        items=_SHEETS, default="F_PLUS"),
    "flip": partial(
        BoolProperty, name="Flip",
        description="Mirror the shell in the plane of the plan: hanging instead of standing"),
    "rotate": partial(
        BoolProperty, name="Allow Rotation",
        description="Match Plan may also turn the shell about the vertical, and the prescribed planes with it"),
    "apply_modifiers": partial(
        BoolProperty, name="Apply Modifiers", description="Solve on the plan with its modifiers applied"),
    "want_twin": partial(BoolProperty, name="Twin", description="Also make the other surface, f- beside f+"),
    "want_g": partial(
        BoolProperty, name="K-Surface",
        description="Also make g, the surface of constant Gauss curvature between shell and twin"),
    "want_gauss": partial(
        BoolProperty, name="Normals on a Sphere",
        description="Also make the Gauss image: the normals as points on a sphere"),
    "sites": partial(
        EnumProperty, name="Normals On", description="Where the mesh carries the unknown normals",
        items=_registered(SITES), default="VERTICES", update=_keep_energy_fitting),
    "energy": partial(
        EnumProperty, name="Energy", description="How bending between neighbouring normals is measured",
        items=_registered(ENERGIES), default="COTAN"),
    "method": partial(
        EnumProperty, name="Method",
        description="How the normals are found; the last two also find shells that are no minimum of the energy",
        items=_registered(METHODS), default="NEWTON"),
    "delaunay": partial(
        BoolProperty, name="Intrinsic Delaunay",
        description="Solve on intrinsic Delaunay triangles of the plan's vertices; the shell keeps the plan's faces"),
    "combinatorics": partial(
        EnumProperty, name="Result Mesh", description="Faces of the results",
        items=_registered(COMBINATORICS), default="PRIMAL"),
    "averaging": partial(
        EnumProperty, name="Averaging", description="How the surface is averaged to points at the vertices",
        items=_registered(AVERAGINGS), default="GALERKIN"),
    "tolerance": partial(
        FloatProperty, name="Accuracy",
        description="The solve stops when its residual is below this; smaller is more accurate",
        default=1e-6, min=1e-12, max=1e-2, precision=8),
    "intersections": partial(
        BoolProperty, name="Self-Intersections", default=True,
        description="Also report faces that intersect; the slowest of the checks on large plans"),
    "count_modes": partial(
        BoolProperty, name="Unstable Modes",
        description="Also count the unstable modes of the shell, at the cost of two sparse factorisations"),
}
SETTINGS = tuple(_SETTINGS)
"""Names of the settings shared by `Object.cmc` and the operators that solve."""


def setting_annotations(options: Iterable[str] = ()) -> dict:
    """The settings of a solve as property annotations; operators pass {'SKIP_SAVE'}, so that values of the last call
    on another plan are not reused silently."""
    return {name: make(options=set(options)) for name, make in _SETTINGS.items()}


def stored_setting_annotations() -> dict:
    """The same for `Object.cmc`, with notification of changes."""
    return {name: notifying(make) for name, make in _SETTINGS.items()}
