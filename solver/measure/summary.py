"""A report as a few lines with numbers and units."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .sheet import CurvatureReport, SheetReport


def size_line(shown: SheetReport, unit: str) -> str:
    """Span, rise, area, volume and boundary length; `unit` names the lengths ("m"), or is empty."""
    return (
        f"{shown.name}: span {number(shown.span, unit)}, rise {number(shown.rise, unit)}, "
        f"area {number(shown.area, unit, 2)}, "
        f"volume {number(shown.volume, unit, 3)}, boundary {number(shown.boundary_length, unit)}."
    )


def measure_lines(shown: SheetReport, unit: str) -> list[str]:
    """Curvature, distortion, outline, overhang and intersections, a line each where they were measured."""
    if shown.mean_curvature is None or shown.distortion is None:
        return [f"{shown.name} is degenerate (a point or a line): nothing else to measure."]
    H, Q = shown.mean_curvature, shown.distortion
    lines = [
        f"Mean curvature {number(H.mean, unit, -1)}, wanted {H.target:.5g}, "
        f"off by {off_by(H, unit)} in the mean (L²), "
        f"{number(H.linf, unit, -1)} at most.",
        f"Conformal distortion Q {Q.mean:.4f} in the mean, {Q.max:.3f} at most (1 is none).",
    ]
    if shown.outline is not None:
        distance = shown.outline
        mean, largest = number(distance.mean, unit), number(distance.max, unit)
        lines.append(
            f"Boundary {mean} from the drawn outline in the mean, {largest} at most "
            f"({number(distance.plan_max, unit)} seen from above)."
        )
    if shown.overhang is not None:
        share = 100 * shown.overhang.area_share
        lines.append(
            f"Overhang: {count(shown.overhang.count, 'face')}, {share:.1f} % of the area, "
            f"at most {shown.overhang.largest_lean:.1f}° past the vertical."
        )
    if shown.intersections is not None:
        crossing = shown.intersections
        lines.append(
            f"The surface goes through itself at {count(crossing.count, 'pair')} of faces."
            if crossing.count
            else "The surface does not go through itself."
        )
    return lines


def number(value: float, unit: str, power: int = 1) -> str:
    """Four digits and the power of the unit."""
    suffix = {-1: f" 1/{unit}", 1: f" {unit}", 2: f" {unit}²", 3: f" {unit}³"}[power] if unit else ""
    return f"{value:.4g}{suffix}"


NOISE = 1e-6
"""A length that is less than this part of the shell's size is noise of rounding and of the solve's tolerance."""


def percent(part: float) -> str:
    """A part as a percentage of two digits, without powers of ten and the digits of rounding errors."""
    value = 100.0 * abs(part)
    if value < 1e-6:
        return "0 %"
    if value < 0.01:
        return "under 0.01 %"
    return f"{value:.2g} %" if value < 99.5 else f"{value:.0f} %"


def how_far(part: float) -> str:
    """How far a number is from its target: "13 % of its target", "43 times its target"."""
    return f"{part:.0f} times its target" if part >= 2.0 else f"{percent(part)} of its target"


def off_by(H: CurvatureReport, unit: str = "") -> str:
    """How far mean curvature is off in the mean: against its target, or as a number where that is zero."""
    return how_far(H.relative_l2 * H.reference / abs(H.target)) if H.target else number(H.l2, unit, -1)


def count(amount: int, one: str, many: str = "") -> str:
    """ "1 face", "2 faces", "3 vertices"."""
    return f"{amount} {one if amount == 1 else many or one + 's'}"
