"""The options of a solve for normals, and how options travel: each is typed once, as a field of a dataclass.

Public functions take the fields as keywords (`with_options`), the code behind them passes the object.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

from numpy.typing import ArrayLike

from ..errors import ConditionError, Progress
from ..limits import TOLERANCE, Range, check_number
from ..signatures import check_fields
from .methods import Method

First = TypeVar("First")
Second = TypeVar("Second")
Result = TypeVar("Result")
Options = TypeVar("Options")
Keywords = ParamSpec("Keywords")


DEGREE = Range(-1000, 1000)
_ITERATIONS = Range(0, 1_000_000, whole=True)


@dataclass(frozen=True, eq=False)
class MapOptions:
    """Options of `HarmonicSolver.solve`, which describes them.

    Raises `ConditionError` on a number out of range.
    """

    initial: ArrayLike | None = None
    _: KW_ONLY
    side: int = +1
    degree: float | None = None
    method: str | Method = "newton"
    tolerance: float = 1e-6
    max_iterations: int | None = None
    progress: Progress | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        check_number(self.tolerance, "tolerance", TOLERANCE)
        if self.max_iterations is not None:
            check_number(self.max_iterations, "largest number of iterations", _ITERATIONS)
        if self.degree is not None:
            check_number(self.degree, "degree", DEGREE)
        if self.side not in (1, -1):
            raise ConditionError(f"The side must be +1 or -1, not {self.side}.")


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
