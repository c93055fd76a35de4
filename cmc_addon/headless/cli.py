"""`blender --command cmc …`: solve plans without a window. The bpy module cannot dispatch commands: call `run`."""

from __future__ import annotations

import argparse
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path

import bpy

from ...solver.errors import CmcError, JobError
from ..properties.settings import SETTINGS, SIZE_PROPERTY, fitted_settings
from ..properties.stored import CmcObject
from .batch import OUTPUTS, Done, Request, run_file
from .batch_files import INPUTS

OK, FAILED, BAD_ARGUMENTS = 0, 1, 2

_EPILOG = """\
examples:
  blender hall.blend --command cmc --output out
  blender --command cmc hall.blend --output out --format blend glb
  blender --command cmc a.blend b.blend canopy.toml --output out --span 12 --ground rim
  blender --command cmc plan.obj --condition 'group = "street", tilt = 25' --format obj

Every input gets a folder OUTPUT/<name>/ with <name>.blend and, for each of its plans, a folder with
shell.glb, shell.obj and report.json. In a .blend, every mesh with boundary groups or results and every mesh
made by Mesh Plan is a plan. In an OBJ, polylines under a group name (g name, l 1 2 3) are boundary groups.

exit code: 0 all plans were solved; 1 a plan failed, or its shell is not as asked: it did not converge, has a gap,
or its mean curvature is off by more than half (it and the others are written all the same); 2 bad arguments
"""


def run(argv: Sequence[str]) -> int:
    """Run the command with these arguments and return the exit code.

    The open file is closed without saving. Messages go to stdout, each error to stderr in one sentence.
    """
    try:
        arguments = _parser().parse_args(list(argv))
        inputs = arguments.inputs or [_open_file()]
        request = _request(arguments, inputs)
    except SystemExit as left:  # argparse has printed the help or an error
        return BAD_ARGUMENTS if left.code else OK
    except CmcError as error:
        print(f"cmc: {error}", file=sys.stderr)
        return BAD_ARGUMENTS
    good = [_print(path, done) for path in inputs for done in run_file(path.resolve(), request)]
    return OK if all(good) else FAILED


def _print(path: Path, done: Done) -> bool:
    """Print how a plan ended; returns whether it succeeded."""
    where = f"{path}, {done.plan}" if done.plan != path.name else f"{path}"
    if done.good:
        print(f"{where}:\n{done.message}")
    else:
        print(f"{where}: {done.message}", file=sys.stderr)
    for warning in done.warnings:
        print(f"{where}: {warning}", file=sys.stderr)
    return done.good


def _open_file() -> Path:
    """The open .blend, as in `blender hall.blend --command cmc`."""
    if not bpy.data.filepath:
        raise JobError("There is nothing to solve; name files, or open a .blend before --command.")
    return Path(bpy.data.filepath)


def _request(arguments: argparse.Namespace, inputs: Sequence[Path]) -> Request:
    stems = [path.stem for path in inputs]
    twice = sorted({stem for stem in stems if stems.count(stem) > 1})
    if twice:
        raise JobError(f'Several inputs are called "{twice[0]}"; run them one by one into different folders.')
    settings = {name: value for name in SETTINGS if (value := getattr(arguments, name)) is not None}
    sizes = [size for size, name in SIZE_PROPERTY.items() if name is not None and name in settings]
    if sizes and "size" not in settings:
        if len(sizes) > 1:
            raise JobError(f"Give one size, not {' and '.join(size.lower() for size in sizes)}; or choose by --size.")
        settings["size"] = sizes[0]
    if "energy" in settings and "sites" in settings:
        fitted_settings(settings, settings)
    return Request(
        output=arguments.output.resolve(),
        formats=arguments.format,
        plans=arguments.plan,
        settings=settings,
        conditions=[_condition(text) for text in arguments.condition],
        up=arguments.up,
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
    parser.add_argument("--up", choices=("y", "z"), help="up axis of mesh files (default: y for GLB, otherwise z)")
    settings = parser.add_argument_group("settings", "override those stored with a plan")
    for name in SETTINGS:
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
    else:
        group.add_argument(option, type=float, metavar="X", help=text)


def _identifier(text: str) -> str:
    """The identifier of a choice: match-plan, match_plan or MATCH_PLAN; f+ and f- for the sheets."""
    return {"f+": "F_PLUS", "f-": "F_MINUS"}.get(text, text.upper().replace("-", "_"))


_handles: list[object] = []


def register() -> None:
    _handles.append(bpy.utils.register_cli_command("cmc", run))


def unregister() -> None:
    while _handles:
        bpy.utils.unregister_cli_command(_handles.pop())
