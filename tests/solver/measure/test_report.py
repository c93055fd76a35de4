"""The report on solved surfaces: against exact numbers, under placement, with gaps, as JSON and in words."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import CmcSurface, Domain, conditions, solve_cmc
from solver.catalogue import shapes
from solver.errors import CmcError, MeshError, Status
from solver.measure import mean_curvature_of, report
from solver.measure.report import _sentence, to_plain
from tests.solver.sampled_surfaces import Delaunay


def solved_disc(n, m=0, **options):
    shape = shapes.disc(n)
    domain = shape.domain
    return solve_cmc(domain, conditions.twisted(domain, shape.positions, domain.boundary_edges, m), **options)


@pytest.fixture(scope="module")
def hemisphere() -> CmcSurface:
    return solved_disc(2000)


@pytest.fixture(scope="module")
def twisted() -> CmcSurface:
    return solved_disc(2000, m=1)


@pytest.fixture(scope="module")
def open_ring() -> CmcSurface:
    shape = shapes.annulus(1.0, 2.5, 1200)
    domain = shape.domain
    data = conditions.binormal(domain, shape.positions, shape.sides["outer"], tilt=0.3)
    data += conditions.fixed(domain, shape.sides["inner"], (0.0, 0.6, 0.8))
    surface = solve_cmc(domain, data)
    assert surface.is_open
    return surface


def test_hemisphere_of_radius_two(hemisphere):
    result = report(hemisphere)
    dome = result.shown
    assert result.status == "converged"
    assert result.converged
    assert re.fullmatch(r"Done\. Curvature is even to \d\.?\d* %\.", result.sentence)
    assert result.ok and result.message == result.sentence
    assert result.energy == pytest.approx(2 * np.pi, rel=2e-3)
    assert abs(result.degree) == pytest.approx(0.5, abs=1e-2)
    assert result.residual < 1e-6
    assert result.iterations == hemisphere.harmonic.iterations
    assert dome.area == pytest.approx(8 * np.pi, rel=5e-3)
    assert dome.boundary_length == pytest.approx(4 * np.pi, rel=2e-3)
    assert dome.span == pytest.approx(4.0, rel=2e-3)
    assert dome.rise == pytest.approx(2.0, rel=2e-3)
    low, high = np.array(dome.bounding_box)
    assert_allclose(high - low, [4.0, 4.0, 2.0], rtol=5e-3)
    assert dome.mean_curvature is not None
    assert dome.mean_curvature.target == 0.5
    assert dome.mean_curvature.mean == pytest.approx(0.5, abs=1e-3)
    assert dome.mean_curvature.linf < 2e-3
    assert dome.mean_curvature.gauss_mean == pytest.approx(0.25, abs=1e-3)
    assert dome.distortion is not None
    assert 1.0 < dome.distortion.mean < 1.03
    assert dome.overhang is not None
    assert dome.overhang.count == 0
    assert dome.intersections is not None
    assert dome.intersections.count == 0


def test_a_degenerate_sheet_is_named_and_not_measured(hemisphere):
    point = report(hemisphere).sheets["f-"]
    assert point.degenerate
    assert point.area < 1e-3
    assert point.mean_curvature is point.distortion is point.overhang is point.intersections is None
    assert "degenerate" in report(hemisphere, sheet="f-").summary()


def test_errors_of_curvature_and_distortion_fall(twisted):
    fine = solved_disc(8000, m=1)
    for sheet in ("f+", "f-"):
        coarse_errors, fine_errors = (errors_of(report(s, intersections=False).sheets[sheet]) for s in (twisted, fine))
        rates = np.log2(coarse_errors / fine_errors)
        assert (rates > (0.9, 0.75, 0.9, 1.8)).all(), rates


def errors_of(sheet):
    H, Q = sheet.mean_curvature, sheet.distortion
    return np.array([H.l2, H.linf, Q.l2, Q.energy_mean])


def test_figures_of_curvature_agree_with_each_other(twisted):
    H = report(twisted).shown.mean_curvature
    assert H is not None
    assert H.l2**2 == pytest.approx(H.std**2 + (H.mean - H.target) ** 2, rel=1e-9)
    assert H.relative_l2 == pytest.approx(2 * H.l2)
    assert H.l2 <= H.linf
    assert H.inside_linf <= H.linf


def rotation(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_a_placed_surface_is_measured_where_it_is(twisted, mirror):
    move = rotation(0.7) @ np.diag([1.0, 1.0, mirror])
    placed = {name: 3.0 * twisted.sheet(name) @ move.T + (100.0, 20.0, 5.0) for name in ("f+", "f-")}
    own, result = report(twisted), report(twisted, positions=placed)
    assert result.scale == pytest.approx(3.0)
    assert result.mean_curvature == pytest.approx(1 / 6)
    for name in ("f+", "f-"):
        there, here = result.sheets[name], own.sheets[name]
        assert there.area == pytest.approx(9 * here.area)
        assert there.rise == pytest.approx(3 * here.rise)
        assert there.span == pytest.approx(3 * here.span)
        assert there.mean_curvature.mean == pytest.approx(here.mean_curvature.mean / 3)
        assert there.mean_curvature.relative_l2 == pytest.approx(here.mean_curvature.relative_l2, rel=1e-6)
        assert there.distortion.l2 == pytest.approx(here.distortion.l2)
        assert there.overhang.count == here.overhang.count


def test_one_placed_sheet_alone(twisted):
    result = report(twisted, sheet="f-", positions=10.0 * twisted.f_minus)
    assert list(result.sheets) == ["f-"]
    assert result.shown.name == "f-"
    assert result.mean_curvature == pytest.approx(0.05)
    single = report(twisted, positions=np.float32(1000.0 * twisted.f_plus + 5000.0))
    assert single.shown.mean_curvature.relative_l2 == pytest.approx(
        report(twisted).shown.mean_curvature.relative_l2, rel=0.05
    )


def test_placed_points_that_are_none(twisted):
    with pytest.raises(MeshError, match=r"positions of f\+ are not its points moved"):
        report(twisted, positions=twisted.f_plus * (1.0, 1.0, 0.5))
    with pytest.raises(MeshError, match=r"positions of f\+ at vertices 7, 9 are not finite"):
        broken = twisted.f_plus.copy()
        broken[[7, 9], 1] = np.nan, np.inf
        report(twisted, positions=broken)
    with pytest.raises(MeshError, match="not its points moved"):
        report(twisted, positions=np.zeros_like(twisted.f_plus))
    with pytest.raises(MeshError, match=r"have shape \(3, 3\)"):
        report(twisted, positions=np.eye(3))
    with pytest.raises(MeshError, match=r"positions of f\+ are missing"):
        report(twisted, positions={"f-": twisted.f_minus})
    with pytest.raises(CmcError, match='no report on a sheet "gauss"'):
        report(twisted, sheet="gauss")


def test_distance_from_the_outline(hemisphere):
    t = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
    circle = np.column_stack([np.cos(t), np.sin(t)])
    rim = report(hemisphere, [2.0 * circle], intersections=False).shown.outline
    assert rim is not None
    assert rim.max < 5e-3
    wide = report(hemisphere, [2.5 * circle], intersections=False).shown.outline
    assert wide is not None
    assert_allclose([wide.max, wide.mean, wide.rms, wide.reverse_max], 0.5, rtol=2e-2)
    flat = np.column_stack([circle, np.full(len(t), hemisphere.f_plus[:, 2].min() - 0.3)])
    raised = report(hemisphere, [2.0 * flat * (1, 1, 0.5)], intersections=False).shown.outline
    assert raised is not None
    assert_allclose([raised.max, raised.mean], 0.3, rtol=2e-2)
    assert raised.plan_max < 5e-3


def test_distance_from_drawn_vertices_and_what_is_not_reached(hemisphere):
    positions = 2.0 * shapes.disc(2000).positions
    rim = report(hemisphere, positions, intersections=False).shown.outline
    assert rim is not None
    assert rim.max < 5e-3
    square = np.array([(-2, -2), (2, -2), (2, 2), (-2, 2)])
    rim = report(hemisphere, [square], intersections=False).shown.outline
    assert rim is not None
    assert rim.reverse_max == pytest.approx(2 * np.sqrt(2) - 2, rel=1e-2)
    assert rim.max == pytest.approx(2 - np.sqrt(2), rel=4e-2)


def test_a_surface_with_a_gap(open_ring):
    result = report(open_ring)
    assert result.status == "gap"
    assert result.converged
    assert result.is_open
    assert result.gap == pytest.approx(np.linalg.norm(result.periods[0]))
    assert result.gap > 0
    assert len(open_ring.f_plus) > result.vertices
    moved = report(open_ring, positions={"f+": -2.0 * open_ring.f_plus, "f-": -2.0 * open_ring.f_minus})
    assert_allclose(moved.periods, -2.0 * np.array(result.periods), rtol=1e-9)
    assert not result.ok and result.sentence.startswith(f"{Status.GAP.sentence} The gap is {result.gap:.4g} long.")
    assert re.search(r"Curvature is even to \d+ %\.$", result.sentence)
    assert f"The gap is {2 * result.gap:.4g} long" in moved.sentence
    # The seam is not a part of the boundary.
    assert result.shown.boundary_length == pytest.approx(boundary_length(open_ring), rel=1e-12)
    assert "the gap" in result.summary()


def boundary_length(surface):
    """Face by face, by the edges that have one face in the domain."""
    total = 0.0
    for face, rows in zip(surface.domain.face_edges, surface.faces, strict=True):
        for k, edge in enumerate(face):
            if surface.domain.edge_faces[edge, 1] < 0:
                a, b = surface.f_plus[rows[k - 1]], surface.f_plus[rows[k - 2]]
                total += np.linalg.norm(a - b)
    return total


def test_json_is_strict_and_whole(twisted, hemisphere, open_ring):
    for surface in (twisted, hemisphere, open_ring):
        result = report(surface, surface.domain.boundary_loops and surface.f_plus[: surface.domain.vertex_count])
        read = json.loads(result.to_json(), parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
        assert read == result.to_dict()
        assert read["energy"] == result.energy
        assert read["sheets"]["f+"]["mean_curvature"]["l2"] == result.shown.mean_curvature.l2


def test_no_number_is_null(twisted):
    broken = replace(report(twisted, intersections=False), energy=float("nan"), residual=float("inf"))
    read = json.loads(broken.to_json(), parse_constant=pytest.fail)
    assert read["energy"] is None
    assert read["residual"] is None


def test_plain_values():
    given = {
        "a": np.float32(1.5),
        "b": np.array([[1, 2]]),
        "c": (np.nan, np.inf, 1),
        "d": np.bool_(True),
        5: None,
    }
    assert to_plain(given) == {"a": 1.5, "b": [[1, 2]], "c": [None, None, 1], "d": True, "5": None}


def test_summary_is_short_and_has_units(twisted):
    positions = {"f+": 8.0 * twisted.f_plus, "f-": 8.0 * twisted.f_minus}
    lines = (
        report(twisted, 8.0 * twisted.f_plus[: twisted.domain.vertex_count], positions=positions)
        .summary("m")
        .split("\n")
    )
    assert 5 <= len(lines) <= 9
    assert any("span" in line and " m, " in line and " m²" in line for line in lines)
    assert any("1/m, wanted 0.0625" in line for line in lines)
    assert any("0 m at most" in line for line in lines)
    assert "does not go through itself" in lines[-1]
    assert "  " not in report(twisted).summary()


def test_crossings_and_overhang_are_reported():
    """A nodoid of a period and more goes through itself; seen as a column, parts of it overhang."""
    height = 9.0
    shape = shapes.cylinder(2 * np.pi, height, 48)
    surface = nodoid_on(shape.domain, shape.positions)
    result = report(surface)
    for sheet in result.sheets.values():
        assert sheet.mean_curvature.mean == pytest.approx(0.5, abs=0.02)
        assert sheet.distortion.mean < 1.1
    crossing = result.shown.intersections
    assert crossing is not None
    assert crossing.count > 48
    assert len(crossing.pairs) == min(100, crossing.count)
    assert crossing.face_count <= len(surface.faces)
    assert f"goes through itself at {crossing.count} pairs" in result.summary()
    assert result.shown.overhang is not None
    assert 0.05 < result.shown.overhang.area_share < 0.95


def nodoid_on(domain: Domain, positions) -> CmcSurface:
    """The exact nodoid c = ½ on the glued strip, in place of a solved one."""
    plus, N = Delaunay(0.5, np.pi + 0.4)(positions[:, 0], positions[:, 1])
    own = solved_disc(20)
    return replace(
        own,
        domain=domain,
        harmonic=replace(own.harmonic, normals=N),
        g=plus - N,
        f_plus=plus,
        f_minus=plus - 2.0 * N,
        normals=N,
        faces=domain.faces,
        source=np.arange(domain.vertex_count, dtype=np.int32),
        periods=np.zeros((0, 3)),
    )


def test_figures_inside_leave_out_the_faces_at_the_rim(open_ring):
    domain = open_ring.domain
    is_inside = ~np.isin(domain.faces, domain.boundary_vertices).any(axis=1)
    error = np.abs(mean_curvature_of(open_ring.f_plus, open_ring.faces, open_ring.normals) - 0.5)
    H = report(open_ring, intersections=False).sheets["f+"].mean_curvature
    assert H.inside_linf == pytest.approx(error[is_inside].max(), rel=1e-9)
    assert H.linf == pytest.approx(error.max(), rel=1e-9)
    assert H.inside_linf < 0.9 * H.linf
    assert H.inside_l2 < 0.9 * H.l2


@pytest.mark.parametrize(
    ("part", "text"),
    [
        (1e-9, "Done. Curvature is even to 0.01 %."),
        (0.00612, "Done. Curvature is even to 0.61 %."),
        (0.14, "Curvature is off by 14 % of its target."),
        (1.234, "Curvature is off by 123 % of its target."),
        (43.2, "Curvature is off by 43 times its target."),
    ],
)
def test_the_sentence_has_two_digits_and_no_powers_of_ten(part, text):
    surface = solved_disc(300, tolerance=1e-8)
    measured = report(surface)
    uneven = replace(measured.shown.mean_curvature, relative_l2=part)
    assert text == _sentence(surface, replace(measured.shown, mean_curvature=uneven), 1.0)
