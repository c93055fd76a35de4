"""Spanning: the surface of constant mean curvature through given lines, from soap film to bubble.

The points f themselves are the unknown here: they are critical for D(f) - 2H V(f), the Dirichlet energy over the plan
and the volume, while rim vertices slide along the lines (`span_outline`, to a `Span`). Files follow the mathematics:
`volume` has V and its derivatives, `curves` and `rim` the ways in which rim vertices slide, `walls` the energy of sides
that lean over their line; `lines`, `boundary`, `layout` and `setting` make them of what was drawn, and `feasible` finds
wishes that cannot be met. `moduli` and `plan_fields` are motions of the plan that change its conformal type, as holes
and sharp corners need; `refine` adds vertices where holes shrink far, `relay` lays a plan anew that is too unlike the
lines. `problem` puts the energy together in the unknowns of `coordinates`, `linearised` has its
derivatives; `preconditioner` inverts its Hessian at H = 0 with Douglas' kernel (`douglas`) up to Möbius transformations
(`gauge`); `descent` is Newton's method, `knobs` and `search` find the surface with the wanted number, `side_ends` keeps
leaning sides over their lines. `normals` has its normals and `verdict` the sentence at the end; `checks`, `branch` and
`contact` measure what was found::

    from solver import shapes, span_outline

    roof = shapes.polygon([[0, 0], [4, 0], [4, 3], [0, 3]], max_edge=0.4)
    film = span_outline(roof, roof.positions)
    shell = span_outline(roof, roof.positions, mean_curvature=0.4, initial=film)
    assert film.ok and shell.ok, shell.message
    assert abs(shell.points[roof.domain.boundary_vertices, 2]).max() < 1e-9
"""
