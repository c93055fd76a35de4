"""Export: the shell as a file for other programs, and its report."""

import os
import re
from pathlib import Path

import bpy
from bpy.props import StringProperty

from ...solver.errors import CmcError
from ...solver.io.mesh_files import FORMATS
from ..background import worker
from ..properties.export_settings import EXPORT_SETTINGS, draw_export, export_annotations
from ..tasks.export import ExportTask, export_owner, wanted_objects
from .modal import ModalOperator
from .poll import RUNNING, allow
from .solve import as_settings


def why_not_export(context: bpy.types.Context) -> str:
    """Why nothing can be exported; "" where something can."""
    if context.window_manager.cmc.running:
        return RUNNING
    try:
        plan = export_owner(context.view_layer.objects.active)
        wanted_objects(context, plan, "AUTO")
    except CmcError as error:
        return str(error).removesuffix(".")
    return ""


def file_name(plan: bpy.types.Object, result: bpy.types.Object) -> str:
    """The default name of a file: the plan's, and which of its shells it is."""
    what = {"NEAREST": "nearest", "COMPLETED": "completed"}.get(result.cmc.role, "shell")
    return re.sub(r'[\\/:*?"<>|\x00-\x1f]', "_", f"{plan.name} {what}")


def _named_file(given: str) -> Path:
    """The path of a file to write. Raises `CmcError` for one that ends without a name, or is a folder."""
    path = Path(bpy.path.abspath(given))
    is_folder = path.suffix.lower() not in FORMATS and os.path.isdir(path)
    if given.endswith(("/", "\\")) or path.name in ("", "..") or is_folder:
        raise CmcError(f"'{given}' names a folder; add the name of a file.")
    return path


class CMC_OT_export(ModalOperator, bpy.types.Operator):
    """Write the solved, fitted or repeated shell as a GLB, OBJ, PLY or STL file, with its report beside it"""

    bl_idname = "cmc.export"
    bl_label = "Export Shell"
    bl_options = {"REGISTER"}

    __annotations__ = {
        "filepath": StringProperty(
            name="File", description="The file to write; its ending chooses the format", subtype="FILE_PATH",
            options={"SKIP_SAVE"}),
        "filter_glob": StringProperty(
            name="Filter", description="Which files the browser shows",
            default=";".join(f"*{suffix}" for suffix in FORMATS), options={"HIDDEN", "SKIP_SAVE"}),
        "check_existing": bpy.props.BoolProperty(
            name="Check Existing", description="Ask before overwriting an existing file", default=True,
            options={"HIDDEN"}),
        **export_annotations({"SKIP_SAVE"}),
    }
    _browsing = False

    @classmethod
    def poll(cls, context):
        return allow(cls, why_not_export(context))

    def invoke(self, context, event):
        if self.filepath:
            return super().invoke(context, event)
        plan = export_owner(context.view_layer.objects.active)
        self._take_settings(plan)
        try:
            name = file_name(plan, wanted_objects(context, plan, self.export_what)[0])
        except CmcError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        folder = Path(bpy.data.filepath).parent if bpy.data.filepath else Path.home()
        self.filepath = str(folder / f"{name}{self._suffix}")
        self._browsing = True
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def check(self, context):
        """In the file browser the ending follows the format."""
        path = Path(self.filepath)
        fitting = path.with_suffix(self._suffix) if path.suffix.lower() in FORMATS else path
        changed = str(fitting) != self.filepath
        self.filepath = str(fitting)
        return changed

    def execute(self, context):
        if not self._browsing:
            return super().execute(context)
        # the browser is closed: start again, now with the progress in the window
        values = {name: getattr(self, name) for name in ("filepath", *EXPORT_SETTINGS)}
        return bpy.ops.cmc.export("INVOKE_DEFAULT", **values)

    def steps(self, context, wait):
        if not self.filepath:
            raise CmcError("No file is named; give the path of the file to write.")
        plan = export_owner(context.view_layer.objects.active)
        self._take_settings(plan)
        path = _named_file(self.filepath)
        if path.suffix.lower() not in FORMATS:
            path = path.with_name(path.name + self._suffix)
        task = ExportTask.read(context, plan, path, self.export_what, self.export_modifiers, self.export_report)
        written = yield from worker.steps(task.work, task.tolerance, wait)
        if written is None:
            return self._report_cancelled()
        warnings = task.write(context, plan, written)
        text = " ".join([f"Written: {', '.join(str(file) for file in written)}", *warnings])
        self.report({"WARNING"} if warnings else {"INFO"}, text)
        return {"FINISHED"}

    def progress_of(self, step):
        return 1.0, "Writing"

    def draw(self, context):
        as_settings(self.layout)
        draw_export(self.layout, self)

    @property
    def _suffix(self) -> str:
        return f".{self.export_format.lower()}"

    def _take_settings(self, plan: bpy.types.Object) -> None:
        """Settings that the call leaves out are the plan's own."""
        for name in EXPORT_SETTINGS:
            if not self.properties.is_property_set(name):
                setattr(self, name, getattr(plan.cmc, name))


CLASSES = (CMC_OT_export,)
