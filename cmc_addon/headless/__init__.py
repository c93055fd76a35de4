"""Blender without a window: `blender --command cmc`.

`cli.py` reads the arguments, `batch.py` forms the plans of each file, `plan_work.py` does the tasks of a plan,
`batch_files.py` opens inputs, `exporters.py` writes results, `folders.py` names their folders. Options, processes and
exit codes are those of the solver's command line (`jobs/runs.py`).
"""
