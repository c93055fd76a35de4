"""The last solves, for what is made of their shells: Complete by Symmetry does not solve again what is solved."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from typing import Any

import numpy as np

from . import plan_cache

Order = Outcome = Any  # of `forming`, which this module is a part of

_KEPT = 3
_solved: OrderedDict[tuple, tuple[Order, Outcome]] = OrderedDict()


def remember(order: Order, outcome: Outcome) -> None:
    """Keep what an order gave."""
    _solved[key_of(order)] = (order, outcome)
    _solved.move_to_end(key_of(order))
    while len(_solved) > _KEPT:
        _solved.popitem(last=False)


def recall(order: Order) -> Outcome | None:
    """What the same order gave, if that is still known."""
    known = _solved.get(key_of(order))
    return None if known is None else known[1]


def latest(name: str) -> tuple[Order, Outcome] | None:
    """The last order of a plan of this name and what it gave, whatever was changed since; for the screen."""
    return next((pair for pair in reversed(_solved.values()) if pair[0].name == name), None)


def forget(which: Callable[[Outcome], bool]) -> None:
    """Drop some outcomes."""
    for key in [key for key, (_, outcome) in _solved.items() if which(outcome)]:
        del _solved[key]


def key_of(order: Order) -> tuple:
    """Equal for orders that give the same: plan, conditions, settings."""
    groups = [
        (group.name, group.kind, sorted(group.parameters.items()), np.asarray(group.edges).tobytes())
        for group in order.groups
    ]
    settings = sorted(vars(order.settings).items())
    return plan_cache.fingerprint(order.mesh), order.mesh.flipped_corners, repr(groups), repr(settings)


def register() -> None:
    """Nothing to do: what is kept comes with use."""


def unregister() -> None:
    _solved.clear()
