"""Shells: from a drawn plan to a shell over it, in world units and measured.

A `Plan` is a mesh with `Group`s of boundary edges, each with a kind of condition; `Settings` say how to solve it and
how to size and place the result. `form` goes the whole way to a `Shell`: domain, conditions, surface, size and place,
measures; `Settings.close` keeps it closed around holes. `fit_plan` does the same for shells near an outline or a mesh,
`complete_plan` and `tile_plan` add the copies by symmetry and by periods, and `update` follows a plan while it is
drawn. What the user of a shell should know is in `shell_notes`. A polygon mesh of the shell (`polygon_sheet`) and its
measures (`vertex_measures`) serve files and pictures::

    from solver import Plan, Settings, form, shapes

    plan = Plan.from_shape(shapes.disc(300), {"outer": ("binormal", {"tilt": 0.3})})
    shell = form(plan, Settings(size="span", value=12.0))
    assert shell.ok and abs(shell.report.shown.span - 12.0) < 1e-6
"""
