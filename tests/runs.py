"""Runs made in memory, without files."""

import pytest

from tribopipe.records.manifest import RunManifest
from tribopipe.run import RawRun

MANIFEST = {
    "schema": "tribopipe.run/1",
    "id": "bare",
    "started": "2006-03-01T09:30:00+01:00",
    "contact": {
        "kind": "pin-on-disc",
        "pin": {"shape": "spherical", "radius": "0.794 mm", "material": "Si3N4", "youngs_modulus": "304 GPa", "poisson_ratio": 0.24},
        "disc": {"material": "Si3N4", "youngs_modulus": "304 GPa", "poisson_ratio": 0.24},
    },
    "conditions": {"normal_load": "200 mN", "sliding_speed": "400 mm/s"},
    "signals": [{"file": "signals.csv"}],
}


@pytest.fixture(scope="session")
def bare_run() -> RawRun:
    """A run with a manifest and no samples yet."""
    return RawRun(RunManifest.model_validate(MANIFEST), {}, {}, {}, {}, ())
