"""The sidebar drawn without a window, on a stand-in for Blender's layout that checks each name.

Blender draws nothing without a window, so the panels draw on `Layout`, which raises where Blender would show a warning
in the console: a property that the data does not have, an operator or an icon that does not exist.
"""

from __future__ import annotations

from importlib import import_module
from types import SimpleNamespace

import bpy

ICONS = set(bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items.keys())
LISTS = {"CMC_UL_groups"}


class Layout:
    """Records texts, properties and operators; rows and columns write into the same record. No text is grey, which is
    hard to read in the light theme."""

    def __init__(self, record=None, active=True) -> None:
        self.active = active
        self.record = record if record is not None else SimpleNamespace(texts=[], props=[], operators=[])

    def _part(self, **_):
        return Layout(self.record, self.active)

    row = column = split = box = grid_flow = _part

    def label(self, *, text="", icon="NONE"):
        assert icon in ICONS
        assert self.active or not text, f"{text!r} is grey"
        self.record.texts.append(text)

    def prop(self, data, name, *, text=None, icon="NONE", index=-1, **_):
        assert name in data.bl_rna.properties, f"{data} has no {name}"
        assert icon in ICONS
        self.record.props.append(name)

    def prop_enum(self, data, name, value, *, text=None):
        prop = data.bl_rna.properties[name]
        assert value in [item.identifier for item in prop.enum_items]
        self.record.props.append(name)
        self.record.texts.append(prop.enum_items[value].name if text is None else text)

    def operator(self, name, *, text="", icon="NONE", **_):
        assert icon in ICONS
        kind = getattr(bpy.ops.cmc, name.removeprefix("cmc.")).get_rna_type()
        self.record.operators.append(name)
        if text:
            self.record.texts.append(text)
        return Properties(kind)

    def menu(self, name, **_):
        assert hasattr(bpy.types, name)

    def template_list(self, kind, _id, data, name, active_data, active_name, rows=5, **_):
        assert kind in LISTS and rows == 4
        for item in getattr(data, name):
            panel_class(kind).draw_item(
                SimpleNamespace(), bpy.context, self, data, item, 0, active_data, active_name)

    def separator(self, **_):
        pass

    def progress(self, *, factor, text, **_):
        assert 0 <= factor <= 1
        self.record.texts.append(text)


class Properties:
    """What `layout.operator` returns: takes only properties that the operator has."""

    def __init__(self, kind) -> None:
        object.__setattr__(self, "kind", kind)

    def __setattr__(self, name, value) -> None:
        assert name in self.kind.properties, f"{self.kind.identifier} has no {name}"


def panel_class(name):
    """A class of the add-on by its name: every panel is drawn, whatever module it is in."""
    from cmc_formfinding import cmc_addon as addon

    for module in (import_module(f"{addon.__name__}.{name}") for name in addon.MODULES):
        if hasattr(module, name):
            return getattr(module, name)
    raise LookupError(name)


def panels() -> list[str]:
    """All panels of the sidebar."""
    from cmc_formfinding.cmc_addon.panels import sidebar
    from cmc_formfinding.cmc_addon.panels import tab as panels

    return [cls.__name__ for cls in sidebar._registered(panels.Tab)]


def draw(*names) -> SimpleNamespace:
    """Draw panels as Blender would, those whose poll allows it."""
    layout = Layout()
    region = SimpleNamespace(width=250)
    context = SimpleNamespace(**{
        name: getattr(bpy.context, name)
        for name in ("object", "scene", "window_manager", "mode", "preferences", "view_layer")
    }, region=region)
    for name in names or panels():
        cls = panel_class(name)
        if getattr(cls, "poll", lambda _: True)(context):
            assert hasattr(bpy.types, name), f"{name} is not registered"
            self = Drawn(cls, layout)
            cls.draw(self, context)
            if hasattr(cls, "draw_header_preset"):
                cls.draw_header_preset(self, context)
    return layout.record


class Drawn:
    """Stands for a panel: its helper methods and a layout."""

    def __init__(self, cls, layout) -> None:
        self._cls, self.layout = cls, layout

    def __getattr__(self, name):
        return getattr(self._cls, name).__get__(self)


def text_of(record) -> str:
    return " ".join(record.texts).replace("\u00a0", " ")
