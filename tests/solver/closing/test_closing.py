"""Periods closed by the boundary normals, by moduli of the domain, and by both."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import (
    CmcSolver,
    ConditionError,
    Domain,
    HarmonicSolver,
    MeshError,
    complete,
    conditions,
    mean_curvature_of,
    shapes,
)
from solver.closing.close import ClosingStatus, close_periods
from solver.closing.holes import MovingHoles, hole, together
from solver.closing.moduli import tube, tubes
from solver.closing.newton_steps import boundary_product
from solver.domain.topology import Homology
from solver.surface.adjoint import AdjointSolver
from solver.surface.periods import harmonic_forms, integrals
from tests.solver.closing_plans import courtyard

WAYS = {
    "normals": lambda shape: {},
    "tilts": lambda shape: {"positions": shape.positions},
    "moduli": lambda shape: {"by": "moduli", "moduli": hole(shape.domain, shape.positions, 1)},
    "both": lambda shape: {"by": "both", "moduli": hole(shape.domain, shape.positions, 1)},
}


@pytest.mark.parametrize("way", WAYS)
def test_a_courtyard_closes_in_a_few_steps_on_every_mesh(way):
    found = []
    for edge in (0.16, 0.11):
        shape, rim = courtyard(edge)
        closing = close_periods(shape.domain, rim, **WAYS[way](shape))
        assert closing.closed and closing.gaps[0] > 0.1 and closing.gaps[-1] < 1e-8
        assert len(closing.gaps) <= 7 and closing.area_ratio > 0.9
        assert not closing.surface.is_open
        again = CmcSolver(closing.domain).solve(closing.conditions, tolerance=1e-11)
        assert np.abs(again.periods).max() < 1e-8
        found.append(closing)
    turned = [c.turned.max() for c in found]
    assert_allclose(turned[0], turned[1], rtol=0.1, atol=1e-9)
    assert_allclose(found[0].moduli, found[1].moduli, rtol=0.1, atol=2e-3)


def test_a_weight_slides_from_normals_to_moduli():
    """Of κ |q|² + |δN|²_W each weight reaches less than the results for other weights would have."""
    shape, rim = courtyard(0.2)
    fixed, before = rim.resolve()
    product = boundary_product(shape.domain, fixed)
    moves, shifts = [], []
    weights = (100.0, 1.0, 0.01)
    for weight in weights:
        moduli = hole(shape.domain, shape.positions, 1)
        closing = close_periods(shape.domain, rim, by="both", moduli=moduli, weight=weight)
        turn = (closing.conditions.resolve()[1] - before).ravel()
        moves.append(turn @ (product @ turn))
        shifts.append(closing.moduli @ closing.moduli)
    assert moves[0] > 2 * moves[1] > 4 * moves[2] and shifts[2] > shifts[1] > 100 * shifts[0]
    cost = np.array(moves) + np.outer(weights, shifts)
    assert (np.argmin(cost, axis=1) == [0, 1, 2]).all()


def test_tilts_turn_about_the_tangent_of_the_boundary():
    shape, rim = courtyard(0.16)
    closing = close_periods(shape.domain, rim, positions=shape.positions)
    fixed, before = rim.resolve()
    _, after = closing.conditions.resolve()
    radial = shape.positions[fixed].copy()
    inner = np.isin(fixed, shape.domain.boundary_loops[1])
    radial[inner] -= [0.25, 0.1]
    along = np.column_stack([-radial[:, 1], radial[:, 0]]) / np.linalg.norm(radial, axis=1)[:, None]
    drift = np.abs(np.einsum("ij,ij->i", (after - before)[:, :2], along))
    assert closing.turned.max() > np.radians(5) and drift.max() < 0.01


def test_three_holes_close():
    """Four loops: three periods are listed, and all close."""
    shape, rim = courtyard(0.11, "three holes")
    before = CmcSolver(shape.domain).solve(rim)
    assert before.is_open and before.periods.shape == (3, 3)
    assert np.linalg.norm(before.periods, axis=1).min() > 0.3
    closing = close_periods(shape.domain, rim)
    assert closing.closed and len(closing.gaps) <= 9 and closing.area_ratio > 0.5
    assert list(closing.left) == ["period 0", "period 1", "period 2"] and max(closing.left.values()) < 1e-9
    assert closing.surface.periods.shape == (3, 3) and not closing.surface.is_open


@pytest.mark.parametrize("way", ["normals", "moduli", "both"])
def test_what_is_closed_along_loops_is_so_as_an_integral_to_second_order(way):
    misses = []
    for edge in (0.14, 0.05):
        shape, rim = courtyard(edge)
        closing = close_periods(shape.domain, rim, **WAYS[way](shape))
        eta = harmonic_forms(Homology.of(closing.domain), HarmonicSolver(closing.domain).dirichlet)
        misses.append(np.abs(integrals(closing.domain, closing.surface.harmonic.normals, eta)).max())
    assert misses[1] < misses[0] / 5 and misses[1] < 2e-3


@pytest.mark.parametrize("way", ["normals", "moduli", "both"])
def test_a_closed_courtyard_is_welded_and_as_curved_at_the_seam_as_elsewhere(way):
    """Where it would be cut, against the next rows beside that, for several cuts; the boundary is left out."""
    shape, rim = courtyard(0.05)
    before = CmcSolver(shape.domain).solve(rim)
    closing = close_periods(shape.domain, rim, **WAYS[way](shape))
    surface = closing.surface
    assert before.is_open and not surface.is_open and len(surface.f_plus) == shape.domain.vertex_count
    areas = [0.5 * np.linalg.norm(np.cross(*edges_of(s)), axis=1).sum() for s in (before, surface)]
    assert areas[1] > 0.5 * areas[0]
    assert_allclose(closing.area_ratio, areas[1] / areas[0], rtol=0.01)
    H = mean_curvature_of(surface.f_plus, surface.faces, surface.normals)
    inside = rows_from(shape.domain, shape.domain.boundary_vertices) >= 1
    errors = {"seam": [], "beside": []}
    for seam in seams(shape):
        far = rows_from(shape.domain, seam)
        errors["seam"].append(H[inside & (far <= 1)] - 0.5)
        errors["beside"].append(H[inside & (far > 2) & (far <= 10)] - 0.5)
    spread = {where: np.sqrt(np.mean(np.concatenate(found) ** 2)) for where, found in errors.items()}
    assert spread["beside"] < 0.03 and spread["seam"] < 1.2 * spread["beside"]


def edges_of(surface):
    a, b, c = surface.f_plus[surface.faces].transpose(1, 0, 2)
    return b - a, c - a


def seams(shape):
    """Vertices along the cut of the plan, and along those when its faces are numbered in other ways."""
    count, random = shape.domain.vertex_count, np.random.default_rng(2)
    orders = [np.arange(len(shape.domain.faces)), *(random.permutation(len(shape.domain.faces)) for _ in range(5))]
    for order in orders:
        domain = Domain.from_positions(shape.positions, shape.domain.faces[order])
        yield Homology.of(domain).sheets.source[count:]


def test_the_closed_surface_does_not_depend_on_the_cut():
    shape, rim = courtyard(0.12)
    closing = close_periods(shape.domain, rim)
    order = np.random.default_rng(3).permutation(len(shape.domain.faces))
    other = Domain.from_positions(shape.positions, shape.domain.faces[order])
    again = CmcSolver(other).solve(closing.conditions, tolerance=1e-10)
    assert not again.is_open
    assert_allclose(again.f_plus, closing.surface.f_plus, rtol=0, atol=1e-7)


def rows_from(domain, vertices):
    """(F,) how many edges each face is away from the nearest of some vertices."""
    far = np.full(domain.vertex_count, domain.vertex_count)
    far[vertices] = 0
    i, j = domain.edges.T
    for _ in range(12):
        nearer = np.minimum(far[i], far[j]) + 1
        np.minimum.at(far, i, nearer)
        np.minimum.at(far, j, nearer)
    return far[domain.faces].min(axis=1)


def test_winding_normals_on_a_cylinder_tiled_by_the_period():
    """Figure 12: the normals along the ends wind along two great circles; three periods, one mesh."""
    shape = shapes.cylinder(2 * np.pi, 1.0, 32)
    held = conditions.Conditions()
    for side, other in (("bottom", (0, 1, 0)), ("top", (0, 0, 1))):
        vertices = np.unique(shape.domain.edges[shape.sides[side]])
        t = shape.positions[vertices, :1]
        held += conditions.fixed_at(shape.domain, vertices, np.cos(t) * [1, 0, 0] + np.sin(t) * other)
    surface = CmcSolver(shape.domain).solve(held)
    assert surface.is_open and surface.gap > 4
    strip = complete(surface, translations=surface.periods, repeat=3)
    mesh = strip.mesh
    size = np.linalg.norm(np.ptp(surface.f_plus, axis=0))
    assert len(strip.copies) == 3 and mesh.largest_gap < 1e-9 * size
    assert_allclose(
        np.ptp(mesh.vertices, axis=0) - np.ptp(surface.f_plus, axis=0), 2 * np.abs(surface.periods[0]), atol=1e-9
    )
    seam = len(surface.g) - shape.domain.vertex_count
    assert len(mesh.vertices) == 3 * len(surface.g) - 2 * seam


def test_the_derivative_by_moduli_against_differences():
    shape, rim = courtyard(0.16)
    moduli = hole(shape.domain, shape.positions, 1, ("x", "y", "twist", "size"))
    q = np.array([0.01, -0.02, 0.05, 0.03])

    def state(q):
        extension = AdjointSolver(HarmonicSolver(moduli.domain(q)), rim)
        return extension, extension(extension.prescribed, tolerance=1e-12)

    extension, here = state(q)
    eta = harmonic_forms(Homology.of(extension.domain), extension.solver.dirichlet)

    def periods_by(extension, here, changed):
        return eta.T @ extension.tau_by_weights(here, changed)

    exact = [periods_by(extension, here, w) for w in moduli.weights(q).T]
    for k, change in enumerate(exact):
        step = 1e-4 * np.eye(4)[k]
        difference = (state(q + step)[1].periods - state(q - step)[1].periods) / 2e-4
        assert_allclose(change, difference, rtol=0, atol=1e-5 * np.abs(difference).max())


def unrolled(shape, circumference):
    corners = shape.positions[shape.domain.faces].copy()
    wrapped = np.ptp(corners[:, :, 0], axis=1) > 0.5 * circumference
    corners[wrapped, :, 0] += np.where(corners[wrapped, :, 0] < 0.5 * circumference, circumference, 0.0)
    return corners


def test_a_tube_that_is_stretched():
    shape = shapes.cylinder(2 * np.pi, 2.0, 16)
    corners = unrolled(shape, 2 * np.pi)
    every = np.arange(len(shape.domain.faces))
    longer = tube(shape.domain, corners, every, (0, 1)).domain(np.array([np.log(1.5)]))
    assert_allclose(longer.area, 1.5 * shape.domain.area, rtol=1e-12)
    lower = np.flatnonzero(corners[:, :, 1].mean(axis=1) < 1.0)
    half = tube(shape.domain, corners, lower, (0, 1)).domain(np.array([np.log(2.0)]))
    assert_allclose(half.area, 1.5 * shape.domain.area, rtol=1e-12)
    with pytest.raises(ConditionError, match="not orthogonal"):
        tube(shape.domain, corners, lower, (1, 1))


def test_several_tubes_that_are_stretched():
    """Each part by its own number, none of them taken twice; weights change as differences say."""
    shape = shapes.cylinder(2 * np.pi, 2.0, 16)
    corners = unrolled(shape, 2 * np.pi)
    upper = corners[:, :, 1].mean(axis=1) > 1.0
    parts = {"low": (np.flatnonzero(~upper), (0, 1)), "high": (np.flatnonzero(upper), (0, 2))}
    moduli = tubes(shape.domain, corners, parts)
    q = np.log([0.5, 1.5])
    stretched = moduli.domain(q)
    halves = [stretched.face_areas[faces].sum() for faces, _ in parts.values()]
    assert_allclose(halves, np.exp(q) * 0.5 * shape.domain.area, rtol=1e-12)
    assert moduli.names == ("low", "high") and moduli.weights(q).shape == (len(shape.domain.edges), 2)
    assert_allclose(moduli.clipped(np.array([9.0, -9.0])), np.log([20, 0.05]))
    with pytest.raises(ConditionError, match="'high' has faces of another"):
        tubes(shape.domain, corners, parts | {"high": (np.flatnonzero(corners[:, :, 1].max(axis=1) > 0.9), (0, 1))})


def test_several_holes_move_each_in_its_own_way():
    """Nine numbers close the nine sums around three holes; the mesh of the moved plan has the lengths of the result."""
    shape, rim = courtyard(0.16, "three holes")
    plan = shape.domain, shape.positions
    closing = close_periods(shape, rim, by="moduli", moduli=[hole(*plan, loop) for loop in (1, 2, 3)])
    assert closing.ok, closing.message
    assert closing.names == tuple(f"hole {k} {name}" for k in (1, 2, 3) for name in ("x", "y", "twist"))
    moved = MovingHoles(*plan, [1, 2, 3]).positions(closing.moduli)
    i, j = shape.domain.edges.T
    assert_allclose(closing.domain.edge_lengths, np.linalg.norm(moved[j] - moved[i], axis=1), rtol=1e-12)


def test_several_holes_are_the_sum_of_their_motions():
    shape, rim = courtyard(0.16, "three holes")
    plan = shape.domain, shape.positions
    one, other = hole(*plan, 2, ("size",)), hole(*plan, 3, ("y", "x"))
    both = together([one, other])
    assert both.names == ("hole 1 size", "hole 2 y", "hole 2 x")
    assert both.ranges == (*one.ranges, *other.ranges)
    assert_allclose(both.lengths(np.array([0.1, 0, 0])), one.lengths(np.array([0.1])), rtol=1e-14)
    assert_allclose(both.lengths(np.array([0, 0.02, 0.01])), other.lengths(np.array([0.02, 0.01])), rtol=1e-14)
    again = close_periods(shape, rim, by="both", moduli=(one, other))
    assert again.closed and again.names == both.names


def test_moduli_that_do_not_go_together_are_refused():
    shape, rim = courtyard(0.2, "three holes")
    plan = shape.domain, shape.positions
    every = np.arange(len(shape.domain.faces))
    stretch = tube(shape.domain, shape.positions[shape.domain.faces], every, (1, 0))
    for moduli, message in (
        ([], "must be a list of holes"),
        ([hole(*plan, 1), stretch], "parts that stretch are one, made by `tubes`"),
        ([hole(*plan, 1), hole(*plan, 1, ("size",))], "loop 1 is given twice"),
        ([hole(*plan, 1), hole(shape.domain, 2 * shape.positions, 2)], "of different plans"),
    ):
        with pytest.raises(ConditionError, match=message):
            close_periods(shape, rim, by="moduli", moduli=moduli)


def test_a_hole_that_moves_too_far_turns_faces_over():
    shape, _ = courtyard(0.2)
    moduli = hole(shape.domain, shape.positions, 1)
    i, j = shape.domain.edges.T
    near = moduli.lengths(np.array([0.02, 0.01, 0.1]))
    assert_allclose(near, np.linalg.norm(shape.positions[j] - shape.positions[i], axis=1), rtol=0.5)
    with pytest.raises(MeshError, match="turned over"):
        moduli.domain(np.array([0.5, 0.0, 0.0]))


@pytest.mark.parametrize("motion", ["x", "size"])
def test_what_cannot_close_ends_with_what_is_left(motion):
    """One modulus does not close three components: what it reaches is closed, and the rest is reported."""
    shape, rim = courtyard(0.16)
    moduli = hole(shape.domain, shape.positions, 1, (motion,))
    closing = close_periods(shape.domain, rim, by="moduli", moduli=moduli)
    assert not closing.closed and closing.status is ClosingStatus.RANK_DEFICIENT
    assert closing.rank == 1 and "Only 1 of their components" in closing.message
    assert closing.gaps[-1] > 1e-3 and closing.surface.is_open and "The gap was" in closing.message
    assert closing.left == {"period 0": closing.gaps[-1]} and "The rest: period 0 0.0" in closing.message


def test_wrong_options_are_refused():
    shape, rim = courtyard(0.2)
    disc = shapes.disc(60)
    flat = conditions.binormal(disc.domain, disc.positions, disc.domain.boundary_edges)
    for arguments, message in (
        ((disc.domain, flat), "neither holes nor handles"),
        ((shape.domain, rim, "moduli"), "needs moduli"),
        ((shape.domain, rim, "force"), "force"),
    ):
        with pytest.raises(ConditionError, match=message):
            close_periods(*arguments[:2], **({"by": arguments[2]} if len(arguments) > 2 else {}))
    with pytest.raises(ConditionError, match='motion of a hole "up"'):
        hole(shape.domain, shape.positions, 1, ("up",))
    with pytest.raises(ConditionError, match="boundary loop 5"):
        hole(shape.domain, shape.positions, 5)


def test_progress_and_cancelling():
    shape, rim = courtyard(0.2)
    seen = []

    def progress(step, gap):
        seen.append(gap)
        return step < 1

    closing = close_periods(shape.domain, rim, progress=progress)
    assert closing.status is ClosingStatus.CANCELLED and seen == closing.gaps
    assert isinstance(closing.domain, Domain)


@pytest.mark.parametrize("way", ["normals", "tilts"])
def test_turned_is_the_angle_between_the_normals_before_and_after(way):
    shape, rim = courtyard(0.2)
    closing = close_periods(shape.domain, rim, **WAYS[way](shape))
    (fixed, before), (still_fixed, after) = rim.resolve(), closing.conditions.resolve()
    assert_array_equal(fixed, still_fixed)
    angle = np.arctan2(np.linalg.norm(np.cross(before, after), axis=1), np.einsum("ij,ij->i", before, after))
    assert_allclose(closing.turned, angle, rtol=1e-9, atol=1e-12)
    assert f"turned by {np.degrees(angle.max()):.1f}° at most" in closing.message
