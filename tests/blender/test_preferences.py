"""Preferences: read with and without the add-on enabled, and the sidebar tab."""

from __future__ import annotations

import bpy
import pytest


@pytest.fixture
def module(addon):
    return addon.cmc_addon.properties.preferences


def test_they_are_read_with_the_add_on_and_without(module, monkeypatch):
    own = bpy.context.preferences.addons["cmc_formfinding"].preferences
    for name, make in module._PREFERENCES.items():
        assert module.get(name) == pytest.approx(make.keywords["default"]) if name != "category" else "CMC"
    own.line_width = 7.0
    assert module.get("line_width") == 7.0
    monkeypatch.setattr(module, "PACKAGE", "nowhere")
    assert module.get("line_width") == 3.0 and module.get("colour_cut") == (1.0, 0.2, 0.55)


def test_the_viewport_draws_with_these_colours(addon, module):
    own = bpy.context.preferences.addons["cmc_formfinding"].preferences
    for name in ("colour_ungrouped", "colour_gaps", "colour_cut"):
        setattr(own, name, (0.25, 0.5, 0.75))
        assert addon.cmc_addon.drawing.palette.other_colour(name) == (0.25, 0.5, 0.75)


def test_the_tab_of_the_sidebar(addon, module):
    own = bpy.context.preferences.addons["cmc_formfinding"].preferences
    names = ["CMC_PT_plan", "CMC_PT_shell", "CMC_PT_approximate", "CMC_PT_checks", "CMC_PT_export", "CMC_PT_symmetry"]
    for wanted, category in (("Architecture", "Architecture"), ("", "CMC")):
        own.category = wanted
        for name in names:
            assert getattr(bpy.types, name).bl_category == category
            assert getattr(bpy.types, name).is_registered
        addon.unregister()
        addon.register()
        own = bpy.context.preferences.addons["cmc_formfinding"].preferences
        assert bpy.types.CMC_PT_plan.bl_category == category
    own.category = "CMC"


def test_they_are_drawn(module):
    drawn = []

    class Layout:
        def column(self, **_):
            return self

        def prop(self, owner, name, **_):
            assert name in owner.bl_rna.properties
            drawn.append(name)

        def separator(self, **_):
            pass

        def label(self, *, text, icon="NONE"):
            pass

    own = bpy.context.preferences.addons["cmc_formfinding"].preferences
    stand_in = type("Drawn", (), {"layout": Layout(), "bl_rna": own.bl_rna})()
    module.CmcPreferences.draw(stand_in, bpy.context)
    assert set(drawn) == set(module._PREFERENCES)
