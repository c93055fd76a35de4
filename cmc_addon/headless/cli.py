"""`blender --command cmc …`: form shells without a window. The bpy module cannot dispatch commands: call `run`."""

from __future__ import annotations

import argparse
import math
import sys
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import bpy

from ...solver.errors import JobError
from ...solver.jobs.outcomes import EXIT_CODES, OK, UNUSABLE
from ...solver.jobs.runs import add_options, command_line
from ...solver.jobs.workers import WORKER, RunOne
from ..properties.settings import SETTINGS, SIZE_PROPERTY, fitted_settings
from ..properties.stored import CmcObject
from .batch import OUTPUTS, Request, run_file
from .batch_files import INPUTS
from .folders import input_folders
from .plan_work import GIVEN, TASKS, task_for
from .ranges import check_range

_EPILOG = f"""\
examples:
  blender hall.blend --command cmc --output out
  blender --command cmc hall.blend --output out --format blend glb
  blender --command cmc a.blend b.blend canopy.toml --output out --span 12 --ground rim
  blender --command cmc halls/*.blend --output out --format glb --jobs 4 --resume --log out/log.txt
  blender --command cmc hall.obj --task fit --fit-rise 0.35
  blender --command cmc plan.obj --condition 'group = "street", tilt = 25' --format obj

Every input gets a folder OUTPUT/<name>/ with <name>.blend and, for each of its plans, a folder with its shell and
report.json. Folders have the names of inputs and plans; where a name is not one for a file, or two differ in spelling
only, six digits follow it, and inputs of equal names lie as in their own folders. In a .blend, every mesh with boundary
groups or results and every mesh made by Mesh Plan is a plan. In an OBJ, polylines under a group name (g name, l 1 2 3)
are boundary groups.

{EXIT_CODES}
"""


def run(argv: Sequence[str]) -> int:
    """Run the command with these arguments and return the exit code.

    The open file is closed without saving. Messages go to stdout, each error to stderr in one sentence.
    """
    try:
        return command_line(argv, _parser(), _read, _worker_command(), at_once=False)
    except SystemExit as left:  # argparse has printed the help or an error
        return UNUSABLE if left.code else OK


def _read(arguments: argparse.Namespace) -> tuple[list[str], RunOne]:
    """The inputs, and what runs one of them. Raises `JobError`."""
    given = {path.resolve(): path for path in arguments.inputs or [_open_file()]}
    folders = input_folders(list(given))
    request = _request(arguments)

    def run_one(path: str):
        resolved = Path(path).resolve()
        folder = request.folder / folders[resolved]
        return (replace(outcome, input=path) for outcome in run_file(resolved, replace(request, folder=folder)))

    return [str(path) for path in given.values()], run_one


def _worker_command() -> list[str]:
    """How to start another process of this command."""
    if bpy.app.binary_path:
        return [bpy.app.binary_path, "--command", "cmc", WORKER]
    package = str(__package__).removesuffix(".cmc_addon.headless")
    code = (
        "import sys, importlib, bpy, addon_utils\n"
        f"addon_utils.enable({package!r}, default_set=True)\n"
        f"sys.exit(importlib.import_module({__name__!r}).run([{WORKER!r}]))"
    )
    return [sys.executable, "-c", code]


def _open_file() -> Path:
    """The open .blend, as in `blender hall.blend --command cmc`."""
    if not bpy.data.filepath:
        raise JobError("There is nothing to solve; name files, or open a .blend before --command.")
    return Path(bpy.data.filepath)


def _request(arguments: argparse.Namespace) -> Request:
    settings = {name: value for name in GIVEN if (value := getattr(arguments, name)) is not None}
    sizes = [size for size, name in SIZE_PROPERTY.items() if name is not None and name in settings]
    if sizes and "size" not in settings:
        if len(sizes) > 1:
            raise JobError(f"Give one size, not {' and '.join(size.lower() for size in sizes)}; or choose by --size.")
        settings["size"] = sizes[0]
    if "energy" in settings and "sites" in settings:
        fitted_settings(settings, settings)
    return Request(
        folder=arguments.output.resolve(),
        formats=tuple(dict.fromkeys(arguments.format)),
        plans=tuple(dict.fromkeys(arguments.plan)),
        task=task_for(arguments.task, settings),
        settings=settings,
        conditions=[_condition(text) for text in arguments.condition],
        up=arguments.up,
        resume=arguments.resume,
    )


def _condition(text: str) -> dict[str, object]:
    """A condition as in a job file, on one line: `group = "street", tilt = 25`."""
    try:
        return tomllib.loads(f"condition = {{ {text} }}")["condition"]
    except tomllib.TOMLDecodeError as error:
        raise JobError(f"The condition {text!r} is not valid TOML, like 'loop = 0, tilt = 20': {error}.") from error


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="blender --command cmc",
        description="Form shells of constant mean curvature over the plans in files.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    kinds = ", ".join(INPUTS)
    parser.add_argument(
        "inputs", nargs="*", type=Path, metavar="FILE", help=f"files to solve: {kinds} (default: the open file)"
    )
    parser.add_argument(
        "-o", "--output", type=Path, default=Path(), metavar="DIR", help="output folder (default: the current one)"
    )
    parser.add_argument(
        "-f", "--format", nargs="+", choices=OUTPUTS, default=["blend"], help="formats to write (default: blend)"
    )
    parser.add_argument(
        "--plan", action="append", default=[], metavar="NAME", help="solve only this object; may be repeated"
    )
    parser.add_argument(
        "--condition",
        action="append",
        default=[],
        metavar="TOML",
        help="for mesh files: a condition as in a job file, angles in degrees",
    )
    parser.add_argument(
        "--task",
        choices=list(TASKS),
        default="auto",
        help="; ".join(f"{name}: {text}" for name, text in TASKS.items()),
    )
    parser.add_argument("--up", choices=("y", "z"), help="up axis of mesh files (default: y for GLB, otherwise z)")
    add_options(parser)
    settings = parser.add_argument_group("settings", "override those stored with a plan")
    for name in SETTINGS:
        _add_setting(settings, CmcObject.bl_rna.properties[name])
    settings = parser.add_argument_group("settings of a task", "override those stored with a plan, and choose the task")
    for name in [name for name in GIVEN if name not in SETTINGS]:
        _add_setting(settings, CmcObject.bl_rna.properties[name])
    return parser


def _add_setting(group: argparse._ArgumentGroup, rna: bpy.types.Property) -> None:
    """An option for a property: with choices for an enum, with --no-… for a flag."""
    option, text = "--" + rna.identifier.replace("_", "-"), (rna.description or rna.name).replace("%", "%%")
    if rna.type == "ENUM":
        choices = [item.identifier for item in rna.enum_items]
        group.add_argument(option, type=_identifier, choices=choices, metavar="|".join(choices).lower(), help=text)
    elif rna.type == "BOOLEAN":
        group.add_argument(option, action=argparse.BooleanOptionalAction, default=None, help=text)
    elif rna.type == "INT":
        count = rna.array_length if rna.is_array else None
        group.add_argument(option, type=_within(rna, int), nargs=count, metavar="N", help=text)
    elif rna.unit == "ROTATION":
        group.add_argument(option, type=_within(rna, _angle), metavar="DEGREES", help=text)
    else:
        group.add_argument(option, type=_within(rna, float), metavar="X", help=text)


def _within(rna: bpy.types.Property, number: Callable[[str], float]) -> Callable[[str], float]:
    """Reads a number in the range of a property."""

    def read(text: str) -> float:
        try:
            value = number(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"it is a number, not {text!r}") from None
        try:
            check_range(rna, value)
        except JobError as error:
            raise argparse.ArgumentTypeError(str(error)) from None
        return value

    return read


def _angle(text: str) -> float:
    """Radians, which properties have."""
    return math.radians(float(text))


def _identifier(text: str) -> str:
    """The identifier of a choice: match-plan, match_plan or MATCH_PLAN; f+ and f- for the sheets."""
    return {"f+": "F_PLUS", "f-": "F_MINUS"}.get(text, text.upper().replace("-", "_"))


_handles: list[object] = []


def register() -> None:
    _handles.append(bpy.utils.register_cli_command("cmc", run))


def unregister() -> None:
    while _handles:
        bpy.utils.unregister_cli_command(_handles.pop())
