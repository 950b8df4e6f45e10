"""What a profile across a wear track or a worn tip says: areas lost and piled up, width, depth, and volumes of them.

Signs: the cross-section of the groove is what was lost and counts above zero; so does what is piled up beside it, which
was gained; the net loss is the one less the other, and below zero where more was piled up than the groove holds.

How the unworn surface and the track are found is told in tribopipe.profile.levelling.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tribopipe.errors import FitError
from tribopipe.profile.levelling import (
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
)
from tribopipe.records.manifest import PinOnDisc, RunManifest, TwinDisc
from tribopipe.records.quantity import Quantity
from tribopipe.run import Column, Profile
from tribopipe.units import show

_CERTAIN = 5.0
"""Standard uncertainties by which a cross-section must exceed zero."""
_WALL = (0.1, 0.3)
"""Shares of the depth through which a track's wall is followed up to the unworn surface."""
_ABOUT_THE_DEEPEST = (0.25, 0.12, 0.06, 0.03)
"""Shares of the width on either side of the deepest place by which the depth is measured, the first that fits."""
_OFF_BY_NOISE, _OFF_BY_FORM = 1.5, 0.02
"""How far a parabola may be off there: standard deviations of the noise, and share of the depth."""


@dataclass(frozen=True)
class Track:
    """A wear track, or the flat on a worn tip, by one profile across it."""

    area: Quantity
    """Cross-section lost below the unworn surface, m², with its standard uncertainty."""
    pile_up: Quantity
    """Cross-section gained beside it above the unworn surface, m²; zero where nothing stands out of the noise."""
    net_area: Quantity
    """What was lost less what is piled up, m²."""
    width: Quantity
    """m: between the places where the surface comes up to the unworn one."""
    depth: Quantity
    """m: below the unworn surface where the track is deepest."""
    cap: Quantity
    """m³: volume lost were it a body of revolution about the middle of the track: the cap of a ball, flat or not."""
    bounds: tuple[float, float]
    """Where the track begins and ends, m, in the profile's positions."""
    ridges: tuple[tuple[float, float], ...]
    """Where material is piled up, m, from and to; left before right."""
    unworn: Column
    """Height of the unworn surface at each position of the profile, m."""
    reference: Mask
    """Which points the unworn surface was fitted to."""
    dust: Mask
    """Which points lie under dust, and were bridged."""
    form: Form
    """What the unworn surface was taken to be."""
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
    """Which points it was fitted to."""
    form: Form
    """What the surface was taken to be."""
    why: str
    """Why it is no track."""


def worn_area(profile: Profile, crown_radius: float | None) -> Track:
    """Return the track that wear has left across a surface of this radius, m; none for a flat one.

    The radius is that of a disc's crown across the track, or of a ball, of which the track is the flat worn on it: its
    width is the diameter of the scar, if the profile leads through its middle.

    Its cross-section is A = ∫(unworn − measured)dx, m², by trapezoids from bound to bound. Within them single samples
    above the unworn surface count against it, so that noise cancels. Material piled up beside the track lies outside
    them and is measured by itself. Of several tracks the one with the deepest place is taken.

    The standard uncertainty is the shoulders' noise, in as many independent samples as it holds, in the fit of the
    unworn surface and in the track itself, to first order, and what lies between the bounds and where the walls lead
    to. That of the crown radius is not in it. It is too small where the shoulders hold fewer than some 20 independent
    samples.

    Raises ``FitError`` where there is no track, or it reaches the edge of the profile.
    """
    x, z, middle = _centred(profile, crown_radius)
    fit, worn = level(x, z, crown_radius)
    lost = fit.unworn.height(x) - z
    dust = find_dust(lost, fit, float(np.max(smoothed(lost, fit)[0])))
    if np.any(dust):
        z = np.interp(x, x[~dust], z[~dust])
        fit, worn = level(x, z, crown_radius)
    return _measured(x, z, fit, worn, _Place(middle, dust))


def examined(profile: Profile, crown_radius: float | None) -> Track | Level:
    """Return the track across a profile, or the profile levelled where it has none.

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
    """Return the radius of the unworn surface that a profile leads across, by its key; none where that is flat."""
    contact = manifest.contact
    if isinstance(contact, TwinDisc):
        return contact.curved_disc.crown_radius if ".curved_disc_profile" in key else None
    if isinstance(contact, PinOnDisc) and ".pin_profile" in key and contact.pin.shape != "flat":
        return contact.pin.radius
    return None


def _centred(profile: Profile, crown_radius: float | None) -> tuple[Column, Column, float]:
    """Return position about the middle of a profile, height, and that middle, m."""
    middle = float(profile.position[0] + profile.position[-1]) / 2
    x = profile.position - middle
    if crown_radius is not None and x[-1] >= crown_radius:
        raise FitError(
            f"profile: found one {show(float(2 * x[-1]), None, 'm', 'mm')} long across a crown of radius "
            f"{show(crown_radius, None, 'm', 'mm')}; expected one shorter than the crown is wide; check the unit of "
            "its positions, and crown_radius"
        )
    return x, profile.height, middle


class _Place(NamedTuple):
    """What was taken out of a profile before it was measured."""

    middle: float
    """m."""
    dust: Mask


class _Edge(NamedTuple):
    """Where the track ends on one side, m."""

    position: float
    spread: float


def _measured(x: Column, z: Column, fit: Fit, worn: Worn, place: _Place) -> Track:
    """Measure the track. Raises ``FitError`` where its cross-section is no larger than its uncertainty lets it be."""
    lost, track, middle = fit.unworn.height(x) - z, worn.groove, place.middle
    weights = _Weights.over(x, track)
    left, right = (_edge(x, lost, fit, track, side) for side in (-1, 1))
    ends = [_between(x, lost, *pair) for pair in ((left.position, x[track][0]), (right.position, x[track][-1]))]
    area = _weighed(x, lost, fit, weights, "m^2", *ends)
    if area.value <= _CERTAIN * (area.standard_uncertainty or 0.0):
        raise no_track(f"a cross-section of {area.shown('um^2')} below the unworn surface")
    beside = _Weights.over(x, worn.left, worn.right).times(-1.0)
    tails = [_tail(x, lost, fit, side, outwards) for side, outwards in ((worn.left, -1), (worn.right, 1))]
    centre = float(weights.fine @ (x * lost)) / area.value
    lean = _lean(fit, centre)
    width = (right.position - left.position) / lean
    turned = weights.times(math.pi / lean * np.abs(x - centre))
    return Track(
        area=area,
        pile_up=_weighed(x, lost, fit, beside, "m^2", *tails, *(end for end in ends if worn.piled_up)),
        net_area=_weighed(x, lost, fit, _Weights.over(x, *worn), "m^2", *tails),
        width=Quantity(value=width, unit="m", standard_uncertainty=math.hypot(left.spread, right.spread)),
        depth=_depth(x, lost, fit, track, lean),
        cap=_weighed(x, lost, fit, turned, "m^3", *(math.pi * width / 2 * end for end in ends)),
        bounds=(left.position + middle, right.position + middle),
        ridges=tuple((float(x[side][0]) + middle, float(x[side][-1]) + middle) for side in worn.piled_up),
        unworn=fit.unworn.height(x),
        reference=fit.shoulders & ~place.dust,
        dust=place.dust,
        form=fit.unworn.form,
        area_per_crown_radius=fit.by_crown_radius(x, weights.fine),
        cap_per_crown_radius=fit.by_crown_radius(x, turned.fine),
    )


class _Weights(NamedTuple):
    """By what heights add up to an area or a volume: by all points, and by every second one."""

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
    """Return the cosine of the angle by which a ball lay turned, its flat beside the top of the arc; 1 if flat."""
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


def _edge(x: Column, lost: Column, fit: Fit, track: slice, side: int) -> _Edge:
    """Return where the wall of the track comes up to the unworn surface.

    By two heights on the wall, carried on as the wall of a parabola, which a flat worn on a crown is.
    """
    smooth, spread = smoothed(lost, fit, track)
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


def _depth(x: Column, lost: Column, fit: Fit, track: slice, lean: float) -> Quantity:
    """Return what was lost at the deepest place, m, by the top of a parabola through half of the track.

    Where the track is no parabola, a narrower part of it is taken.
    """
    smooth, _ = smoothed(lost, fit, track)
    deepest = track.start + int(np.argmax(smooth[track]))
    away = (x - x[deepest]) / (x[track][-1] - x[track][0])
    for share in _ABOUT_THE_DEEPEST:
        near = np.abs(away) <= share
        near[: track.start] = near[track.stop :] = False
        if np.count_nonzero(near) < 3:
            near = np.abs(np.arange(len(x)) - deepest) <= 1
        parabola = np.linalg.pinv(np.vander(away[near], 3, increasing=True))
        level, slope, curvature = parabola @ lost[near]
        off = lost[near] - np.vander(away[near], 3, increasing=True) @ [level, slope, curvature]
        if np.std(off) <= max(_OFF_BY_NOISE * math.sqrt(fit.single), _OFF_BY_FORM * smooth[deepest]):
            break
    at = float(np.clip(-slope / (2 * curvature), -share, share)) if curvature < 0 else 0.0
    weights = np.zeros(len(x))
    weights[near] = [lean, lean * at, lean * at**2] @ parabola
    return Quantity(value=float(weights @ lost), unit="m", standard_uncertainty=fit.spread(x, weights))
