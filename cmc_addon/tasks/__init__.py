"""The tasks: solve, fit, approximate, count, complete, tile, close, export.

Each is a `Task` with three verbs: `read` takes Blender's objects into arrays, `work` runs without bpy and may run in a
thread, `write` puts the result into the scene. `task.py` says what all share, `shell_task.py` what tasks on a solved
shell share. A new task is a file here and an operator.
"""
