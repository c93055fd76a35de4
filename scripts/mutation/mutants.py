"""Mutants of a Python file: the same text with one small fault each.

A fault is an operator exchanged (< for <=, + for -, `and` for `or`), a constant shifted, a `not` or a minus dropped, a
returned value dropped, or a statement without a name of its own left out. Left alone are docstrings, annotations,
decorators, f-strings, imports and texts: no test should hold those.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

_OTHERS: dict[type[ast.AST], tuple[type[ast.AST], ...]] = {
    ast.Lt: (ast.LtE, ast.Gt),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div,),
    ast.Div: (ast.Mult,),
    ast.And: (ast.Or,),
    ast.Or: (ast.And,),
}
_SKIPPED = (ast.JoinedStr, ast.Import, ast.ImportFrom)
_SKIPPED_FIELDS = {"annotation", "returns", "type_comment", "decorator_list"}


@dataclass(frozen=True)
class Mutant:
    """A fault in one file. span: the bytes replaced. line: the first of these. lines: first and last of the statement,
    or of the head of a block; (0, 0) where it runs at import only. name: that of the constant it then defines."""

    file: str
    line: int
    span: tuple[int, int]
    old: str
    new: str
    lines: tuple[int, int]
    name: str | None

    def applied(self, source: bytes) -> bytes:
        return source[: self.span[0]] + self.new.encode() + source[self.span[1] :]

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.old}  ->  {self.new}"


def mutants_of(file: str, root: Path) -> list[Mutant]:
    """All mutants of a file, in the order of its lines."""
    source = (root / file).read_bytes()
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found = []
    for node, new, place in _walk(ast.parse(source), _Place()):
        span = (starts[node.lineno - 1] + node.col_offset, starts[node.end_lineno - 1] + node.end_col_offset)
        mutant = Mutant(file, node.lineno, span, source[slice(*span)].decode(), new, place.lines, place.name)
        try:
            compile(mutant.applied(source), file, "exec")
        except SyntaxError:
            continue
        found.append(mutant)
    return sorted(found, key=lambda mutant: (mutant.span, mutant.new))


@dataclass(frozen=True)
class _Place:
    """Where a part of a tree is: see `Mutant`."""

    lines: tuple[int, int] = (0, 0)
    name: str | None = None
    in_function: bool = False

    def at(self, node: ast.AST) -> _Place:
        if isinstance(node, ast.FunctionDef):
            return _Place((node.lineno, node.end_lineno or node.lineno), None, True)
        if not isinstance(node, ast.stmt):
            return self
        if not self.in_function:
            target = node.targets[0] if isinstance(node, ast.Assign) else getattr(node, "target", None)
            return replace(self, name=target.id if isinstance(target, ast.Name) else None)
        last = node.body[0].lineno - 1 if hasattr(node, "body") else node.end_lineno
        return replace(self, lines=(node.lineno, max(node.lineno, last)))


def _walk(node: ast.AST, place: _Place) -> Iterator[tuple[ast.AST, str, _Place]]:
    """The parts of a tree that can be replaced, with their replacements."""
    if isinstance(node, _SKIPPED):
        return
    place = place.at(node)
    yield from ((node, new, place) for new in _replacements(node))
    for field, value in ast.iter_fields(node):
        if field not in _SKIPPED_FIELDS:
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    yield from _walk(child, place)


def _replacements(node: ast.AST) -> Iterator[str]:
    match node:
        case ast.Compare(left, ops, comparators):
            for k, op in enumerate(ops):
                for other in _OTHERS.get(type(op), ()):
                    yield _text(ast.Compare(left, [*ops[:k], other(), *ops[k + 1 :]], comparators))
        case ast.BinOp(left, op, right) if type(op) in _OTHERS and not _is_text(left) and not _is_text(right):
            yield from (_text(ast.BinOp(left, other(), right)) for other in _OTHERS[type(op)])
        case ast.BoolOp(op, values):
            yield from (_text(ast.BoolOp(other(), values)) for other in _OTHERS[type(op)])
        case ast.UnaryOp(ast.Not() | ast.USub(), operand):
            yield _text(operand)
        case ast.Constant(bool() as value):
            yield str(not value)
        case ast.Constant(int() as value):
            yield str(value + 1)
        case ast.Constant(float() as value):
            yield repr(2.0 * value if value else 1.0)
        case ast.Return(value) if value is not None and not (isinstance(value, ast.Constant) and value.value is None):
            yield "return None"
        case ast.AugAssign() | ast.Raise() | ast.Expr(ast.Call()) | ast.Continue() | ast.Break():
            yield "pass"
        case ast.Assign([ast.Attribute() | ast.Subscript()]):
            yield "pass"


def _text(node: ast.expr) -> str:
    return f"({ast.unparse(node)})"


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))
