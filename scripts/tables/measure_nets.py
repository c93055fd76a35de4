"""The tables of docs/measured/nets.md, measured: Hopf differentials, nets, flat panels and moulds.

    make gallery                                            # measures, writes the tables, draws the pictures
    .venv/bin/python -m scripts.tables.measure_nets exact   # some of them, printed only
    .venv/bin/python -m scripts.tables.measure_nets --write

Needs no Blender.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from scripts.tables.measured_page import Tables, measure
from solver import CmcError, Net, panel_net, planarise, report, shapes, solve_cmc
from solver.gauss import conditions
from solver.nets.moulds import _laid, covered
from solver.nets.patches import frames, local, quads, samples, sphere_quartic
from tests.solver.exact_surfaces import rates
from tests.solver.nets.net_checks import faults, gaps
from tests.solver.nets.random_plans import shell
from tests.solver.nets.test_hopf import SURFACES, errors
from tests.solver.nets.test_panel_net import span

ROOT = Path(__file__).resolve().parents[2]

PAGE = ROOT / "docs" / "measured" / "nets.md"
COLUMNS = (32, 64, 128)
SHELLS = {
    "square": ("square", 0.2, 0.0, 0.1),
    "hypar, H = 0": ("square", 0.0, 0.3, 0.1),
    "rectangle": ("rectangle", 0.5, 0.0, 0.1),
    "L": ("L", 0.2, 0.0, 0.1),
    "courtyard": ("courtyard", 0.2, 0.0, 0.13),
    "two holes": ("two holes", 0.2, 0.0, 0.13),
    "ring": ("ring", 0.4, 0.0, 0.13),
    "hanging ring": ("ring", -0.4, 0.3, 0.13),
}
PLANS = 300


def exact() -> list[str]:
    """Errors of Q and of the directions on exact surfaces."""
    rows = ["| surface | columns | Q as measured | Q | order | directions, ° |", "|---" * 6 + "|"]
    for name, (make, Q, _, _) in SURFACES.items():
        found = [errors(*make(columns), Q) for columns in COLUMNS]
        order = [np.nan, *rates([one[1] for one in found])]
        for columns, (raw, denoised, angle), rate in zip(COLUMNS, found, order, strict=True):
            rows.append(f"| {name} | {columns} | {raw:.1e} | {denoised:.1e} | {rate:.1f} | {angle:.4f} |")
    return [row.replace("nan", "") for row in rows]


def spans() -> list[str]:
    """Nets of 300 panels, and 1000, on spanning surfaces."""
    rows = [
        "| surface | vertices | umbilics | off, ° | gap, 100 | 300 | 1000 | torsion, 300 | κ of 45° net - H |",
        "|---" * 9 + "|",
    ]
    for name, case in SHELLS.items():
        surface = span(*case)
        nets = {count: panel_net(surface, count=count) for count in (100, 300, 1000)}
        diagonal = panel_net(surface, count=300, kind="diagonal")
        off = np.median(diagonal.normal_curvature[diagonal.family >= 0]) - case[1]
        flat = " | ".join(f"{np.median(gaps(net)):.1e}" for net in nets.values())
        net = nets[300]
        rows.append(
            f"| {name} | {len(surface.points)} | {net.orders.sum()} | {np.degrees(net.deviation):.2f} | {flat} | "
            f"{np.median(net.torsion):.1e} | {off:+.4f} |"
        )
    return rows


def random() -> list[str]:
    """How many random plans get nets that pass all checks."""
    rows = ["| plans | shells | right | wrong | refused |", "|---" * 5 + "|"]
    for name, seeds, rounded in (("rounded", range(PLANS), True), ("sharp", range(1000, 1000 + PLANS // 3), False)):
        right, wrong, refused = 0, 0, 0
        for seed in seeds:
            surface = shell(seed, 400, rounded)
            if surface is None:
                continue
            try:
                net = panel_net(surface, count=(100, 300, 1000)[seed % 3], kind=("principal", "diagonal")[seed % 2])
                right, wrong = (right, wrong + 1) if faults(net) else (right + 1, wrong)
            except CmcError:
                refused += 1
        rows.append(f"| {name} | {right + wrong + refused} | {right} | {wrong} | {refused} |")
    return rows


def flat() -> list[str]:
    """How far nodes move for flat panels, in % of the side."""
    rows = [
        "| surface | panels | rim | inner nodes, median | largest | rim, largest | left, of the side |",
        "|---" * 7 + "|",
    ]
    for name in ("square", "L", "courtyard", "hanging ring"):
        for count in (100, 300, 1000):
            net = panel_net(span(*SHELLS[name]), count=count)
            inner = np.setdiff1d(np.arange(len(net.vertices)), net.rim)
            for keep in (False, True):
                made = planarise(net, keep_rim=keep)
                moved = 100.0 * made.moved / np.median(net.side_lengths)
                rows.append(
                    f"| {name} | {len(net.polygons)} | {'kept' if keep else 'free'} | {np.median(moved[inner]):.2f} | "
                    f"{moved[inner].max():.1f} | {moved[net.rim].max():.1f} | {made.flatness:.0e} |"
                )
    return rows


def mould() -> list[str]:
    """The departure of whole panels from one sphere, and the number of moulds by tolerance."""
    rows = [
        "| surface | panels | w² / 16 | median | 5 % | 95 % | moulds at w² / 16 | half | a quarter | a tenth |",
        "|---" * 10 + "|",
    ]
    for name in ("square", "rectangle", "L", "courtyard", "hanging ring"):
        net = panel_net(span(*SHELLS[name]), count=300)
        off = departures(net) / net.sphere_gap
        counts = [covered(net, part * net.sphere_gap)[0].max() + 1 for part in (1.0, 0.5, 0.25, 0.1)]
        low, high = np.quantile(off, [0.05, 0.95])
        rows.append(
            f"| {name} | {len(off)} | 1 | {np.median(off):.3f} | {low:.3f} | {high:.3f} | "
            + " | ".join(str(count) for count in counts)
            + " |"
        )
    return rows


def departures(net: Net) -> np.ndarray:
    """How far each whole four-sided panel is from the sphere of radius 1 / |H|."""
    panels = quads(net)
    points = samples(net, panels)
    return _laid(sphere_quartic(net.mean_curvature), local(points, *frames(net, panels, points)))


def steiner() -> list[str]:
    """Steiner's mean curvature of the corner complex of a pavilion, H = ½."""
    rows = ["| vertices | f+ | f- |", "|---" * 3 + "|"]
    for edge in (0.2, 0.1, 0.05):
        plan = shapes.polygon([[0, 0], [4, 0], [4, 3], [0, 3]], max_edge=edge, corner_radius=0.8)
        surface = solve_cmc(plan, conditions.binormal(plan, "outer", tilt=np.radians(40)))
        values = [report(surface, sheet=sheet, intersections=False).steiner_mean_curvature for sheet in ("f+", "f-")]
        rows.append(f"| {plan.domain.vertex_count} | {values[0]:.6f} | {values[1]:.6f} |")
    return rows


TABLES: Tables = {
    "exact": exact,
    "spans": spans,
    "random": random,
    "flat": flat,
    "mould": mould,
    "steiner": steiner,
}

if __name__ == "__main__":
    measure(PAGE, TABLES)
