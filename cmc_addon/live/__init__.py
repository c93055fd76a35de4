"""Tasks that start by themselves when something changes.

`live.py`: the shell follows its plan, groups and settings; `update.py` has its tasks. `follow.py`: the fitted shell
follows the settings of Fit to Outline. Both run on the timer of `background`.
"""
