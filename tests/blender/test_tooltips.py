"""Tooltips: every operator, property and choice has one, which ends without a full stop, as Blender's own do; units."""

from __future__ import annotations

import bpy
import pytest

UNITS = {"LENGTH": {"DISTANCE", "TRANSLATION"}, "ROTATION": {"ANGLE"}}


def groups() -> dict:
    from cmc_formfinding.cmc_addon.properties import preferences, stored

    found = {cls.__name__: cls.bl_rna for cls in stored.CLASSES}
    found["CmcPreferences"] = preferences.CmcPreferences.bl_rna
    return found


def operators() -> dict:
    return {
        f"cmc.{name}": getattr(bpy.ops.cmc, name).get_rna_type() for name in dir(bpy.ops.cmc)
        if not name.startswith("_")
    }


def own_properties(rna):
    """Those that are declared here, not Blender's own ("name" of a property group, "rna_type")."""
    base = {"rna_type", "name", "bl_idname"}
    return [prop for prop in rna.properties if prop.identifier not in base]


def faults(rna) -> list[str]:
    wrong = []
    for prop in own_properties(rna):
        where = f"{rna.identifier}.{prop.identifier}"
        texts = {where: prop.description}
        if prop.type == "ENUM":
            texts |= {f"{where} {item.identifier}": item.description for item in prop.enum_items}
        if not prop.name:
            wrong.append(f"{where} has no name")
        wrong += [f"{place} has no description" for place, text in texts.items() if not text.strip()]
        wrong += [f"{place} ends with a full stop" for place, text in texts.items() if text.rstrip().endswith(".")]
    return wrong


def test_properties():
    assert "\n".join(fault for rna in groups().values() for fault in faults(rna)) == ""


def test_operators():
    assert len(operators()) > 20
    wrong = []
    for name, rna in operators().items():
        if not rna.description or rna.description.rstrip().endswith("."):
            wrong.append(f"{name}: {rna.description!r}")
        if not rna.name or rna.name == name:
            wrong.append(f"{name} has no label")
        wrong += faults(rna)
    assert "\n".join(wrong) == ""


def test_what_is_attached_to_blenders_own_types():
    assert bpy.types.Collection.bl_rna.properties["cmc_plan"].description


@pytest.mark.parametrize("word", ["length", "size", "radius", "height", "span", "tilt", "angle", "spacing"])
def test_lengths_and_angles_have_units(word):
    """Numbers that are lengths or angles are shown in the scene's units."""
    parts_of_a_length = {"width", "height", "hole", "offset", "arrow_scale", "close_size", "slenderness"}
    for rna in (*groups().values(), *operators().values()):
        for prop in own_properties(rna):
            named = word in prop.identifier.split("_") and prop.identifier not in parts_of_a_length
            if prop.type == "FLOAT" and named:
                assert prop.unit in {"LENGTH", "ROTATION"}, f"{rna.identifier}.{prop.identifier} has no unit"
