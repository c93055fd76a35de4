"""What Count Unstable Modes says: numbers of modes in words, for one and for many."""

from __future__ import annotations

import bpy
import pytest

from .scenes import quad_disc


@pytest.mark.parametrize(
    ("index", "nullity", "sentence"),
    [
        (0, 0, "No unstable mode: a minimum among its neighbours."),
        (0, 1, "No unstable mode: a minimum among its neighbours; 1 null mode."),
        (1, 0, "1 unstable mode: a saddle, from which minimisers run away."),
        (11, 5, "11 unstable modes: a saddle, from which minimisers run away; 5 null modes."),
    ],
)
def test_the_sentence(addon, index, nullity, sentence):
    assert addon.cmc_addon.tasks.count_modes.modes_text(index, nullity) == sentence


def test_the_sentence_is_that_of_the_shell(addon):
    tasks = addon.cmc_addon.tasks.count_modes
    result = tasks.CountTask.read(bpy.context, quad_disc()).work(lambda *_: True)
    assert result.converged
    assert result.message == tasks.modes_text(0, 0)
