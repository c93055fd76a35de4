"""Sentences and numbers about the gaps around holes, from the report of a solve."""

from __future__ import annotations

from collections.abc import Mapping

from ...solver.measure.summary import percent
from ..properties.units import length_text, vector_text


def gap_sentence(report: Mapping) -> str:
    """The size of the gap, after why it could not be closed; empty if the shell is closed."""
    holes = report.get("holes") or []
    if not report.get("is_open") or not holes:
        return ""
    widest = max(holes, key=lambda hole: hole["length"])
    where = "around the hole" if len(holes) == 1 else f"around {len(holes)} holes"
    words = [f"The shell is open by {gap_text(widest)} {where}."]
    if report.get("closing"):
        words.insert(0, report["message"])  # that of the closing
    return " ".join(words)


def gap_text(hole: Mapping) -> str:
    """A gap as a length, and as a part of the shell's size."""
    return f"{length_text(hole['length'])} ({percent(hole['relative'])} of its size)"


def gap_rows(report: Mapping) -> list[tuple[str, str]]:
    """The gap of each hole, and its vector."""
    rows = []
    for hole in report.get("holes") or []:
        name = hole["name"].capitalize()
        if not report.get("is_open"):
            rows.append((name, "Closed"))
            continue
        rows.append((name, f"{length_text(hole['length'])} ({percent(hole['relative'])})"))
        rows.append(("", vector_text(hole["period"])))
    return rows


def closing_rows(report: Mapping) -> list[tuple[str, str]]:
    """What has changed to keep the shell closed."""
    closing = report.get("closing")
    if not closing:
        return []
    rows = [("Gap Before", percent(closing["gap_before"])), ("Gap Now", percent(closing["gap"]))]
    if closing["largest_turn"] > 1e-6:
        turns = f"{closing['largest_turn']:.1f}° at most, {closing['rms_turn']:.1f}° (RMS)"
        rows.append(("Normals Turned", turns))
    for name, number in closing["moved"].items():
        motion = name.rpartition(" ")[2]
        text = {"twist": f"{number:.3g}°", "size": f"× {number:.3g}"}.get(motion) or length_text(number)
        rows.append((name.title() if " " in name else f"Hole {name.title()}", text))
    return rows + [("Steps", str(closing["steps"]))]
