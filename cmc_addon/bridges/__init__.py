"""Between Blender's meshes and arrays; nothing else touches mesh data in bulk."""
