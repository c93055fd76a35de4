"""Whether a data-block keeps what the add-on stores with it: not if it is linked, nor if it is a library override.

Blender lets scripts change an override and drops the add-on's properties when the file is opened again.
"""

from __future__ import annotations

import bpy

_MAKE_LOCAL = "make it local (Object > Relations > Make Local)"


def keeps_changes(block: bpy.types.ID) -> bool:
    """Whether groups, settings and links stay with this object or mesh when the file is saved and opened again."""
    return block.is_editable and block.override_library is None


def why_not_kept(block: bpy.types.ID) -> str:
    """Why a data-block keeps no changes, and the way out; "" if it does."""
    if keeps_changes(block):
        return ""
    what = "The mesh " if isinstance(block, bpy.types.Mesh) else ""
    if block.is_editable:
        return f"{what}'{block.name}' is a library override, which keeps no groups, settings and shells; {_MAKE_LOCAL}"
    return f"{what}'{block.name}' is linked from another file; {_MAKE_LOCAL}"
