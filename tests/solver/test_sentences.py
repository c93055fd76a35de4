"""Sentences with lengths, which a program writes in its own unit."""

from __future__ import annotations

import copy
import pickle

from solver.notes import Sentence


def test_a_sentence_in_another_unit():
    text = Sentence("The rim stays up to {} off.", 0.12345)
    assert text == "The rim stays up to 0.123 off."
    assert text.written(lambda length, power: f"{100 * length:.1f} cm") == "The rim stays up to 12.3 cm off."
    volume = Sentence("The volume is missed by {}.", 2.0, power=3)
    assert volume.written(lambda number, power: f"{number:g} m{power}") == "The volume is missed by 2 m3."


def test_copies_keep_the_lengths():
    text = Sentence("{} and {}", 1.0, 2.0, power=2)
    for other in (copy.deepcopy(text), pickle.loads(pickle.dumps(text))):
        assert other == text and other.lengths == (1.0, 2.0) and other.power == 2
