"""The direction of every import, function-level ones too.

A file imports from the rooms to the left of its own and from its own room, without cycles. Nothing below
`cmc_addon` knows Blender, and the add-on reaches the solver only through relative imports, since two names for
one solver would make two copies of every class.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

# The rooms of each half, from the ground up. Those before `io` are files; `__init__` and `__main__` are last.
SOLVER = (
    "interrupts", "version",
    "errors", "notes", "limits", "signatures", "linalg", "io", "meshing", "domain", "gauss", "surface", "measure",
    "symmetry", "closing", "spanning", "fitting", "catalogue", "nets", "shells", "jobs",
)
ADDON = (
    "properties", "bridges", "drawing", "background", "results", "tasks", "operators", "live", "headless", "panels",
)
TOP = "the top"
RANK = {
    package: {room: rank for rank, room in enumerate((*rooms, TOP))}
    for package, rooms in (("solver", SOLVER), ("cmc_addon", ADDON))
}

BLENDER_MODULES = {"bpy", "bpy_extras", "bmesh", "mathutils", "gpu", "gpu_extras", "blf", "addon_utils"}
OUR_PACKAGES = {"solver", "cmc_addon", "cmc_formfinding"}
# Access to mesh data in bulk; `bmesh` is looked for among the imports.
MESH_ACCESS = {"foreach_get", "foreach_set", "from_pydata", "attributes"}


@dataclass(frozen=True)
class Import:
    """One imported module: its absolute name below the root, and whether it was written with dots."""

    module: str
    relative: bool
    line: int


@dataclass(frozen=True)
class Source:
    """A parsed file, its path below the root and its module name (`solver.domain` for a package)."""

    path: Path
    module: str
    tree: ast.Module
    imports: tuple[Import, ...]


def read_sources(root: Path) -> list[Source]:
    """Every Python file of `solver/` and `cmc_addon/` below `root`."""
    paths = sorted(path for package in ("solver", "cmc_addon") for path in (root / package).rglob("*.py"))
    modules = {path: module_name(path.relative_to(root)) for path in paths}
    known = set(modules.values())
    sources = []
    for path, module in modules.items():
        tree = ast.parse(path.read_text(encoding="utf-8"), filename=str(path))
        package = module if path.name == "__init__.py" else module.rpartition(".")[0]
        found = tuple(imports_of(tree, package, known))
        sources.append(Source(path.relative_to(root), module, tree, found))
    return sources


def module_name(path: Path) -> str:
    parts = path.with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports_of(tree: ast.Module, package: str, known: set[str]) -> Iterator[Import]:
    """Imports at any depth; `from . import x` is `package.x` where that is a module."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield Import(alias.name, False, node.lineno)
        elif isinstance(node, ast.ImportFrom):
            base = absolute_name(node, package)
            for alias in node.names:
                inner = f"{base}.{alias.name}".lstrip(".")
                yield Import(inner if inner in known else base, node.level > 0, node.lineno)
        elif isinstance(node, ast.Call) and (name := dynamic_import(node)):
            yield Import(name, False, node.lineno)


def absolute_name(node: ast.ImportFrom, package: str) -> str:
    """The module an import statement names; above the root of the checkout it is empty."""
    if node.level == 0:
        return node.module or ""
    parts = package.split(".")
    parts = parts[: max(0, len(parts) - node.level + 1)]
    return ".".join([*parts, *([node.module] if node.module else [])])


def dynamic_import(node: ast.Call) -> str | None:
    """The literal in `import_module("…")` or `__import__("…")`."""
    function = node.func
    name = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
    if name not in ("import_module", "__import__") or not node.args:
        return None
    argument = node.args[0]
    literal = isinstance(argument, ast.Constant) and isinstance(argument.value, str)
    return argument.value if literal else None


def room_of(module: str) -> str:
    """The room of a module, "the top" for the files beside the rooms."""
    package, part = [*module.split("."), ""][:2]
    return part if part in RANK[package] else TOP


# --------------------------------------------------------------------------------------------
# the rules: each yields sentences, one a violation
# --------------------------------------------------------------------------------------------


def direction(sources: list[Source]) -> Iterator[str]:
    """Rooms import leftwards, in each half."""
    for package, rank in RANK.items():
        for source in of_package(sources, package):
            mine = room_of(source.module)
            for found in source.imports:
                if not found.relative or top(found.module) != package:
                    continue
                other = room_of(found.module)
                if rank[other] > rank[mine]:
                    yield f"{source.path}:{found.line}: {mine} must not import {found.module} ({other})"


def known_rooms(sources: list[Source]) -> Iterator[str]:
    """Every folder is a room with a place in the order; beside the rooms there are only the two ways in."""
    for package, rank in RANK.items():
        for source in of_package(sources, package):
            room, *inside = source.path.parts[1:]
            if inside and room not in rank:
                yield f"{source.path}: {room}/ has no place in the order of rooms"
            elif not inside and room not in ("__init__.py", "__main__.py") and room.removesuffix(".py") not in rank:
                yield f"{source.path}: belongs into a room"


def solver_names(sources: list[Source]) -> Iterator[str]:
    """The solver knows itself only by relative imports, and Blender and the add-on not at all."""
    for source in of_package(sources, "solver"):
        for found in source.imports:
            where = f"{source.path}:{found.line}"
            if found.relative and top(found.module) != "solver":
                yield f"{where}: a relative import leads out of solver/"
            elif not found.relative and top(found.module) in BLENDER_MODULES:
                yield f"{where}: {found.module} under solver/"
            elif not found.relative and top(found.module) in OUR_PACKAGES:
                yield f"{where}: write the import of {found.module} with dots"


def addon_names(sources: list[Source]) -> Iterator[str]:
    """The add-on takes the solver, and itself, by relative imports only."""
    for source in of_package(sources, "cmc_addon"):
        for found in source.imports:
            where = f"{source.path}:{found.line}"
            if not found.relative and top(found.module) in OUR_PACKAGES:
                yield f"{where}: write the import of {found.module} with dots"
            elif found.relative and top(found.module) not in ("solver", "cmc_addon"):
                yield f"{where}: a relative import leads to neither solver/ nor cmc_addon/"


def cycles(sources: list[Source]) -> Iterator[str]:
    """No file imports itself through others."""
    known = {source.module for source in sources}
    edges = {
        source.module: sorted({found.module for found in source.imports if found.relative} & known)
        for source in sources
    }
    state: dict[str, str] = {}

    def visit(module: str, path: tuple[str, ...]) -> Iterator[str]:
        state[module] = "open"
        for other in edges[module]:
            if state.get(other) == "open":
                loop = (*path, module, other)
                yield "a cycle of imports: " + " → ".join(loop[loop.index(other) :])
            elif other not in state:
                yield from visit(other, (*path, module))
        state[module] = "done"

    for module in edges:
        if module not in state:
            yield from visit(module, ())


def mesh_bridge_alone(sources: list[Source]) -> Iterator[str]:
    """Only `*_bridge.py`, in `cmc_addon/bridges/`, touch mesh data in bulk."""
    for source in of_package(sources, "cmc_addon"):
        if source.path.name.endswith("_bridge.py"):
            continue
        for found in source.imports:
            if top(found.module) == "bmesh":
                yield f"{source.path}:{found.line}: bmesh outside the mesh bridges"
        for node in ast.walk(source.tree):
            if isinstance(node, ast.Attribute) and node.attr in MESH_ACCESS:
                yield f"{source.path}:{node.lineno}: .{node.attr} outside the mesh bridges"


def of_package(sources: list[Source], package: str) -> list[Source]:
    return [source for source in sources if top(source.module) == package]


def top(module: str) -> str:
    return module.split(".")[0]


RULES = (direction, known_rooms, solver_names, addon_names, cycles, mesh_bridge_alone)


# --------------------------------------------------------------------------------------------
# the tests
# --------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def sources() -> list[Source]:
    return read_sources(ROOT)


def test_there_is_something_to_check(sources: list[Source]) -> None:
    assert len(of_package(sources, "solver")) >= 3
    assert any(found.module == "solver.errors" for source in sources for found in source.imports)


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.__name__)
def test_imports(sources: list[Source], rule) -> None:
    violations = list(rule(sources))
    assert not violations, "\n".join(violations)


GOOD = {
    "solver/__init__.py": "from .gauss.harmonic import solve",
    "solver/errors.py": "",
    "solver/linalg.py": "from .errors import CmcError",
    "solver/domain/__init__.py": "",
    "solver/domain/domain.py": "from ..errors import MeshError\nimport numpy as np",
    "solver/domain/sites.py": "from .domain import Domain",
    "solver/gauss/harmonic.py": "from ..domain import domain\nfrom .. import linalg",
    "solver/jobs/job.py": "from ..gauss import harmonic",
    "cmc_addon/__init__.py": "from .operators import solve",
    "cmc_addon/bridges/mesh_bridge.py": "import bpy\nimport bmesh\nfrom ...solver import solve\nx.foreach_get('co')",
    "cmc_addon/tasks/solve.py": "from ...solver.errors import CmcError\nfrom ..bridges import mesh_bridge",
    "cmc_addon/operators/solve.py": "from ..tasks import solve",
}
MESH, TASK, JOB = "cmc_addon/bridges/mesh_bridge.py", "cmc_addon/tasks/solve.py", "solver/jobs/job.py"
BAD = {
    "rightwards": ("direction", "solver/domain/domain.py", "from ..gauss import harmonic"),
    "rightwards, in a function": (
        "direction",
        "solver/domain/domain.py",
        "def f():\n    from ..gauss.harmonic import solve",
    ),
    "linalg from a room": ("direction", "solver/linalg.py", "from .domain.domain import Domain"),
    "the public names from a room": ("direction", "solver/gauss/harmonic.py", "from .. import solve"),
    "rightwards in the add-on": ("direction", MESH, "from ..tasks import solve"),
    "the add-on's top from a room": ("direction", TASK, "from .. import register"),
    "a room without a place": ("known_rooms", "solver/work/solve.py", ""),
    "a room of the add-on without a place": ("known_rooms", "cmc_addon/work/solve.py", ""),
    "a file beside the rooms": ("known_rooms", "solver/pipeline.py", ""),
    "bpy": ("solver_names", JOB, "import bpy.types"),
    "bpy by name": ("solver_names", JOB, "import importlib\nimportlib.import_module('bpy')"),
    "absolute": ("solver_names", JOB, "from solver.errors import CmcError"),
    "the add-on": ("solver_names", JOB, "from ...cmc_addon.bridges import mesh_bridge"),
    "an absolute solver in the add-on": ("addon_names", MESH, "import solver"),
    "beside the add-on": ("addon_names", MESH, "from ...scripts import demo"),
    "a cycle": ("cycles", "solver/domain/domain.py", "def f():\n    from .sites import disc"),
    "a cycle in the add-on": ("cycles", MESH, "from ..operators import solve"),
    "bmesh": ("mesh_bridge_alone", TASK, "import bmesh"),
    "bulk access": ("mesh_bridge_alone", "cmc_addon/__init__.py", "mesh.vertices.foreach_set('co', a)"),
    "an attribute": ("mesh_bridge_alone", "cmc_addon/__init__.py", "mesh.attributes.new('x', 'INT', 'EDGE')"),
}


def write_tree(root: Path, files: dict[str, str]) -> list[Source]:
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text + "\n", encoding="utf-8")
    return read_sources(root)


def test_a_good_tree_passes(tmp_path: Path) -> None:
    tree = write_tree(tmp_path, GOOD)
    assert [violation for rule in RULES for violation in rule(tree)] == []


@pytest.mark.parametrize(("rule", "name", "text"), BAD.values(), ids=BAD.keys())
def test_each_rule_can_fail(tmp_path: Path, rule: str, name: str, text: str) -> None:
    tree = write_tree(tmp_path, {**GOOD, name: text})
    violations = {candidate.__name__: list(candidate(tree)) for candidate in RULES}
    assert violations[rule]
    assert name in violations[rule][0] or rule == "cycles"
