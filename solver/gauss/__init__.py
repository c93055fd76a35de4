"""The Gauss map of a CMC surface, a harmonic map into the sphere: the nonlinear half of the method.

The unknowns are the unit normals N at the sites of a domain. `conditions` prescribes tangent planes along the boundary
(`Conditions`): those that a vector gives (`held`), those of the drawn surface (`rim_normals`, `horizon`), and all by
name (`kinds`). `admissible` resolves these into the maps they admit. `energies` has the discrete Dirichlet energies,
`problem` their gradients and Hessians; `initial_map` and `mirror_start` provide a start, `methods` the minimisers. A
`HarmonicSolver` composes all this and returns a `HarmonicMap`. One boundary may have several harmonic maps: `modes`
finds saddles and the Morse index of a map, without the null directions. `surface/` then integrates N to the surface::

    disc = shapes.disc(400)
    rim = conditions.binormal(disc, "outer", tilt=np.radians(20))
    solver = HarmonicSolver(disc)
    harmonic = solver.solve(rim)
    assert harmonic.ok, harmonic.message
    assert modes_of(solver, rim, harmonic.normals).index == 0  # a minimiser
"""
