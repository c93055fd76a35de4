"""Nets: curvature lines and panels from the harmonic map.

A surface of constant mean curvature has a holomorphic Hopf differential Q, and w = ∫ √Q dz are coordinates whose lines
are its curvature lines (`hopf`, `cut`, `isothermic`). Rounded to whole numbers (`sides`, `quantise`) the lines close
around umbilics and loops. They are traced by their order on edges alone (`tracing`), and are the sides of cells
(`cells`, `zero_cells`), whose smallest at the rim are joined to others (`slivers`, `rim_nodes`). `sheets` and `places`
know the surface in space, `field` puts the coordinates together; `curvature_lines` (`lines`, `exact_lines`) and
`panel_net` (`net`, `panel_measures`) are what comes of them::

    from solver import curvature_lines, panel_net, shapes, span_outline

    roof = shapes.polygon([[0, 0], [4, 0], [4, 3], [0, 3]], max_edge=0.3, corner_radius=0.8)
    shell = span_outline(roof, roof.positions, mean_curvature=0.3)
    net = panel_net(shell, 0.5)
    assert net.counted == net.euler_characteristic == 1
    assert {len(net.polygons[panel]) for panel in net.inner} <= {4, 6, 8}
    beams = curvature_lines(shell, 0.5, kind="diagonal")
    assert all(line.closed or len(line.ends) == 2 for line in beams)
"""
