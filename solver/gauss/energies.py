"""Edge energies of sphere-valued maps, as functions of c = <N_i, N_j> (paper, Sec. 4.1 and Appendix A).

An energy is `Σ value(c)` over the links of a `SiteGraph`; `star = -d value / dc` is also the Hodge star of the
conjugate, `tau = star N_i × N_j`; `dstar` is its derivative in c, which Newton's method needs. As functions of c
rather than of the bending angle α (c = cos α, star = ε'(α) / sin α) they are smooth where normals agree.

Those on faces use the dual weights w* = 1 / w or the corner angles opposite the edge. w* is negative where an edge is
not Delaunay, and shell and tan are unbounded below there; Möbius is not. Where a star diverges (opposite normals,
c = -1) the value is +inf: no line search accepts such a step.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..domain.sites import Links
from ..errors import ConditionError, check_choice

Array = NDArray[np.float64]

_ON_FACES = ("faces", "faces_and_rim")
# Below this angle of intersection β the Möbius energy is smoothed.
_COCIRCULAR = 1e-4
# 1 + cos β below which two circles count as opposite.
_OPPOSITE = 1e-14


class EdgeEnergy(Protocol):
    """An energy of a link: `value`, `star` = -d value / dc and `dstar` at `c` (K,), as arrays (K,).

    Only `weights` and `angles` of the links are read. sites: the kinds of site it is defined on. quadratic: whether
    the star is constant.
    """

    label: str
    description: str
    sites: tuple[str, ...]
    quadratic: bool

    def value(self, c: Array, links: Links) -> Array: ...

    def star(self, c: Array, links: Links) -> Array: ...

    def dstar(self, c: Array, links: Links) -> Array: ...


class Cotan:
    """ε = ½ w |N_i - N_j|² = w (1 - c), with the cotangent weights w of the domain (paper, Eq. 6).

    The Dirichlet energy of the piecewise linear map; quadratic in N, so its star is constant.
    """

    label = "Cotangent"
    description = "Dirichlet energy of the piecewise linear map; the standard choice on triangle meshes"
    sites: tuple[str, ...] = ("vertices",)
    quadratic = True

    def value(self, c: Array, links: Links) -> Array:
        return links.weights * (1.0 - c)

    def star(self, c: Array, links: Links) -> Array:
        return links.weights + 0.0 * c

    def dstar(self, c: Array, links: Links) -> Array:
        return 0.0 * links.weights * c


class DualCotan(Cotan):
    """ε = ½ w* |N_f - N_h|² across the edge between two faces, w* = 1 / w (paper, Sec. 4.1)."""

    label = "Dual Cotangent"
    description = "Inverse cotangent weights; brittle: it needs a Delaunay triangulation"
    sites: tuple[str, ...] = _ON_FACES


class Mobius:
    """ε = 2 (β + θ_k + θ_l - π), cos β = sin θ_k sin θ_l c - cos θ_k cos θ_l (paper, Eq. 15, 16, 20, 21).

    β is the angle between the circumcircles of two triangles with the opposite angles θ_k, θ_l that are bent
    against each other by α. star = 2 sin θ_k sin θ_l / sin β; at c = 1 it is |w*|, so it is positive on every
    triangulation; there ε = 0 on Delaunay edges and 4 (θ_k + θ_l - π) on others.

    On a cocircular edge (θ_k + θ_l = π: halves of a rectangle) β = 0 at c = 1, and ε is linear in α with an
    infinite star: such triangles prefer to turn as one. So for β < β₀ = 1e-4, β as a function of t = 1 - cos β is
    replaced by the cubic that vanishes with t and is twice continuously differentiable at β₀; ε and its derivatives
    are then finite at c = 1, and exact wherever β >= β₀ and where the two triangles are coplanar and cocircular.
    +inf at c = -1 where θ_k = θ_l (β = π).
    """

    label = "Möbius"
    description = "Möbius-invariant, from the discrete Willmore energy; robust on bad triangulations"
    sites: tuple[str, ...] = _ON_FACES
    quadratic = False

    def value(self, c: Array, links: Links) -> Array:
        k, ell = links.angles.T
        _, t, r = _circles(c, links)
        beta = np.where(t < _T0, _smooth(t, 0), 2.0 * np.arctan2(np.sqrt(t), np.sqrt(r)))
        return np.where(r < _OPPOSITE, np.inf, 2.0 * (beta + k + ell - np.pi))

    def star(self, c: Array, links: Links) -> Array:
        """2 p dβ/dt with p = sin θ_k sin θ_l and dβ/dt = 1 / sin β, since dt/dc = -p for t = 1 - cos β."""
        p, t, r = _circles(c, links)
        with np.errstate(divide="ignore"):
            slope = 1.0 / np.sqrt(np.maximum(t, _T0) * r)
        return 2.0 * p * np.where(t < _T0, _smooth(t, 1), slope)

    def dstar(self, c: Array, links: Links) -> Array:
        """-2 p² d²β/dt², d²β/dt² = -cos β / sin³ β."""
        p, t, r = _circles(c, links)
        with np.errstate(divide="ignore"):
            bend = -(1.0 - t) / np.sqrt(np.maximum(t, _T0) * r) ** 3
        return -2.0 * p**2 * np.where(t < _T0, _smooth(t, 2), bend)


_T0 = 1.0 - np.cos(_COCIRCULAR)


def _circles(c: Array, links: Links) -> tuple[Array, Array, Array]:
    """p = sin θ_k sin θ_l, t = 1 - cos β and r = 1 + cos β, without cancellation at either end."""
    k, ell = links.angles.T
    p = np.sin(k) * np.sin(ell)
    t = 2.0 * np.sin(0.5 * (k + ell - np.pi)) ** 2 + p * np.maximum(1.0 - c, 0.0)
    r = 2.0 * np.sin(0.5 * (k - ell)) ** 2 + p * np.maximum(1.0 + c, 0.0)
    return p, t, r


# The cubic in s = t / t₀ that vanishes with s and has the value and two derivatives of β at s = 1.
_V, _D, _DD = _COCIRCULAR, _T0 / np.sin(_COCIRCULAR), -(_T0**2) * np.cos(_COCIRCULAR) / np.sin(_COCIRCULAR) ** 3
_C3 = _V - _D + 0.5 * _DD
_CUBIC = np.polynomial.Polynomial([0.0, _D - _DD + 3.0 * _C3, 0.5 * _DD - 3.0 * _C3, _C3])


_CUBICS = (_CUBIC, _CUBIC.deriv(1), _CUBIC.deriv(2))


def _smooth(t: Array, order: int) -> Array:
    """The smoothed β(t) for 0 <= t < t₀, or a derivative of it in t."""
    return _CUBICS[order](np.minimum(t / _T0, 1.0)) / _T0**order


class Shell:
    """ε = ½ w* α², the bending energy of discrete shells (paper, Sec. 4.1); star = w* α / sin α.

    The star diverges at α = π, where the value is set to +inf.
    """

    label = "Shell"
    description = "Square of the bending angle, with inverse cotangent weights; as brittle as these"
    sites: tuple[str, ...] = _ON_FACES
    quadratic = False

    def value(self, c: Array, links: Links) -> Array:
        return np.where(c <= -1.0, np.inf, 0.5 * links.weights * _angle(c) ** 2)

    def star(self, c: Array, links: Links) -> Array:
        with np.errstate(divide="ignore"):
            return links.weights / np.sinc(np.where(c <= -1.0, 1.0, _angle(c) / np.pi)) + _infinite(c, links)

    def dstar(self, c: Array, links: Links) -> Array:
        """-w* (sin α - α cos α) / sin³ α."""
        angle = _angle(c)
        far = np.where(angle < _SERIES, 1.0, np.where(c <= -1.0, 1.0, angle))
        direct = (np.sin(far) - far * np.cos(far)) / np.sin(far) ** 3
        return -links.weights * np.where(angle < _SERIES, _near(angle), direct) - _infinite(c, links)


_SERIES = 0.1


def _near(angle: Array) -> Array:
    """(sin α - α cos α) / sin³ α by its series, exact to rounding for α < 0.1."""
    s = angle**2
    return 1.0 / 3.0 + s * (2.0 / 15.0 + s * (2.0 / 63.0 + s * (4.0 / 675.0 + s * (2.0 / 2079.0))))


def _infinite(c: Array, links: Links) -> Array:
    """Zero; at c = -1 infinite with the sign of the weight."""
    return np.where(c <= -1.0, np.copysign(np.inf, links.weights), 0.0)


def _angle(c: Array) -> Array:
    """α = arccos c, accurate at both ends."""
    return 2.0 * np.arctan2(np.sqrt(np.maximum(1.0 - c, 0.0)), np.sqrt(np.maximum(1.0 + c, 0.0)))


class Tan:
    """ε = 2 w* log sec² (α/2) = -2 w* log ½ (1 + c) (paper, Sec. 4.1, after Bobenko and Suris); +inf at c = -1.

    star = 2 w* / (1 + c).
    """

    label = "Tangent"
    description = "Keeps neighbouring normals from becoming opposite; inverse cotangent weights, as brittle as these"
    sites: tuple[str, ...] = _ON_FACES
    quadratic = False

    def value(self, c: Array, links: Links) -> Array:
        half = 0.5 * (1.0 + c)
        return np.where(half <= 0.0, np.inf, -2.0 * links.weights * np.log(np.where(half > 0.0, half, 1.0)))

    def star(self, c: Array, links: Links) -> Array:
        return 2.0 * links.weights / np.where(c > -1.0, 1.0 + c, 1.0) + _infinite(c, links)

    def dstar(self, c: Array, links: Links) -> Array:
        return -2.0 * links.weights / np.where(c > -1.0, 1.0 + c, 1.0) ** 2 - _infinite(c, links)


ENERGIES: dict[str, EdgeEnergy] = {
    "cotan": Cotan(),
    "dual_cotan": DualCotan(),
    "mobius": Mobius(),
    "shell": Shell(),
    "tan": Tan(),
}


def energy_on(name: str, sites: str) -> EdgeEnergy:
    """The energy of that name on that kind of site; at faces "cotan" is the dual one.

    Raises `ConditionError` for an unknown name, and for an energy that is not defined there.
    """
    check_choice(name, ENERGIES, "energy")
    if name == "cotan" and sites in _ON_FACES:
        return ENERGIES["dual_cotan"]
    if sites not in ENERGIES[name].sites:
        fitting = ", ".join(key for key, energy in ENERGIES.items() if sites in energy.sites)
        raise ConditionError(
            f"The energy {name!r} is not defined for normals on {sites}; choose {fitting}, or normals on "
            f"{' or '.join(ENERGIES[name].sites)}."
        )
    return ENERGIES[name]
