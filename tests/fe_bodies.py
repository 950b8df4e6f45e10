"""The paper's pin and discs as finite elements, that tests of them share."""

import numpy as np

from tribopipe.physics.geometry import cap_height
from tribopipe.physics.hertz import contact_modulus, hertz_ellipse, hertz_radius
from tribopipe.physics.local.finite_elements import PinBody, QuarterDisc, pin_body, quarter_disc

LOAD, RADIUS = 0.2, 0.794e-3
MODULUS = float(contact_modulus(pin_modulus=304e9, pin_ratio=0.24, disc_modulus=304e9, disc_ratio=0.24))
START = float(hertz_radius(normal_load=LOAD, pin_radius=RADIUS, modulus=MODULUS))
PEAK = 1.5 * LOAD / (np.pi * START**2)
COEFFICIENT = 13.5e-15

ZIRCONIA = float(contact_modulus(pin_modulus=152e9, pin_ratio=0.32, disc_modulus=152e9, disc_ratio=0.32))
DISC_LOAD, DISC_COEFFICIENT = 0.3, 1e-16
ELLIPSE = hertz_ellipse(normal_load=DISC_LOAD, radius_x=4e-3, radius_z=2e-3, modulus=ZIRCONIA)


def sphere(radius: np.ndarray) -> PinBody:
    gap = cap_height(scar_radius=radius, sphere_radius=RADIUS)
    return pin_body(normal_load=LOAD, modulus=MODULUS, poisson_ratio=0.24, radius=radius, gap=gap)


def discs(cells: tuple[int, int], rotations: float = 0.0) -> QuarterDisc:
    return quarter_disc(
        normal_load=DISC_LOAD,
        modulus=ZIRCONIA,
        poisson_ratio=0.32,
        crown_radius=4e-3,
        curved_radius=4e-3,
        flat_radius=4e-3,
        amount=DISC_COEFFICIENT * rotations,
        cells=cells,
    )
