"""Blender without a window: `blender --command cmc`.

`cli.py` reads the arguments, `batch.py` solves the plans of each file, `batch_files.py` opens and writes files.
"""
