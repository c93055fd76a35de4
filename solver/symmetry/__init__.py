"""Symmetry: sides of a surface in mirrors and planes, and the surface completed by its copies across them.

A `Side` is a part of the boundary across which the surface continues by an isometry (paper, Theorem G.1): reflection in
a mirror or a tangent plane, inversion in the point of a free side. `side_plane` measures where it lies (`SidePlane`),
and `arrange` makes the planes of several sides consistent (`Arrangement`). They generate a group of isometries
(`isometries`); `complete` takes all of it if it is finite, else one unit cell (`unit_cell`), and returns a
`Completion`. Neighbours meet along a `Seam`, also across the cuts of an open surface, and are welded into a
`CompletedMesh`. The copies of the normals form the Gauss map of the whole surface (`glued_map`)::

    from solver import Side, complete, conditions, modules, solve_cmc, whole

    module = modules.node(3, 2.4, max_edge=0.3)  # half a sixth of a node of three tubes
    shape, normals = module.shape, module.normals
    held = sum((conditions.mirror(shape, name, normals[name]) for name in normals), conditions.Conditions())
    sides = [Side(name, shape.sides[name], "mirror", normals[name]) for name in normals]
    honeycomb = complete(solve_cmc(shape, held), sides)
    assert len(honeycomb.copies) == 24 and len(honeycomb.lattice) == 2
    assert honeycomb.ok, honeycomb.message
    assert honeycomb.mesh.is_oriented and whole(honeycomb).domain.genus >= 0
"""
