"""F1 over a button or a setting: its paragraph in the documentation.

Operators have an anchor of their own (`<a id="cmc.solve"></a>`) on the pages docs/operators/; settings lead to the
section that tells about them. The pages are those of the website that the manifest names; without one those that came
with the extension (`help/`, made from docs/ by the build), and in a checkout docs/ itself.
"""

from __future__ import annotations

import tomllib
from contextlib import suppress
from pathlib import Path

import bpy

ROOT = Path(__file__).parents[2]

PAGES = {
    "plan": ("mesh_plan", "add_plan", "add_module", "add_bubble", "go_to"),
    "boundary": ("group_*", "select_ungrouped", "flip_corner"),
    "solve": ("solve", "solve_selection", "flip", "cancel", "count_modes", "start_from_shell", "start_clear"),
    "look": ("gauss_image",),
    "design": ("fit_outline", "approximate_surface"),
    "symmetry": ("complete",),
    "periods": ("close_periods", "tile_periods"),
    "export": ("export",),
}
"""Page below docs/operators/ → the operators on it."""

SETTINGS = {
    "cmcgroup.across": "blender#mirrors-and-planes",
    "cmcgroup": "blender#boundary",
    "cmcmesh": "blender#boundary",
    "cmcscene.edge_length": "blender#plan",
    "cmcscene.round_corners": "blender#plan",
    "cmcscene.corner_radius": "blender#plan",
    "cmcscene": "operators/look",
    "cmcobject.complete_": "blender#symmetry",
    "cmcobject.close_": "blender#close-gaps",
    "cmcobject.tile_": "blender#repeat-by-gaps",
    "cmcobject.export_": "blender#export",
    "cmcobject.fit_": "blender#fit-to-outline",
    "cmcobject.height_parameter": "blender#fit-to-outline",
    "cmcobject.free_heights": "blender#fit-to-outline",
    "cmcobject.limit_tilt": "blender#fit-to-outline",
    "cmcobject.tilt_": "blender#fit-to-outline",
    "cmcobject.hanging": "blender#fit-to-outline",
    "cmcobject.follow": "blender#fit-to-outline",
    "cmcobject.anchor_weight": "blender#fit-to-outline",
    "cmcobject.smoothness": "blender#approximate-surface",
    "cmcobject.match": "blender#approximate-surface",
    "cmcobject.near": "blender#approximate-surface",
    "cmcobject.sites": "blender#advanced",
    "cmcobject.energy": "blender#advanced",
    "cmcobject.method": "blender#advanced",
    "cmcobject.delaunay": "blender#advanced",
    "cmcobject.averaging": "blender#advanced",
    "cmcobject.combinatorics": "blender#advanced",
    "cmcobject.live": "operators/live",
    "cmcobject.colour_": "operators/look",
    "cmcobject.curvature_line": "operators/look",
    "cmcobject": "blender#shell",
    "cmcrun": "operators/solve",
    "cmcpreferences": "blender#preferences",
}
"""Beginning of a setting's name, the more special before the more general → page and heading."""


def links(suffix: str) -> tuple[tuple[str, str], ...]:
    """(pattern, what follows the prefix) of every name, as `bpy.utils.register_manual_map` wants them; `suffix` is
    that of the pages. Blender's names are in small letters."""
    found = []
    for page, names in PAGES.items():
        for name in names:
            found += [(f"bpy.ops.cmc.{each}", f"operators/{page}{suffix}#cmc.{each}") for each in _spelt_out(name)]
    for beginning, place in SETTINGS.items():
        page, _, heading = place.partition("#")
        found.append((f"bpy.types.{beginning}*", f"{page}{suffix}" + (f"#{heading}" if heading else "")))
    return tuple(found)


def _spelt_out(name: str) -> list[str]:
    """The operators that a name with a star stands for; each has an anchor of its own."""
    if not name.endswith("*"):
        return [name]
    return [each for each in dir(bpy.ops.cmc) if each.startswith(name[:-1])]


def where() -> tuple[str, str]:
    """What all links begin with, and the suffix of the pages."""
    manifest = ROOT / "blender_manifest.toml"
    website = tomllib.loads(manifest.read_text(encoding="utf-8")).get("website") if manifest.is_file() else None
    if website:
        return f"{website.rstrip('/')}/docs/", ".md"
    if (ROOT / "help").is_dir():
        return f"{(ROOT / 'help').as_uri()}/", ".html"
    return f"{(ROOT / 'docs').as_uri()}/", ".md"


def manual_map() -> tuple[str, tuple[tuple[str, str], ...]]:
    prefix, suffix = where()
    return prefix, links(suffix)


def register() -> None:
    bpy.utils.register_manual_map(manual_map)


def unregister() -> None:
    with suppress(ValueError):  # was never registered: registering failed before it came to this
        bpy.utils.unregister_manual_map(manual_map)
