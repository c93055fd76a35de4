"""Result: a sentence and numbers about the shell that is shown (see `links.shown_shell`), from its report."""

import bpy

from ...solver.measure.summary import NOISE, percent
from ...solver.notes import NOT_AS_ASKED
from ..properties.links import plan_to_solve, shown_shell
from ..properties.registration import registration
from ..properties.reports import complete_report, is_design, last_report, shown_sheet, warnings_in
from ..properties.stored import COMPLETED_ROLES
from ..properties.units import in_units, length_text, per_length
from ..tasks.recipe import is_behind
from .periods_text import gap_sentence
from .symmetry_panel import draw_behind
from .tab import Tab, fitting, numbers, paragraph

# An overhang of less of the area is noise of the rim's triangles.
_SOME = 1e-4


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
    bl_label = "Result"
    bl_order = 3

    def draw_header_preset(self, context):
        shell = shown_shell(context)
        if shell is not None:
            self.layout.label(text=fitting(shell.name))

    def draw_report(self, context, report):
        layout, shell = self.layout, shown_shell(context)
        copies = copies_rows(shell)
        warnings = [note for note in warnings_in(report) if not (copies and note[0] == "gap")]
        done = bool(copies) or (report["converged"] and report.get("met", True))
        done = done and not any(code in NOT_AS_ASKED for code, _ in warnings)
        fine = done and not any(code == "curvature" for code, _ in warnings)
        paragraph(layout, context, sentence(report, bool(copies), done), "CHECKMARK" if fine else "ERROR")
        numbers(layout, [*copies, *size_rows(report), *rim_rows(report)])
        for code, warning in warnings:
            if warning != report["message"]:
                paragraph(layout, context, warning, "ERROR")
            self._remedy(layout, plan_to_solve(context), code)
        plan = plan_to_solve(context)
        if plan is not None and is_behind(plan):
            draw_behind(layout, context)

    def _remedy(self, layout, plan, code):
        """The button that helps, where one does."""
        if plan is not None and code == "gap" and not plan.cmc.keep_closed:
            layout.operator("cmc.solve", text="Keep Closed Around Courts", icon="CHECKMARK").keep_closed = True
        elif plan is not None and code == "faces-down":
            layout.operator("cmc.flip")


def sentence(report: dict, is_repeated: bool, is_done: bool) -> str:
    """What has happened, first: a repeated shell has no gap of its own to tell of."""
    if is_repeated:
        return "Done. The shell is repeated."
    if is_design(report):
        return report["message"]
    gap, beginning = gap_sentence(report), "Done. "
    outline, message = shown_sheet(report).get("outline"), report["message"]
    on_line = "span" in report and not report["span"].get("leans")
    if gap or not outline or not (is_done and on_line):
        return gap or message
    off = outline["max"]
    near = f" to {length_text(off, digits=2)}" if off > NOISE * shown_sheet(report)["span"] else ""
    return f"{beginning if message.startswith(beginning) else ''}On its line{near}. {message.removeprefix(beginning)}"


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
    bl_options = {"DEFAULT_CLOSED"}
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
    bl_parent_id = "CMC_PT_checks"
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
