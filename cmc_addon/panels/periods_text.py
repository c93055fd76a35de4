"""What is said of the gaps around holes, from the report that a solve has left."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ..properties.units import length_text


def gap_sentence(report: Mapping) -> str:
    """That the shell has a gap, how large, and what to press; empty where it has none."""
    holes = report.get("holes") or []
    if not report.get("is_open") or not holes:
        return ""
    widest = max(holes, key=lambda hole: hole["length"])
    where = "around the hole" if len(holes) == 1 else f"around {len(holes)} holes"
    words = [f"The shell does not close {where}: it has a gap of {gap_text(widest)}."]
    if report.get("closing"):
        words.insert(0, report["closing"]["message"])
    else:
        words.append("Close Periods, below, closes it; Tile by Periods repeats the shell across it.")
    return " ".join(words)


def gap_text(hole: Mapping) -> str:
    """A length, and the part of the shell's size that it is."""
    return f"{length_text(hole['length'])} ({share_text(hole['relative'])} of its size)"


def vector_text(vector: Sequence[float], length: float) -> str:
    """Its parts with as many decimals as its length has three digits with."""
    decimals = max(0, 2 - math.floor(math.log10(length))) if length > 0.0 else 0
    return "({}, {}, {})".format(*(f"{round(x, decimals) + 0.0:.{decimals}f}" for x in vector))


def share_text(part: float) -> str:
    return f"{100 * part:.2g} %"


def gap_rows(report: Mapping) -> list[tuple[str, str]]:
    """For each hole its gap, and as a vector."""
    rows = []
    for hole in report.get("holes") or []:
        name = hole["name"].capitalize()
        if not report.get("is_open"):
            rows.append((name, "Closed"))
            continue
        rows.append((name, f"{length_text(hole['length'])} ({share_text(hole['relative'])})"))
        rows.append(("", vector_text(hole["period"], hole["length"])))
    return rows


def closing_rows(report: Mapping) -> list[tuple[str, str]]:
    """What Close Periods has changed."""
    told = report.get("closing")
    if not told:
        return []
    rows = [("Gap before", share_text(told["gap_before"])), ("Gap now", share_text(told["gap"]))]
    if told["largest_turn"] > 1e-6:
        rows.append(("Normals turned", f"{told['largest_turn']:.1f}° at most, {told['rms_turn']:.1f}° (RMS)"))
    for name, number in told["moved"].items():
        motion = name.rpartition(" ")[2]
        text = {"twist": f"{number:.3g}°", "size": f"× {number:.3g}"}.get(motion) or length_text(number)
        rows.append((name.capitalize() if " " in name else f"Hole {name}", text))
    return rows + [("Steps", str(told["steps"]))]
