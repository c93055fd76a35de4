"""Outlines, holes and lengths that the mesher refuses, by name."""

from __future__ import annotations

import numpy as np
import pytest

from solver import MeshError
from solver.meshing.mesher import mesh_plan
from tests.solver.drawn_outlines import SQUARE

BOW_TIE = [(0, 0), (4, 3), (4, 0), (0, 3)]
BAD = {
    "shape": (dict(outline=[1, 2, 3]), r"shape \(3,\)", ()),
    "words": (dict(outline=[("a", "b")] * 3), "not numbers", ()),
    "two points": (dict(outline=[(0, 0), (1, 0)]), "has 2 points", ()),
    "three that are two": (dict(outline=[(0, 0), (1, 0), (0, 0)]), "has 2 points", ()),
    "nan": (dict(outline=[(0, 0), (4, 0), (4, np.nan), (0, 3)]), "Point 2 of the outline is not finite", (2,)),
    "nan in a hole": (
        dict(outline=SQUARE, holes=[[(1, 1), (2, 1), (2, np.inf)]]),
        "Point 2 of hole 0 is not finite",
        (6,),
    ),
    "repeated": (dict(outline=[(0, 0), (4, 0), (4, 0), (0, 3)]), "Points 1 and 2 of the outline", (1, 2)),
    "nearly repeated": (
        dict(outline=[(0, 0), (4, 0), (4, 2e-6), (4, 3), (0, 3)]),
        "Points 1 and 2 of the outline are within a millionth of .*; merge them by distance",
        (1, 2),
    ),
    "a hole beside a corner": (
        dict(outline=SQUARE, holes=[[(1, 1), (9.9999995, 9.9999995), (2, 1)]]),
        "Point 2 of the outline and point 1 of hole 0 are within a millionth",
        (2, 5),
    ),
    "a hole beside an edge": (
        dict(outline=SQUARE, holes=[[(1, 1), (9.99999999, 6.0), (2, 1)]]),
        r"At \(10, 5\.\d+\) the plan is too narrow for a mesh",
        None,
    ),
    "tiny and far away": (
        dict(outline=1e-6 * np.array(SQUARE) + 1e6, max_edge=1e-6),
        "The outline measures 1e-05 and lies 1e.06 from the origin, .* rounded to 1e-10; move it nearer",
        (),
    ),
    "pinched": (
        dict(outline=[(0, 0), (4, 0), (4, 3), (2, 1), (0, 3), (2, 1)]),
        "Points 3 and 5 of the outline",
        (3, 5),
    ),
    "spike": (
        dict(outline=[(0, 0), (4, 0), (4, 3), (4, 9), (4, 3.5), (0, 3)]),
        "Point 3 of the outline is a spike",
        (3,),
    ),
    "line": (dict(outline=[(0, 0), (4, 0), (9, 0)]), "encloses no area", (0, 1, 2)),
    "bow tie": (dict(outline=BOW_TIE), "its segments 0 and 2 meet", (0, 1, 2, 3)),
    "touching": (
        dict(outline=[(0, 0), (8, 0), (8, 4), (6, 4), (4, 0), (2, 4), (0, 4)]),
        "outline crosses or touches itself: its segments 0 and 3 meet",
        (0, 1, 3, 4, 5),
    ),
    "hole across": (
        dict(outline=SQUARE, holes=[[(8, 4), (12, 4), (12, 6), (8, 6)]]),
        "outline and hole 0 cross or touch: segment 1 meets segment 0",
        (1, 2, 4, 5, 6, 7),
    ),
    "hole outside": (dict(outline=SQUARE, holes=[[(12, 4), (13, 4), (13, 6)]]), "Hole 0 lies outside", (4, 5, 6)),
    "holes across": (
        dict(outline=SQUARE, holes=[[(1, 1), (4, 1), (4, 4), (1, 4)], [(3, 3), (6, 3), (6, 6), (3, 6)]]),
        "hole 0 and hole 1 cross",
        None,
    ),
    "hole in hole": (
        dict(outline=SQUARE, holes=[[(1, 1), (6, 1), (6, 6), (1, 6)], [(3, 3), (5, 3), (5, 5)]]),
        "Hole 1 lies inside hole 0",
        (8, 9, 10),
    ),
    "length": (dict(outline=SQUARE, max_edge=0.0), "give a positive length", ()),
    "no number": (dict(outline=SQUARE, max_edge=np.nan), "give a positive length", ()),
    "too long": (dict(outline=SQUARE, max_edge=12.0), "larger than the plan, which measures 10; .* 0.5 ", ()),
    "too short": (dict(outline=SQUARE, max_edge=1e-4), "more than 1,000,000 vertices.* longer than 0.011", ()),
    "no length": (dict(outline=SQUARE, max_edge=1e-300), "more than 1,000,000 vertices.* longer than 0.011", ()),
    "far away": (dict(outline=[(0, 0), (4, 0), (4, 1e160), (0, 3)]), "Point 2 of the outline is beyond 1e.30", (2,)),
    "radius": (dict(outline=SQUARE, corner_radius=-1.0), "corner radius is -1", ()),
    "corners": (dict(outline=SQUARE, corners="sharp"), 'no kind of corners to round "sharp"; known are', ()),
    "no radius": (dict(outline=SQUARE, corners="re-entrant"), "by a radius of 0; give", ()),
    "keep": (dict(outline=SQUARE, keep=[[7]]), "Point 7 to keep", ()),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_plans_are_refused_by_name(name):
    plan, message, vertices = BAD[name]
    with pytest.raises(MeshError, match=f"(?i){message}") as caught:
        mesh_plan(**{"max_edge": 0.5, **plan})
    assert vertices is None or caught.value.vertices == vertices
    assert str(caught.value).endswith(".")
