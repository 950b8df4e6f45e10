"""Figures of the pages that explain: Euler's error, what tells wear from drift, and wear of two discs by the model."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.units import axis, from_si
from tribopipe.contacts.wear import State
from tribopipe.evaluation.wear.scenario import Scenario
from tribopipe.physics.hertz import contact_modulus, hertz_radius
from tribopipe.physics.pin_on_disc import SphericalPin
from tribopipe.results.wear_prediction import OUTCOMES, Outcome
from tribopipe.views.layout import TWO_COLUMNS, in_columns
from tribopipe.views.plot import turned
from tribopipe.views.run_figures import BLACK, FORMULA, GREY, PALETTE, finish, key, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BLUE, RED, GREEN = PALETTE[:3]
RADIUS, DISTANCE = 0.794e-3, 500.0
STEPS = np.unique(np.logspace(2, 5.3, 18).round().astype(int))
AFTER_START = -0.117
"""What Hertz's start and the late elastic part add to ln(a/a*), on a contact that has become wide."""
WARM_UP = 0.2
"""Time constant of the warm-up drift, as a fraction of the test."""


_MOST_PLACES = 240
_DOTTED_PLACES = np.linspace(0, _MOST_PLACES - 1, 41).astype(int)
"""Where states of the published scheme are drawn."""
_STEPS = "published scheme"
_LEAST_SHARE = 1e-5
"""Of all rotations: where an axis of powers of ten begins."""
_STYLES: tuple[Any, ...] = ("-", (0, (5, 1.6)), (0, (5, 1.4, 1.2, 1.4)), (0, (1.2, 1.2)))


class Case(NamedTuple):
    """A pin of the paper with its k_D, m²/N."""

    name: str
    load: float
    modulus: float
    coefficient: float

    @property
    def pin(self) -> SphericalPin:
        """Depth against worn volume."""
        return SphericalPin(self.load, RADIUS, self.modulus)

    @property
    def volume(self) -> float:
        """Volume worn off over the whole distance, m³."""
        return self.coefficient * self.load * DISTANCE

    def stepped(self, steps: int) -> NDArray[np.float64]:
        """Return the depths that equal published steps reach, m."""
        return self.pin.published_depth(np.full(steps, self.volume / steps))

    def short_steps(self, steps: NDArray[np.int_]) -> NDArray[np.float64]:
        """Return the relative error of short steps, n/N·(ln(a/a*) − 0.117)."""
        start, end = self.pin.worn(np.array([0.0, self.volume])).radius
        exponent = self.volume / (np.pi * end**2) / float(self.pin.worn(self.volume).depth)
        return exponent / steps * (np.log(end / start) + AFTER_START)

    def long_steps(self, steps: NDArray[np.int_]) -> NDArray[np.float64]:
        """Return the relative error by what the first step alone runs ahead, πR/2v·(v/Nπa_H²)²."""
        radius = float(hertz_radius(normal_load=self.load, pin_radius=RADIUS, modulus=self.modulus))
        return np.pi * RADIUS / (2 * self.volume) * (self.volume / (steps * np.pi * radius**2)) ** 2


def _modulus(pin: float, disc: float) -> float:
    return float(contact_modulus(pin_modulus=pin, pin_ratio=0.24, disc_modulus=disc, disc_ratio=0.24))


NITRIDE = Case("Si₃N₄, 200 mN", 0.2, _modulus(304e9, 304e9), 13.5e-15)
CARBIDE = Case("WC-Co, 400 mN", 0.4, _modulus(320e9, 305e9), 0.75e-17)


@styled
def plot_euler_steps() -> Figure:
    """Draw the published steps beside the exact curve, and their error at the end against their number."""
    figure = Figure(figsize=(7.0, 3.2), layout="constrained")
    curve, error = figure.subplots(1, 2)
    _draw_curves(curve)
    for case, colour, marker in ((NITRIDE, BLUE, "o"), (CARBIDE, RED, "s")):
        exact = float(case.pin.worn(case.volume).depth)
        off = [case.stepped(int(steps))[-1] / exact - 1 for steps in STEPS]
        error.loglog(STEPS, 100 * np.array(off), marker, ms=4, color=colour, label=case.name)
        error.loglog(STEPS, 100 * case.short_steps(STEPS), color=colour, lw=0.8)
    long = STEPS[STEPS < 30_000]
    error.loglog(long, 100 * NITRIDE.long_steps(long), color=BLUE, lw=0.8, ls="--")
    error.set_xlabel("steps to 500 m")
    error.set_ylabel(axis("depth error at 500 m", "%"))
    error.legend()
    finish(error, "Error of the scheme", "formulas: dashed, long steps; solid, short steps")
    return figure


def _draw_curves(ax: "Axes") -> None:
    metres = np.linspace(0.0, DISTANCE, 501)
    exact = NITRIDE.pin.worn(NITRIDE.volume * metres / DISTANCE).depth
    ax.plot(metres, 1e6 * exact, color=BLACK, label="exact")
    for steps, look in ((500, {"color": RED, "ls": "--"}), (1000, {"color": GREEN, "ls": ":"})):
        depth = NITRIDE.stepped(steps)
        at = np.linspace(0.0, DISTANCE, steps + 1)
        ax.plot(at, 1e6 * depth, label=f"{steps} steps", **look)
    ax.set_xlabel(axis("sliding distance", "m"))
    ax.set_ylabel(axis("wear depth", "um"))
    ax.legend()
    finish(ax, NITRIDE.name, "wear depth, published scheme")


@styled
def plot_drift_and_wear() -> Figure:
    """Draw wear and warm-up drift, and the residuals of both after subtraction of offset and linear drift."""
    share = np.linspace(0.0, 1.0, 801)
    wear, drift = np.sqrt(share), -np.expm1(-share / WARM_UP) / -np.expm1(-1 / WARM_UP)
    line = np.column_stack([np.ones_like(share), share])
    figure = Figure(figsize=(7.0, 3.0), layout="constrained")
    whole, left = figure.subplots(1, 2)
    for curve, colour, style, name in ((wear, BLUE, "-", "wear, √s"), (drift, RED, "--", "warm-up drift")):
        whole.plot(share, curve, color=colour, ls=style, label=name)
        rest = curve - line @ np.linalg.lstsq(line, curve)[0]
        left.plot(share, 100 * rest, color=colour, ls=style)
    whole.plot(share, share, color=GREY, lw=0.9, ls=":", label="linear drift")
    left.axhline(0.0, color=GREY, lw=0.8)
    for ax, label in ((whole, "signal / final value"), (left, "residual, % of final value")):
        ax.set_xlabel("fraction of the test")
        ax.set_ylabel(label)
    whole.legend()
    finish(whole, "Depth signal", "")
    finish(left, "Residual", "offset and linear drift subtracted")
    return figure


class _Panel(NamedTuple):
    """One of the four panels of Fig. 9."""

    outcome: Outcome
    label: str
    unit: str


_PANELS = (
    _Panel("depth", "wear depth", "um"),
    _Panel("pressure", "mean pressure p", "GPa"),
    _Panel("half_width", "$a_x$", "um"),
    _Panel("half_length", "$a_z$", "um"),
)


@in_columns
def plot_disc_model(scenarios: Mapping[str, Scenario], rotations: float, steps: int | None = None) -> Figure:
    """Draw wear depth, mean pressure, a_x and a_z of named scenarios up to some rotations (paper, Fig. 9).

    Beside them, as dots, the paper's scheme in so many equal ``steps``, where that is given; it starts from Hertz's
    ellipse. The depth is that of both discs. Rotations, depth and a_x have logarithmic axes where there are several
    scenarios, which may wear at very different rates.
    """
    figure = Figure(figsize=(TWO_COLUMNS, 5.4), dpi=150, layout="constrained")
    axes = list(figure.subplots(2, 2, sharex=True).flat)
    several = len(scenarios) > 1
    share = np.geomspace(_LEAST_SHARE, 1.0, _MOST_PLACES) if several else np.linspace(0.0, 1.0, _MOST_PLACES) ** 1.5
    along, label = (share * rotations, "rotations of the crowned disc") if several else turned(share * rotations)
    for number, (name, scenario) in enumerate(scenarios.items()):
        look = {"color": PALETTE[number % len(PALETTE)], "ls": _STYLES[number % len(_STYLES)], "label": name}
        _draw_states(axes, along, scenario.worn(share * rotations), **look)
    for scenario in scenarios.values() if steps is not None else ():
        grid = np.linspace(0.0, rotations, (steps or 1) + 1)
        at = np.unique(np.rint(np.interp(share[_DOTTED_PLACES] * rotations, grid, np.arange(len(grid)))).astype(int))
        states = scenario.published(grid[at], steps or 1)
        dots = {"color": BLACK, "ls": "", "marker": "o", "ms": 1.6, "mew": 0, "zorder": 4, "label": _STEPS}
        _draw_states(axes, grid[at] * along[-1] / rotations, states, **dots)
    if several:
        _magnify(axes)
    _finish_four(axes, label)
    for ax, named in zip(axes, "abcd", strict=True):
        ax.set_title(f"({named})", loc="left")
    key(figure, axes, 4)
    return figure


def _magnify(axes: "Sequence[Axes]") -> None:
    """Make the axes logarithmic of what spreads over powers of ten: rotations, wear depth and a_x."""
    from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

    for ax, panel in zip(axes, _PANELS, strict=True):
        ax.set_xscale("log")
        ax.tick_params(labelsize=FORMULA)  # powers of ten
        if panel.outcome in ("depth", "half_width"):
            ax.set_yscale("log")
        if panel.outcome == "half_width":
            ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            ax.yaxis.set_major_formatter(ScalarFormatter())
            ax.yaxis.set_minor_formatter(NullFormatter())


def _draw_states(axes: "Sequence[Axes]", along: Column, worn: State, **look: Any) -> None:
    for ax, panel in zip(axes, _PANELS, strict=True):
        ax.plot(along, from_si(worn[panel.outcome], OUTCOMES[panel.outcome], panel.unit), **look)


def _finish_four(axes: "Sequence[Axes]", label: str) -> None:
    for ax, panel in zip(axes, _PANELS, strict=True):
        ax.set_ylabel(axis(panel.label, panel.unit))
        ax.margins(x=0.02)
    for ax in axes[2:]:
        ax.set_xlabel(label)
