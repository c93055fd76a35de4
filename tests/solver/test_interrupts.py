"""Ctrl-C where it may not come at once: while a compiled module is imported, and in Blender."""

from __future__ import annotations

import signal

import pytest

from solver.interrupts import Pressed, check, compiled, interruptible, undisturbed


def test_it_waits_for_a_block_that_must_not_be_disturbed():
    done = False
    with pytest.raises(KeyboardInterrupt), interruptible():
        with undisturbed():
            signal.raise_signal(signal.SIGINT)
            done = True
        pytest.fail("it came after the block")
    assert done


def test_a_compiled_module():
    assert compiled("scipy.sparse").__name__ == "scipy.sparse"
    with pytest.raises(ImportError):
        compiled("no_such_module")


def test_it_waits_until_asked():
    with pytest.raises(KeyboardInterrupt), interruptible(at_once=False):
        assert not Pressed.yes
        signal.raise_signal(signal.SIGINT)
        assert Pressed.yes
        check()
    assert not Pressed.yes


def test_the_second_one_comes_at_once():
    with pytest.raises(KeyboardInterrupt), interruptible(at_once=False):
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
    assert not Pressed.yes
    with interruptible():
        check()
