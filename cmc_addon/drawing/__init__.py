"""The viewport: the overlay of a plan and its shell, curvature lines, the colour legend and the preview of a fit.

The overlay runs one way. `rim_strip` and `rim` find what the boundary conditions prescribe along the rim;
`overlay_layers` and `result_layers` make lines and triangles of it (`overlay_geometry`, arrays only); `overlay`
collects the layers of a view, and `overlay_draw` draws them. `overlay_cache` keeps every step until its input changes.
"""
