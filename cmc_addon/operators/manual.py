"""F1 over a button or a setting opens its paragraph in the documentation.

Operators have their own anchors (`<a id="cmc.solve"></a>`) on the pages docs/reference/operators/; settings lead to the
section that describes them. The pages are on the website that the manifest names; without a website they are those
bundled with the extension (`help/`, made from docs/ by the build), and in a checkout docs/ itself.
"""

from __future__ import annotations

import tomllib
from contextlib import suppress
from pathlib import Path

import bpy

ROOT = Path(__file__).parents[2]

PAGES = {
    "plan": ("mesh_plan", "weld", "add_plan", "add_module", "add_bubble", "go_to"),
    "boundary": ("group_*", "rim_free", "select_ungrouped", "flip_corner"),
    "solve": (
        "solve", "solve_selection", "update_all", "flip", "cancel", "count_modes", "start_from_shell", "start_clear"
    ),
    "live": ("live",),
    "look": ("gauss_image",),
    "approximate": ("approximate_surface",),
    "symmetry": ("complete",),
    "periods": ("tile_periods",),
    "export": ("export",),
}
"""Page in docs/reference/operators/ → the operators on it."""

SETTINGS = {
    "cmcgroup.across": "reference/blender#mirrors-and-planes",
    "cmcgroup": "reference/blender#sides",
    "cmcmesh": "reference/blender#sides",
    "cmcscene.edge_length": "reference/blender#plan",
    "cmcscene.corners": "reference/blender#plan",
    "cmcscene.corner_radius": "reference/blender#plan",
    "cmcscene": "reference/operators/look",
    "cmcobject.complete_": "reference/blender#symmetry",
    "cmcobject.close_": "reference/blender#plans-with-holes",
    "cmcobject.keep_closed": "reference/blender#plans-with-holes",
    "cmcobject.tile_": "reference/blender#repeat-by-gaps",
    "cmcobject.export_": "reference/blender#export",
    "cmcobject.smoothness": "reference/blender#approximate-surface",
    "cmcobject.match": "reference/blender#approximate-surface",
    "cmcobject.near": "reference/blender#approximate-surface",
    "cmcobject.sites": "reference/blender#advanced",
    "cmcobject.energy": "reference/blender#advanced",
    "cmcobject.method": "reference/blender#advanced",
    "cmcobject.delaunay": "reference/blender#advanced",
    "cmcobject.averaging": "reference/blender#advanced",
    "cmcobject.combinatorics": "reference/blender#advanced",
    "cmcobject.live": "reference/operators/live",
    "cmcobject.colour_": "reference/operators/look",
    "cmcobject.curvature_line": "reference/operators/look",
    "cmcobject": "reference/blender#shell",
    "cmcrun": "reference/operators/solve",
    "cmcpreferences": "reference/blender#preferences",
}
"""Start of a setting's name, specific ones before general ones → page and heading."""


def links(suffix: str) -> tuple[tuple[str, str], ...]:
    """(pattern, rest of the URL) of every name, in the form of `bpy.utils.register_manual_map`. `suffix` is the
    pages' file suffix; patterns are in lower case, as Blender looks them up."""
    pairs = []
    for page, names in PAGES.items():
        for name in names:
            place = f"reference/operators/{page}{suffix}"
            pairs += [(f"bpy.ops.cmc.{each}", f"{place}#cmc.{each}") for each in _matching(name)]
    for beginning, place in SETTINGS.items():
        page, _, heading = place.partition("#")
        pairs.append((f"bpy.types.{beginning}*", f"{page}{suffix}" + (f"#{heading}" if heading else "")))
    return tuple(pairs)


def _matching(name: str) -> list[str]:
    """The operators that match a name with a star; each has its own anchor."""
    if not name.endswith("*"):
        return [name]
    return [each for each in dir(bpy.ops.cmc) if each.startswith(name[:-1])]


def where() -> tuple[str, str]:
    """The common start of all links, and the suffix of the pages."""
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
    with suppress(ValueError):  # never registered: registration failed earlier
        bpy.utils.unregister_manual_map(manual_map)
