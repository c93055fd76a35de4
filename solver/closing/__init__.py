"""Closing: make a surface over a domain with holes or handles close.

Around every hole and handle of the domain the surface may miss itself by a period (paper, Sec. 5.3.3).
`ClosingConditions` lists the periods, and the distances between mirrors of one plane, that must vanish. `ClosingMap`
maps boundary normals and conformal `Moduli` (`hole` moves a hole of a plan, `tube` stretches a part of a domain) to
them, with derivatives by the adjoint. `ClosingSteps` is Newton's method with the least change, and `close_periods` runs
it to a `ClosingResult`::

    from solver import close_periods, conditions, hole, shapes

    court = shapes.annulus(0.4, 1.0, 300)
    rim = conditions.binormal(court.domain, court.positions, court.domain.boundary_edges, 0.4)
    closing = close_periods(court.domain, rim, by="moduli", moduli=hole(court.domain, court.positions, loop=1))
    assert closing.ok and closing.gaps[-1] < 1e-9
"""
