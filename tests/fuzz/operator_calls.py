"""Random calls of our operators: which one, with which properties, and how it ended."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from random import Random

import bpy

# Properties that decide how large a mesh becomes: more than this only takes longer.
_MOST = {"columns": 16, "edges": 12}
# Settings that a sequence rarely needs, each worth seconds.
_RARE = {"complete_repeat", "complete_count", "tile_repeat"}
# Shown in the window only.
_NOT_CALLED = {"cancel"}


@dataclass(frozen=True)
class Call:
    """A call of `bpy.ops.cmc.<name>` with these properties."""

    name: str
    properties: dict

    def __str__(self) -> str:
        return f"cmc.{self.name}({', '.join(f'{key}={value!r}' for key, value in self.properties.items())})"

    @property
    def has_undo(self) -> bool:
        return "UNDO" in getattr(bpy.types, f"CMC_OT_{self.name}").bl_options

    def run(self) -> tuple[str, str]:
        """"finished", "cancelled", "refused" by poll, or "failed", and the message. Other errors are raised.

        A step for undo, as a click is.
        """
        operator = getattr(bpy.ops.cmc, self.name)
        try:
            ended = operator("EXEC_DEFAULT", True, **self.properties)
        except RuntimeError as error:
            text = str(error)
            if ".poll() failed" in text or "poll()" in text.split("\n")[0]:
                return "refused", text
            return "failed", text
        return ("finished" if "FINISHED" in ended else "cancelled"), ""


def random_call(random: Random, folder: Path) -> Call:
    name = random.choice(sorted(set(_operators()) - _NOT_CALLED) + _OFTEN)
    given = {}
    for rna in getattr(bpy.ops.cmc, name).get_rna_type().properties:
        key = rna.identifier
        if key == "rna_type" or random.random() > (0.03 if key in _RARE else 0.3):
            continue
        given[key] = random_value(random, rna)
    for key in _MOST.keys() & {rna.identifier for rna in getattr(bpy.ops.cmc, name).get_rna_type().properties}:
        given[key] = random.randint(4, _MOST[key])
    if name == "export":
        given["filepath"] = _path(random, folder)
    return Call(name, given)


def _operators() -> list[str]:
    return [name for name in dir(bpy.ops.cmc) if not name.startswith("_")]


_OFTEN = ["solve"] * 6 + ["mesh_plan", "group_add", "group_assign", "add_plan", "complete", "export"]


def random_value(random: Random, rna: bpy.types.Property):
    """A value that the property takes: usual, at its limits, or by name."""
    if rna.type == "ENUM":
        items = [item.identifier for item in rna.enum_items] or [rna.default]
        return {random.choice(items)} if rna.is_enum_flag else random.choice(items)
    if rna.type == "STRING":
        return random.choice(_names())
    if rna.type == "BOOLEAN" and not rna.is_array:
        return random.random() < 0.5
    if rna.is_array:
        return tuple(_number(random, rna) for _ in range(rna.array_length))
    return _number(random, rna)


def _number(random: Random, rna: bpy.types.Property):
    if rna.type == "BOOLEAN":
        return random.random() < 0.5
    low, high = max(rna.soft_min, -1e3), min(rna.soft_max, 1e3)
    if rna.type == "INT":
        high = min(high, 8)
        return random.choice((rna.hard_min, rna.hard_max)) if random.random() < 0.1 else random.randint(
            int(low), int(max(low, high)))
    if random.random() < 0.15:
        return random.choice((rna.hard_min, rna.hard_max, 0.0, 1e-30, -1e-30, 1e30, math.inf, math.nan))
    return random.uniform(low, high)


def _names() -> list[str]:
    """Names of what there is, and of what is not."""
    groups = [group.name for mesh in bpy.data.meshes for group in mesh.cmc.groups]
    return sorted({*bpy.data.objects.keys(), *bpy.data.collections.keys(), *groups}) + ["", "nobody", "x" * 200]


def _path(random: Random, folder: Path) -> str:
    name = random.choice(("a", "ä ö", "..", ".", "a.b", "x" * 300, "report"))
    ending = random.choice(("", ".glb", ".obj", ".ply", ".stl", ".json", ".GLB", ".xyz", "/"))
    place = random.choice((str(folder), f"{folder}/sub", "//", "", "/proc", "/dev/null", f"{folder}/a.glb"))
    return f"{place}/{name}{ending}" if place != "//" else f"//{name}{ending}"


def is_sentence(text: str) -> bool:
    """Whether a message is a sentence for a user rather than the trace of an error."""
    is_ours = "Traceback" in text or "of the program itself" in text
    return not is_ours and bool(re.match(r"(Error: )?\S.* .*\S$", text.strip(), re.DOTALL))
