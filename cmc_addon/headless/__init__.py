"""Job files in Blender without a window."""
