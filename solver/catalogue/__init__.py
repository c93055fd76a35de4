"""Ready-made domains, plans and surfaces, for tests, examples, job files and the menu of plans.

`shapes` has domains with named sides: discs, polygons, strips, and glued ones such as cylinders and tori (`Shape`).
`modules` has shapes between mirrors whose copies form columns, tubes and lattices (`Module`); `module_presets` lists
those that a user can choose. `wente` finds Wente's cylinders and tori (`Bubble`), at heights that `wente_heights` knows
exactly; `honeycomb_ring` assembles a ring of tubes (`Ring`). `start_plans`, `holed_plans` and `bubble_plans` are the
same as plans to start from: points, groups and settings (`StartPlan`)::

    from solver import complete, ring, shapes, wente

    cylinder = shapes.cylinder(circumference=6.0, height=2.0, columns=24)
    assert set(cylinder.sides) == {"bottom", "top"}
    bubble = wente(2.0943951, columns=8)  # normals of the two ends 120° apart
    assert bubble.ok, bubble.message
    assert len(complete(bubble.surface, bubble.sides).copies) > 1
    assert ring(2.4, max_edge=0.6).domain.genus == 1
"""
