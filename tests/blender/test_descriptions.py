"""Tooltips that depend on the properties of a button, for every choice."""

from __future__ import annotations

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
