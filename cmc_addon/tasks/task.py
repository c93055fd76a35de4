"""The base class of tasks: they read Blender's data, work on arrays and write the result.

    task = SolveTask.read(context, plan, settings)    from objects to arrays
    result = task.work(progress)                      no bpy: may run in a thread
    warnings = task.write(context, plan, result)      from arrays to objects

Reading and writing raise `CmcError` and then leave the scene as it is.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Generic, TypeVar

import bpy

from ...solver.errors import Progress
from ...solver.notes import Note

R = TypeVar("R")


class Task(ABC, Generic[R]):
    """One piece of work on one plan. Each has a class method `read(context, plan, …)` with arguments of its own."""

    @property
    def tolerance(self) -> float:
        """The residual at which the progress bar is full."""
        return 1.0

    def shows(self) -> str:
        """The role of the result that the user waits for; "" for none."""
        return ""

    @abstractmethod
    def work(self, progress: Progress) -> R:
        """Do the work, without any Blender data. Raises `CmcError` in the plan's own numbering."""

    @abstractmethod
    def write(self, context: bpy.types.Context, plan: bpy.types.Object, result: R) -> list[Note]:
        """Write a result into the scene; returns warnings for the user.

        Raises `CmcError`, with nothing changed, where the plan is not as it was read.
        """


class Result(ABC):
    """The result of a task's work, as far as the operator needs it."""

    @property
    @abstractmethod
    def converged(self) -> bool:
        """Whether the goal was reached; if not, a warning says how the work ended."""

    @property
    @abstractmethod
    def message(self) -> str:
        """How the work ended, in a sentence."""
