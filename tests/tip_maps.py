"""Height maps of worn balls whose lost volume is known, by a simulator of its own."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter

from tribopipe.results.run import Profile


@dataclass(frozen=True)
class WornBall:
    """A ball worn by one surface, and the way its map was measured; lengths in m."""

    radius: float = 3e-3
    scar: float = 0.5e-3
    """Diameter of a plane scar of this depth."""
    tilt: float = 0.0
    """Angle of the pin in its holder: the scar is not where the map has its top."""
    curvature: float = 0.0
    """Curvature of the worn surface across the sliding direction, over that of the ball; convex above 0."""
    shear: float = 0.0
    """Slope of a plane that the instrument has added."""
    off: tuple[float, float] = (0.0, 0.0)
    """Place of the scar from the middle of the map."""
    size: float = 2.0
    """Length of the map over the scar's diameter."""
    points: int = 121
    lines: int = 101
    rough: float = 30e-9
    correlated: float = 10e-6
    noise: float = 10e-9
    spike: float = 0.0
    missing: float = 0.0
    hole: float = 0.0
    """Radius of a place without heights in the scar."""

    @property
    def depth(self) -> float:
        return self.radius - math.sqrt(self.radius**2 - self.scar**2 / 4)

    def surfaces(self, x, y):
        """Heights of the ball before the test and of the worn surface, about the middle of the scar."""
        away = self.radius * math.sin(self.tilt)
        ball = np.sqrt(self.radius**2 - (x + away) ** 2 - y**2)
        if self.tilt:
            # The plane at R − h from the center, whose normal is that through the middle of the scar.
            worn = (self.radius - self.depth - (x + away) * math.sin(self.tilt)) / math.cos(self.tilt)
        else:
            worn = self.radius - self.depth - self.curvature * y**2 / (2 * self.radius)
        return ball, worn

    @property
    def volume(self) -> float:
        """By its formula for a plane cut, else by a sum over a grid far finer than any map."""
        if not self.curvature:
            return math.pi * self.depth**2 * (3 * self.radius - self.depth) / 3
        side = np.linspace(-self.scar, self.scar, 3001)
        ball, worn = self.surfaces(side, side[:, None])
        return float(np.sum(np.maximum(ball - worn, 0.0))) * (side[1] - side[0]) ** 2

    def map(self, seed=0) -> list[Profile]:
        rng = np.random.default_rng(seed)
        length = self.size * self.scar
        x = np.linspace(-length / 2, length / 2, self.points)
        y = np.linspace(-length / 2, length / 2, self.lines)
        ball, worn = self.surfaces(x - self.off[0], (y - self.off[1])[:, None])
        height = np.minimum(ball, worn) + self.shear * x + 0.5 * self.shear * y[:, None] + 7e-6
        steps = y[1] - y[0], x[1] - x[0]
        # Cells of the map are averages over its own pixels, of which roughness is finer than some.
        field = gaussian_filter(rng.standard_normal(height.shape), [self.correlated / step for step in steps])
        height += self.rough * field / np.std(field) + self.noise * rng.standard_normal(height.shape)
        if self.spike:
            rows, columns = rng.integers(0, self.lines, 12), rng.integers(0, self.points, 12)
            height[rows, columns] += self.spike
            middle = self.lines // 2, self.points // 2
            height[middle[0] : middle[0] + 2, middle[1] : middle[1] + 2] += self.spike
        height[rng.random(height.shape) < self.missing] = np.nan
        if self.hole:
            height[np.hypot(x - self.off[0], (y - self.off[1])[:, None]) < self.hole] = np.nan
        return lines_of(x, y, height)


def lines_of(x, y, height, scan="map") -> list[Profile]:
    """Scan lines as readers give them: without missing heights, and none of less than 20 points."""
    seen = [np.isfinite(row) for row in height]
    return [
        Profile(x[kept], row[kept], float(place), scan)
        for place, row, kept in zip(y, height, seen, strict=True)
        if np.count_nonzero(kept) >= 20
    ]
