"""The last solves, for tasks on their shells: a plan that is solved is not solved again."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from typing import Any

import numpy as np

from . import plan_cache

SolveTask = SolveResult = Any  # of the room `tasks`, which is above this one

_KEPT = 3
_solved: OrderedDict[tuple, tuple[SolveTask, SolveResult]] = OrderedDict()


def remember(task: SolveTask, result: SolveResult) -> None:
    """Keep the result of a task."""
    key = key_of(task)
    _solved[key] = (task, result)
    _solved.move_to_end(key)
    while len(_solved) > _KEPT:
        _solved.popitem(last=False)


def recall(task: SolveTask) -> SolveResult | None:
    """The result of an equal task, if it is still known."""
    known = _solved.get(key_of(task))
    return None if known is None else known[1]


def latest(name: str) -> tuple[SolveTask, SolveResult] | None:
    """The last task of the plan of this name and its result, whatever has changed since; for the screen."""
    return next((pair for pair in reversed(_solved.values()) if pair[0].name == name), None)


def forget(which: Callable[[SolveResult], bool]) -> None:
    """Drop some results."""
    for key in [key for key, (_, result) in _solved.items() if which(result)]:
        del _solved[key]


def key_of(task: SolveTask) -> tuple:
    """Equal for tasks with equal results: plan, conditions, settings."""
    groups = [
        (group.name, group.kind, sorted(group.parameters.items()), np.asarray(group.edges).tobytes())
        for group in task.groups
    ]
    settings = sorted(vars(task.settings).items())
    return plan_cache.fingerprint(task.mesh), task.mesh.flipped_corners, repr(groups), repr(settings)


def register() -> None:
    """Nothing to do: the cache fills with use."""


def unregister() -> None:
    _solved.clear()
