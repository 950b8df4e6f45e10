"""Worn and piled-up areas, width, depth and volumes from a profile across a wear track or a worn tip."""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.base.units import show
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.measurements.profile_gaps import Filled, filled
from tribopipe.evaluation.measurements.profile_levelling import (
    SMOOTHING,
    Fit,
    Form,
    Mask,
    Worn,
    find_dust,
    level,
    level_all,
    no_track,
    smoothed,
    windows,
)
from tribopipe.results.run import Profile

_CERTAIN = 5.0
"""Standard uncertainties by which a cross-section must exceed zero."""
_WALL = (0.065, 0.25, 0.55)
"""Shares of the depth at which a track's wall is looked for, to be carried on up to the unworn surface."""
_LEFT_ON_WALL, _LEFT_ON_FLOOR = 0.04, 0.006
"""Shares of the depth that the noise may have where smoothed least: on the walls, and to find the deepest place."""
_AS_DEEP = 6.0
"""Standard deviations of the noise, smoothed, by which it may hide that a place is less deep than another."""
_ABOUT_THE_DEEPEST = 0.25
"""Most of the width on either side of the deepest place by which the depth is measured."""
_MOST_MISSING = 0.5
"""Share of the width of a track that may lie in one gap between heights."""
GAP_REMEDY = "measure the profile again with more light or a larger aperture"
_AGREE, _CLEAR = 3.0, 3.0
"""Standard uncertainties: within which estimates agree; beyond which a floor is clearly not level."""


@dataclass(frozen=True)
class Track:
    """A wear track, or the flat on a worn tip, by one profile across it."""

    area: Quantity
    """Cross-section lost below the unworn surface, m², with its standard uncertainty."""
    pile_up: Quantity
    """Cross-section gained next to it above the unworn surface, m²; zero where nothing stands out of the noise."""
    net_area: Quantity
    """Worn minus piled-up area, m²."""
    width: Quantity
    """m: between the places where the surface comes up to the unworn one."""
    depth: Quantity
    """m: below the unworn surface where the track is deepest."""
    cap: Quantity
    """m³: volume lost were it a body of revolution about the middle of the track: the cap of a ball, flat or not."""
    bounds: tuple[float, float]
    """Positions of both edges of the wear track, m."""
    ridges: tuple[tuple[float, float], ...]
    """Start and end of each ridge of piled-up material, m, from left to right."""
    unworn: Column
    """Height of the unworn surface at each position of the profile, m."""
    reference: Mask
    """Mask of the points to which the unworn surface was fitted."""
    dust: Mask
    """Mask of the points under dust, which were bridged."""
    gap: float
    """Share of the width in the widest gap between heights, which was filled; 0 where none is wide."""
    roughness: float
    """Standard deviation of the heights next to the track, m, by roughness and noise."""
    form: Form
    """Assumed shape of the unworn surface."""
    area_per_crown_radius: float
    """∂area/∂r, m: what an error of the crown radius does to the area; 0 on a flat specimen."""
    cap_per_crown_radius: float
    """∂cap/∂r, m²."""


@dataclass(frozen=True)
class Level:
    """A profile in which no track was found."""

    unworn: Column
    """Height of the surface at each position of the profile, m."""
    reference: Mask
    """Mask of the points to which it was fitted."""
    form: Form
    """Assumed shape of the surface."""
    why: str
    """Why it is no track."""


def worn_area(profile: Profile, crown_radius: float | None) -> Track:
    """Return the wear track across a surface with this crown radius, m; a radius of None stands for a flat surface.

    The radius is that of a disc's crown across the track, or of a ball, of which the track is the flat worn on it: its
    width is the diameter of the scar, if the profile leads through its middle.

    Its cross-section is A = ∫(unworn − measured)dx, m², by trapezoids from bound to bound. Within them single samples
    above the unworn surface count against it, so that noise cancels. Material piled up next to the track lies outside
    them and is measured by itself. Of several tracks the one with the deepest place is taken.

    The standard uncertainty is the shoulders' noise, in as many independent samples as it holds, in the fit of the
    unworn surface and in the track itself, by first-order propagation, and what lies between the bounds and where the
    walls lead to. That of the crown radius is not in it. It is too small where the shoulders hold fewer than some 20
    independent samples.

    Wide gaps between heights are filled by a smooth continuation of both sides. What a straight line across them would
    leave out is uncertain.

    Width and depth are taken by as many points as the shape of the track lets be; that of the width also holds how far
    the walls are no parabola's, by which a wall that runs out slowly is taken too narrow.

    Raises ``FitError`` where there is no track, it reaches the edge of the profile, or heights are missing in most of
    it.
    """
    x, z, middle = _centred(profile, crown_radius)
    fit, worn = level(x, z, crown_radius)
    lost = fit.unworn.height(x) - z
    dust = find_dust(lost, fit, float(np.max(smoothed(lost, fit)[0])))
    if np.any(dust):
        z = np.interp(x, x[~dust], z[~dust])
        fit, worn = level(x, z, crown_radius)
    if (whole := filled(x, z, fit, worn)) is not None:
        return _across_gaps(whole, crown_radius, _Place(middle, whole.spread(dust)))
    return _measured(x, z, fit, worn, _Place(middle, dust))


def _across_gaps(whole: Filled, crown_radius: float | None, place: "_Place") -> Track:
    """Measure a track with filled gaps, uncertain by what the heights in them may be off."""
    track, other = (
        _measured(whole.x, z, *level(whole.x, z, crown_radius), place) for z in (whole.z, whole.z - whole.off)
    )
    widest = whole.widest / track.width.value
    if widest > _MOST_MISSING:
        raise FitError(
            f"profile: found {gap_in_words(widest)}; expected at most {100 * _MOST_MISSING:.0f} %; {GAP_REMEDY}"
        )
    edges = [whole.within(bound - place.middle) for bound in track.bounds]
    return replace(
        track,
        area=_off(track.area, other.area),
        pile_up=_off(track.pile_up, other.pile_up),
        net_area=_off(track.net_area, other.net_area),
        width=_off(track.width, other.width, *edges),
        depth=_off(track.depth, other.depth),
        cap=_off(track.cap, other.cap),
        unworn=track.unworn[whole.measured],
        reference=track.reference[whole.measured],
        dust=track.dust[whole.measured],
        gap=widest,
    )


def gap_in_words(share: float) -> str:
    """Return what a gap over this share of the width of a track is called in messages."""
    return f"a gap without heights over {100 * share:.0f} % of the width of the wear track"


def gap_found(share: float) -> str:
    """Return what was found and expected where such a gap is filled."""
    return (
        f"found {gap_in_words(share)}; expected heights across the whole track; they are interpolated there, and area "
        "and depth are more uncertain"
    )


def _off(one: Quantity, other: Quantity, *more: float) -> Quantity:
    """Return a quantity with its difference from another, and more, as parts of its standard uncertainty."""
    spread = math.hypot(one.u_or_zero, one.value - other.value, *more)
    return one.model_copy(update={"standard_uncertainty": spread})


def examined(profile: Profile, crown_radius: float | None) -> Track | Level:
    """Return the track across a profile, or the profile leveled where it has none.

    Raises ``FitError`` where the profile does not fit the radius.
    """
    try:
        return worn_area(profile, crown_radius)
    except FitError as error:
        x, z, _ = _centred(profile, crown_radius)
        fit = level_all(x, z, crown_radius)
        why = str(error).removeprefix("profile: ")
        return Level(fit.unworn.height(x), fit.shoulders, fit.unworn.form, why)


def reference_radius(manifest: RunManifest, key: str) -> Quantity | None:
    """Return the radius of the unworn surface that a profile leads across, by its key; None if that is flat."""
    round_surfaces = {} if manifest.contact is None else manifest.contact.round_surfaces
    return next((radius for role, radius in round_surfaces.items() if f".{role}_profile" in key), None)


def _centred(profile: Profile, crown_radius: float | None) -> tuple[Column, Column, float]:
    """Return position about the middle of a profile, height, and that middle, m."""
    middle = float(profile.position[0] + profile.position[-1]) / 2
    x = profile.position - middle
    if crown_radius is not None and x[-1] >= crown_radius:
        raise FitError(
            f"profile: found a profile {show(float(2 * x[-1]), None, 'm', 'mm')} long across a crown of radius "
            f"{show(crown_radius, None, 'm', 'mm')}; expected a length less than the width of the crown; check the "
            "unit of the positions, and crown_radius"
        )
    return x, profile.height, middle


class _Place(NamedTuple):
    """Points removed from a profile before its evaluation."""

    middle: float
    """m."""
    dust: Mask


class _Estimate(NamedTuple):
    """A length, m, and its standard uncertainty."""

    value: float
    spread: float


class _Edge(NamedTuple):
    """Edge of the wear track on one side."""

    position: _Estimate
    bent: _Estimate
    """How much farther outwards that is than where the wall leads to from farther down: 0 for a parabola's."""
    halfway: float
    """Between the two, m."""


def _measured(x: Column, z: Column, fit: Fit, worn: Worn, place: _Place) -> Track:
    """Measure the track. Raises ``FitError`` where its cross-section is no larger than its uncertainty lets it be."""
    lost, track, middle = fit.unworn.height(x) - z, worn.groove, place.middle
    weights = _Weights.over(x, track)
    depth = _depth(x, lost, fit, track)
    left, right = (_edge(x, lost, fit, track, side, depth.value) for side in (-1, 1))
    bounds = left.position.value, right.position.value
    ends = [_between(x, lost, left.halfway, x[track][0]), _between(x, lost, right.halfway, x[track][-1])]
    area = _weighed(x, lost, fit, weights, "m^2", *ends)
    if area.value <= _CERTAIN * area.u_or_zero:
        raise no_track(f"a cross-sectional area of {area.shown('um^2')} below the unworn surface")
    beside = _Weights.over(x, worn.left, worn.right).times(-1.0)
    tails = [_tail(x, lost, fit, side, outwards) for side, outwards in ((worn.left, -1), (worn.right, 1))]
    centre = float(weights.fine @ (x * lost)) / area.value
    lean = _lean(fit, centre)
    width = (bounds[1] - bounds[0]) / lean
    turned = weights.times(math.pi / lean * np.abs(x - centre))
    return Track(
        area=area,
        pile_up=_weighed(x, lost, fit, beside, "m^2", *tails, *(end for end in ends if worn.piled_up)),
        net_area=_weighed(x, lost, fit, _Weights.over(x, *worn), "m^2", *tails),
        width=Quantity(value=width, unit="m", standard_uncertainty=_spread_of_width(left, right)),
        depth=Quantity(value=lean * depth.value, unit="m", standard_uncertainty=lean * depth.spread),
        cap=_weighed(x, lost, fit, turned, "m^3", *(math.pi * width / 2 * end for end in ends)),
        bounds=(bounds[0] + middle, bounds[1] + middle),
        ridges=tuple((float(x[side][0]) + middle, float(x[side][-1]) + middle) for side in worn.piled_up),
        unworn=fit.unworn.height(x),
        reference=fit.shoulders & ~place.dust,
        dust=place.dust,
        gap=0.0,
        roughness=math.sqrt(fit.single),
        form=fit.unworn.form,
        area_per_crown_radius=fit.by_crown_radius(x, weights.fine),
        cap_per_crown_radius=fit.by_crown_radius(x, turned.fine),
    )


class _Weights(NamedTuple):
    """Weights with which heights add up to an area or a volume: for all points, and for every second point."""

    fine: Column
    coarse: Column

    @classmethod
    def over(cls, x: Column, *stretches: slice) -> "_Weights":
        """Return the weights of an area, m."""
        return cls(
            sum((_trapezoids(x, one) for one in stretches), np.zeros(len(x))),
            sum((_trapezoids(x, one, 2) for one in stretches), np.zeros(len(x))),
        )

    def times(self, factor: Column | float) -> "_Weights":
        """Return the weights of what is multiplied by a factor at each point."""
        return _Weights(self.fine * factor, self.coarse * factor)


def _lean(fit: Fit, centre: float) -> float:
    """Return the cosine of the angle by which a ball lay turned, its flat next to the top of the arc; 1 if flat."""
    radius = fit.unworn.crown_radius
    return 1.0 if radius is None else math.sqrt(1 - ((centre - fit.unworn.sideways) / radius) ** 2)


def _trapezoids(x: Column, stretch: slice, every: int = 1) -> Column:
    """Return the weights by which heights at every so many points of a stretch add up to an area, m."""
    weights = np.zeros(len(x))
    points = np.arange(stretch.start, stretch.stop, every)
    if len(points) < 2:
        return weights
    points[-1] = stretch.stop - 1
    steps = np.diff(x[points])
    weights[points] = (np.append(steps, 0.0) + np.append(0.0, steps)) / 2
    return weights


def _weighed(x: Column, lost: Column, fit: Fit, by: "_Weights", unit: str, *ends: float) -> Quantity:
    """Return Σ weights·lost, uncertain by noise and fit, by where it ends, and by how far apart the points are."""
    value = float(by.fine @ lost) + 0.0
    sampling = (float(by.coarse @ lost) - value) / 3
    spread = math.hypot(fit.spread(x, by.fine), sampling, *ends)
    return Quantity(value=value, unit=unit, standard_uncertainty=spread)


def _tail(x: Column, lost: Column, fit: Fit, ridge: slice, outwards: int) -> float:
    """Return the area that material piled up may hold beyond where it sinks into the noise, m².

    Its foot is taken for a triangle as long as the last stretch over which the height has halved. Where nothing stands
    out, it is what noise may hide in the stretch that is averaged.
    """
    smooth, spread = smoothed(lost, fit)
    if ridge.stop <= ridge.start:
        return spread * SMOOTHING * float(x[-1] - x[0])
    gained, across = -smooth[ridge][::outwards], x[ridge][::outwards]
    last = max(float(gained[-1]), 0.0)
    higher = np.flatnonzero(gained > 2 * last + spread)
    length = abs(float(across[-1] - across[higher[-1]])) if len(higher) else 0.0
    return last * length / 2


def _settled(estimates: list[_Estimate]) -> tuple[int, float]:
    """Return which of several estimates is the best, and how far it may be off by more than its noise, m.

    They come by ever more points, so that noise sinks from each to the next while the error of form rises. By Lepski's
    rule (Theory Probab. Appl. 35 (1990) 454) the last is found that agrees with all before it. The error of form may
    still be as large as the noise there; where a later one disagrees the one before it is taken, whose error is less,
    as for confidence intervals (Hall, Ann. Statist. 20 (1992) 675). What its neighbor differs by remains uncertain.
    """
    agree = 0
    while agree + 1 < len(estimates) and all(
        abs(estimates[agree + 1].value - one.value) <= _AGREE * one.spread for one in estimates[: agree + 1]
    ):
        agree += 1
    last = len(estimates) - 1
    best, neighbour = (last, max(last - 1, 0)) if agree == last else (max(agree - 1, 0), max(agree, 1))
    return best, abs(estimates[best].value - estimates[neighbour].value)


def _edge(x: Column, lost: Column, fit: Fit, track: slice, side: int, depth: float) -> _Edge:
    """Return where the wall of the track comes up to the unworn surface, smoothed no wider than leaves it there."""
    widths = windows(fit, _LEFT_ON_WALL * depth, len(x), track)
    edges = [_followed(x, *smoothed(lost, fit, width), track, side, depth) for width in widths]
    best, off = _settled([edge.position for edge in edges])
    position = edges[best].position
    return edges[best]._replace(position=position._replace(spread=math.hypot(position.spread, off)))


def _followed(x: Column, smooth: Column, spread: float, track: slice, side: int, depth: float) -> _Edge:
    """Return where a wall leads to by two heights on it, carried on as the wall of a parabola.

    A flat worn on a crown is one. How far another wall is none, by two heights farther down, shows how far it may lead.
    """
    raised = min(spread / depth, 0.3)
    low, high, higher = (share + raised for share in _WALL)
    outer, inner, innermost = (_crossing(x, smooth, track, side, share * depth) for share in (low, high, higher))
    near, far = _ahead(low, high), _ahead(high, higher)
    edge, from_below = outer + near * (outer - inner), inner + far * (inner - innermost)
    noise = spread * abs(outer - inner) / ((high - low) * depth)
    grid = float(x[-1] - x[0]) / len(x) / math.sqrt(12)
    return _Edge(
        _Estimate(edge, math.hypot((1 + near) * noise, near * noise, grid)),
        _Estimate(side * (edge - from_below), math.hypot(1 + near, 1 + near + far, far) * noise),
        halfway=(edge + from_below) / 2,
    )


def _ahead(low: float, high: float) -> float:
    """Return how far beyond the lower of two shares of its depth a parabola ends, over the distance between them."""
    return (1 - math.sqrt(1 - low)) / (math.sqrt(1 - low) - math.sqrt(1 - high))


def _spread_of_width(left: _Edge, right: _Edge) -> float:
    """Return the standard uncertainty of the width, m: of the edges, and by walls that seem to be no parabola's."""
    bent = abs(left.bent.value + right.bent.value)
    seems = bent > math.hypot(left.bent.spread, right.bent.spread)
    return math.hypot(left.position.spread, right.position.spread, bent if seems else 0.0)


def _between(x: Column, lost: Column, one: float, other: float) -> float:
    """Return what was lost between two places, m²: that much is uncertain where a track may end at either."""
    between = (x >= min(one, other)) & (x <= max(one, other))
    return float(np.sum(lost[between] * np.gradient(x)[between]))


def _crossing(x: Column, smooth: Column, track: slice, side: int, level: float) -> float:
    """Return where, going outwards from its deepest place, a track is no longer deeper than a level, m.

    Noise takes it across several times: the middle of the first and the last is off to neither side.
    """
    deepest = track.start + 1 + int(np.argmax(smooth[track][1:-1]))
    onwards = np.arange(deepest, track.stop) if side > 0 else np.arange(deepest, track.start - 1, -1)
    deeper = smooth[onwards] >= level
    deeper[0], deeper[-1] = True, False
    first, last = int(np.argmin(deeper)), len(deeper) - int(np.argmax(deeper[::-1]))
    across = [onwards[[after - 1, after]] for after in (first, last)]
    return float(np.mean([np.interp(-level, -smooth[pair], x[pair]) for pair in across]))


def _depth(x: Column, lost: Column, fit: Fit, track: slice) -> _Estimate:
    """Return what was lost at the deepest place, m, by a parabola through as wide a part of the track as is one."""
    deepest = _deepest(lost, fit, track)
    widest = _ABOUT_THE_DEEPEST * (track.stop - track.start)
    halvings = int(math.log2(max(widest, 1.0)))
    reaches = [max(1, int(widest / 2**halving)) for halving in range(halvings, -1, -1)]
    tops = [_top(x, lost, fit, _about(deepest, reach, track), deepest) for reach in reaches]
    best, off = _settled(tops)
    return _Estimate(tops[best].value, math.hypot(tops[best].spread, off))


def _about(place: int, reach: int, track: slice) -> slice:
    return slice(max(track.start, place - reach), min(track.stop, place + reach + 1))


def _deepest(lost: Column, fit: Fit, track: slice) -> int:
    """Return the middle of the points around the deepest one that may be as deep but for noise, weighted by depth."""
    depth = float(np.max(smoothed(lost, fit)[0][track]))
    smooth, spread = smoothed(lost, fit, windows(fit, _LEFT_ON_FLOOR * depth, len(lost), track)[0])
    inside = smooth[track][1:-1]
    above = inside - float(np.max(inside)) + _AS_DEEP * spread + fit.rounding
    shallower = np.concatenate([[-1], np.flatnonzero(above <= 0), [len(above)]])
    after = int(np.searchsorted(shallower, np.argmax(above)))
    places = np.arange(shallower[after - 1] + 1, shallower[after])
    middle = float(np.average(places, weights=(above[places] / np.max(above)) ** 4))
    return int(track.start) + 1 + round(middle)


def _top(x: Column, lost: Column, fit: Fit, near: slice, deepest: int) -> _Estimate:
    """Return the greatest height of a parabola through a stretch; at the deepest place where it is level but for noise.

    A top sought in noise would be too high.
    """
    away = (x[near] - x[deepest]) / float(x[near][-1] - x[near][0])
    parabola = np.linalg.pinv(np.vander(away, 3, increasing=True))
    _, slope, curvature = parabola @ lost[near]
    clear = _CLEAR * math.sqrt(fit.variance) * np.linalg.norm(parabola, axis=1)
    at = 0.0
    if abs(slope) > clear[1] or curvature < -clear[2]:
        top = -slope / (2 * curvature) if curvature < 0 else 0.0
        places = (away[0], float(np.clip(top, away[0], away[-1])), away[-1])
        at = max(places, key=lambda place: slope * place + curvature * place**2)
    weights = np.zeros(len(x))
    weights[near] = [1.0, at, at**2] @ parabola
    return _Estimate(float(weights @ lost), fit.spread(x, weights))
