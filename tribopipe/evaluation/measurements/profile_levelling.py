"""The unworn surface in a profile across a wear track, by which the profile is leveled, and where the track is."""

import math
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column, robust_deviation
from tribopipe.base.errors import FitError
from tribopipe.base.units import show
from tribopipe.physics.autocorrelation import inflation
from tribopipe.physics.geometry import cap_height

Mask = NDArray[np.bool_]
Form = Literal["line", "parabola", "arc"]
"""Assumed shape of the unworn surface."""

_FIRST_SHOULDER, _FIRST_CURVED_SHOULDER = 0.1, 0.25
"""Share of the points at either end that shoulders are first taken to be: of a line or crown, of a parabola."""
_LONGER_SHOULDER = 0.15
"""The same of a crown whose radius is not quite the one stated."""
_LEAST_SHOULDER, _FEWEST_ON_SHOULDER = 0.02, 4
"""Share and number of the points that must lie on either side of the track."""
SMOOTHING, _SMOOTHING_OF_TRACK = 0.02, 0.04
"""Share of all points that are averaged where the track is looked for, and most of those in the track."""
_STANDS_OUT = 4.0
"""Standard deviations of the noise beyond which a point is no noise."""
_IN_NOISE = 1.0
"""Standard deviations of the noise, smoothed, within which the surface is no longer off the unworn one."""
_IN_FORM = 0.02
"""Share of the depth by which the unworn surface may be of another form than it is taken to be."""
_CLEARLY_CURVED = 4.0
"""Standard uncertainties by which the curvature of a flat specimen must differ from zero to be taken for one."""
_CURVED_SHOULDERS = 0.4
"""Least share of the points that show that curvature."""
_BESIDE_PILE_UP = 0.5
"""Share of its width with piled-up material that may still belong to it."""
_DUST_WIDTH, _DUST_NOISE, _DUST_DEPTH = 0.005, 5.0, 0.03
"""Limits for dust: maximum share of points; minimum height over the noise, and over the depth."""
_ROUNDING = 1e-9
"""Share of the profile's height that may be rounding."""
_MOST_ROUNDS, _MOST_STEPS, _CONVERGED = 60, 30, 1e-12


@dataclass(frozen=True)
class Unworn:
    """The surface before it was worn."""

    crown_radius: float | None
    offset: float
    """z₀, m."""
    sideways: float = 0.0
    """x_c of a crown, m, or t of a flat specimen."""
    bend: float | None = None
    """b of a flat specimen that is curved, 1/m; none of a line."""

    @property
    def form(self) -> Form:
        """What it is."""
        if self.crown_radius is not None:
            return "arc"
        return "line" if self.bend is None else "parabola"

    def _arc(self, x: Column) -> Column:
        return cap_height(scar_radius=x - self.sideways, sphere_radius=self.crown_radius or 0.0)

    def height(self, x: Column) -> Column:
        """Return the height of the surface, m."""
        if self.crown_radius is not None:
            return np.asarray(self.offset - self._arc(x))
        return np.asarray(self.offset + self.sideways * x + (self.bend or 0.0) * x**2)

    def gradients(self, x: Column) -> Column:
        """Return the derivatives of the height by its parameters, one in each column."""
        slope = x if self.crown_radius is None else (x - self.sideways) / (self.crown_radius - self._arc(x))
        bent = [] if self.bend is None else [x**2]
        return np.column_stack([np.ones_like(x), slope, *bent])

    def by_crown_radius(self, x: Column) -> Column:
        """Return the derivative of the height by r: arc/√(r² − (x − x_c)²)."""
        return np.zeros(len(x)) if self.crown_radius is None else self._arc(x) / (self.crown_radius - self._arc(x))

    def moved(self, x: Column, steps: Column) -> "Unworn":
        """Return the surface after steps of its parameters. Raises ``FitError`` where the profile would leave it."""
        bend = None if self.bend is None else self.bend + float(steps[2])
        moved = Unworn(self.crown_radius, self.offset + float(steps[0]), self.sideways + float(steps[1]), bend)
        if self.crown_radius is not None and abs(moved.sideways) + x[-1] >= self.crown_radius:
            raise FitError(
                "profile: found shoulders that do not fit a crown of radius "
                f"{show(self.crown_radius, None, 'm', 'mm')}; expected the unworn crown on both sides of the track; "
                "check the units of position and height, and crown_radius"
            )
        return moved


@dataclass(frozen=True)
class Fit:
    """The unworn surface fitted to the shoulders, and the noise that they show."""

    unworn: Unworn
    shoulders: Mask
    single: float = 0.0
    """Variance of one sample, m²."""
    variance: float = 0.0
    """The same, times the autocorrelation time."""
    rounding: float = 0.0
    """Height, m, that may be rounding."""
    hidden_bend: float = 0.0
    """Curvature that the noise of a line may hide, 1/m."""

    def solver(self, x: Column) -> Column:
        """Return the matrix that turns deviations on the shoulders into steps of the parameters."""
        gradients = self.unworn.gradients(x[self.shoulders])
        scale = np.linalg.norm(gradients, axis=0)
        return np.asarray(np.linalg.pinv(gradients / scale) / scale[:, None])

    def spread(self, x: Column, weights: Column) -> float:
        """Return the standard uncertainty of Σ weights·(unworn − measured), by first-order propagation."""
        through_fit = (weights @ self.unworn.gradients(x)) @ self.solver(x)
        noise = self.variance * float(np.dot(through_fit, through_fit) + np.dot(weights, weights))
        form = self.hidden_bend * self._off(x, weights, x**2) if self.hidden_bend else 0.0
        return math.hypot(math.sqrt(noise), form)

    def by_crown_radius(self, x: Column, weights: Column) -> float:
        """Return the derivative of Σ weights·(unworn − measured) by r, the fit following it."""
        return self._off(x, weights, self.unworn.by_crown_radius(x))

    def _off(self, x: Column, weights: Column, form: Column) -> float:
        """Return the error of Σ weights·(unworn − measured) due to a form, minus the part that the fit absorbs."""
        follows = self.unworn.gradients(x) @ (self.solver(x) @ form[self.shoulders])
        return float(weights @ (form - follows))

    def bend(self, x: Column) -> tuple[float, float]:
        """Return the curvature of a parabola, 1/m, and its standard uncertainty."""
        return self.unworn.bend or 0.0, math.sqrt(self.variance * float(np.sum(self.solver(x)[2] ** 2)))


class Worn(NamedTuple):
    """Worn range of a profile, as slices of its points; slices of piled-up material may be empty."""

    groove: slice
    left: slice
    right: slice

    @property
    def piled_up(self) -> tuple[slice, ...]:
        """Slices with piled-up material."""
        return tuple(side for side in (self.left, self.right) if side.stop > side.start)

    def stretch(self, count: int) -> slice:
        """Return everything of so many points that is no shoulder."""
        apart = [math.ceil(_BESIDE_PILE_UP * (side.stop - side.start)) for side in (self.left, self.right)]
        least = _least(count)
        return slice(max(least, self.left.start - apart[0]), min(count - least, self.right.stop + apart[1]))


def level(x: Column, z: Column, crown_radius: float | None) -> tuple[Fit, Worn]:
    """Find the unworn surface and the track, each by the other. Raises ``FitError`` where there is no track."""
    start = Unworn(crown_radius, offset=float(np.mean(z)))
    if crown_radius is not None:
        return _on_arc(x, z, start)
    curved = _curved(x, z, replace(start, bend=0.0))
    if curved is not None:
        return curved
    fit, worn = _in_turns(x, z, start, _FIRST_SHOULDER)
    return replace(fit, hidden_bend=_hidden(x, z, fit)), worn


def level_all(x: Column, z: Column, crown_radius: float | None) -> Fit:
    """Fit the unworn surface to a whole profile, but for what stands out of it."""
    start = Unworn(crown_radius, offset=float(np.mean(z)))
    if crown_radius is None:
        curved = _trimmed(x, z, replace(start, bend=0.0))
        if _is_clear(x, curved):
            return curved
    return _trimmed(x, z, start)


def _trimmed(x: Column, z: Column, start: Unworn) -> Fit:
    """Fit again and again to what did not stand out the time before."""
    fit = _fitted(x, z, start, np.ones(len(x), bool))
    for _ in range(_MOST_ROUNDS):
        before, fit = fit, _fitted(x, z, fit.unworn, fit.shoulders)
        if np.array_equal(before.shoulders, fit.shoulders):
            break
    return fit


def _on_arc(x: Column, z: Column, start: Unworn) -> tuple[Fit, Worn]:
    """Level on an arc; by longer shoulders where it is a little off, and all with the ends seems piled up."""
    try:
        return _in_turns(x, z, start, _FIRST_SHOULDER)
    except FitError:
        return _in_turns(x, z, start, _LONGER_SHOULDER)


def _curved(x: Column, z: Column, start: Unworn) -> tuple[Fit, Worn] | None:
    """Return what a parabola makes of a profile, where its shoulders clearly show one."""
    try:
        fit, worn = _in_turns(x, z, start, _FIRST_CURVED_SHOULDER)
    except FitError:
        return None
    return (fit, worn) if _is_clear(x, fit) else None


def _is_clear(x: Column, fit: Fit) -> bool:
    bend, spread = fit.bend(x)
    if np.count_nonzero(fit.shoulders) < _CURVED_SHOULDERS * len(x):
        return False
    return abs(bend) > _CLEARLY_CURVED * spread and abs(bend) * float(np.ptp(x)) ** 2 > fit.rounding


def _hidden(x: Column, z: Column, fit: Fit) -> float:
    """Return the curvature that may be hidden in the noise of a line's shoulders, by an unbiased estimate of b²."""
    unworn = _solved(x, z, replace(fit.unworn, bend=0.0), fit.shoulders)
    bend, spread = replace(fit, unworn=unworn).bend(x)
    return math.sqrt(max(0.0, bend**2 - spread**2))


def _in_turns(x: Column, z: Column, start: Unworn, share: float) -> tuple[Fit, Worn]:
    ends = max(_FEWEST_ON_SHOULDER, math.ceil(share * len(x)))
    beside, tried = slice(ends, len(x) - ends), set[tuple[int, int]]()
    fit = Fit(start, np.ones(len(x), bool))
    for _ in range(_MOST_ROUNDS):
        fit = _fitted(x, z, fit.unworn, _apart_from(beside, len(x)))
        worn = _worn(fit.unworn.height(x) - z, fit)
        beside = worn.stretch(len(x))
        if (beside.start, beside.stop) in tried:
            break
        tried.add((beside.start, beside.stop))
    if worn.left.start <= _least(len(x)) or worn.right.stop >= len(x) - _least(len(x)):
        raise _at_the_edge()
    return _fitted(x, z, fit.unworn, _apart_from(beside, len(x))), worn


def _apart_from(stretch: slice, count: int) -> Mask:
    """Return which of so many points lie outside a stretch."""
    apart = np.ones(count, bool)
    apart[stretch] = False
    return apart


def _fitted(x: Column, z: Column, start: Unworn, beside: Mask) -> Fit:
    """Fit the unworn surface with the track, first to all of it and then to what does not stand out."""
    unworn = _solved(x, z, start, beside)
    rounding = _ROUNDING * float(np.ptp(z))
    kept = _within_noise(z - unworn.height(x), beside, rounding)
    unworn = _solved(x, z, unworn, kept)
    left = z[kept] - unworn.height(x[kept])
    parameters = 2 if unworn.bend is None else 3
    return Fit(unworn, kept, float(np.var(left)), inflation(left, parameters), rounding)


def _solved(x: Column, z: Column, unworn: Unworn, shoulders: Mask) -> Unworn:
    """Fit by Gauss and Newton's steps, of which a straight line takes one."""
    for _ in range(_MOST_STEPS):
        steps = Fit(unworn, shoulders).solver(x) @ (z - unworn.height(x))[shoulders]
        unworn = unworn.moved(x, steps)
        if np.max(np.abs(unworn.gradients(x) @ steps)) <= _CONVERGED * np.ptp(z):
            break
    return unworn


def _within_noise(residuals: Column, beside: Mask, rounding: float) -> Mask:
    spread = robust_deviation(residuals[beside])
    kept = beside & (np.abs(residuals) <= _STANDS_OUT * spread + rounding)
    return kept if np.count_nonzero(kept) > np.count_nonzero(beside) / 2 else beside


def _worn(lost: Column, fit: Fit) -> Worn:
    """Return the groove around the deepest place and what is piled up next to it.

    Raises ``FitError`` where the deepest place is no deeper than noise, or the groove reaches the edge.
    """
    smooth, spread = smoothed(lost, fit)
    groove = _groove(smooth, spread, fit.rounding)
    depth, reach = float(np.max(smooth[groove])), _window(len(lost))
    least = max(_STANDS_OUT * spread + fit.rounding, _IN_FORM * depth)
    right = _pile_up(-smooth[groove.stop - 1 :], _IN_NOISE * spread + fit.rounding, least, reach)
    left = _pile_up(-smooth[: groove.start + 1][::-1], _IN_NOISE * spread + fit.rounding, least, reach)
    return Worn(
        groove,
        left=slice(groove.start + 1 - left, groove.start + 1) if left else slice(groove.start, groove.start),
        right=slice(groove.stop - 1, groove.stop - 1 + right) if right else slice(groove.stop, groove.stop),
    )


def _groove(smooth: Column, spread: float, rounding: float) -> slice:
    """Return the stretch around the deepest place up to the first points on either side that are in the noise."""
    deepest = int(np.argmax(smooth))
    if smooth[deepest] <= _STANDS_OUT * spread + rounding:
        deep = show(float(smooth[deepest]), None, "m", "um")
        raise no_track(f"no feature deeper than the noise (the deepest point is {deep} below the unworn surface)")
    at_level = np.flatnonzero(smooth <= max(_IN_NOISE * spread, _IN_FORM * smooth[deepest]) + rounding)
    before, after = at_level[at_level < deepest], at_level[at_level > deepest]
    least = _least(len(smooth))
    if not len(before) or not len(after) or before[-1] < least or after[0] >= len(smooth) - least:
        raise _at_the_edge()
    return slice(int(before[-1]), int(after[0]) + 1)


def _pile_up(gained: Column, level: float, least: float, reach: int) -> int:
    """Return how many points outwards from the edge of the groove material is piled up; 0 where none stands out."""
    begins = int(np.argmax(gained > level))
    if gained[begins] <= level or begins > reach:
        return 0
    ends = begins + _first(gained[begins:] <= level)
    top = begins + int(np.argmax(gained[begins:ends]))
    if gained[top] <= least:
        return 0
    return top + _first(gained[top:] <= max(level, _IN_FORM * gained[top]))


def _first(found: Mask) -> int:
    """Return the place of the first that is true, or the number of all where none is."""
    return int(np.argmax(found)) if np.any(found) else len(found)


def _least(count: int) -> int:
    return max(_FEWEST_ON_SHOULDER, math.ceil(_LEAST_SHOULDER * count))


def _window(count: int) -> int:
    """Return how many points are averaged where the track is looked for."""
    return _odd(SMOOTHING * count)


def _odd(length: float) -> int:
    return 2 * int(length / 2) + 1


def find_dust(lost: Column, fit: Fit, depth: float) -> Mask:
    """Return the points under narrow spikes that stand up from what is on both sides of them."""
    from scipy.ndimage import binary_dilation, median_filter, white_tophat

    widest = max(2, math.ceil(_DUST_WIDTH * len(lost)))
    above = median_filter(lost, 2 * widest + 1, mode="nearest") - lost
    noise, form = math.sqrt(fit.single), _DUST_DEPTH * depth + fit.rounding
    # Unlike the median, an opening follows the rim of a steep wall.
    spikes = (above > _DUST_NOISE * noise) & (white_tophat(-lost, widest + 1, mode="nearest") > form) & (above > form)
    return np.asarray(binary_dilation(spikes, iterations=widest, mask=above > max(_DUST_NOISE / 2 * noise, form / 2)))


def windows(fit: Fit, noise: float, count: int, track: slice) -> list[int]:
    """Return over how many points a track that is known is averaged, narrow to wide, each some twice the one before.

    The narrowest leaves no more than this noise, m, if any does.
    """
    widest = min(_window(count), _odd(_SMOOTHING_OF_TRACK * (track.stop - track.start)))
    least = fit.variance / noise**2 if fit.single > noise**2 else 1.0
    halvings = int(math.log2(max(widest / least, 1.0)))
    return [_odd(widest / 2**halving) for halving in range(halvings, -1, -1)]


def smoothed(lost: Column, fit: Fit, window: int | None = None) -> tuple[Column, float]:
    """Return the moving average of what was lost, and its standard deviation by noise, m."""
    window = window or _window(len(lost))
    padded = np.pad(lost, window // 2, mode="reflect")
    smooth = np.convolve(padded, np.full(window, 1 / window), mode="valid")
    return smooth, math.sqrt(min(fit.single, fit.variance / window))


def no_track(found: str) -> FitError:
    """Report that a profile has no wear track."""
    return FitError(
        f"profile: found {found}; expected a wear track with unworn surface on both sides; check that heights increase "
        "outward from the disc and that the profile is long enough, or remove the profile from run.toml"
    )


def _at_the_edge() -> FitError:
    return FitError(
        "profile: found a track that reaches the edge of the profile; expected unworn surface on both sides for "
        "leveling; measure a longer profile, and check the radius if the profile crosses a ball or a crown"
    )
