"""A virtual test as if its run folder had been written and ingested."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, cast

from tribopipe.base.arrays import Column
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.plan import Series, TwinDiscSeries, TwinDiscVirtualRun, VirtualRun
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.derived_columns import derive_missing
from tribopipe.extras.simulate.pin_on_disc import VirtualTest
from tribopipe.extras.simulate.twin_disc import VirtualTwinDiscTest
from tribopipe.results.run import Origin, RawRun


def pin_run(series: Series, run: VirtualRun, test: VirtualTest) -> RawRun:
    """Return a virtual test of a pin as ingested, its sliding distance derived from the nominal speed."""
    conditions = {
        "normal_load": run.normal_load.model_dump(),
        "sliding_speed": series.sliding_speed.model_dump(),
        "sliding_distance": series.sliding_distance.model_dump(),
        "stroke": None if series.stroke is None else series.stroke.model_dump(),
    }
    columns, ends = test.record()
    slid: dict[SignalName, Column] = {"sliding_distance": series.sliding_speed.value * test.time}
    return _ingested(series, run, conditions, columns, ends, slid)


def disc_run(series: TwinDiscSeries, run: TwinDiscVirtualRun, test: VirtualTwinDiscTest) -> RawRun:
    """Return a virtual test of two discs as ingested."""
    conditions = {
        "normal_load": series.load_of(run).model_dump(),
        "curved_disc_speed": series.curved_disc_speed.model_dump(),
        "slip": run.slip.model_dump(),
        "rotations": run.rotations,
    }
    return _ingested(series, run, conditions, *test.record())


def _ingested(
    series: Series | TwinDiscSeries,
    run: VirtualRun | TwinDiscVirtualRun,
    conditions: dict[str, Any],
    columns: Mapping[str, Column],
    ends: Mapping[str, Quantity],
    slid: Mapping[SignalName, Column] = MappingProxyType({}),
) -> RawRun:
    """Put together what was recorded, and a distance that follows from the nominal speed."""
    manifest = RunManifest.model_validate(
        {
            "schema": "tribopipe.run/1",
            "id": run.id,
            "started": run.started,
            "contact": series.contact.model_dump(),
            "conditions": conditions | {"medium": series.medium},
            "signals": [{"file": "signals.csv"}],
            "sensors": {"depth_scale": series.depth_scale.model_dump()},
            "end_values": {name: value.model_dump() for name, value in ends.items()},
        }
    )
    signals = cast("dict[SignalName, Column]", {**columns, **slid})
    origins: dict[SignalName, Origin] = dict.fromkeys(signals, "measured")
    origins |= dict.fromkeys(slid, "derived from nominal speed")
    derive_missing(signals, origins, manifest)
    return RawRun(manifest, signals, origins, {}, {}, ())
