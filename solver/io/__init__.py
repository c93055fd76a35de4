"""Files: meshes in several formats, OBJ with its groups, polygons into triangles."""
