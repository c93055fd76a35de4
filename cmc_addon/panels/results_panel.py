"""Results: the shell that is shown in numbers, drawn from the report that it stored (see `links.shown_shell`)."""

import re
import textwrap

import bpy

from ...solver.measure.summary import percent
from ...solver.notes import NOT_AS_ASKED
from ..properties.links import shown_shell
from ..properties.registration import registration
from ..properties.reports import complete_report, is_design, last_report, shown_sheet, warnings_in
from ..properties.stored import COMPLETED_ROLES
from ..properties.units import in_units, length_text, per_length
from .periods_text import gap_sentence
from .tab import Tab

_LETTER = 7.0  # pixels, of the interface font at scale 1
_UNIT = r"(?<=\d) (?=%|[a-zµ]{1,2}[²³]?\b)"


def paragraph(layout: bpy.types.UILayout, context: bpy.types.Context, text: str, icon: str) -> None:
    """A text wrapped to the width of the sidebar."""
    scale = context.preferences.system.ui_scale or 1.0  # 0 where there is no window
    letters = max(16, int((context.region.width / scale - 60) / _LETTER))
    column = layout.column(align=True)
    column.scale_y = 0.8
    text = re.sub(_UNIT, "\u00a0", text)  # a unit stays with its number
    for k, line in enumerate(textwrap.wrap(text, letters)):
        column.label(text=line, icon=icon if k == 0 else "BLANK1")


def numbers(layout: bpy.types.UILayout, rows: list[tuple[str, str]]) -> None:
    """Names on the left, values on the right, aligned with the settings above."""
    column = layout.column(align=True)
    column.scale_y = 0.85
    for name, value in rows:
        split = column.split(factor=0.4)
        left = split.row()
        left.alignment = "RIGHT"
        left.label(text=name)
        split.label(text=value)


# An overhang of less of the area is noise of the rim's triangles.
_SOME = 1e-4


# Longer names run over the title of the panel.
_LONGEST = 20


def _fitting(name: str) -> str:
    """The name, its middle left out if it is long: it ends in what kind of shell it is."""
    return name if len(name) <= _LONGEST else f"{name[:9].rstrip()}…{name[-10:].lstrip()}"


class ResultPanel(Tab):
    """Shown once the plan has a shell; draws from the report of the one that is shown."""

    @classmethod
    def poll(cls, context):
        return last_report(context) is not None

    def draw(self, context):
        report = last_report(context)
        if report is not None:
            self.draw_report(context, report)


class CMC_PT_results(ResultPanel, bpy.types.Panel):
    bl_idname = "CMC_PT_results"
    bl_label = "Results"
    bl_order = 3

    def draw_header_preset(self, context):
        shell = shown_shell(context)
        if shell is not None:
            self.layout.label(text=_fitting(shell.name))

    def draw_report(self, context, report):
        warnings = warnings_in(report)
        done = report["converged"] and report.get("met", True) and not any(code in NOT_AS_ASKED for code, _ in warnings)
        sentence = report["message"] if is_design(report) else gap_sentence(report) or report["message"]
        paragraph(self.layout, context, sentence, "CHECKMARK" if done else "ERROR")
        numbers(self.layout, [*copies_rows(shown_shell(context)), *size_rows(report), *rim_rows(report)])
        for _, warning in warnings:
            if warning != report["message"]:
                paragraph(self.layout, context, warning, "ERROR")


def copies_rows(shell: bpy.types.Object | None) -> list[tuple[str, str]]:
    """Of a repeated shell: the numbers below are those of one copy."""
    plan = shell.cmc.source if shell is not None and shell.cmc.role in COMPLETED_ROLES else None
    report = None if plan is None else complete_report(plan)
    return [] if report is None else [("One Of", f"{report['copies']:,} copies")]


def size_rows(report: dict) -> list[tuple[str, str]]:
    """Size and curvature of the shown sheet, from the report of a solve or a fit."""
    shown, H = shown_sheet(report), report["mean_curvature"]
    return [
        ("Span", length_text(shown["span"])),
        ("Rise", length_text(shown["rise"])),
        ("Area", length_text(shown["area"], 2)),
        *([("Radius 1/H", length_text(1 / abs(H)))] if H else []),
        ("H", f"{in_units(H):.4g} {per_length()}"),
    ]


def rim_rows(report: dict) -> list[tuple[str, str]]:
    return [("Rim", length_text(shown_sheet(report)["boundary_length"]))]


class CMC_PT_checks(ResultPanel, bpy.types.Panel):
    bl_idname = "CMC_PT_checks"
    bl_label = "Checks"
    bl_parent_id = "CMC_PT_results"
    bl_order = 1

    def draw_report(self, context, report):
        numbers(self.layout, check_rows(report))


def check_rows(report: dict) -> list[tuple[str, str]]:
    """Labels and numbers of the checks: curvature, distortion, distance from the outline, and others."""
    shown, rows = shown_sheet(report), []
    if shown["mean_curvature"]:
        off = shown["mean_curvature"]
        H = abs(report["mean_curvature"])
        against = H and off.get("reference", H) == abs(off["target"])
        by = percent(off["relative_l2"]) if against else f"{in_units(off['l2']):.2g} {per_length()}"
        rows.append(("H Off By", by))
    if shown["distortion"]:
        rows.append(("Distortion", f"{shown['distortion']['mean']:.3f}, at most {shown['distortion']['max']:.3f}"))
    for side in report.get("sides", []):
        name = side["name"] or "Other Edges"
        if side["kind"] == "line":
            rows.append((name, f"{length_text(side['distance'], digits=2)} off the line"))
        elif side["kind"] == "held":
            rows.append((name, f"{side['angle']:.2g}° off, rim {length_text(side['distance'], digits=2)} away"))
    for lean in report.get("span", {}).get("leans", []):
        rows.append(("Leans By", f"{lean['measured']:.1f}° for {lean['asked']:.1f}°"))
    if shown["outline"] and not is_design(report):
        mean, most = (length_text(shown["outline"][name], digits=2) for name in ("mean", "max"))
        rows.append(("Off Outline", f"{mean}, at most {most}"))
    if shown["overhang"]:
        share, lean = shown["overhang"]["area_share"], shown["overhang"]["largest_lean"]
        rows.append(("Overhang", f"{percent(share)}, by {lean:.1f}°" if share >= _SOME else "None"))
    if shown["intersections"]:
        pairs = shown["intersections"]["count"]
        rows.append(("Crossing", f"{pairs} pair{'s' * (pairs != 1)} of faces" if pairs else "None"))
    if report["periods"]:
        rows.append(("Gap", length_text(report["gap"])))
    return rows


class CMC_PT_solver(ResultPanel, bpy.types.Panel):
    bl_idname = "CMC_PT_solver"
    bl_label = "Solver"
    bl_parent_id = "CMC_PT_results"
    bl_order = 2
    bl_options = {"DEFAULT_CLOSED"}

    def draw_report(self, context, report):
        rows = [
            ("Energy E", f"{report['energy']:.6g}"),
            *map_rows(report),
            ("Accuracy", f"{report['residual']:.1e}"),
            ("Steps", str(report["iterations"])),
            ("Faces", str(report["faces"])),
            ("Closing Error", percent(report["closure_error"] / (shown_sheet(report)["span"] or 1.0))),
        ]
        numbers(self.layout, rows)
        if report["converged"] and report.get("index") is None and not is_design(report) and "span" not in report:
            self.layout.operator("cmc.count_modes")


def map_rows(report: dict) -> list[tuple[str, str]]:
    """The degree, and the number of unstable modes if counted."""
    rows = [("Degree", f"{round(report['degree'], 6) + 0.0:.3g}")]
    if report.get("index") is not None:
        null = f", {report['nullity']} null" if report.get("nullity") else ""
        rows.append(("Unstable Modes", f"{report['index'] or 'None'}{null}"))
    return rows


CLASSES = (CMC_PT_results, CMC_PT_checks, CMC_PT_solver)
register, unregister = registration(CLASSES)
