"""The options of a solve, each typed once: public functions take keywords, the code behind them passes one object."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ..errors import ConditionError, Progress, check_choice
from ..gauss.harmonic import HarmonicSolver
from .averaging import AVERAGINGS

First = TypeVar("First")
Second = TypeVar("Second")
Result = TypeVar("Result")
Options = TypeVar("Options")
Keywords = ParamSpec("Keywords")


@dataclass(frozen=True, eq=False)
class SolveOptions:
    """What `CmcSolver.solve` takes besides the conditions; `solve_cmc` describes them.

    Raises `ConditionError` on a mean curvature or a tolerance that is out of range, and on an unknown average.
    """

    initial: ArrayLike | None = None
    _: KW_ONLY
    averaging: str = "galerkin"
    method: str = "newton"
    tolerance: float = 1e-6
    max_iterations: int | None = None
    mean_curvature: float = 0.5
    side: int = +1
    degree: float | None = None
    period_tolerance: float = 1e-3
    progress: Progress | None = None

    def __post_init__(self) -> None:
        if not (_is_number(self.mean_curvature) and np.isfinite(self.mean_curvature) and self.mean_curvature > 0.0):
            raise ConditionError(f"The mean curvature must be a positive number, not {self.mean_curvature!r}.")
        check_choice(self.averaging, AVERAGINGS, "average")
        # an infinite tolerance closes every gap
        if not (_is_number(self.period_tolerance) and self.period_tolerance >= 0.0):
            raise ConditionError(
                f"The tolerance of periods must be a part of the diameter, 0 or more, not {self.period_tolerance!r}."
            )

    @property
    def scale(self) -> float:
        """1 / (2 H), the factor from the paper's scale to that of the result."""
        return 0.5 / self.mean_curvature

    @property
    def map_keywords(self) -> dict[str, Any]:
        """The keywords that `HarmonicSolver.solve` has, too."""
        names = inspect.signature(HarmonicSolver.solve).parameters
        return {name: value for name, value in vars(self).items() if name in names}


@dataclass(frozen=True, eq=False)
class CmcOptions(SolveOptions):
    """What `solve_cmc` takes besides domain and conditions: the options of the solver, and those of its solve."""

    _: KW_ONLY
    sites: str = "vertices"
    energy: str = "cotan"
    delaunay: bool = False


def with_options(
    kind: Callable[Keywords, Options],
) -> Callable[
    [Callable[[First, Second, Options], Result]],
    Callable[Concatenate[First, Second, Keywords], Result],
]:
    """Decorator: callers give the fields of the dataclass `kind` as keywords, the function takes one as last argument.

    Type checkers and `help` see the signature with all keywords. An unknown one is a `TypeError` that names the
    function.
    """

    def decorate(
        function: Callable[[First, Second, Options], Result],
    ) -> Callable[Concatenate[First, Second, Keywords], Result]:
        own = inspect.signature(function, eval_str=False)
        leading = list(own.parameters.values())[:-1]
        signature = own.replace(parameters=[*leading, *inspect.signature(kind).parameters.values()])

        @wraps(function)
        def call(*args: Any, **keywords: Any) -> Result:
            try:
                given = signature.bind(*args, **keywords).arguments
            except TypeError as error:
                raise TypeError(f"{function.__name__}: {error}") from None
            values = [given.pop(parameter.name) for parameter in leading]
            return function(*values, kind(**given))  # pyright: ignore[reportCallIssue]

        call.__signature__ = signature  # type: ignore[attr-defined]
        return call

    return decorate


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float, np.number))
