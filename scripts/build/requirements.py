"""Print requirements of pyproject.toml, one a line, for `pip install -r`.

    python scripts/build/requirements.py [NAME ...]

NAME is `base` (the dependencies of the library), an optional dependency (`test`, `blender`, …) or a
dependency group (`bpy-4.5`, `wheels`, …). Needs nothing but Python 3.11.
"""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

PYPROJECT = Path(__file__).parents[2] / "pyproject.toml"


def requirements(names: list[str]) -> list[str]:
    """The requirement lines of all names, in order; KeyError names the unknown one."""
    table = tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))
    known = {
        "base": table["project"]["dependencies"],
        **table["project"]["optional-dependencies"],
        **table["dependency-groups"],
    }
    return [line for name in names for line in known[name]]


def main(names: list[str]) -> int:
    try:
        print("\n".join(requirements(names)))
    except KeyError as error:
        print(f"pyproject.toml has no dependencies called {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
