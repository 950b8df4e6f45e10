"""What a profile across a wear track says: cross-section lost, width and depth of the track.

The unworn surface is fitted to the shoulders on either side of the track. On a flat disc it is a straight line, on a
disc with a crown of known radius r an arc of that radius; offset z₀, tilt t and centre x_c are free:

    z = z₀ + t·x  (flat),     z = z₀ − arc(x − x_c),  arc(x) = r − √(r² − x²)  (crown)

A circle that is tilted is a circle, so that x_c takes in the tilt of a crown. Software that levels a profile shears it
instead, which changes the curvature by 3t²/2 of itself: by 5·10⁻⁴ at 1°.

Shoulders and track are found in turns, beginning with a tenth of the profile at either end as shoulders. The track is
the contiguous stretch around the deepest place in which the surface, smoothed, lies below the unworn one by more than
the shoulders' noise. Dust on the shoulders and material piled up there stand out of it and are left out of the fit.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tribopipe.errors import FitError
from tribopipe.geometry import cap_height
from tribopipe.noise import inflation
from tribopipe.records.quantity import Quantity
from tribopipe.run import Column, Profile
from tribopipe.units import show

Mask = NDArray[np.bool_]

_FIRST_SHOULDER = 0.1
_LEAST_SHOULDER, _FEWEST_ON_SHOULDER = 0.02, 4
"""Share and number of the points that must lie on either side of the track."""
_SMOOTHING = 0.02
"""Share of the points that are averaged where the track is looked for."""
_STANDS_OUT = 4.0
"""Standard deviations of the noise beyond which a point is no noise."""
_IN_NOISE = 1.0
"""Standard deviations of the noise, smoothed, within which the surface is no longer below the unworn one."""
_IN_FORM = 0.02
"""Share of the depth by which the unworn surface may be of another form than it is taken to be."""
_CERTAIN = 5.0
"""Standard uncertainties by which a cross-section must exceed zero."""
_WALL = (0.1, 0.3)
"""Shares of the depth through which a track's wall is followed up to the unworn surface."""
_MAD = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""
_ROUNDING = 1e-9
"""Share of the profile's height that may be rounding."""
_MOST_ROUNDS, _MOST_STEPS, _CONVERGED = 60, 30, 1e-12


@dataclass(frozen=True)
class Track:
    """A wear track by one profile across it."""

    area: Quantity
    """Cross-section lost below the unworn surface, m², with its standard uncertainty."""
    width: Quantity
    """m: between the places where the surface comes up to the unworn one."""
    depth: Quantity
    """m: below the unworn surface where the track is deepest."""
    bounds: tuple[float, float]
    """Where the track begins and ends, m, in the profile's positions."""
    unworn: Column
    """Height of the unworn surface at each position of the profile, m."""
    area_per_crown_radius: float
    """∂area/∂r, m: what an error of the crown radius does to the area; 0 on a flat disc."""


def worn_area(profile: Profile, crown_radius: float | None) -> Track:
    """Return the track that wear has left across a disc whose crown has this radius, m; none for a flat disc.

    Its cross-section is A = ∫(unworn − measured)dx, m², by trapezoids from bound to bound. Within them single samples
    above the unworn surface count against it, so that noise cancels. Material piled up beside the track lies outside
    them and is not set against what was lost. Of several tracks the one with the deepest place is taken.

    The standard uncertainty is the shoulders' noise, in as many independent samples as it holds, in the fit of the
    unworn surface and in the track itself, to first order, and what lies between the bounds and where the walls lead
    to. That of the crown radius is not in it. It is too small where the shoulders hold fewer than some 20 independent
    samples.

    Raises ``FitError`` where there is no track, or it reaches the edge of the profile.
    """
    middle = float(profile.position[0] + profile.position[-1]) / 2
    x, z = profile.position - middle, profile.height
    if crown_radius is not None and x[-1] >= crown_radius:
        raise FitError(
            f"profile: found one {show(float(2 * x[-1]), None, 'm', 'mm')} long across a crown of radius "
            f"{show(crown_radius, None, 'm', 'mm')}; expected one shorter than the crown is wide; check the unit of "
            "its positions, and crown_radius"
        )
    fit, stretch = _levelled(x, z, crown_radius)
    return _measured(x, z, fit, stretch, middle)


@dataclass(frozen=True)
class _Unworn:
    """The surface before it was worn."""

    crown_radius: float | None
    offset: float
    """z₀, m."""
    sideways: float = 0.0
    """x_c of a crown, m, or t of a flat disc."""

    def _arc(self, x: Column) -> Column:
        return cap_height(scar_radius=x - self.sideways, sphere_radius=self.crown_radius or 0.0)

    def height(self, x: Column) -> Column:
        """Return z₀ + t·x or z₀ − arc(x − x_c), m."""
        return np.asarray(self.offset + (self.sideways * x if self.crown_radius is None else -self._arc(x)))

    def gradients(self, x: Column) -> Column:
        """Return the derivatives of the height by z₀ and t or x_c, in two columns."""
        slope = x if self.crown_radius is None else (x - self.sideways) / (self.crown_radius - self._arc(x))
        return np.column_stack([np.ones_like(x), slope])

    def by_crown_radius(self, x: Column) -> Column:
        """Return the derivative of the height by r: arc/√(r² − (x − x_c)²)."""
        return np.zeros(len(x)) if self.crown_radius is None else self._arc(x) / (self.crown_radius - self._arc(x))

    def moved(self, x: Column, steps: Column) -> "_Unworn":
        """Return the surface after steps of its parameters. Raises ``FitError`` where the profile would leave it."""
        moved = _Unworn(self.crown_radius, self.offset + float(steps[0]), self.sideways + float(steps[1]))
        if self.crown_radius is not None and abs(moved.sideways) + x[-1] >= self.crown_radius:
            raise FitError(
                "profile: found shoulders that fit no crown of radius "
                f"{show(self.crown_radius, None, 'm', 'mm')}; expected the unworn crown on both sides of the track; "
                "check the units of position and height, and crown_radius"
            )
        return moved


@dataclass(frozen=True)
class _Fit:
    """The unworn surface fitted to the shoulders, and the noise that they show."""

    unworn: _Unworn
    shoulders: Mask
    single: float = 0.0
    """Variance of one sample, m²."""
    variance: float = 0.0
    """The same, times the autocorrelation time."""
    rounding: float = 0.0
    """Height, m, that may be rounding."""

    def solver(self, x: Column) -> Column:
        """Return the matrix that turns deviations on the shoulders into steps of the parameters."""
        gradients = self.unworn.gradients(x[self.shoulders])
        scale = np.linalg.norm(gradients, axis=0)
        return np.asarray(np.linalg.pinv(gradients / scale) / scale[:, None])

    def spread(self, x: Column, weights: Column) -> float:
        """Return the standard uncertainty of Σ weights·(unworn − measured), to first order."""
        through_fit = (weights @ self.unworn.gradients(x)) @ self.solver(x)
        return math.sqrt(self.variance * float(np.dot(through_fit, through_fit) + np.dot(weights, weights)))

    def by_crown_radius(self, x: Column, weights: Column) -> float:
        """Return the derivative of Σ weights·(unworn − measured) by r, the fit following it."""
        slope = self.unworn.by_crown_radius(x)
        follows = self.unworn.gradients(x) @ (self.solver(x) @ slope[self.shoulders])
        return float(weights @ (slope - follows))


def _levelled(x: Column, z: Column, crown_radius: float | None) -> tuple[_Fit, slice]:
    """Find the unworn surface and the track, each by the other."""
    ends = max(_FEWEST_ON_SHOULDER, math.ceil(_FIRST_SHOULDER * len(x)))
    track, tried = slice(ends, len(x) - ends), set[tuple[int, int]]()
    fit = _Fit(_Unworn(crown_radius, offset=float(np.mean(z))), np.ones(len(x), bool))
    for _ in range(_MOST_ROUNDS):
        fit = _fitted(x, z, fit.unworn, track)
        track = _stretch(fit.unworn.height(x) - z, fit)
        if (track.start, track.stop) in tried:
            break
        tried.add((track.start, track.stop))
    return _fitted(x, z, fit.unworn, track), track


def _fitted(x: Column, z: Column, start: _Unworn, track: slice) -> _Fit:
    """Fit the unworn surface beside the track, first to all of it and then to what does not stand out."""
    beside = np.ones(len(x), bool)
    beside[track] = False
    unworn = _solved(x, z, start, beside)
    rounding = _ROUNDING * float(np.ptp(z))
    kept = _within_noise(z - unworn.height(x), beside, rounding)
    unworn = _solved(x, z, unworn, kept)
    left = z[kept] - unworn.height(x[kept])
    return _Fit(unworn, kept, float(np.var(left)), inflation(left, 2), rounding)


def _solved(x: Column, z: Column, unworn: _Unworn, shoulders: Mask) -> _Unworn:
    """Fit by Gauss and Newton's steps, of which a straight line takes one."""
    for _ in range(_MOST_STEPS):
        steps = _Fit(unworn, shoulders).solver(x) @ (z - unworn.height(x))[shoulders]
        unworn = unworn.moved(x, steps)
        if np.max(np.abs(unworn.gradients(x) @ steps)) <= _CONVERGED * np.ptp(z):
            break
    return unworn


def _within_noise(residuals: Column, beside: Mask, rounding: float) -> Mask:
    spread = _MAD * float(np.median(np.abs(residuals[beside])))
    kept = beside & (np.abs(residuals) <= _STANDS_OUT * spread + rounding)
    return kept if np.count_nonzero(kept) > np.count_nonzero(beside) / 2 else beside


def _stretch(lost: Column, fit: _Fit) -> slice:
    """Return the stretch around the deepest place up to the first points on either side that are in the noise.

    Raises ``FitError`` where the deepest place is no deeper than noise, or the stretch reaches the edge.
    """
    smooth, spread = _smoothed(lost, fit)
    deepest = int(np.argmax(smooth))
    if smooth[deepest] <= _STANDS_OUT * spread + fit.rounding:
        deep = show(float(smooth[deepest]), None, "m", "um")
        raise _no_track(f"no place that stands out of the noise beside it, the deepest {deep} below the unworn surface")
    level = np.flatnonzero(smooth <= max(_IN_NOISE * spread, _IN_FORM * smooth[deepest]) + fit.rounding)
    before, after = level[level < deepest], level[level > deepest]
    least = max(_FEWEST_ON_SHOULDER, math.ceil(_LEAST_SHOULDER * len(lost)))
    if not len(before) or not len(after) or before[-1] < least or after[0] >= len(lost) - least:
        raise FitError(
            "profile: found a track that reaches the edge of the profile; expected unworn surface on both sides, by "
            "which it is levelled; measure a longer profile"
        )
    return slice(int(before[-1]), int(after[0]) + 1)


def _smoothed(lost: Column, fit: _Fit) -> tuple[Column, float]:
    """Return the moving average of what was lost, and its standard deviation by noise, m."""
    reach = int(_SMOOTHING * len(lost) / 2)
    padded = np.pad(lost, reach, mode="reflect")
    smooth = np.convolve(padded, np.full(2 * reach + 1, 1 / (2 * reach + 1)), mode="valid")
    return smooth, math.sqrt(min(fit.single, fit.variance / (2 * reach + 1)))


def _no_track(found: str) -> FitError:
    return FitError(
        f"profile: found {found}; expected a wear track with unworn surface on both sides; check that heights count "
        "upwards, out of the disc, and that the profile is long enough, or take it out of run.toml"
    )


class _Edge(NamedTuple):
    """Where the track ends on one side, m."""

    position: float
    spread: float


def _measured(x: Column, z: Column, fit: _Fit, track: slice, middle: float) -> Track:
    """Measure the track. Raises ``FitError`` where its cross-section is no larger than its uncertainty lets it be."""
    lost = fit.unworn.height(x) - z
    steps = np.diff(x[track])
    weights = np.zeros(len(x))
    weights[track] = (np.append(steps, 0.0) + np.append(0.0, steps)) / 2
    left, right = (_edge(x, lost, fit, track, side) for side in (-1, 1))
    ends = [_between(x, lost, *pair) for pair in ((left.position, x[track][0]), (right.position, x[track][-1]))]
    spread = math.hypot(fit.spread(x, weights), *ends)
    area = Quantity(value=float(weights @ lost), unit="m^2", standard_uncertainty=spread)
    if area.value <= _CERTAIN * spread:
        raise _no_track(f"a cross-section of {area.shown('um^2')} below the unworn surface")
    return Track(
        area=area,
        width=Quantity(
            value=right.position - left.position, unit="m", standard_uncertainty=math.hypot(left.spread, right.spread)
        ),
        depth=_depth(x, lost, fit, track),
        bounds=(left.position + middle, right.position + middle),
        unworn=fit.unworn.height(x),
        area_per_crown_radius=fit.by_crown_radius(x, weights),
    )


def _edge(x: Column, lost: Column, fit: _Fit, track: slice, side: int) -> _Edge:
    """Return where the wall of the track comes up to the unworn surface.

    By two heights on the wall, carried on as the wall of a parabola, which a flat worn on a crown is.
    """
    smooth, spread = _smoothed(lost, fit)
    deepest = track.start + int(np.argmax(smooth[track]))
    depth = float(smooth[deepest])
    low = min(_WALL[0] + 2 * spread / depth, 0.5)
    high = low + _WALL[1] - _WALL[0]
    outer, inner = (_crossing(x, smooth, deepest, side, share * depth) for share in (low, high))
    ahead = (1 - math.sqrt(1 - low)) / (math.sqrt(1 - low) - math.sqrt(1 - high))
    wall = abs(outer - inner) / ((high - low) * depth)
    grid = float(x[-1] - x[0]) / len(x) / math.sqrt(12)
    noise = math.hypot(1 + ahead, ahead) * spread * wall
    return _Edge(outer + ahead * (outer - inner), math.hypot(noise, grid))


def _between(x: Column, lost: Column, one: float, other: float) -> float:
    """Return what was lost between two places, m²: that much is uncertain where a track may end at either."""
    between = (x >= min(one, other)) & (x <= max(one, other))
    return float(np.sum(lost[between] * np.gradient(x)[between]))


def _crossing(x: Column, smooth: Column, deepest: int, side: int, level: float) -> float:
    """Return where, going outwards from the deepest place, the track first is no deeper than a level, m."""
    onwards = slice(deepest, None) if side > 0 else slice(deepest, None, -1)
    heights, positions = smooth[onwards], x[onwards]
    first = int(np.argmax(heights < level))
    share = (heights[first - 1] - level) / (heights[first - 1] - heights[first])
    return float(positions[first - 1] + share * (positions[first] - positions[first - 1]))


def _depth(x: Column, lost: Column, fit: _Fit, track: slice) -> Quantity:
    """Return what was lost at the deepest place, m, by the top of a parabola through half of the track."""
    smooth, _ = _smoothed(lost, fit)
    deepest = track.start + int(np.argmax(smooth[track]))
    away = (x - x[deepest]) / (x[track][-1] - x[track][0])
    near = np.abs(away) <= 0.25
    near[: track.start] = near[track.stop :] = False
    if np.count_nonzero(near) < 3:
        near = np.abs(np.arange(len(x)) - deepest) <= 1
    parabola = np.linalg.pinv(np.vander(away[near], 3, increasing=True))
    _, slope, curvature = parabola @ lost[near]
    at = float(np.clip(-slope / (2 * curvature), -0.25, 0.25)) if curvature < 0 else 0.0
    weights = np.zeros(len(x))
    weights[near] = [1.0, at, at**2] @ parabola
    return Quantity(value=float(weights @ lost), unit="m", standard_uncertainty=fit.spread(x, weights))
