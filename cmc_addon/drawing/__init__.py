"""The viewport: the overlay of a plan and its shell, handles, curvature lines, the colour legend, the preview of a fit.

The overlay runs one way. `rim_strip` and `rim` find what the boundary conditions prescribe along the rim;
`overlay_layers` and `result_layers` make lines and triangles of it (`overlay_geometry`, arrays only); `overlay`
collects the layers of a view, and `overlay_draw` draws them. `overlay_cache` keeps every step until its input changes.

Handles are gizmos (`handle_gizmos`, `caption_gizmo`, drawn by `handle_draw`). What a drag means is in `handles` and
`crown`, where things are on the screen in `screen`: arrays only.
"""
