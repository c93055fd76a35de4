"""Errors for bad input, the status of a solve, and how long work reports progress and is cancelled.

Bad input raises a `CmcError` whose message names the offender and the way out. A solve that does not reach
its tolerance is not an error: its result carries a `Status`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from difflib import get_close_matches
from enum import Enum
from numbers import Integral, Real
from typing import Any

_LISTED = 8
_DIGITS = 40


class CmcError(Exception):
    """Bad input. The message is one or two sentences; the offending indices are attributes.

    `vertices`, `edges` and `faces` hold the offenders as tuples of ints, numbered as in the input, so that a user
    interface can select them or translate them to its own numbering.
    """

    def __init__(
        self,
        message: str,
        *,
        vertices: Iterable[int] = (),
        edges: Iterable[int] = (),
        faces: Iterable[int] = (),
    ) -> None:
        super().__init__(message)
        self.vertices = tuple(int(i) for i in vertices)
        self.edges = tuple(int(i) for i in edges)
        self.faces = tuple(int(i) for i in faces)


class MeshError(CmcError):
    """The mesh is not a domain: not a connected, oriented, manifold triangle mesh with proper triangles."""


class ConditionError(CmcError):
    """The boundary conditions contradict each other, or do not fit the domain."""


class ArgumentError(ConditionError, TypeError):
    """An argument is of another type than the call takes."""


class JobError(CmcError):
    """A job file, a mesh file or a setting cannot be used."""


class Status(Enum):
    """How a solve ended. The value is the name in reports; `sentence` is for people."""

    CONVERGED = "converged"
    STALLED = "stalled"
    ITERATION_LIMIT = "iteration limit"
    UNDER_RESOLVED = "under-resolved"
    COLLAPSED = "collapsed"
    CANCELLED = "cancelled"
    GAP = "gap"
    SADDLE = "saddle"
    OTHER_DEGREE = "other degree"
    UNBOUNDED = "unbounded"

    @property
    def sentence(self) -> str:
        """How the solve ended, and the way out if it failed."""
        return _SENTENCES[self]


_SENTENCES = {
    Status.CONVERGED: "Converged: the normals are harmonic to the tolerance.",
    Status.STALLED: "No step lowers the energy any further, but the tolerance is not reached; "
    "refine or improve the mesh.",
    Status.ITERATION_LIMIT: "The iteration limit comes before the tolerance; allow more iterations, or take another "
    "method.",
    Status.UNDER_RESOLVED: "Neighbouring normals differ by more than 90°, so the mesh does not resolve the map; "
    "refine it, or round the corners of the plan.",
    Status.COLLAPSED: "The normals are all the same, so the surface shrinks to a point; tilt some boundary normals.",
    Status.CANCELLED: "The solve was cancelled; the map is the last one reached.",
    Status.SADDLE: "The map is a saddle: small changes lower its energy; refine the mesh, or give an initial map.",
    Status.OTHER_DEGREE: "A map was found, but not of the degree wanted: over this boundary that one may not exist, or "
    "the mesh is too coarse for it.",
    Status.UNBOUNDED: "The energy fell below zero: edges that are not Delaunay have negative weights. Solve on the "
    "Delaunay triangulation (delaunay), or with the Möbius energy.",
    Status.GAP: "The surface does not close around the holes of the plan: it is cut open and has a gap.",
}


Progress = Callable[[int, float], bool | None]
"""Called as progress(step, residual) while long work runs; returning False cancels the work."""


class Interrupted(Exception):  # noqa: N818  nothing is wrong
    """Raised inside long work that was cancelled."""


def listed(indices: Iterable[int]) -> str:
    """Indices as a message lists them: all of a few, the first of many."""
    items = [str(int(i)) for i in indices]
    if len(items) <= _LISTED:
        return ", ".join(items)
    return ", ".join(items[:_LISTED]) + f" and {len(items) - _LISTED} more"


def suggestion(name: object, known: Iterable[str]) -> str:
    """"; did you mean …?" where a known name resembles this one, else the known names."""
    names = {one.casefold(): one for one in known}
    near = get_close_matches(name.casefold(), names, n=2) if isinstance(name, str) else []
    meant = " or ".join(f'"{names[one]}"' for one in near)
    return f"; did you mean {meant}?" if near else f"; known are {', '.join(names.values()) or 'none'}."


def shown(value: Any) -> str:
    """A value as a message has it: texts in quotes, long ones cut; 1000000 as 1,000,000; functions without address."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Integral):
        digits = int(int(value).bit_length() * 0.30103) + 1
        return f"{value:,}" if digits < _DIGITS else f"a number of about {digits} digits"
    if isinstance(value, Real):
        return f"{float(value):g}"
    if isinstance(value, str):
        text = f'"{value}"'
    else:
        try:
            text = str(value)
        except (RecursionError, ValueError):  # nested too deeply, or with thousands of digits
            text = f"a {type(value).__name__}"
        if text.startswith("<") or " at 0x" in text:  # what Python shows of functions, types and bare objects
            text = "a function" if callable(value) and not isinstance(value, type) else f"a {type(value).__name__}"
    return text if len(text) <= _DIGITS else text[: _DIGITS - 3] + "..."


def check_choice(name: object, known: Iterable[str], what: str, error: type[CmcError] = ConditionError) -> None:
    """Raise `error` unless `name` is among the `known` names; `what` is the noun for them."""
    names = list(known)
    if not isinstance(name, str) or name not in names:
        raise error(f"There is no {what} {shown(name)}{suggestion(name, names)}")


def unexpected(error: Exception, way_out: str) -> str:
    """The sentence for an error that is no `CmcError`. way_out: what to do, where it is the program's own fault."""
    if isinstance(error, MemoryError):
        return "The memory is not enough; take a coarser mesh."
    text = f"{type(error).__name__}: {error}".removesuffix(": ").split("\n")[0]
    return f"An error of the program itself ({text}); {way_out}."


def plural(noun: str, indices: Iterable[int]) -> str:
    """Noun and indices as a message names them: "vertex 3", "vertices 3, 5", "face 0", "edges 1, 2"."""
    items = list(indices)
    many = {"vertex": "vertices"}.get(noun, noun + "s")
    return f"{noun if len(items) == 1 else many} {listed(items)}"
