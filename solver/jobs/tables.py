"""Tables of a TOML file, read key by key: types are checked, unknown keys are named."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import JobError, shown, suggestion
from ..limits import LARGEST, NUMBERS, Range
from ..notes import Note

INTEGERS = Range(-(10**9), 10**9, whole=True)
"""Numbers of vertices and the like."""


class Table:
    """A TOML table, its name ("[size]") and where it stands ("job.toml, [size]"), for messages.

    Every reading method takes a key, remembers that it is known, and raises `JobError` on a value of another type.
    notes: warnings about values that are likely mistakes, shared with the tables below.
    """

    def __init__(self, data: Any, where: str, name: str = "", notes: list[Note] | None = None) -> None:
        if not isinstance(data, dict):
            raise JobError(f"{where} must be a table, not {shown(data)}.")
        self.data: dict[str, Any] = data
        self.where = where
        self.name = name
        self.known: list[str] = []
        self.notes: list[Note] = [] if notes is None else notes

    def __contains__(self, key: str) -> bool:
        return key in self.data

    def fail(self, what: str) -> JobError:
        return JobError(f"{self.where}: {what}")

    def _take(self, key: str, default: Any) -> Any:
        self.known.append(key)
        return self.data.get(key, default)

    def _wrong(self, key: str, kind: str) -> JobError:
        return self.fail(f'"{key}" must be {kind}, not {shown(self.data[key])}.')

    def text(self, key: str, default: str = "", among: Sequence[str] = ()) -> str:
        value = self._take(key, default)
        if not isinstance(value, str):
            raise self._wrong(key, "a text")
        self._check_text(key, value)
        if among and value not in among and key in self.data:
            raise self.fail(f'there is no {key} "{value}"{suggestion(value, among)}')
        return value

    def _check_text(self, key: str, value: str) -> None:
        if "\0" in value:
            raise self.fail(f'"{key}" contains a null character (\\u0000); take it out.')

    def flag(self, key: str, default: bool = False) -> bool:
        value = self._take(key, default)
        if not isinstance(value, bool):
            raise self._wrong(key, "true or false")
        return value

    def number(self, key: str, default: float = 0.0, within: Range = NUMBERS) -> float:
        value = self._take(key, default)
        if key in self.data and value not in within:
            raise self._wrong(key, str(within))
        return float(value)

    def angle(self, key: str, default: float = 0.0) -> float:
        """An angle in radians, given in degrees."""
        return self.radians(key, self.number(key, default))

    def radians(self, key: str, degrees: float) -> float:
        """Degrees given under a key, in radians; notes numbers that look like radians already.

        Raises `JobError` beyond half a turn.
        """
        if abs(degrees) > 180.0:
            raise self.fail(f'"{key}" must be an angle from -180 to 180 degrees, not {degrees:g}.')
        if 0.0 < abs(degrees) < 0.5 * np.pi and degrees % 1.0:
            text = (
                f'{self.name}: "{key}" is {degrees:g}°; angles in jobs are in degrees, and {degrees:g} radians would '
                f"be {np.degrees(degrees):.4g}."
            )
            self.notes.append(Note("radians", text))
        return float(np.radians(degrees))

    def integer(self, key: str, default: int = 0, within: Range = INTEGERS) -> int:
        value = self._take(key, default)
        if key in self.data and value not in within:
            raise self._wrong(key, str(within))
        return value

    def integers(self, key: str) -> list[int]:
        """A list of whole numbers, empty without the key."""
        value = self._take(key, [])
        if not isinstance(value, list) or not all(item in INTEGERS for item in value):
            raise self._wrong(key, f"a list, each {INTEGERS}")
        return value

    def texts(self, key: str) -> list[str]:
        """A list of texts, empty without the key."""
        value = self._take(key, [])
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            raise self._wrong(key, "a list of texts")
        for item in value:
            self._check_text(key, item)
        return value

    def vector(self, key: str, default: tuple[float, ...]) -> tuple[float, ...]:
        value = self._take(key, default)
        numbers = _numbers(value)
        if numbers is None or numbers.shape != (len(default),):
            raise self._wrong(key, f"a list of {len(default)} numbers")
        return tuple(self._sized(key, numbers).tolist())

    def rows(self, key: str, columns: int, kind: str) -> NDArray[np.float64]:
        """A list of rows of numbers, (n, columns)."""
        numbers = _numbers(self._take(key, []))
        if numbers is None or numbers.ndim != 2 or numbers.shape[1] != columns:
            raise self._wrong(key, f"a list of {kind}")
        return self._sized(key, numbers)

    def _sized(self, key: str, numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        """The numbers, which are no larger than `LARGEST`."""
        if not (np.abs(numbers) <= LARGEST).all():
            raise self.fail(f'The numbers of "{key}" must be at most {LARGEST:g} in size.')
        return numbers

    def table(self, key: str) -> Table:
        return self._below(self._take(key, {}), f"[{key}]")

    def tables(self, key: str) -> list[Table]:
        """An array of tables, counted from 1."""
        value = self._take(key, [])
        if not isinstance(value, list):
            raise self.fail(f'"{key}" must be written as [[{key}]].')
        return [self._below(item, f"[[{key}]] {number}") for number, item in enumerate(value, start=1)]

    def _below(self, data: Any, name: str) -> Table:
        return Table(data, f"{self.where}, {name}", name, self.notes)

    def finish(self, known: Sequence[str] = ()) -> None:
        """Raise on a key that no method has read, and that is not `known` either."""
        names = [*self.known, *known]
        for key in self.data:
            if key not in names:
                raise self.fail(f"unknown key {shown(key)}{suggestion(key, names)}")


def _numbers(value: Any) -> NDArray[np.float64] | None:
    """A list of numbers, or of equally long lists of them, as an array; None on anything else."""
    try:
        numbers = np.asarray(value)
    except ValueError:
        return None
    if not (np.issubdtype(numbers.dtype, np.integer) or np.issubdtype(numbers.dtype, np.floating)):
        return None
    return numbers.astype(np.float64)
