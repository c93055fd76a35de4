"""Runs one case and says what came of it."""

from __future__ import annotations

import re
import tempfile
import traceback
import warnings
from dataclasses import dataclass
from pathlib import Path
from zlib import crc32

import numpy as np

from solver.errors import CmcError

from .case import Case, Result
from .generators import GENERATORS

GOOD = ("converged", "warned", "refused")
BAD = ("traceback", "no sentence", "stray warning", "NaN", "H off in silence", "over time", "over memory", "crash")
"""What may come of a case. Stray warnings are Python's own, such as those of divisions by zero in numpy."""

OFF = 0.2
"""A mean curvature that is off by more needs a warning."""

_SENTENCE = re.compile(r"^\S.*[.!?)\"]$", re.DOTALL)
_SCRAPS = re.compile(r"Traceback|np\.float64|array\(|<class|object at 0x|Error\b")
_LONGEST = 1500


@dataclass(frozen=True)
class Outcome:
    """kind: of `GOOD` or `BAD`. text: the sentence, or where it happened. seconds: of the processor."""

    case: str
    kind: str
    text: str = ""
    seconds: float = 0.0

    @property
    def is_good(self) -> bool:
        return self.kind in GOOD


def make_case(name: str, folder: Path) -> Case:
    """The case with this name, "generator:seed"."""
    generator, seed = name.split(":")
    return GENERATORS[generator][0](np.random.default_rng([crc32(generator.encode()), int(seed)]), folder)


def judge(name: str) -> Outcome:
    """Run a case in a folder of its own. Limits of time and memory are the worker's."""
    with tempfile.TemporaryDirectory(prefix="cmc-fuzz-") as folder, warnings.catch_warnings(record=True) as stray:
        with np.errstate(all="ignore"):
            case = make_case(name, Path(folder))
        warnings.simplefilter("always")
        try:
            result = case.run()
        except CmcError as error:
            return _with_stray(_refusal(name, str(error).replace(folder, "…")), stray)
        except MemoryError as error:
            return Outcome(name, "over memory", place(error))
        except Exception as error:
            return Outcome(name, "traceback", f"{type(error).__name__}: {str(error)[:200]} {place(error)}")
    return _with_stray(_of(name, result), stray)


def place(error: BaseException) -> str:
    """The innermost line of the solver that an error came through."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [frame for frame in frames if "/solver/" in frame.filename] or list(frames)
    return f"({ours[-1].filename.split('/solver/')[-1]}:{ours[-1].lineno} {ours[-1].name})"


def _refusal(name: str, text: str) -> Outcome:
    bad = not _SENTENCE.match(text) or _SCRAPS.search(text) or len(text) > _LONGEST
    return Outcome(name, "no sentence" if bad else "refused", text[: _LONGEST + 1])


def _of(name: str, result: Result) -> Outcome:
    for what, numbers in result.numbers.items():
        if not np.isfinite(np.asarray(numbers, dtype=np.float64)).all():
            return Outcome(name, "NaN", what)
    codes = {getattr(note, "code", "") for note in result.warnings}
    if result.off > OFF and not codes & {"curvature", "not-cmc"}:
        return Outcome(
            name, "H off in silence", f"by {100 * result.off:.0f} %; warnings: {' | '.join(result.warnings)}"
        )
    if not result.ok and not result.warnings:
        return Outcome(name, "no sentence", "not converged, and no warning")
    return Outcome(name, "warned" if result.warnings else "converged", " | ".join(result.warnings))


def _with_stray(outcome: Outcome, stray: list[warnings.WarningMessage]) -> Outcome:
    if not stray or not outcome.is_good:
        return outcome
    first = stray[0]
    where = f"({first.filename.split('/solver/')[-1]}:{first.lineno})"
    return Outcome(outcome.case, "stray warning", f"{first.category.__name__}: {first.message} {where}; {outcome.kind}")
