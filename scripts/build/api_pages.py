"""The Python reference: a page for each public name of the solver, made from its signature and docstring.

    .venv/bin/python scripts/build/api_pages.py solve_cmc     # print a page

The pages are not committed. `make docs` and the build of the extension make them, and lead the links of the index,
docs/reference/python.md, to them.
"""

from __future__ import annotations

import ast
import inspect
import re
import sys
import textwrap
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
if str(ROOT) not in sys.path:
    sys.path.append(str(ROOT))

import solver

FOLDER = Path("reference/python")
_ITEM = re.compile(r"^([a-z_]\w*(?:, \w+)*)((?: \([^)]*\))?: )")
_NO_VALUE = inspect.Parameter.empty


def api_pages() -> dict[Path, str]:
    """Path below docs/ → Markdown: a page for each name in `solver.__all__`, and the index with links to them."""
    index = FOLDER.with_suffix(".md")
    text = (ROOT / "docs" / index).read_text(encoding="utf-8")
    linked = re.sub(r"\[`(\w+)`\]\([^)]*\)", rf"[`\1`]({FOLDER.name}/\1.md)", text)
    return {FOLDER / f"{name}.md": page(name) for name in solver.__all__} | {index: linked}


def page(name: str) -> str:
    """Markdown of a public name; other public names in its docstrings become links."""
    value = getattr(solver, name)
    parts = [f"# {name}", f"`from solver import {name}`, defined in `{source_of(value)}`."]
    if isinstance(value, ModuleType):
        parts.append(_docstring(value))
        for key, each in _public(vars(value)):
            if (inspect.isroutine(each) or inspect.isclass(each)) and _is_own(value, key, each):
                parts += [f"## {key}", *_described(key, each)]
    else:
        parts += _described(name, value)
    text = "\n\n".join(part for part in parts if part) + "\n"
    others = set(solver.__all__) - {name}
    return re.sub(r"(?<!\[)`(\w+)`", lambda match: _link(match) if match[1] in others else match[0], text)


def _is_own(module: ModuleType, name: str, each: Any) -> bool:
    """Whether a module defines a name, or hands it on as its own and no page of its own has it."""
    handed_on = name in getattr(module, "__all__", ()) and name not in solver.__all__
    return handed_on or each.__module__ == module.__name__


def source_of(value: Any) -> str:
    """The file that defines a function, class or module, from the project's folder."""
    file = inspect.getsourcefile(inspect.unwrap(value) if callable(value) else value)
    return Path(file or "").relative_to(ROOT).as_posix()


def _link(match: re.Match[str]) -> str:
    return f"[{match[0]}]({match[1]}.md)"


def _public(names: Any) -> Iterator[tuple[str, Any]]:
    return ((name, value) for name, value in list(names.items()) if not name.startswith("_"))


def _described(name: str, value: Any) -> list[str]:
    """Signature and docstring of a function; of a class also its fields, properties and methods."""
    if not inspect.isclass(value):
        return [_code(_signature(f"def {name}", value)), _docstring(value)]
    fields = _fields(value)
    head = f"class {name}:\n" + "\n".join(fields) if fields else _signature(f"class {name}", value)
    parts = [_code(head), _docstring(value)]
    for key, each in _public(vars(value)):
        if isinstance(each, property | cached_property):
            getter = each.fget if isinstance(each, property) else each.func
            parts += [f"### {key}", _code("@property\n" + _signature(f"def {key}", getter)), _docstring(each)]
        elif isinstance(each, FunctionType | classmethod | staticmethod):
            function = each if isinstance(each, FunctionType) else each.__func__
            made = "" if each is function else f"@{type(each).__name__}\n"
            parts += [f"### {key}", _code(made + _signature(f"def {key}", function)), _docstring(function)]
    return parts


def _fields(kind: type) -> list[str]:
    """Lines of the public fields of a dataclass, or the members of an enum."""
    if issubclass(kind, Exception):
        return []
    (node,) = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
    assert isinstance(node, ast.ClassDef)
    lines = [ast.unparse(each) for each in node.body if isinstance(each, ast.Assign | ast.AnnAssign)]
    return [f"    {line}" for line in lines if not line.startswith("_")]


def _signature(head: str, value: Any) -> str:
    """`def name(…) -> result`, with an argument a line if it is long; no `self`, `cls`."""
    try:
        signature = inspect.signature(value)
    except ValueError:  # exceptions of Python's own kind have none
        return head
    words, named = [], False
    for parameter in signature.parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and not named:
            words.append("*")
        named = named or parameter.kind in (parameter.KEYWORD_ONLY, parameter.VAR_POSITIONAL)
        words += [_argument(parameter)] if parameter.name not in ("self", "cls") else []
    result = "" if signature.return_annotation in (_NO_VALUE, None) else f" -> {_kind(signature.return_annotation)}"
    result = "" if head.startswith("class ") else result
    line = f"{head}({', '.join(words)}){result}"
    return line if len(line) <= 100 else f"{head}(\n    " + ",\n    ".join(words) + f",\n){result}"


def _argument(parameter: inspect.Parameter) -> str:
    star = {parameter.VAR_POSITIONAL: "*", parameter.VAR_KEYWORD: "**"}.get(parameter.kind, "")
    kind = "" if parameter.annotation is _NO_VALUE else f": {_kind(parameter.annotation)}"
    if parameter.default is _NO_VALUE:
        return star + parameter.name + kind
    return f"{parameter.name}{kind}{' = ' if kind else '='}{parameter.default!r}"


def _kind(annotation: Any) -> str:
    return annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)


def _code(text: str) -> str:
    return f"```py\n{text}\n```"


def _docstring(value: Any) -> str:
    """A docstring as Markdown: paragraphs of `name: text` lines become lists."""
    paragraphs = (inspect.getdoc(value) or "").split("\n\n")
    return "\n\n".join(_list(text) if _ITEM.match(text) else text for text in paragraphs)


def _list(paragraph: str) -> str:
    lines = [_ITEM.sub(r"- `\1`\2", line) for line in paragraph.split("\n")]
    return "\n".join(line if line.startswith("- ") else f"  {line.strip()}" for line in lines)


if __name__ == "__main__":
    print(*map(page, sys.argv[1:]), sep="\n")
