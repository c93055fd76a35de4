"""Between Blender's meshes and arrays: the only readers and writers of mesh data.

`mesh_bridge` reads a plan as arrays (`PlanMesh`) and writes attributes, `edge_bridge` handles groups and selections of
edges in any mode, `result_bridge` and `polygon_bridge` build the meshes of results with all layers of the plan. The
others each serve one capability: outlines, colours, corners, export, import, holes, start maps, the overlay.
`group_history` makes the list of groups undoable in edit mode, `numbering` translates the solver's indices into
Blender's, and `highlight_bridge` selects the elements that an error names.
"""
