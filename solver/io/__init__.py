"""Reading and writing: mesh files, OBJ, and polygons cut into triangles.

A file becomes a `MeshData`: positions and polygons as drawn, with UVs, groups, materials and named polylines. `obj`
reads and writes all of these; `mesh_files` adds PLY, STL and GLB by trimesh, turns y-up files so that z is up, and
keeps the digits of places far from the origin (`far_places`). Files are written by an `Outbox` (`whole_files`): whole,
checked (`file_checks`), those of one piece of work together. `polygons` triangulates without new vertices and returns
the polygon of each triangle, so that triangles can be traced back to what was drawn. Positions and triangles make a
`Domain`::

    from solver.io.mesh_files import MeshData, read_mesh, triangulate_polygons, write_mesh

    corners = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    write_mesh("plan.obj", MeshData(corners, [np.arange(4)]))
    mesh = read_mesh("plan.obj")
    triangles, polygon = triangulate_polygons(mesh.positions, mesh.polygons)
    domain = Domain.from_positions(mesh.positions, triangles)
    assert repr(domain) == "Domain(4 vertices, 2 triangles, 1 boundary loop)"
"""
