"""Plans with edge lengths of their own and a map to start from; closed plans; the second shell; unstable modes."""

from __future__ import annotations

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import CmcError, MeshError, complete, shapes, wente
from solver.errors import JobError
from solver.jobs.job import make_job, run_job
from solver.jobs.start_table import write_start
from solver.shells.form import count_modes, form
from solver.shells.plan import Group, Plan, Settings, matches, plan_domain
from solver.shells.plan_metric import side_lengths
from solver.symmetry.glued_map import whole


@pytest.fixture(scope="module")
def torus() -> Plan:
    """Wente's torus as a map of a flat one, drawn as a lump: only the lengths say that it is a torus."""
    quarter = wente(np.radians(120), 8)
    found = whole(complete(quarter.surface, quarter.sides))
    drawn = 3.0 * found.normals + np.random.default_rng(0).uniform(-0.3, 0.3, found.normals.shape) + [5.0, 1.0, 2.0]
    return Plan(drawn, found.domain.faces, lengths=found.domain.side_lengths, initial=found.normals)


def disc_plan(tilt: float, n: int = 1500) -> Plan:
    disc = shapes.disc(n)
    positions = np.column_stack([disc.positions, np.zeros(len(disc.positions))])
    rim = disc.domain.edges[disc.domain.boundary_edges]
    return Plan(positions, disc.domain.faces, groups=[Group("rim", rim, "binormal", {"tilt": tilt})])


def noisy(normals: np.ndarray, seed: int = 0) -> np.ndarray:
    return normals + 0.02 * np.random.default_rng(seed).standard_normal(normals.shape)


def test_a_closed_plan_is_solved_from_its_start(torus):
    plan = Plan(torus.positions, torus.triangles, lengths=torus.lengths, initial=noisy(torus.initial))
    shell = form(plan, Settings(method="critical", tolerance=1e-9), intersections=False)
    assert shell.ok and shell.report.residual <= 1e-9
    assert_allclose(np.linalg.norm(shell.surface.periods, axis=1), 0, rtol=0, atol=1e-6)
    assert shell.surface.domain.genus == 1 and not shell.surface.is_open
    assert_allclose(shell.report.degree, 0, rtol=0, atol=1e-6)
    assert shell.report.index > 20
    shown = shell.report.shown
    assert shown.outline is None and shown.overhang is None and shown.boundary_length == 0.0
    assert shown.span > 0.0 and shown.rise > 0.0


@pytest.mark.parametrize("ground", ["lowest", "rim"])
def test_a_closed_shell_has_the_size_and_place_of_its_plan(torus, ground):
    shell = form(torus, Settings(method="critical", ground=ground), intersections=False)
    weights = shell.surface.domain.vertex_areas

    def centre(points):
        return np.average(points, axis=0, weights=weights)

    def radius(points):
        return np.sqrt(np.average(((points - centre(points)) ** 2).sum(axis=1), weights=weights))

    points = shell.placed["f+"]
    assert_allclose(radius(points), radius(torus.positions), rtol=1e-9, atol=0)
    assert_allclose(centre(points)[:2], centre(torus.positions)[:2], rtol=0, atol=1e-9)
    if ground == "lowest":
        assert_allclose(points[:, 2].min(), torus.positions[:, 2].min(), rtol=0, atol=1e-9)
    else:
        assert_allclose(centre(points)[2], centre(torus.positions)[2], rtol=0, atol=1e-9)
    sized = form(torus, Settings(method="critical", size="radius", value=2.0, ground=ground), intersections=False)
    assert_allclose(sized.report.mean_curvature, 0.5, rtol=1e-12, atol=0)


def test_own_lengths_are_those_of_the_domain(torus):
    domain = plan_domain(torus)
    assert_allclose(domain.side_lengths, torus.lengths, rtol=1e-12, atol=0)
    assert matches(domain, torus)
    assert not matches(domain, Plan(torus.positions, torus.triangles, lengths=2.0 * torus.lengths))
    assert not matches(domain, Plan(torus.positions, torus.triangles, initial=torus.initial))


def test_a_stretched_metric_is_that_of_a_stretched_plan():
    """Lengths of an ellipse on the drawing of a circle give the normals over the ellipse."""
    round_plan, long_plan = disc_plan(0.5, 300), disc_plan(0.5, 300)
    long_plan.positions = long_plan.positions * [1.5, 1.0, 1.0]
    domain = plan_domain(long_plan)
    rim = domain.edges[domain.boundary_edges]
    right = long_plan.positions[rim].mean(axis=1)[:, 0] > 0
    normals = {"one": (right, (0, 0, 1)), "other": (~right, (0.8, 0, 0.6))}
    groups = [Group(name, rim[here], "plane", {"normal": normal}) for name, (here, normal) in normals.items()]
    long_plan.groups = round_plan.groups = groups
    round_plan.lengths = side_lengths(round_plan.triangles, domain.edges, domain.edge_lengths)
    one, other = (form(plan, intersections=False).surface for plan in (round_plan, long_plan))
    assert_allclose(one.normals, other.normals, rtol=0, atol=1e-7)


def test_bad_metrics_and_starts_are_refused(torus):
    closed = Plan(torus.positions, torus.triangles, lengths=torus.lengths)
    with pytest.raises(MeshError, match=r"closed.*map to start from"):
        form(closed)
    wrong = torus.lengths.copy()
    wrong[3, 0] = wrong[3].sum()
    with pytest.raises(MeshError, match=r"no triangle of faces? .*3.*leave them out") as caught:
        plan_domain(Plan(torus.positions, torus.triangles, lengths=wrong, initial=torus.initial))
    assert 3 in caught.value.faces
    zero = torus.initial.copy()
    zero[[7, 9]] = 0.0
    with pytest.raises(MeshError, match="no normal at vertices 7, 9") as caught:
        plan_domain(Plan(torus.positions, torus.triangles, lengths=torus.lengths, initial=zero))
    assert caught.value.vertices == (7, 9)
    with pytest.raises(MeshError, match="each of the"):
        plan_domain(Plan(torus.positions, torus.triangles, lengths=torus.lengths, initial=zero[:-1]))
    edges = plan_domain(torus).edges
    with pytest.raises(MeshError, match="a side without; triangulate"):
        side_lengths(torus.triangles, edges[1:], np.ones(len(edges) - 1))
    with pytest.raises(MeshError, match="not positive numbers at face"):
        side_lengths(torus.triangles, edges, np.concatenate([[0.0], np.ones(len(edges) - 1)]))


def test_the_large_bubble_is_the_other_shell_over_a_rim():
    """A circle with normals tilted by 45°: together the two are a sphere (Theorem D.1)."""
    plan = disc_plan(0.25 * np.pi, 4000)
    chosen = {"first": Settings(count_modes=True), "bubble": Settings(shell="bubble", sheet="f-", count_modes=True)}
    small, large = (form(plan, settings, intersections=False) for settings in chosen.values())
    assert small.ok and large.ok
    assert_allclose(small.report.degree - large.report.degree, 1.0, rtol=0, atol=1e-2)
    assert_allclose(small.report.energy + large.report.energy, 4.0 * np.pi, rtol=0.02, atol=0)
    assert large.report.energy > 3.0 * small.report.energy
    assert (small.report.index, large.report.index) == (0, 0)
    cap, bubble = small.report.shown, large.report.shown
    assert (cap.name, bubble.name) == ("f+", "f-") and bubble.outline.max < 0.03  # turned by half, on the outline
    assert_allclose([cap.rise, bubble.rise], [np.sqrt(2) - 1, np.sqrt(2) + 1], rtol=0.02, atol=0)


@pytest.mark.parametrize("tilt", [0.0, 0.35, 0.8])
@pytest.mark.parametrize("n", [300, 700, 1500])
def test_a_bubble_is_found_on_any_mesh_that_carries_it(n, tilt):
    settings = Settings(shell="bubble", sheet="f-")
    shell = form(disc_plan(tilt, n), settings, intersections=False)
    assert shell.ok and shell.report.iterations <= 10
    assert_allclose(shell.report.degree, -0.5 * (1.0 + np.sin(tilt)), rtol=0, atol=0.01)


@pytest.mark.parametrize("n", [300, 1000])
def test_a_degree_is_reached_or_its_absence_told(n):
    wanted = -0.5 * (1.0 + np.sin(0.35))
    shell = form(disc_plan(0.35, n), Settings(degree=wanted, sheet="f-"), intersections=False)
    assert shell.ok and abs(shell.report.degree - wanted) < 0.01
    shell = form(disc_plan(0.8, 60), Settings(degree=7.0), intersections=False)
    assert any("not 7: no map" in note for note in shell.warnings)


def test_no_large_bubble_is_said():
    """A bubble of a few triangles shrinks to a point."""
    with pytest.raises(CmcError, match="Halve the edge length"):
        form(disc_plan(1.2, 60), Settings(shell="bubble"), intersections=False)


def test_modes_are_counted_where_they_are_asked_for():
    plan = disc_plan(0.5, 200)
    shell = form(plan, intersections=False)
    assert shell.report.index is None and "unstable" not in shell.summary()
    assert json.loads(shell.report.to_json())["index"] is None
    counted = count_modes(plan, Settings(), shell)
    assert (counted.report.index, counted.report.nullity) == (0, 0)
    assert "0 unstable modes" in counted.summary()
    assert form(plan, Settings(method="saddle"), intersections=False).report.index == 0
    stopped = form(plan, Settings(), progress=lambda step, residual: False, intersections=False)
    with pytest.raises(CmcError, match="converged"):
        count_modes(plan, Settings(), stopped)


def test_a_start_on_faces_is_the_mean_of_its_corners():
    plan = disc_plan(0.5, 300)
    plan.initial = form(plan, intersections=False).surface.normals
    for sites in ("faces", "faces_and_rim"):
        shell = form(plan, Settings(sites=sites), intersections=False)
        assert shell.ok


def write_torus(torus: Plan, folder) -> None:
    lines = ["v {:.9f} {:.9f} {:.9f}".format(*p) for p in torus.positions]
    lines += ["f {} {} {}".format(*(face + 1)) for face in torus.triangles]
    (folder / "torus.obj").write_text("\n".join(lines) + "\n")
    domain = plan_domain(torus)
    write_start(folder / "torus.npz", torus.initial, domain.edges, domain.edge_lengths)


def test_a_job_has_a_start(torus, tmp_path):
    write_torus(torus, tmp_path)
    job = make_job(
        {
            "mesh": "torus.obj",
            "start": "torus.npz",
            "solver": {"method": "critical", "tolerance": 1e-9},
            "size": {"radius": 1.0},
            "output": {"f_plus": "wente.obj", "report": "wente.json"},
        },
        tmp_path / "job.toml",
    )
    shell = run_job(job)
    assert shell.ok
    report = json.loads((tmp_path / "wente.json").read_text())
    assert report["index"] > 20 and report["residual"] <= 1e-9 and abs(report["degree"]) < 1e-6
    assert report["mean_curvature"] == pytest.approx(1.0)


def test_bad_starts_of_jobs_are_named(torus, tmp_path):
    write_torus(torus, tmp_path)
    (tmp_path / "text.npz").write_text("no zip")
    np.savez(tmp_path / "empty.npz", other=np.zeros(3))
    np.savez(tmp_path / "short.npz", normals=np.zeros((2, 3)))
    np.save(tmp_path / "array.npy", np.zeros((3, 3)))
    (tmp_path / "array.npy").rename(tmp_path / "array.npz")
    (tmp_path / "nothing.npz").write_bytes(b"")
    damaged = bytearray((tmp_path / "torus.npz").read_bytes())
    damaged[len(damaged) // 4] ^= 255
    (tmp_path / "damaged.npz").write_bytes(damaged)
    np.savez(tmp_path / "words.npz", normals=np.array(["up", "down"]))
    np.savez(tmp_path / "far.npz", edges=[[0, 2**62]], lengths=[1.0])
    for start, words in {
        "array.npz": "damaged, or no .npz",
        "nothing.npz": "damaged, or no .npz",
        "damaged.npz": "damaged, or no .npz",
        "words.npz": '"normals" of .* must hold numbers',
        "far.npz": "an edge has a vertex that is not there",
        "a\0b.npz": "null character",
        "missing.npz": "cannot be read",
        "text.npz": "cannot be read",
        "empty.npz": "must have the arrays",
        "short.npz": "each of the",
    }.items():
        with pytest.raises(JobError, match=f'"start".*{words}'):
            make_job({"mesh": "torus.obj", "start": start}, tmp_path / "job.toml")


def test_a_job_chooses_the_large_bubble(tmp_path):
    tables = {
        "shape": {"kind": "disc", "n": 1500},
        "default": {"tilt": 45},
        "solver": {"shell": "bubble", "count_modes": True},
        "output": {"report": "bubble.json"},
    }
    shell = run_job(make_job(tables, tmp_path / "job.toml"))
    assert shell.ok and shell.report.degree < -0.8 and shell.report.index == 0
    with pytest.raises(JobError, match="degree"):
        make_job(tables | {"solver": {"shell": "bubble", "degree": 1.0}}, tmp_path / "job.toml")
    with pytest.raises(JobError, match="bubbles"):
        make_job(tables | {"solver": {"shell": "bubbles"}}, tmp_path / "job.toml")
