"""Percentages in sentences have no powers of ten."""

from __future__ import annotations

import pytest

from solver.measure.planes import PlaneReport
from solver.measure.summary import percent


@pytest.mark.parametrize("part", [0.996, 1.2, 43.0])
def test_large_parts_have_no_powers_of_ten(part):
    line = PlaneReport("side", "mirror", (0.0, 0.0, 1.0), 0.0, 1.0, part).line()
    assert line.endswith(f"({100 * part:.0f} % of the size).")
    assert percent(part) == f"{100 * part:.0f} %"
