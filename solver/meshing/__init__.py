"""From an outline to a well-shaped mesh of the plan inside it.

`wires` chains edges drawn in space into the closed loops of an `Outline` and its plane. `outline` checks loops and
orients them (`Loop`). `rounding` replaces corners by arcs (`Curve`), since the mean curvature diverges at a sharp
corner. `sampling` places the boundary vertices (`Boundary`) with the edge lengths of a `SizeField` (`sizes`).
`mesher` fills the inside: `triangulate` is the constrained Delaunay triangulation, `quality` opens small angles. The
result is a `PlanMesh`: positions, triangles, and for each boundary edge its loop and the drawn segment it comes
from::

    from solver.meshing.mesher import mesh_plan

    outline = [(0, 0), (4, 0), (4, 3), (0, 3)]
    courtyard = [(1.5, 1), (2.5, 1), (2.5, 2), (1.5, 2)]
    mesh = mesh_plan(outline, [courtyard], max_edge=0.25, corner_radius=0.3)
    domain = Domain.from_positions(mesh.positions, mesh.triangles)
    street = mesh.edges[(mesh.loop == 0) & (mesh.segment == 0)]  # vertex pairs along the first side
    rim = conditions.binormal(domain, mesh.positions, street, tilt=np.radians(30))
    assert len(domain.boundary_loops) == 2
"""
