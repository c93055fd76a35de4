"""Relax the stubs of `bpy` in an environment where they are stricter than Blender.

    python scripts/build/relax_bpy_types.py FOLDER

Blender guarantees what the stubs leave open: a panel that is drawn has a layout, the data of a mesh object are a mesh,
vectors and matrices are sequences. Enumerations become strings, since icons and modes come from tables.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

DRAW = (r"draw_func: collections\.abc\.Callable\[\[Context\], None\]", "draw_func: typing.Any")
LITERAL = (r"typing\.Literal\[[^\]]*\]", "str")
RULES = {
    "bpy-stubs/types/__init__.pyi": (
        (r"def layout\(self\) -> None \| UILayout \| None:", "def layout(self) -> UILayout:"),
        (r"def active\(self\) -> None \| Space \| None:", "def active(self) -> typing.Any:"),
        (r"(?<=\n    )data: \(\n        Armature\n[^)]*\)", "data: typing.Any"),
        (r"(?<=\) -> )(Mesh|Curve) \| None:", r"\1:"),
        (r"def copy\(self\) -> None \| typing_extensions\.Self:", "def copy(self) -> typing_extensions.Self:"),
        DRAW,
    ),
    "_bpy_types-stubs/__init__.pyi": (DRAW,),
    "bpy-stubs/stub_internal/rna_enums/__init__.pyi": (LITERAL,),
    "gpu-stubs/state/__init__.pyi": (LITERAL,),
    "gpu-stubs/types/__init__.pyi": (
        (r"(?<=class MatrixStackContext):", "(contextlib.AbstractContextManager):"),
        (r"\Aimport typing\n", "import contextlib\nimport typing\n"),
    ),
    "gpu_extras-stubs/batch/__init__.pyi": (
        LITERAL,
        (r"content: dict\[[^*]*\],\n    \*", "content: dict[str, typing.Any],\n    *"),
        (r"indices: None\n[^=]*=", "indices: typing.Any ="),
    ),
    "mathutils-stubs/__init__.pyi": (
        (r"class Vector:", "class Vector(collections.abc.Sequence[float]):"),
        (r"class Matrix:", "class Matrix(collections.abc.Sequence[Vector]):"),
    ),
}
"""Stub file -> patterns and their replacements."""


def relax(packages: Path) -> None:
    for name, rules in RULES.items():
        file = packages / name
        text = file.read_text(encoding="utf-8")
        for pattern, replacement in rules:
            text = re.sub(pattern, replacement, text)
        file.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    (site_packages,) = Path(sys.argv[1]).glob("lib/python3.*/site-packages")
    relax(site_packages)
