"""Warnings are sentences with codes, and the documentation has each of them."""

from __future__ import annotations

import copy
import pickle
import re
from pathlib import Path

import pytest

from solver.errors import CmcError
from solver.notes import CODES, NOT_AS_ASKED, Note, as_asked, notes_data

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "warnings.md"


def test_a_note_is_its_sentence_with_a_code() -> None:
    note = Note("overhang", "It leans out.")
    assert note == "It leans out." and note.code == "overhang"
    assert notes_data([note]) == [{"code": "overhang", "text": "It leans out."}]


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda note: pickle.loads(pickle.dumps(note))])
def test_copies_keep_the_code(again) -> None:
    assert again(Note("gap", "A gap.")).code == "gap"


def test_a_code_is_known() -> None:
    with pytest.raises(CmcError, match='no warning "overhung"'):
        Note("overhung", "It leans out.")


def test_some_codes_say_that_the_shell_is_not_as_asked() -> None:
    assert as_asked([Note("overhang", "It leans out."), Note("curvature", "Off by 12 %.")])
    for code in NOT_AS_ASKED:
        assert not as_asked([Note("overhang", "It leans out."), Note(code, "No.")])


def test_the_page_lists_every_code_and_what_it_says() -> None:
    rows = re.findall(r"^\| (\*\*)?`([a-z-]+)`(?:\*\*)? \| (.*?) \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert {code: text for _, code, text in rows} == CODES
    assert {code for bold, code, _ in rows if bold} == NOT_AS_ASKED
