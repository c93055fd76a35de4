"""The Python reference: a page for each public name of the solver, made from its signature and docstring.

    .venv/bin/python scripts/build/api_pages.py solve_cmc     # print a page

The pages are not committed. `make docs` and the build of the extension make them, and lead the links of the index,
docs/reference/python.md, to them. The sources are parsed, not imported, so that any Python can do this.
"""

from __future__ import annotations

import ast
import inspect
import re
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
FOLDER = Path("reference/python")
Function = ast.FunctionDef | ast.AsyncFunctionDef
_ITEM = re.compile(r"^([a-z_]\w*(?:, \w+)*)((?: \([^)]*\))?: )")


class Definition(NamedTuple):
    """A public name, the file that defines it, and its syntax tree: a function, class, assignment or module."""

    name: str
    file: Path
    node: ast.AST


def api_pages(solver: Path = ROOT / "solver") -> dict[Path, str]:
    """Path below docs/ → Markdown: a page for each name in `__all__`, and the index with links to them."""
    definitions = {name: find(solver / "__init__.py", name) for name in public_names(solver)}
    pages = {FOLDER / f"{name}.md": page(definition, set(definitions)) for name, definition in definitions.items()}
    index = FOLDER.with_suffix(".md")
    text = (solver.parent / "docs" / index).read_text(encoding="utf-8")
    return pages | {index: re.sub(r"\[`(\w+)`\]\([^)]*\)", rf"[`\1`]({FOLDER.name}/\1.md)", text)}


def public_names(package: Path) -> list[str]:
    """The literal list `__all__` of a package."""
    for node in _tree(package / "__init__.py").body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return sorted(ast.literal_eval(node.value))
    raise LookupError(f"{package} has no __all__")


def find(file: Path, name: str) -> Definition:
    """Follow relative imports from a file to the definition of a name."""
    for node in _tree(file).body:
        if name in _defined(node):
            return Definition(name, file, node)
        if isinstance(node, ast.ImportFrom):
            for alias in node.names:
                if (alias.asname or alias.name) == name:
                    return _imported(file, node, alias.name)
    raise LookupError(f"{file} does not define {name}")


def _imported(file: Path, node: ast.ImportFrom, name: str) -> Definition:
    folder = file.parents[node.level - 1].joinpath(*(node.module or "").split("."))
    module = folder / f"{name}.py"
    if module.is_file():
        return Definition(name, module, _tree(module))
    return find(folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py"), name)


def _tree(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"))


def _defined(node: ast.AST) -> set[str]:
    """Names that a statement of a module or class defines."""
    if isinstance(node, Function | ast.ClassDef):
        return {node.name}
    if isinstance(node, ast.AnnAssign):
        return {ast.unparse(node.target)}
    return {ast.unparse(target) for target in node.targets} if isinstance(node, ast.Assign) else set()


def page(definition: Definition, names: set[str] = frozenset()) -> str:
    """Markdown of a public name; other public names in its docstrings become links."""
    source = definition.file.relative_to(ROOT).as_posix()
    node = definition.node
    parts = [f"# {definition.name}", f"`from solver import {definition.name}`, defined in `{source}`."]
    if isinstance(node, ast.Module):
        parts.append(_docstring(node))
        for each in node.body:
            if isinstance(each, Function | ast.ClassDef) and not each.name.startswith("_"):
                parts += [f"## {each.name}", *_described(each)]
    else:
        parts += _described(node)
    text = "\n\n".join(part for part in parts if part) + "\n"
    others = names - {definition.name}
    return re.sub(r"(?<!\[)`(\w+)`", lambda m: f"[{m[0]}]({m[1]}.md)" if m[1] in others else m[0], text)


def _described(node: ast.AST) -> list[str]:
    """Signature and docstring of a function; of a class also its fields and public methods."""
    if isinstance(node, Function):
        return [_code(_signature(node)), _docstring(node)]
    if not isinstance(node, ast.ClassDef):
        return [_code(ast.unparse(node))]
    bases = f"({', '.join(map(ast.unparse, node.bases))})" if node.bases else ""
    fields = [f"    {ast.unparse(each)}" for each in node.body if _is_field(each)]
    parts = [_code("\n".join([f"class {node.name}{bases}" + (":" if fields else ""), *fields])), _docstring(node)]
    for each in node.body:
        if isinstance(each, Function) and not each.name.startswith("_"):
            parts += [f"### {each.name}", _code(_signature(each)), _docstring(each)]
    return parts


def _is_field(node: ast.AST) -> bool:
    """Whether a statement of a class defines a public field of a dataclass, or a member of an enum."""
    return isinstance(node, ast.Assign | ast.AnnAssign) and not any(name.startswith("_") for name in _defined(node))


def _signature(node: Function) -> str:
    """`def name(…) -> result`, with an argument a line if it is long; no `self`, `cls`."""
    decorators = "".join(f"@{name}\n" for name in map(ast.unparse, node.decorator_list) if "property" in name)
    returned = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    words = _arguments(node.args)
    line = f"def {node.name}({', '.join(words)}){returned}"
    if len(line) > 100:
        line = f"def {node.name}(\n    " + ",\n    ".join(words) + f",\n){returned}"
    return decorators + line


def _arguments(given: ast.arguments) -> list[str]:
    places = [*given.posonlyargs, *given.args]
    defaults = [None] * (len(places) - len(given.defaults)) + given.defaults
    words = [_argument(each, default) for each, default in zip(places, defaults, strict=True)]
    if given.vararg or given.kwonlyargs:
        words.append(f"*{_argument(given.vararg, None) if given.vararg else ''}")
    words += [_argument(each, default) for each, default in zip(given.kwonlyargs, given.kw_defaults, strict=True)]
    words += [f"**{_argument(given.kwarg, None)}"] if given.kwarg else []
    return [word for word in words if word not in ("self", "cls")]


def _argument(argument: ast.arg, default: ast.expr | None) -> str:
    kind = f": {ast.unparse(argument.annotation)}" if argument.annotation else ""
    if default is None:
        return argument.arg + kind
    return f"{argument.arg}{kind}{' = ' if kind else '='}{ast.unparse(default)}"


def _code(text: str) -> str:
    return f"```py\n{text}\n```"


def _docstring(node: ast.AST) -> str:
    """A docstring as Markdown: paragraphs of `name: text` lines become lists."""
    assert isinstance(node, Function | ast.ClassDef | ast.Module)
    paragraphs = inspect.cleandoc(ast.get_docstring(node) or "").split("\n\n")
    return "\n\n".join(_list(text) if _ITEM.match(text) else text for text in paragraphs)


def _list(paragraph: str) -> str:
    lines = [_ITEM.sub(r"- `\1`\2", line) for line in paragraph.split("\n")]
    return "\n".join(line if line.startswith("- ") else f"  {line.strip()}" for line in lines)


if __name__ == "__main__":
    print(*(page(find(ROOT / "solver" / "__init__.py", name)) for name in sys.argv[1:]), sep="\n")
