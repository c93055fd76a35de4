"""Ready-made domains, plans and surfaces: shapes, modules between mirrors, Wente cylinders, the honeycomb ring."""
