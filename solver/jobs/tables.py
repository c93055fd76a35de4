"""Tables of a TOML file, read key by key: types are checked, unknown keys are named."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import JobError
from ..notes import Note


def suggestion(name: str, known: Iterable[str]) -> str:
    """ "; did you mean …?" where a known name resembles this one, else the known names."""
    names = list(dict.fromkeys(known))
    near = difflib.get_close_matches(name, names, n=1)
    return f'; did you mean "{near[0]}"?' if near else f"; known are {', '.join(names)}."


class Table:
    """A TOML table, its name ("[size]") and where it stands ("job.toml, [size]"), for messages.

    Every reading method takes a key, remembers that it is known, and raises `JobError` on a value of another type.
    notes: warnings about values that are likely mistakes, shared with the tables below.
    """

    def __init__(self, data: Any, where: str, name: str = "", notes: list[Note] | None = None) -> None:
        if not isinstance(data, dict):
            raise JobError(f"{where} must be a table, not {_written(data)}.")
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
        return self.fail(f'"{key}" must be {kind}, not {_written(self.data[key])}.')

    def text(self, key: str, default: str = "", among: Sequence[str] = ()) -> str:
        value = self._take(key, default)
        if not isinstance(value, str):
            raise self._wrong(key, "a text")
        if "\0" in value:
            raise self.fail(f'"{key}" contains a null character (\\u0000); take it out.')
        if among and value not in among and key in self.data:
            raise self.fail(f'there is no {key} "{value}"{suggestion(value, among)}')
        return value

    def flag(self, key: str, default: bool = False) -> bool:
        value = self._take(key, default)
        if not isinstance(value, bool):
            raise self._wrong(key, "true or false")
        return value

    def number(self, key: str, default: float = 0.0) -> float:
        value = self._take(key, default)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not np.isfinite(value):
            raise self._wrong(key, "a number")
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

    def integer(self, key: str, default: int = 0) -> int:
        value = self._take(key, default)
        if isinstance(value, bool) or not isinstance(value, int):
            raise self._wrong(key, "a whole number")
        return value

    def integers(self, key: str) -> list[int]:
        """A list of whole numbers, empty without the key."""
        value = self._take(key, [])
        if not isinstance(value, list) or not all(type(item) is int for item in value):
            raise self._wrong(key, "a list of whole numbers")
        return value

    def texts(self, key: str) -> list[str]:
        """A list of texts, empty without the key."""
        value = self._take(key, [])
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            raise self._wrong(key, "a list of texts")
        return value

    def vector(self, key: str, default: tuple[float, ...]) -> tuple[float, ...]:
        value = self._take(key, default)
        numbers = _numbers(value)
        if numbers is None or numbers.shape != (len(default),):
            raise self._wrong(key, f"a list of {len(default)} numbers")
        return tuple(numbers.tolist())

    def rows(self, key: str, columns: int, kind: str) -> NDArray[np.float64]:
        """A list of rows of numbers, (n, columns)."""
        numbers = _numbers(self._take(key, []))
        if numbers is None or numbers.ndim != 2 or numbers.shape[1] != columns:
            raise self._wrong(key, f"a list of {kind}")
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

    def finish(self) -> None:
        """Raise on a key that no method has read."""
        for key in self.data:
            if key not in self.known:
                raise self.fail(f'unknown key "{key}"{suggestion(key, self.known)}')


def _numbers(value: Any) -> NDArray[np.float64] | None:
    """A list of numbers, or of equally long lists of them, as an array; None on anything else."""
    try:
        numbers = np.asarray(value)
    except ValueError:
        return None
    if not (np.issubdtype(numbers.dtype, np.integer) or np.issubdtype(numbers.dtype, np.floating)):
        return None
    return numbers.astype(np.float64) if np.isfinite(numbers).all() else None


def _written(value: Any) -> str:
    text = f'"{value}"' if isinstance(value, str) else str(value).lower() if isinstance(value, bool) else str(value)
    return text if len(text) <= 40 else text[:37] + "..."
