"""Height maps of one place before and after a test, whose lost volume is known, by a simulator of its own."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import RectBivariateSpline
from scipy.ndimage import gaussian_filter
from tip_maps import lines_of


@dataclass(frozen=True)
class MapPair:
    """A rough specimen, worn by a rough counterbody, and the way that its two maps were measured; lengths in m."""

    body: str = "ball"
    """ball, disc or pin: a flat pin in its holder."""
    radius: float = 3e-3
    half: float = 0.5e-3
    """Half length of the maps."""
    scar: float = 0.4e-3
    """Diameter of the scar of a ball, width of a track, diameter of a flat pin."""
    depth: float = 0.0
    """Depth of the groove, or height lost by a flat pin; negative for transfer."""
    whole: bool = False
    """Whether the groove ends within the map."""
    off: tuple[float, float] = (60e-6, -40e-6)
    form: float = 1e-6
    """Amplitude of the error of form, common to both maps."""
    rough: float = 50e-9
    correlated: float = 20e-6
    noise: float = 10e-9
    shift: tuple[float, float] = (43.7e-6, -26.2e-6)
    tilt: tuple[float, float] = (1e-3, -2e-3)
    rotation: float = 0.0
    points: int = 101
    lines: int = 91
    coarser: float = 1.0
    """Distances in the map before over those in the map after."""
    debris: float = 0.0
    missing: float = 0.0
    seed: int = 0

    @cached_property
    def _fine(self):
        """Roughness before and of the worn surface, on a grid finer than the maps, as functions of the position."""
        rng = np.random.default_rng(1000 + self.seed)
        reach, count = 1.5 * self.half, 451
        places = np.linspace(-reach, reach, count)
        fields = []
        for _ in range(2):
            field = gaussian_filter(rng.standard_normal((count, count)), self.correlated / (places[1] - places[0]))
            fields.append(RectBivariateSpline(places, places, self.rough * field / np.std(field)))
        return fields

    def before(self, x, y):
        away = np.hypot(x - 30e-6, y)
        error = self.form * (np.cos(1.1 * math.pi * away / self.half) + 0.5 * (x**2 - y**2) / self.half**2)
        height = error + self._fine[0].ev(y, x)
        if self.body == "ball":
            return height + np.sqrt(self.radius**2 - x**2 - y**2) - self.radius
        if self.body == "pin":
            return height + np.where(self._inside(x, y), 20e-6, 0.0)
        return height

    def _inside(self, x, y):
        return np.hypot(x - self.off[0], y - self.off[1]) < self.scar / 2

    def after(self, x, y):
        before, texture = self.before(x, y), self._fine[1].ev(y, x)
        if self.body == "ball":
            away = math.hypot(*self.off)
            lean = self.off[0] / self.radius, self.off[1] / self.radius
            top = math.sqrt(self.radius**2 - away**2 - self.scar**2 / 4) - self.radius
            plane = top - lean[0] * (x - self.off[0]) - lean[1] * (y - self.off[1])
            return np.minimum(before, plane + 2 * texture)
        if self.body == "pin":
            return before - np.where(self._inside(x, y), self.depth * (1 + 0.3 * (x - self.off[0]) / self.scar), 0.0)
        across = 1 - ((x - self.off[0]) / (self.scar / 2)) ** 2
        if self.whole:
            across = across - ((y - self.off[1]) / (0.6 * self.scar)) ** 2
        return before - self.depth * np.maximum(across, 0.0) ** 1.5

    @property
    def volume(self) -> float:
        """Volume lost within half a map length around the middle, by a sum over a grid far finer than the maps."""
        side = np.linspace(-self.half, self.half, 601)
        x, y = np.meshgrid(side, side)
        return float(np.sum(self.before(x, y) - self.after(x, y))) * (side[1] - side[0]) ** 2

    @property
    def section(self) -> float:
        """Cross-section of a groove that leads through the map."""
        return self.volume / (2 * self.half)

    def maps(self):
        """Scan lines of the map after, and of that before."""
        rng = np.random.default_rng(self.seed)
        found = []
        for name, surface, moved, step in (
            ("after.csv", self.after, True, 1.0),
            ("before.csv", self.before, False, self.coarser),
        ):
            x = np.linspace(-self.half, self.half, round((self.points - 1) / step) + 1)
            y = np.linspace(-self.half, self.half, round((self.lines - 1) / step) + 1)
            along, across = np.meshgrid(x, y)
            if moved:
                turned = math.cos(self.rotation), math.sin(self.rotation)
                along, across = (
                    turned[0] * along + turned[1] * across - self.shift[0],
                    turned[0] * across - turned[1] * along - self.shift[1],
                )
            height = surface(along, across) + self.noise * rng.standard_normal(along.shape)
            if moved:
                height = height + self.tilt[0] * x + self.tilt[1] * y[:, None] + 3e-6
                if self.debris:
                    height[5:8, 5:8] += self.debris
            height[rng.random(height.shape) < self.missing] = np.nan
            found.append(lines_of(x, y, height, name))
        return found
