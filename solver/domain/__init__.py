"""The domain of a map: triangles with edge lengths, their topology, and the sites that carry normals.

A `Domain` is faces and edge lengths, nothing else: positions are one way to get them. `connectivity` checks that the
triangles form a surface. A `Shape` adds positions and named sides, and serves wherever a domain is wanted. A
`SiteGraph` turns the domain into sites and links, at vertices or at faces; energies live on its links. `Homology`
finds loops and cuts, a `Tree` integrates closed forms, and a `CutSurface` is the domain cut open, on which the
integral jumps by its periods. `intrinsic_delaunay` replaces the triangles and keeps the metric (`flips`); `gluing`
joins copies along sides::

    from solver.domain.delaunay import intrinsic_delaunay
    from solver.domain.sites import SiteGraph
    from solver.domain.topology import Homology

    ring = shapes.annulus(0.5, 1.0, 200)
    homology = Homology.of(ring.domain)
    assert len(homology.generators) == 1  # one loop around the hole
    delaunay = intrinsic_delaunay(ring).domain
    assert SiteGraph.of(delaunay, "vertices").weights.min() > 0.0
"""
