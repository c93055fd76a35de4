"""From normals to surfaces: the linear half of the method.

A harmonic map N gives the `Conjugate` g, a surface of constant Gauss curvature, by integrating dg = N × *dN
(`conjugate`). `averaging` brings g and N to the same vertices, along mirrors exactly into their planes, and f± = g ± N
are the two sheets of a `CmcSurface`. A `CmcSolver` composes all this and keeps factors for many conditions; `solve_cmc`
is one solve, and `options` has its keywords. Around holes g may fail to close, by its `periods`. `dual_mesh` gives a
surface other polygons (`PolygonMesh`), `placement` puts it over a plan (`Similarity`), `convert` hands it to files and
other packages. `adjoint` differentiates the surface by its boundary normals, for `closing/` and `fitting/`::

    from solver import CmcSolver, conditions, shapes

    disc = shapes.disc(300)
    solver = CmcSolver(disc)
    for tilt in (0.2, 0.4):
        surface = solver.solve(conditions.binormal(disc, "outer", tilt=tilt), mean_curvature=0.25)
        assert surface.ok, surface.message
    assert abs(surface.f_plus - surface.f_minus - 4.0 * surface.normals).max() < 1e-12  # f± = g ± N / (2 H)
    surface.save("honeycomb.obj", combinatorics="dual")
"""
