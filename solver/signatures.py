"""The types of arguments at the public door: what a signature promises is checked, and the message names the argument.

`checked` is for functions and methods, `check_fields` for the options that dataclasses hold. Arrays are left to the
code that makes them arrays (`linalg.as_numbers`), and so is every annotation that is no class.
"""

from __future__ import annotations

import inspect
import types
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from functools import cache, wraps
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from .errors import ArgumentError, shown

Function = TypeVar("Function", bound=Callable[..., Any])

_PLAIN: dict[object, tuple[tuple[type, ...], str]] = {
    float: ((int, float, np.integer, np.floating), "a number"),
    int: ((int, np.integer), "a whole number"),
    bool: ((bool, np.bool_), "True or False"),
    str: ((str,), "a text"),
    type(None): ((type(None),), "None"),
}


def checked(function: Function) -> Function:
    """Decorator: raise `ArgumentError` on an argument of another type than annotated."""
    signature = inspect.signature(function)

    @wraps(function)
    def call(*args: Any, **keywords: Any) -> Any:
        check_arguments(function, signature.bind(*args, **keywords).arguments)
        return function(*args, **keywords)

    return call  # type: ignore[return-value]


def check_fields(options: Any) -> None:
    """Raise `ArgumentError` on a field of a dataclass of another type than annotated."""
    kind = type(options)
    check_arguments(kind, {field.name: getattr(options, field.name) for field in fields(options)})


def check_arguments(owner: Callable[..., Any], values: Mapping[str, Any]) -> None:
    """Raise `ArgumentError` on a value of another type than `owner`, a function or a class, annotates by that name."""
    hints = _hints(owner)
    for name, value in values.items():
        if name in hints and not _fits(value, hints[name]):
            call = "" if isinstance(owner, type) else owner.__qualname__.removesuffix(".__init__") + ": "
            raise ArgumentError(f"{call}{name} must be {_said(hints[name])}, not {shown(value)}.")


@cache
def _hints(owner: Callable[..., Any]) -> dict[str, Any]:
    if isinstance(owner, type):
        return get_type_hints(owner, include_extras=True)
    arguments = {name: hint for name, hint in owner.__annotations__.items() if name != "return"}
    stand_in = types.SimpleNamespace(__annotations__=arguments)
    return get_type_hints(stand_in, owner.__globals__, include_extras=True)


def _fits(value: Any, hint: Any) -> bool:
    origin, parts = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        return any(_fits(value, part) for part in parts)
    if hint is Any:
        return True
    if hint in _PLAIN:
        return isinstance(value, _PLAIN[hint][0]) and (hint is bool or not isinstance(value, (bool, np.bool_)))
    if origin is Callable:
        return callable(value)
    if origin in (Sequence, list, tuple):
        if isinstance(value, np.ndarray):  # of items alike
            return value.ndim > 0 and (not len(value) or _fits(value[0], parts[0]))
        if isinstance(value, str):
            return parts[0] is str  # one name in place of a list: where it is used, the message is better
        if not isinstance(value, Sequence) or isinstance(value, bytes):
            return False
        fixed = origin is tuple and parts[-1] is not Ellipsis
        items = parts if fixed else parts[:1] * len(value)
        return len(items) == len(value) and all(map(_fits, value, items))
    if origin is Mapping:
        return isinstance(value, Mapping) and all(_fits(one, parts[1]) for one in value.values())
    kind = origin or hint
    if kind is Annotated:  # checked, with a better message, where it is used
        return True
    if not isinstance(kind, type) or kind is np.ndarray:
        return True
    if getattr(kind, "_is_protocol", False) and not (kind.__module__ or "").startswith(str(__package__)):
        return True  # numpy's, in ArrayLike
    return isinstance(value, kind)


def _said(hint: Any) -> str:
    """A type in words: "a CmcSurface", "a number or None"."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        return " or ".join(dict.fromkeys(_said(part) for part in parts))
    if hint in _PLAIN:
        return _PLAIN[hint][1]
    if origin is Callable:
        return "a function"
    if origin in (Sequence, list, tuple):
        return "a list"
    name = getattr(origin or hint, "__name__", str(hint))
    return f"{'an' if name[0] in 'AEIOU' else 'a'} {name}"
