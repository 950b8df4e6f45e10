"""Exceptions, each with one sentence that a lab can act on.

Every message names where (file, key or line), what was found, what was expected and how to correct it.
Nothing outside this module derives from ``Exception``.
"""

import re
from collections.abc import Iterable, Sequence
from difflib import get_close_matches

_HALF = 600
_MOST_LISTED = 12
_MOST_MEANT = 3
_MEAN_THE_SAME = {
    "frame": (
        "df data to_dataframe to_pandas to_frame to_numpy to_excel to_parquet iloc loc tail shape info dtypes values "
        "items rolling best_fit eval predict"
    ),
    "id": "name",
    "manifest": "metadata attrs conditions contact",
    "params": "best_values parameters popt coefficients",
    "bodies": "ci conf_interval interval",
    "fits": "fit k_d",
    "u": "error err std std_dev stderr sigma uncertainty s",
    "value": "nominal_value magnitude m n nominal",
    "table": "query filter select where df to_dataframe to_pandas loc iloc",
    "ids": "list runs",
    "read_run": "load Run",
    "open_archive": "open_dataset",
}
"""Names of pandas, xarray, lmfit, pint and uncertainties, by the name that means the same here."""
_CAPITAL = re.compile("(?<=[a-z])(?=[A-Z])")


class TribopipeError(Exception):
    """Root of everything tribopipe raises on purpose; its text is shown to people as it stands."""

    code = "tribopipe-error"
    """Section of docs/messages.md about the error, for `tribopipe help`."""

    def __init_subclass__(cls) -> None:
        """Name the section of a kind of error after its class: "unit-error" for ``UnitError``."""
        cls.code = _CAPITAL.sub("-", cls.__name__).lower()

    def __str__(self) -> str:
        """Return the sentence in one line; what a file makes of it for a terminal is written out, or cut in the middle.

        Texts of a file stand in many sentences, and may hold line ends, signs that steer a terminal, or a megabyte.
        """
        said = printable(super().__str__())
        return said if len(said) <= 2 * _HALF else f"{said[:_HALF]} … {said[-_HALF:]}"


class UnitError(TribopipeError):
    """A text that is no quantity, or one of the wrong kind."""


class ManifestError(TribopipeError):
    """A run.toml, recipe or plan that cannot be taken as it is."""


class ReaderError(TribopipeError):
    """A signal file that cannot be read."""


class CheckError(TribopipeError):
    """A run whose content is wrong enough to be refused."""


class ContactError(TribopipeError):
    """A contact outside what the wear model describes."""


class FitError(TribopipeError):
    """Data from which the asked-for quantity cannot be found."""


class ArchiveError(TribopipeError):
    """An archive, or a file in it, that cannot be read or written."""


class NotInstalledError(ArchiveError):
    """An archived run that needs a package which is not installed here."""


NotInstalledError.code = ArchiveError.code


class OutputError(TribopipeError):
    """A file must not be written where it was to be."""


class QueryError(TribopipeError):
    """A choice of runs, or of what is listed of them, that cannot be understood."""


class UnknownNameError(QueryError, AttributeError, KeyError):
    """A name that a run, a result or an archive does not have, asked for in Python as an item or an attribute."""


UnknownNameError.code = QueryError.code


class BatchError(TribopipeError):
    """A batch whose workers cannot be had, or were lost."""


class InternalError(TribopipeError):
    """An unexpected error: a bug in tribopipe, not in its input."""


def printable(text: str) -> str:
    """Return a text with line ends, and signs that steer a terminal, written out."""
    return text if text.isprintable() else "".join(sign if sign.isprintable() else repr(sign)[1:-1] for sign in text)


def counted(count: int, one: str, many: str = "") -> str:
    """Return a number with its noun: "1 run", "2 studies"."""
    return f"{count} {one if count == 1 else many or f'{one}s'}"


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Name what was probably meant, or list what is known, as the tail of an error sentence."""
    choices = sorted(set(known))
    # "load" is spelled more like "weld_load" than like "normal_load", which is what it means.
    within = sorted(_with_word(name, choices), key=len)
    if near := within[:_MOST_MEANT] or _listed_nearest(name, choices):
        return f"did you mean {' or '.join(map(repr, near))}?"
    return f"available: {_listed(choices)}" if choices else "none are available"


def unknown_name(owner: str, name: object, known: Iterable[str], call: str = "") -> UnknownNameError:
    """Return the error about a name that is asked for in Python: what there is, the nearest of it, what to call."""
    choices = list(dict.fromkeys(known))
    there = f"expected one of {_listed(choices)}" if choices else "none are available"
    near = " or ".join(map(repr, meant(str(name), choices)))
    rest = [f"did you mean {near}?" if near else "", call]
    return UnknownNameError("; ".join([f"{owner}: found no {name!r}", there, *filter(None, rest)]))


def meant(name: str, choices: Sequence[str]) -> list[str]:
    """Return what was probably meant: names that mean the same, contain the word, or are spelled alike."""
    same = [own for own, others in _MEAN_THE_SAME.items() if own in choices and name in others.split()]
    return same[:1] or _with_word(name, choices)[:_MOST_MEANT] or _listed_nearest(name, choices)


def _with_word(name: str, choices: Iterable[str]) -> list[str]:
    """Return the names of which this is one of several words."""
    return [choice for choice in choices if name in choice.split("_") and name != choice]


def _listed_nearest(name: str, choices: Iterable[str]) -> list[str]:
    near = nearest(name, choices)
    return [near] if near else []


def nearest(name: str, choices: Iterable[str]) -> str | None:
    """Return what was probably meant; none where nothing is near."""
    return next(iter(get_close_matches(name, list(choices), n=1, cutoff=0.6)), None)


def _listed(choices: Sequence[str]) -> str:
    return ", ".join(choices[:_MOST_LISTED]) + (", …" if len(choices) > _MOST_LISTED else "")
