"""A virtual test as if its run folder had been written and ingested."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import cast

from tribopipe.base.arrays import Column
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.plan import Series, TwinDiscSeries, TwinDiscVirtualRun, VirtualRun
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.derived_columns import derive_missing
from tribopipe.extras.simulate.pin_on_disc import VirtualTest
from tribopipe.extras.simulate.twin_disc import VirtualTwinDiscTest
from tribopipe.results.run import Origin, RawRun


def pin_run(series: Series, run: VirtualRun, test: VirtualTest) -> RawRun:
    """Return a virtual test of a pin as ingested, its sliding distance derived from the nominal speed."""
    columns, ends = test.record()
    slid: dict[SignalName, Column] = {"sliding_distance": series.sliding_speed.value * test.time}
    return _ingested(series.manifest(run, ends), columns, slid)


def disc_run(series: TwinDiscSeries, run: TwinDiscVirtualRun, test: VirtualTwinDiscTest) -> RawRun:
    """Return a virtual test of two discs as ingested."""
    columns, ends = test.record()
    return _ingested(series.manifest(run, ends), columns)


def _ingested(
    manifest: RunManifest, columns: Mapping[str, Column], slid: Mapping[SignalName, Column] = MappingProxyType({})
) -> RawRun:
    """Put together what was stated and recorded, and a distance that follows from the nominal speed."""
    signals = cast("dict[SignalName, Column]", {**columns, **slid})
    origins: dict[SignalName, Origin] = dict.fromkeys(signals, "measured")
    origins |= dict.fromkeys(slid, "derived from nominal speed")
    derive_missing(signals, origins, manifest)
    return RawRun(manifest, signals, origins, {}, {}, ())
