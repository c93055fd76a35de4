"""Where the reports of Blender come from: the solver's provenance, with Blender's version and the plan's own hash."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import bpy

from ...solver.jobs.provenance import provenance
from ...solver.shells.plan import Group


def made_here(
    plan: str, fingerprint: bytes, settings: Mapping[str, object], groups: Sequence[Group], started: float
) -> dict[str, object]:
    """The table `made` of a report about a plan; fingerprint: of what was read of it. started: when that was."""
    return provenance(
        {plan: fingerprint.hex()}, plain(settings), conditions_of(groups), started=started,
        blender=bpy.app.version_string,
    )  # fmt: skip


def conditions_of(groups: Sequence[Group]) -> list[dict[str, object]]:
    return [
        {"name": group.name, "kind": group.kind, "edges": len(group.edges), **_written(group.parameters)}
        for group in groups
    ]


def _written(parameters: Mapping[str, object]) -> dict[str, object]:
    """The parameters of a group, without the points of a curve."""
    return {name: value if name != "curve" else "chosen" for name, value in parameters.items()}


def plain(settings: Mapping[str, object]) -> dict[str, object]:
    """Settings without Blender's own arrays."""
    return {
        name: value if isinstance(value, (str, int, float)) else list(value)  # type: ignore[call-overload]
        for name, value in settings.items()
        if value is not None
    }
