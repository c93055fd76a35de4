"""The public door: an argument of another type than the call takes is named in a sentence, wherever it is given."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable

import numpy as np
import pytest

import solver
from solver import conditions, modules, shapes
from solver.errors import ArgumentError, CmcError
from solver.fitting.fit import Start

DISC = shapes.disc(60)
DOMAIN, FACES = DISC.domain, DISC.domain.faces
RIM = conditions.binormal(DISC, "outer", tilt=0.3)
SURFACE = solver.solve_cmc(DISC, RIM)
NORMALS, PLACES = SURFACE.normals, SURFACE.f_plus
HARMONIC, CMC = solver.HarmonicSolver(DISC), solver.CmcSolver(DISC)
SIDE = solver.Side("a", DISC.sides["outer"][:5], "mirror", [0, 0, 1])
PLAN = solver.Plan.from_shape(DISC)
SHELL = solver.form(PLAN)
SPAN = solver.span_outline(DISC, DISC.positions, rise=0.4)
START = Start(RIM, 1.0, np.zeros(3))
NONE = np.zeros((0, 2), dtype=int)
SQUARE = shapes.polygon([[0, 0], [1, 0], [1, 1], [0, 1]], max_edge=0.2, corner_radius=0.2)
SQUARE_SPAN = solver.span_outline(SQUARE, SQUARE.positions, mean_curvature=0.3)
NET = solver.panel_net(SQUARE_SPAN, 0.3)


class Thing:
    """Something of no use anywhere; it prints alike in every process."""

    def __repr__(self) -> str:
        return "a thing"


# Calls of each public name, with one argument left open.
CALLS: dict[str, list[Callable]] = {
    "CmcSolver": [solver.CmcSolver, CMC.moved, lambda x: CMC.index(RIM, x), lambda x: CMC.index(x, NORMALS)],
    "CmcSurface": [SURFACE.save, SURFACE.as_mesh],
    "Conditions": [lambda x: solver.solve_cmc(DISC, x), lambda x: solver.Conditions(edges=x)],
    "Domain": [
        lambda x: solver.Domain.from_positions(x, FACES),
        lambda x: solver.Domain.from_positions(PLACES, x),
        lambda x: solver.Domain.from_edge_lengths(FACES, x),
        DOMAIN.with_lengths,
    ],
    "Group": [lambda x: solver.Group(x, NONE), lambda x: solver.Group("a", x)],
    "HarmonicSolver": [solver.HarmonicSolver, lambda x: HARMONIC.solve(x)],
    "Plan": [
        lambda x: solver.Plan(x, FACES),
        lambda x: solver.form(solver.Plan(DISC.positions, x)),
        lambda x: solver.form(solver.Plan(DISC.positions, FACES, groups=x)),
        solver.Plan.from_shape,
        solver.Plan.from_mesh,
        lambda x: solver.Plan.from_shape(DISC, {"outer": x}),
        lambda x: solver.form(solver.Plan.from_shape(DISC, {"outer": ("binormal", {"tilt": x})})),
    ],
    "Report": [solver.report(SURFACE).summary],
    "Settings": [
        lambda x: solver.Settings(size=x),
        lambda x: solver.Settings(size="span", value=x),
        lambda x: solver.Settings(delaunay=x),
        lambda x: solver.Settings(tolerance=x),
        lambda x: solver.Settings(default_tilt=x),
    ],
    "ClosingOptions": [
        solver.ClosingOptions,
        lambda x: solver.ClosingOptions("both", x),
        lambda x: solver.ClosingOptions("hole", move=x),
        lambda x: solver.ClosingOptions("hole", holes=x),
        lambda x: solver.Settings(close=x),
    ],
    "Shell": [SHELL.points, SHELL.save, SHELL.summary],
    "Side": [lambda x: solver.complete(SURFACE, [solver.Side("a", x)])],
    "Span": [SPAN.harmonic, SPAN.distance, SPAN.sheet, SPAN.save],
    "close_periods": [
        lambda x: solver.close_periods(DISC, x),
        lambda x: solver.close_periods(DISC, RIM, coplanar=x),
        lambda x: solver.close_periods(DISC, RIM, by="hole", moduli=x),
        lambda x: solver.close_periods(DISC, RIM, by=x),
    ],
    "complete": [lambda x: solver.complete(x, [SIDE]), lambda x: solver.complete(SURFACE, x)],
    "conformal_distortion": [
        lambda x: solver.conformal_distortion(x, PLACES),
        lambda x: solver.conformal_distortion(DISC, x),
    ],
    "curvature_lines": [
        lambda x: solver.curvature_lines(x, 0.3),
        lambda x: solver.curvature_lines(SQUARE_SPAN, x),
        lambda x: solver.curvature_lines(SQUARE_SPAN, 0.3, quantised=x),
    ],
    "fit": [lambda x: solver.fit(DISC, x, START, size=1.0), lambda x: solver.fit(DISC, [], x, size=1.0)],
    "fit_gauss_map": [
        lambda x: solver.fit_gauss_map(DISC, x, max_evaluations=2),
        lambda x: solver.fit_gauss_map(DISC, PLACES, initial=x, max_evaluations=2),
        lambda x: solver.fit_gauss_map(DISC, PLACES, solver=x, max_evaluations=2),
        lambda x: solver.fit_gauss_map(DISC, PLACES, progress=x, max_evaluations=2),
    ],
    "fit_outline": [
        lambda x: solver.fit_outline(DISC, x, max_evaluations=2),
        lambda x: solver.fit_outline(DISC, DISC.positions, anchors=x, max_evaluations=2),
        lambda x: solver.fit_outline(DISC, DISC.positions, initial=x, max_evaluations=2),
        lambda x: solver.fit_outline(DISC, DISC.positions, solver=x, max_evaluations=2),
        lambda x: solver.fit_outline(DISC, DISC.positions, free_heights=x, max_evaluations=2),
    ],
    "form": [solver.form, lambda x: solver.form(PLAN, x)],
    "gauss_curvature_of": [lambda x: solver.gauss_curvature_of(x, FACES, NORMALS)],
    "hole": [
        lambda x: solver.hole(DISC, DISC.positions, x),
        lambda x: solver.hole(DISC, x, 0),
        lambda x: solver.hole(DISC, DISC.positions, 0, x),
    ],
    "isothermic_coordinates": [
        lambda x: solver.isothermic_coordinates(x, 0.3),
        lambda x: solver.isothermic_coordinates(SQUARE_SPAN, x),
    ],
    "mean_curvature_of": [lambda x: solver.mean_curvature_of(PLACES, x, NORMALS)],
    "modes_of": [
        lambda x: solver.modes_of(x, RIM, NORMALS),
        lambda x: solver.modes_of(HARMONIC, x, NORMALS),
        lambda x: solver.modes_of(HARMONIC, RIM, x),
    ],
    "moulds": [lambda x: solver.moulds(x, 0.01), lambda x: solver.moulds(NET, x)],
    "Net": [NET.save],
    "panel_net": [
        lambda x: solver.panel_net(x, 0.3),
        lambda x: solver.panel_net(SQUARE_SPAN, x),
        lambda x: solver.panel_net(SQUARE_SPAN, count=x),
        lambda x: solver.panel_net(SQUARE_SPAN, 0.3, kind=x),
        lambda x: solver.panel_net(SQUARE_SPAN, 0.3, sheet=x),
        lambda x: solver.panel_net(SQUARE_SPAN, 0.3, planar=x),
    ],
    "periods": [solver.periods],
    "preview_net": [
        lambda x: solver.preview_net(x, 0.3),
        lambda x: solver.preview_net(SQUARE_SPAN, x),
        lambda x: solver.preview_net(SQUARE_SPAN, count=x),
    ],
    "planarise": [solver.planarise, lambda x: solver.planarise(NET, keep_rim=x)],
    "principal_curvatures": [lambda x: solver.principal_curvatures(PLACES, FACES, x)],
    "read_plan": [solver.read_plan],
    "report": [
        solver.report,
        lambda x: solver.report(SURFACE, x),
        lambda x: solver.report(SURFACE, sheet=x),
        lambda x: solver.report(SURFACE, up=x),
    ],
    "ring": [lambda x: solver.ring(x, max_edge=1.0), lambda x: solver.ring(max_edge=x)],
    "saddle": [lambda x: solver.saddle(x, RIM, NORMALS), lambda x: solver.saddle(HARMONIC, x, NORMALS)],
    "side_plane": [lambda x: solver.side_plane(x, SIDE), lambda x: solver.side_plane(SURFACE, x)],
    "solve_cmc": [
        lambda x: solver.solve_cmc(x, RIM),
        lambda x: solver.solve_cmc(DISC, RIM, progress=x),
        lambda x: solver.solve_cmc(DISC, RIM, delaunay=x),
        lambda x: solver.solve_cmc(DISC, RIM, initial=x),
        lambda x: solver.solve_cmc(DISC, RIM, max_iterations=x),
        lambda x: solver.solve_cmc(DISC, RIM, method=x),
    ],
    "span_outline": [
        lambda x: solver.span_outline(x, DISC.positions),
        lambda x: solver.span_outline(DISC, x),
        lambda x: solver.span_outline(DISC, DISC.positions, x),
        lambda x: solver.span_outline(DISC, DISC.positions, rise=x),
        lambda x: solver.span_outline(DISC, DISC.positions, mirrors=x),
        lambda x: solver.span_outline(DISC, DISC.positions, leans=x),
        lambda x: solver.span_outline(DISC, DISC.positions, anchors=x),
        lambda x: solver.span_outline(DISC, DISC.positions, solver=x),
        lambda x: solver.span_outline(DISC, DISC.positions, progress=x),
    ],
    "tube": [
        lambda x: solver.tube(DISC, x, [0], [0, 1]),
        lambda x: solver.tube(DISC, DISC.positions[FACES], x, [0, 1]),
        lambda x: solver.tube(DISC, DISC.positions[FACES], [0], x),
    ],
    "vertex_principal_curvatures": [lambda x: solver.vertex_principal_curvatures(PLACES, FACES, x)],
    "wente": [lambda x: solver.wente(x, 4), lambda x: solver.wente(1.5, x)],
    "wente_height": [solver.wente_height],
    "wente_start": [lambda x: solver.wente_start(x, 1.0, 1.0)],
    "whole": [solver.whole],
    "modules": [
        lambda x: modules.node(x, 2.4, max_edge=0.3),
        lambda x: modules.node(3, x, max_edge=0.3),
        lambda x: modules.capital(x, max_edge=0.2),
        lambda x: modules.vault(x, 0.3, max_edge=0.3),
    ],
    "shapes": [
        shapes.disc,
        shapes.polygon,
        lambda x: shapes.strip(1.0, 1.0, x),
    ],
    "conditions": [
        lambda x: conditions.binormal(DISC, x),
        lambda x: conditions.binormal(DISC, "outer", tilt=x),
        lambda x: conditions.free(DISC, x),
        lambda x: conditions.twisted(DISC, "outer", m=x),
        lambda x: conditions.mirror(DISC, "outer", x),
        lambda x: conditions.build(x, DISC, DISC.positions, "outer"),
    ],
}
# Results, which nobody makes, and names that are no calls.
NO_CALLS = {"ClosingResult", "Completion", "Fit", "HarmonicMap", "Line", "NetPreview", "Shape", "Status"}


def test_every_public_name_has_a_call():
    names = {name for name in solver.__all__ if not name.endswith("Error")}
    assert names == {*CALLS, *NO_CALLS}


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.parametrize("value", [3, None, "outside", {}, [1, [2, 3]], np.zeros(3), 10**40, Thing()], ids=repr)
def test_an_argument_of_another_type_ends_in_nothing_but_a_sentence(name: str, value: object):
    for call in CALLS[name]:
        try:  # some of the values are right for some arguments
            call(value)
        except CmcError as error:
            assert len(str(error)) > 15
            assert not re.search(r"object at 0x|<class|<built-in", str(error))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: solver.report(SIDE), r"report: surface must be a CmcSurface or a SurfaceResult, not Side\("),
        (lambda: solver.form(PLAN, "y"), 'form: settings must be a Settings.*, not "y"'),
        (lambda: solver.solve_cmc(DISC, RIM, delaunay="no"), 'delaunay must be True or False, not "no"'),
        (lambda: solver.solve_cmc(DISC, RIM, progress=3), "progress must be a function or None, not 3"),
        (lambda: solver.close_periods(DISC, RIM, coplanar=3), "coplanar must be a list, not 3"),
        (lambda: solver.read_plan(None), "read_plan: file must be a text or a PathLike, not None"),
        (lambda: solver.fit_outline(DISC, DISC.positions, anchors=3), "anchors must be a list or None, not 3"),
        (lambda: solver.fit_outline(DISC, DISC.positions, solver=3), "solver must be a CmcSolver or None, not 3"),
        (lambda: solver.ring("x"), 'ring: length must be a number, not "x"'),
        (lambda: solver.whole(SURFACE), "whole: completion must be a Completion"),
        (lambda: solver.modes_of(None, RIM, NORMALS), "modes_of: solver must be a HarmonicSolver, not None"),
        (lambda: solver.complete(SURFACE, np.zeros(3)), "complete: sides must be a list, not"),
        (lambda: SPAN.save(None), "Span.save: path must be a text or a PathLike, not None"),
        (lambda: solver.Settings(sheet=len), "sheet must be a text, not a function"),
        (lambda: SURFACE.save(3), "CmcSurface.save: path must be a text or a PathLike, not 3"),
    ],
)
def test_the_call_the_argument_and_the_value_are_named(call: Callable, message: str):
    with pytest.raises(ArgumentError, match=message) as caught:
        call()
    assert isinstance(caught.value, TypeError)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: solver.Conditions(edges=None), "Conditions: edges must be an array"),
        (lambda: DOMAIN.with_lengths([1.0]), r"must have the shape \(\d+,\), not \(1,\)"),
        (lambda: solver.wente(10**40, 4), "radians, not by a number of about 41 digits"),
    ],
)
def test_a_value_that_cannot_be_is_named(call: Callable, message: str):
    with pytest.raises(CmcError, match=message):
        call()


def test_a_size_without_a_value_is_refused():
    with pytest.raises(CmcError, match='size "span" needs a value'):
        solver.Settings(size="span")


def test_help_shows_the_signature():
    assert list(inspect.signature(solver.report).parameters)[:2] == ["surface", "outline"]
