"""Tasks that start by themselves when something changes.

`live.py`: the shell follows its plan, groups and settings, on the timer of `background`; `update.py` has its tasks.
"""
