"""Local wear of a sample run with a pin, and of two discs, in little time."""

from functools import cache

from folders import SAMPLES

from tribopipe.documents.manifest import read_manifest
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.wear.local import LocalOptions, local_scenario, wear_locally
from tribopipe.results.local_wear import LocalCurves

PIN, DISCS = "si3n4-air-200mN", "si3n4-twin-disc-10pct-1000k-a"


@cache
def pin_curves() -> LocalCurves:
    """A pin under 200 mN, worn for 500 m."""
    return _worn(PIN, [13.5e-15], [0.01, 0.1, 1.0, 10.0, 500.0])


@cache
def disc_curves() -> LocalCurves:
    """Two discs that both wear, in few steps."""
    return _worn(DISCS, [1.2e-14, 7e-15], [1e4, 1e5, 1e6], steps_per_decade=4)


def _worn(run_id: str, coefficients: list[float], at: list[float], **how) -> LocalCurves:
    manifest, _ = read_manifest(SAMPLES / run_id / "run.toml")
    values = [Quantity(value=coefficient, unit="m^2/N") for coefficient in coefficients]
    known = dict(zip(manifest.described.body_names, values, strict=False))
    return wear_locally(local_scenario(manifest, known), at, LocalOptions(**how))
