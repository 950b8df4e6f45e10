"""Prior information from the archive: drift of the instrument, and k_D of the same bodies.

Of n archived values the next one is expected at their mean, with the standard deviation s·√(1 + 1/n)·√((n − 1)/(n − 3))
of Student's t (JCGM 101:2008, 6.4.9.4): it exists from four values on.
"""

import math
import re
from collections.abc import Callable, Sequence
from statistics import fmean, stdev
from typing import NamedTuple

from tribopipe.archive.step_names import WEAR_FITS
from tribopipe.archive.store import Archive
from tribopipe.base.errors import FitError, UnitError
from tribopipe.base.units import KINDS, parse
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity, wear_coefficient
from tribopipe.documents.recipe import LawName
from tribopipe.documents.study import bodies
from tribopipe.results.evaluation import DriftCorrection
from tribopipe.results.wear_fit import WearFit

_FEWEST = 4
_GIVEN = re.compile(r"\s*(?P<value>\S{1,40})\s*(?:±|\+-|\+/-)\s*(?P<spread>[^\s±]{1,40})\s+(?P<unit>.+)", re.DOTALL)


class Expected(NamedTuple):
    """Prior of a run, and the archived runs that it is from."""

    quantity: Quantity
    runs: tuple[str, ...]


def quantity_given(option: str, text: str, kind: str) -> Quantity:
    """Read "0 +- 5 nm/min". Raises ``UnitError`` where that is no value with its standard uncertainty."""
    found = _GIVEN.fullmatch(text)
    if found is None:
        raise UnitError(
            f'{option}: found {text!r}; expected a value and its standard uncertainty, such as "0 +- 5 '
            f'{KINDS[kind].shown}"'
        )
    try:
        value, spread = (parse(f"{found[part]} {found['unit']}", kind) for part in ("value", "spread"))
    except UnitError as error:
        raise UnitError(f"{option}: {error}") from None
    if not spread > 0:
        raise UnitError(f"{option}: found {text!r}; expected a positive standard uncertainty")
    return Quantity(value=value, unit=KINDS[kind].si, standard_uncertainty=spread)


def archived_drift(archive: Archive, manifest: RunManifest) -> Expected:
    """Return the drift rate, m/s, that runs on this instrument had. Raises ``FitError`` where there are too few."""

    def rate(run_id: str) -> float | None:
        found = archive.result(run_id, "drift_correction", DriftCorrection)
        same = archive.manifest(run_id).instrument == manifest.instrument
        return found.drift_rate.value if same and found is not None and found.drift_rate is not None else None

    rates = _found(archive, manifest.id, rate)
    what = f"drift rate measured on the instrument {manifest.instrument!r}"
    value, spread = _next(list(rates.values()), what)
    return Expected(Quantity(value=value, unit="m/s", standard_uncertainty=spread), tuple(rates))


def archived_coefficient(archive: Archive, manifest: RunManifest, law: LawName) -> Expected:
    """Return k_D, m²/N, that runs of the same bodies had. Raises ``FitError`` where there are too few."""
    mine = bodies(manifest)

    def log_k(run_id: str) -> float | None:
        fit = archive.result(run_id, WEAR_FITS[law], WearFit)
        if fit is None or fit.first is None or bodies(archive.manifest(run_id)) != mine:
            return None
        return math.log(fit.first.wear_coefficient.value)

    logs = _found(archive, manifest.id, log_k)
    value, spread = _next(list(logs.values()), "k_D of the same bodies")
    return Expected(wear_coefficient(math.exp(value), math.exp(value) * spread), tuple(logs))


def _found(archive: Archive, but: str, of: Callable[[str], float | None]) -> dict[str, float]:
    """Return what is found of each run that is not marked bad."""
    others = [run_id for run_id in archive.ids() if run_id != but and archive.bad(run_id) is None]
    found = {run_id: of(run_id) for run_id in others}
    return {run_id: value for run_id, value in found.items() if value is not None}


def _next(values: Sequence[float], what: str) -> tuple[float, float]:
    count = len(values)
    if count < _FEWEST:
        raise FitError(
            f"found {count} archived runs with a {what}; expected at least {_FEWEST} to predict the next run; archive "
            "more of them, or omit the option"
        )
    return fmean(values), stdev(values) * math.sqrt((1 + 1 / count) * (count - 1) / (count - 3))
