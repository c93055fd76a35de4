"""The [shape] table of a job: a ready-made plan, with its named sides and what comes with it."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..catalogue import bubble_plans, holed_plans, shapes
from ..catalogue.holed_plans import StartPlan
from ..domain.shape import Shape
from ..errors import CmcError, suggestion
from ..io.obj import MeshData
from ..limits import POSITIVE, Range
from ..notes import Note
from ..shells.plan import Group, Plan
from .tables import Table

Pairs = NDArray[np.integer]


def wente(size: float, angle: float, height: float = 1.0, columns: int = 16) -> StartPlan:
    return bubble_plans.wente_plan(size, angle, height, columns)


def ring(size: float, slenderness: float = 0.5, columns: int = 8) -> StartPlan:
    return bubble_plans.ring_plan(size, slenderness, columns)


SHAPES: dict[str, Callable[..., Shape | StartPlan]] = {
    "disc": shapes.disc,
    "polygon": shapes.polygon,
    "rectangle": shapes.rectangle,
    "strip": shapes.strip,
    "annulus": shapes.annulus,
    "cylinder": holed_plans.cylinder,
    "wente": wente,
    "ring": ring,
}


@dataclass(frozen=True, eq=False)
class MadePlan:
    """A mesh and what a shape brings: sides (vertex pairs), their conditions, settings (`Settings`), lengths, a map."""

    mesh: MeshData
    sides: Mapping[str, Pairs] = field(default_factory=dict)
    groups: tuple[Group, ...] = ()
    settings: Mapping[str, object] = field(default_factory=dict)
    lengths: NDArray[np.float64] | None = None
    initial: NDArray[np.float64] | None = None

    def plan(self) -> Plan:
        plan = Plan.from_mesh(self.mesh)
        plan.lengths, plan.initial = self.lengths, self.initial
        return plan

    def groups_beside(self, given: list[Group]) -> list[Group]:
        """The given groups, and those of the shape on sides that no edge of a given one is on."""
        taken = {tuple(sorted(pair)) for group in given for pair in np.asarray(group.edges).reshape(-1, 2).tolist()}
        free = [one for one in self.groups if not taken & {tuple(sorted(pair)) for pair in one.edges.tolist()}]
        return [*given, *free]


def read_shape(root: Table) -> MadePlan:
    """The shape of a job's [shape]: `kind`, the arguments of that function of `SHAPES`, and a `scale`.

    Raises `JobError`.
    """
    table = root.table("shape")
    name = table.text("kind")
    if "kind" not in table:
        table.finish(["scale", *_READERS])  # a misspelt one
        raise table.fail(f'a shape needs a "kind"{suggestion("", SHAPES)}')
    if name not in SHAPES:
        raise table.fail(f'there is no shape "{name}"{suggestion(name, SHAPES)}')
    scale = table.number("scale", 1.0, POSITIVE)
    arguments = {}
    for key, parameter in inspect.signature(SHAPES[name]).parameters.items():
        if key in table:
            arguments[key] = _READERS.get(key, Table.number)(table, key)
        elif parameter.default is inspect.Parameter.empty:
            table.finish([*inspect.signature(SHAPES[name]).parameters])
            raise table.fail(f'a {name} needs "{key}".')
        table.known.append(key)
    table.finish()
    try:
        made = SHAPES[name](**arguments)
    except CmcError as error:
        raise table.fail(str(error)) from error
    return _of_shape(made, scale) if isinstance(made, Shape) else _of_plan(made, scale)


def _of_shape(made: Shape, scale: float) -> MadePlan:
    flat = scale * made.positions
    faces = list(made.domain.faces)
    before = "" if scale == 1.0 else " The lengths are those before the scale."
    notes = [Note(note.code, f"{note}{before}") for note in made.notes]
    mesh = MeshData(np.column_stack([flat, np.zeros(len(flat))]), faces, uvs=flat, uv_corners=faces, notes=notes)
    return MadePlan(mesh, {side: made.domain.edges[edges] for side, edges in made.sides.items()})


def _of_plan(made: StartPlan, scale: float) -> MadePlan:
    faces = made.domain.faces
    corners = np.arange(faces.size, dtype=np.int32).reshape(-1, 3)
    mesh = MeshData(scale * made.points, list(faces), uvs=scale * made.uvs.reshape(-1, 2), uv_corners=list(corners))
    sides = {title.lower(): made.domain.edges[edges] for title, edges in made.sides.items()}
    groups = []
    for title, (kind, given) in made.kinds.items():
        parameters = {key: value for key, value in given.items() if key != "across"}
        goes_on = {"ON": True, "OFF": False}.get(str(given.get("across")))
        groups.append(Group(f"side {title.lower()}", sides[title.lower()], kind, parameters, goes_on))
    settings = {key: str(made.settings[key]).lower() for key in ("method", "ground", "size") if key in made.settings}
    if "size" in settings:
        settings["value"] = scale * float(made.settings[settings["size"]])  # type: ignore[arg-type]
    lengths = made.domain.side_lengths if made.own_lengths else None
    return MadePlan(mesh, sides, tuple(groups), settings, lengths, made.initial)


def _holes(table: Table, key: str) -> list[np.ndarray]:
    holes = table.data[key]
    if not isinstance(holes, list):
        raise table.fail(f'"{key}" must be a list of outlines.')
    return [Table({key: hole}, table.where).rows(key, 2, "points, [[0, 0], [1, 0]]") for hole in holes]


def _corner_radius(table: Table, key: str) -> float | None:
    return None if table.data[key] == "auto" else table.number(key)


_READERS: dict[str, Callable[[Table, str], object]] = {
    "n": Table.integer,
    "columns": Table.integer,
    "angle": Table.angle,
    "slenderness": lambda table, key: table.number(key, within=Range(0.0, 1.0)),
    "size": lambda table, key: table.number(key, within=POSITIVE),
    "height": lambda table, key: table.number(key, within=POSITIVE),
    "outline": lambda table, key: table.rows(key, 2, "points, [[0, 0], [1, 0]]"),
    "holes": _holes,
    "corner_radius": _corner_radius,
    "corners": Table.text,
}
