"""The result objects of a plan.

Here belong their names, places and updates (`objects.py`), copies as instances, the Gauss image, colours and measures.
Meshes themselves are written by the bridges.
"""
