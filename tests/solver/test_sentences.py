"""Sentences with lengths, which a program writes in its own unit."""

from __future__ import annotations

import copy
import pickle

from solver.notes import Note, Sentence


def test_a_sentence_in_another_unit():
    text = Sentence("The rim stays up to {} off.", 0.12345)
    assert text == "The rim stays up to 0.1235 off."
    assert text.written(lambda length, power: f"{100 * length:.1f} cm") == "The rim stays up to 12.3 cm off."
    volume = Sentence("The volume is missed by {}.", 2.0, power=3)
    assert volume.written(lambda number, power: f"{number:g} m{power}") == "The volume is missed by 2 m3."


def test_copies_keep_the_lengths():
    text = Sentence("{} and {}", 1.0, 2.0, power=2)
    for other in (copy.deepcopy(text), pickle.loads(pickle.dumps(text))):
        assert other == text and other.lengths == (1.0, 2.0) and other.power == 2


def test_a_note_in_another_unit():
    note = Note("gap", Sentence("The gap is {} long.", 2.0))
    other = pickle.loads(pickle.dumps(note)).written(lambda length, power: f"{length:g} m")
    assert (other, other.code) == ("The gap is 2 m long.", "gap")
    assert Note("gap", "It is open.").written(str) == "It is open."
