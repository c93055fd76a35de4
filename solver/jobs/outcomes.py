"""How the plans of a run end: outcomes and exit codes, the same for both command lines."""

from __future__ import annotations

import traceback
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..errors import CmcError, unexpected
from ..notes import Note, as_asked, notes_data

OK, FAILED, UNUSABLE, INTERRUPTED = 0, 1, 2, 130

EXIT_CODES = """\
exit code: 0 everything is as asked (there may be warnings); 1 a shell is not (it did not converge, has a gap, misses a
goal, or its mean curvature is far off), or a file could not be written; 2 an input is unusable; 130 interrupted. A run
over several inputs ends with the largest. A failure does not stop the others"""


@dataclass(frozen=True)
class Outcome:
    """How a plan ended.

    input: the file. plan: its name in the file, "" where the file is the plan. message: the summary of a shell, or an
    error. formed: whether there is a shell. files: name → path. skipped: done by an earlier run. of: the number of
    plans of the input. details: a traceback for the log.
    """

    input: str
    plan: str = ""
    code: int = OK
    message: str = ""
    warnings: Sequence[Note] = ()
    files: Mapping[str, str] = field(default_factory=dict)
    seconds: float = 0.0
    formed: bool = False
    skipped: bool = False
    of: int = 1
    details: str = ""

    @property
    def where(self) -> str:
        return f"{self.input}, {self.plan}" if self.plan else self.input

    def to_dict(self) -> dict[str, Any]:
        """Plain data, a line of `--json`."""
        data = {**vars(self), "warnings": notes_data(self.warnings), "files": dict(self.files)}
        del data["of"], data["details"]
        return data


def exit_code(ok: bool, warnings: Iterable[Note]) -> int:
    """The code of a shell: whether it is as asked."""
    return OK if ok and as_asked(warnings) else FAILED


def failed(input: str, error: Exception, code: int = UNUSABLE, plan: str = "", of: int = 1) -> Outcome:
    """The outcome of an error; one that nobody expected keeps its traceback for the log."""
    if isinstance(error, CmcError):
        return Outcome(input, plan, code, str(error), of=of)
    if isinstance(error, OSError) and error.strerror:
        return Outcome(input, plan, FAILED, f"{error.filename or 'A file'} cannot be used: {error.strerror}.", of=of)
    message = unexpected(error, "please report it with this input and the log")
    details = "" if isinstance(error, MemoryError) else "".join(traceback.format_exception(error))
    return Outcome(input, plan, FAILED, message, of=of, details=details)
