"""Which parts of a plan may change so that its shell closes around its holes: an option of `Settings`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..closing.holes import MOTIONS
from ..errors import JobError, check_choice, shown
from ..limits import COUNT, POSITIVE, check_number
from ..signatures import check_fields

WAYS = {
    "normals": "the normals along the boundary change, as little as possible",
    "tilts": "the normals turn about the boundary only: the tilts change",
    "hole": "the holes move",
    "both": "normals and holes",
}
"""The parts of a plan that may change to close its shell."""
MOVING = ("hole", "both")


@dataclass(frozen=True)
class ClosingOptions:
    """How a shell with given normals is kept closed around the holes of its plan (paper, Sec. 5.3.3).

    by: of `WAYS`. weight: with "both", of the motions of holes (see `close_periods`): the larger, the less they move.
    move: with "hole" and "both", of `holes.MOTIONS`, or a number of a hole → its own ones. holes: numbers of the moving
    ones, 1 has the longest rim; None: all, or those in `move`. max_steps: of Newton's method. Raises `JobError` on
    unknown ways and motions, and on numbers out of range.
    """

    by: str = "normals"
    weight: float = 1.0
    move: tuple[str, ...] | Mapping[int, tuple[str, ...]] = ("x", "y", "twist")
    holes: tuple[int, ...] | None = None
    max_steps: int = 12

    def __post_init__(self) -> None:
        if not all(_is_list(names) for names in self._each):
            raise JobError(f"The motions of holes must be a list, or a list for each hole, not {shown(self.move)}.")
        if not (self.holes is None or _is_list(self.holes)):
            raise JobError(f"The numbers of holes must be a list, not {shown(self.holes)}.")
        check_choice(self.by, WAYS, "way to close", JobError)
        for name in self.motions:
            check_choice(name, MOTIONS, "motion of a hole", JobError)
        if isinstance(self.move, Mapping) and self.holes is not None:
            raise JobError("The motions of each hole name the holes already; leave the numbers of holes out.")
        if self.by in MOVING and not (self._each and all(self._each)):
            raise JobError(f"The holes need a motion: one or more of {', '.join(MOTIONS)}.")
        check_number(self.weight, "weight", POSITIVE, JobError)
        check_number(self.max_steps, "limit of steps", COUNT, JobError)
        check_fields(self)

    @property
    def motions(self) -> tuple[str, ...]:
        """The motions of any hole."""
        return tuple(name for names in self._each for name in names)

    @property
    def _each(self) -> list[tuple[str, ...]]:
        return list(self.move.values()) if isinstance(self.move, Mapping) else [self.move]


def _is_list(value: object) -> bool:
    return isinstance(value, (tuple, list))
