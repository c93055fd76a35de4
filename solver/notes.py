"""Warnings: sentences for people, each with a code for programs.

A `Note` is a text, so it is printed and compared as one; reports write its code beside it (`notes_data`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

from .errors import CmcError

CODES = {
    "not-converged": "the solve ended before its tolerance, or not where it was asked to",
    "goal-missed": "a fit did not come as near to its goals as it should",
    "gap": "the shell is cut open and does not close around its holes or handles",
    "curvature": "the measured mean curvature is off its target by more than a tenth of it",
    "not-cmc": "the measured mean curvature is off its target by more than half of it",
    "degree": "the normals do not have the degree that was asked for",
    "unbalanced": "the mean curvature that the area of a spanned surface balances is off that of its search",
    "distorted": "the plan's holes were kept, so the map to the surface distorts and its mean curvature is not even",
    "several": "several surfaces of this mean curvature span the lines, and this is the fuller one or a saddle",
    "lean-missed": "a side meets the wall over its line at another angle than asked",
    "runs-back": "the rim of a side that leans runs back along its line, or past the end of the side, next to a line",
    "steep-corner": "two sides lean steeply about a corner that is rounded a little, where the rim goes far down or up",
    "crossing": "the shell goes through itself",
    "overhang": "part of the shell leans out past the vertical",
    "not-repeated": "the shell changed, and its copies could not be made again",
    "seams": "copies of a shell did not meet by themselves and were joined",
    "size-only": "the boundary does not follow the outline, so only the size was matched",
    "point": "a sheet degenerates to a point and is left out",
    "empty-group": "a group has no boundary edges",
    "faces-down": "the faces of the plan look down",
    "no-report": "there was no report to write beside an exported mesh",
    "slow": "the mesh makes the solve slow",
    "merged": "vertices of a file in one place were merged, which joins its parts",
    "left-out": "something in a file or a group was left out",
    "rounded": "corners of the outline were rounded, by a radius that was chosen or that is less than the one wanted",
    "radians": "an angle looks as if it were given in radians",
    "not-seen": "a plan or an outline was taken otherwise than the viewport shows it",
    "hidden": "the result cannot be seen in this view layer",
    "far": "points lie so far from the origin that they are rounded",
}
"""Every code, and what it says; docs/reference/warnings.md lists them with the way out."""

NOT_AS_ASKED = frozenset({"not-converged", "goal-missed", "gap", "not-cmc", "degree"})
"""The codes of a shell that is not what was asked for: with one of them a command line ends with exit code 1."""


class Note(str):
    """A warning: a sentence, and `code`, one of `CODES`."""

    code: str
    text: str

    def __new__(cls, code: str, text: str) -> Note:
        if code not in CODES:
            raise CmcError(f'There is no warning "{code}"; known are {", ".join(CODES)}.')
        note = super().__new__(cls, text)
        note.code, note.text = code, text
        return note

    def __getnewargs__(self) -> tuple[str, str]:  # for copies and pickles
        return self.code, self.text

    def written(self, write: Callable[[float, int], str]) -> Note:
        """The note with its lengths as `write` gives them, see `Sentence`."""
        return Note(self.code, self.text.written(write)) if isinstance(self.text, Sentence) else self


def as_asked(notes: Iterable[Note]) -> bool:
    """Whether a shell with these warnings is what was asked for."""
    return not any(note.code in NOT_AS_ASKED for note in notes)


class Sentence(str):
    """A sentence with numbers in a power of the unit of length, which `written` gives in another unit.

    template: the sentence with "{}" for each number.
    """

    template: str
    lengths: tuple[float, ...]
    power: int

    def __new__(cls, template: str, *lengths: float, power: int = 1) -> Sentence:
        sentence = super().__new__(cls, template.format(*(f"{length:.4g}" for length in lengths)))
        sentence.template, sentence.lengths, sentence.power = template, lengths, power
        return sentence

    def __reduce__(self) -> tuple:  # for copies and pickles
        return partial(Sentence, power=self.power), (self.template, *self.lengths)

    def written(self, write: Callable[[float, int], str]) -> str:
        """The sentence with each number as `write(number, power)` gives it."""
        return self.template.format(*(write(length, self.power) for length in self.lengths))


def notes_data(notes: Iterable[Note]) -> list[dict[str, str]]:
    """Notes as reports have them: `[{"code": …, "text": …}, …]`."""
    return [{"code": note.code, "text": str(note)} for note in notes]
