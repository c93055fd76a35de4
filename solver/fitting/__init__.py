"""Fitting: the CMC surface that comes nearest to a goal, such as an outline, supports, or a given surface.

A `Target` measures a placed sheet (`Shape`) and knows its derivatives by points, normals and periods; `targets` has
them all. `Objective` adds targets up as a function of boundary normals, size and place, with gradients by the adjoint,
and `fit` minimises it with L-BFGS, preconditioned by a `GaussNewtonModel` on the `Response` of the surface. Two goals
have a function of their own: `fit_outline` puts the rim on a curve (`OutlineOptions`, `Goals`), or keeps given normals
along some of its `Sides`, and `fit_gauss_map` brings the tangent planes near those of a surface (`GaussMapOptions`).
Where the points themselves answer, on lines and on saddles, both take the span of the rim (`spanned`). All return a
`Fit`::

    from solver import fit_outline, shapes

    disc = shapes.disc(200)
    fit = fit_outline(disc.domain, disc.positions, rise=0.4)
    assert fit.ok and abs(fit.points()[:, 2].max() - 0.4) < 0.01
"""
