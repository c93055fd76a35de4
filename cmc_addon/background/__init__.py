"""Work that runs beside Blender: a worker thread, a timer, and the caches of what was computed last."""
