"""Data stored in a .blend file, and the settings of every operator and panel.

`stored` attaches the property groups to meshes, objects and scenes. Each `*_settings` file lists the settings of one
capability once: as annotations for `Object.cmc`, as annotations for its operator, and as rows for the panel. `links`
finds the plan of a result and the results of a plan, `reports` reads what a solve or a fit has left, `units` writes
numbers in the units of the scene, and `preferences` holds what is the same in all files.
"""
