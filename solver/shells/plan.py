"""The drawn plan, a mesh with groups of boundary edges; its settings and its domain."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..domain.shape import Shape, is_names, side_edges
from ..domain.sites import SITES
from ..errors import ConditionError, JobError, MeshError, check_choice
from ..gauss.conditions import AGAINST, KINDS
from ..gauss.energies import ENERGIES, energy_on
from ..gauss.methods import METHODS
from ..io.mesh_files import read_mesh
from ..io.obj import MeshData
from ..io.polygons import triangulate_polygons
from ..limits import NOT_NEGATIVE, check_number
from ..linalg import as_array, as_numbers
from ..signatures import check_fields, checked
from ..spanning.outline import CORNERS, HOLES
from ..surface.cmc_surface import COMBINATORICS, SHEETS
from ..surface.options import SolveOptions
from ..surface.placement import PlacementError, Rule
from .closing_options import ClosingOptions
from .numbering import drawn_numbers, renumbered, rules
from .plan_metric import metric_domain, start_map
from .t_junctions import check_junctions, rim_of

Array = NDArray[np.float64]
Int = NDArray[np.int32]

SHELLS = {
    "first": "First Found",
    "bubble": "Large Bubble",
}
"""Which of the shells over one rim: the one that a solve reaches, or the other one of Theorem D.1 of the paper."""

COUNTED = ("saddle", "critical")
"""Methods after which unstable modes are counted."""


Condition = str | tuple[str, Mapping[str, object]]
"""A kind of `KINDS`, or a kind and its parameters (radians)."""


@dataclass(eq=False, repr=False)
class Group:
    """Boundary edges (K, 2), vertex pairs, and their condition: kind and parameters (radians) of `KINDS`.

    goes_on: whether `complete_plan` continues the shell across them; None leaves that to the kind. Raises
    `ConditionError` on names of sides, which `Plan.from_shape` takes, and on indices of edges.
    """

    name: str
    edges: NDArray[np.integer]
    kind: str = "binormal"
    parameters: Mapping[str, object] = field(default_factory=dict)
    goes_on: bool | None = None

    def __post_init__(self) -> None:
        given = as_array(self.edges, f'The edges of group "{self.name}"', ConditionError)
        if is_names(self.edges) or (given.size and given.ndim != 2):
            raise ConditionError(
                f'Group "{self.name}": the edges of a group are vertex pairs (K, 2), such as '
                "shape.domain.edges[shape.sides[name]]; Plan.from_shape takes names of sides."
            )
        check_fields(self)

    def __repr__(self) -> str:
        parameters = "".join(f", {name}={value}" for name, value in self.parameters.items())
        return f"Group({self.name!r}, {len(self.edges)} edges, {self.kind}{parameters})"


@dataclass(eq=False, repr=False)
class Plan:
    """A drawn plan: positions (V, 3) in world units, triangles (T, 3), and groups of its boundary edges.

    Positions (V, 2) are taken at height zero. polygons: the faces as drawn, with triangle_polygons (T,) the polygon of
    each triangle; only output uses them. flipped_corners: vertices between two mirrors that take the other one of their
        two normals (see `conditions.mirror`); other vertices are left alone.
    lengths: (T, 3) side lengths of the triangles, side k opposite corner k, in place of the drawn ones; the positions
        then only say where the shell stands. polygon_numbers, vertex_numbers: those of a file, where they differ, for
        messages. initial: (V, 3) the normals that a solve starts from.
    """

    positions: Array
    triangles: NDArray[np.integer]
    polygons: Sequence[NDArray[np.integer]] | None = None
    groups: Sequence[Group] = ()
    triangle_polygons: NDArray[np.integer] | None = None
    flipped_corners: Sequence[int] = ()
    lengths: Array | None = None
    initial: Array | None = None
    polygon_numbers: NDArray[np.integer] | None = None
    vertex_numbers: NDArray[np.integer] | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        self.positions = as_numbers(self.positions, "The positions of a plan", MeshError)
        if self.positions.ndim == 2 and self.positions.shape[1] == 2:
            self.positions = np.column_stack([self.positions, np.zeros(len(self.positions))])

    @classmethod
    @checked
    def from_shape(cls, shape: Shape, sides: Mapping[str, Condition] | None = None) -> Plan:
        """The plan of a ready-made shape. sides: name of a side → kind of its group, or kind and parameters.

        For example `Plan.from_shape(shapes.strip(2, 1, 8), {"bottom": "mirror", "top": ("binormal", {"tilt": 0.3})})`.
        Raises `ConditionError` on a side that the shape does not have.
        """
        groups = []
        for name, condition in (sides or {}).items():
            kind, parameters = (condition, {}) if isinstance(condition, str) else condition
            groups.append(Group(name, shape.domain.edges[side_edges(shape, name)], kind, parameters))
        return cls(shape.positions, shape.domain.faces, groups=groups)

    @classmethod
    @checked
    def from_mesh(cls, mesh: MeshData) -> Plan:
        """The plan of a mesh as files have it, its polygons cut into triangles, without groups.

        Raises `MeshError` naming a polygon that cannot be cut.
        """
        polygons = mesh.polygon_numbers if len(mesh.polygon_numbers) else None
        vertices = mesh.vertex_numbers if len(mesh.vertex_of) else None
        try:
            triangles, owner = triangulate_polygons(mesh.positions, mesh.polygons)
        except MeshError as error:
            raise renumbered(error, rules(vertices, polygons)) from error
        return cls(
            mesh.positions,
            triangles,
            mesh.polygons,
            triangle_polygons=owner,
            polygon_numbers=polygons,
            vertex_numbers=vertices,
        )

    def __repr__(self) -> str:
        groups = ", ".join(f"{group.name}: {group.kind}" for group in self.groups)
        return f"Plan({len(self.positions)} vertices, {len(self.triangles)} triangles, groups: {groups or 'none'})"


@checked
def read_plan(file: str | os.PathLike[str], *, up: str | None = None) -> Plan:
    """The plan in a mesh file (OBJ, PLY, STL, GLB); named polylines of an OBJ along its boundary become its groups.

    Groups are of kind "binormal" with tilt 0; set `kind` and `parameters` of `plan.groups`. up: the file's up axis, "y"
    or "z"; None is y for GLB and z for the rest. Raises `JobError` where the file cannot be read, `MeshError` where it
    has no mesh.
    """
    mesh = read_mesh(file, up=up)
    plan = Plan.from_mesh(mesh)
    plan.groups = [Group(name, edges) for name, edges in mesh.edge_groups.items()]
    return plan


@dataclass
class Settings:
    """How a plan is solved and its shell placed.

    default_kind, default_tilt (radians): the condition of boundary edges in no group.
    against: of `conditions.AGAINST`, what the tilts of kind "binormal" are measured against, the horizon or the drawn
        surface.
    blend: length of boundary over which the tilts of neighbouring groups flow into each other; 0: they jump.
    size, value, ground, rotate, flip: see `placement.Rule`; they apply to `sheet`, "f+" or "f-".
    combinatorics: of `COMBINATORICS`, the polygons of the written sheets; they are measured on triangles.
    holes, corners: of shells on lines, see `span_outline`.
    close: how a shell with given normals is kept closed around holes and handles, None to leave its gaps; shells on
        lines close by themselves.
    shell: of `SHELLS`; degree and "bubble" exclude each other. A bubble is f- as a rule (see `usual_sheet`); its rim
        appears on the other side of the centre, and so it may always rotate.
    count_modes: report how many unstable modes the map has; always with the methods of `COUNTED`.
    The rest goes to the solver: see `solve_cmc`. Raises `CmcError` on an unknown name, and on an energy that is not
    defined on the sites.
    """

    default_kind: str = "binormal"
    default_tilt: float = 0.0
    against: str = "horizon"
    blend: float = 0.0
    size: str = "match_plan"
    value: float | None = None
    ground: str = "lowest"
    rotate: bool = False
    flip: bool = False
    sheet: str = "f+"
    sites: str = "vertices"
    energy: str = "cotan"
    method: str = "newton"
    delaunay: bool = False
    averaging: str = "galerkin"
    tolerance: float = 1e-6
    period_tolerance: float = 1e-3
    side: int = +1
    degree: float | None = None
    combinatorics: str = "primal"
    holes: str = "adapt"
    corners: str = "sharp"
    close: ClosingOptions | None = None
    shell: str = "first"
    count_modes: bool = False

    def __post_init__(self) -> None:
        check_fields(self)
        check_number(self.blend, "blend", NOT_NEGATIVE, JobError)
        for what, name, known in (
            ("reference for the lean", self.against, AGAINST),
            ("sheet", self.sheet, SHEETS),
            ("boundary condition", self.default_kind, KINDS),
            ("kind of sites", self.sites, SITES),
            ("method", self.method, METHODS),
            ("combinatorics", self.combinatorics, COMBINATORICS),
            ("shell", self.shell, SHELLS),
            ("treatment of holes", self.holes, HOLES),
            ("treatment of corners", self.corners, CORNERS),
        ):
            check_choice(name, known, what, JobError)
        if self.shell != "first" and self.degree is not None:
            raise JobError("A degree already chooses the shell; leave it out, or the large bubble.")
        energy_on(self.energy, self.sites)
        SolveOptions(**self.solve_options())
        self.rule()

    def __repr__(self) -> str:
        """The settings that differ from the default."""
        changed = [one for one in fields(self) if getattr(self, one.name) != one.default]
        return f"Settings({', '.join(f'{one.name}={getattr(self, one.name)!r}' for one in changed)})"

    @property
    def counts_modes(self) -> bool:
        """Whether unstable modes are counted: on request, and where the method may end at a map that has some."""
        return self.count_modes or self.method in COUNTED

    @property
    def solver_choice(self) -> tuple[str, str, bool]:
        """The arguments of `CmcSolver` after the domain: sites, energy by its name there, and Delaunay or not."""
        energy = energy_on(self.energy, self.sites)
        return self.sites, next(name for name, one in ENERGIES.items() if one is energy), self.delaunay

    def solve_options(self, **changes: object) -> dict[str, Any]:
        """Keywords of `CmcSolver.solve`: the settings that are `SolveOptions`, with changes."""
        names = {option.name for option in fields(SolveOptions)} & {setting.name for setting in fields(self)}
        return {name: getattr(self, name) for name in names} | changes

    def rule(self) -> Rule:
        """The placement part; raises `PlacementError` on an unknown size or ground, and on a size without a value."""
        if self.value is None and self.size != "match_plan":
            raise PlacementError(f'The size "{self.size}" needs a value, a number.')
        value = 1.0 if self.value is None else self.value
        return Rule(self.size, value, self.ground, self.rotate or self.shell == "bubble", self.flip)


def usual_sheet(shell: str) -> str:
    """The sheet to show: a bubble's normals point the other way, and its f- is the one that goes around."""
    return "f-" if shell == "bubble" else "f+"


def _drawn_domain(positions: Array, triangles: NDArray[np.integer]) -> Domain:
    """The domain of drawn triangles; T-junctions along the rim are refused, since the mesh is open there unnoticed."""
    try:
        domain = Domain.from_positions(positions, triangles)
    except MeshError as error:
        check_junctions(np.asarray(positions), rim_of(triangles, len(positions)))
        raise error
    check_junctions(np.asarray(positions), domain.edges[domain.boundary_edges])
    return domain


def plan_domain(plan: Plan) -> Domain:
    """The plan's mesh as a domain, with its own edge lengths if it has them.

    Raises `MeshError` where it is no domain, is closed and without a start, or has no vertex inside.
    """
    if plan.initial is not None:
        start_map(plan.initial, len(plan.positions))
    with drawn_numbers(plan):
        if plan.lengths is None:
            domain = _drawn_domain(plan.positions, plan.triangles)
        else:
            domain = metric_domain(plan.positions, plan.triangles, plan.lengths)
    if not len(domain.boundary_edges) and plan.initial is None:
        raise MeshError(
            "The mesh is closed: it has no boundary along which to prescribe tangent planes; delete the faces that are "
            "not part of the plan, or give it a map to start from."
        )
    if len(domain.boundary_vertices) == domain.vertex_count:
        count = len(domain.faces)
        raise MeshError(
            f"The mesh ({count} triangle{'s' * (count > 1)}) has no vertex inside its boundary, so nothing is left to "
            "solve for; run Mesh Plan, or subdivide it."
        )
    return domain


def matches(domain: Domain, plan: Plan) -> bool:
    """Whether `domain` is the plan's: the same triangles and, to rounding, the same edge lengths."""
    if not np.array_equal(domain.faces, plan.triangles) or domain.vertex_count != len(plan.positions):
        return False
    if plan.lengths is not None:
        same = np.shape(plan.lengths) == domain.side_lengths.shape
        return same and bool(np.allclose(plan.lengths, domain.side_lengths, rtol=1e-12, atol=0.0))
    vectors = plan.positions[domain.edges[:, 1]] - plan.positions[domain.edges[:, 0]]
    return bool(np.allclose(np.linalg.norm(vectors, axis=1), domain.edge_lengths, rtol=1e-12, atol=0.0))
