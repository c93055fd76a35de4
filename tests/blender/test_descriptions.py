"""Tooltips that depend on the properties of a button, for every choice; icons, which a window alone would miss."""

from __future__ import annotations

import re
from pathlib import Path

import bpy
import pytest


@pytest.mark.parametrize(
    "operator, setting", [("add_plan", "shape"), ("add_bubble", "bubble"), ("group_plane", "plane")]
)
def test_of_every_choice(operator, setting):
    cls = getattr(bpy.types, f"CMC_OT_{operator}")
    properties = bpy.context.window_manager.operator_properties_last(f"cmc.{operator}")
    for choice in properties.bl_rna.properties[setting].enum_items:
        setattr(properties, setting, choice.identifier)
        assert cls.description(bpy.context, properties) == choice.description != ""


def test_every_icon_is_one_of_blender(addon):
    """The name after `icon=`, and strings in capitals with an underscore beside which an icon's name is expected."""
    known = {item.identifier for item in bpy.types.UILayout.bl_rna.functions["prop"].parameters["icon"].enum_items}
    folder = Path(addon.__file__).parent / "cmc_addon"
    used = {preset.icon for preset in addon.cmc_addon.properties.group_presets.PRESETS.values()}
    for file in folder.rglob("*.py"):
        used |= set(re.findall(r'icon="([A-Z0-9_]+)"', file.read_text(encoding="utf-8")))
    assert len(used) > 10 and used <= known, used - known
