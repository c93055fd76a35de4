"""The minimisers by name, all behind the same call."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

from .balance import balanced
from .flow import flow
from .gauss_seidel import gauss_seidel
from .lagrange import lagrange
from .newton import Minimum, newton
from .saddles import climb


@dataclass(frozen=True)
class Method:
    """A minimiser as a user interface offers it: `of(problem, N, tolerance=, max_iterations=, progress=)`."""

    label: str
    description: str
    of: Callable[..., Minimum] = field(repr=False)
    minimises: bool = True


METHODS = {
    "newton": Method("Newton", "Newton's method with conjugate gradients: a few steps on any mesh", newton),
    "flow": Method("Gradient flow", "The paper's H¹ gradient flow: steady, tens to hundreds of steps", flow),
    "gauss_seidel": Method("Gauss-Seidel", "Average the neighbours again and again: simple and slow", gauss_seidel),
    "lagrange": Method("Lagrange-Newton", "The paper's system with multipliers: a slow reference", lagrange),
    "saddle": Method("Saddle", "Up along one unstable mode, down along all others: unstable maps", climb, False),
    "critical": Method(
        "Nearest critical",
        "To the nearest critical map of any kind, from an initial map",
        partial(climb, index=None, max_iterations=30),  # it converges quickly or not at all
        False,
    ),
}

BALANCED = Method("Balanced", "Descent among maps whose normals balance: for closed domains", balanced, False)
"""The method for `conditions.balanced`; not a choice for other conditions."""
