"""What runs and results offer at a Python prompt and in a notebook: tables, figures, a page of their own.

The code is in ``tribopipe.views.interactive``, which knows pandas and matplotlib. It is imported when it is called, so
that results know neither.
"""

from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple, Self, overload

from pydantic import PrivateAttr

from tribopipe.base.arrays import Column
from tribopipe.base.errors import meant, nearest, unknown_name
from tribopipe.documents.record import Record

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame, Series


def views() -> Any:
    """Return the module that draws and tabulates what people look at in Python."""
    return import_module("tribopipe.views.interactive")


class Displayed:
    """Object with a figure, shown in a notebook."""

    def plot(self) -> "Figure":
        """Draw it as reports do. Return the figure, which a notebook shows by itself."""
        figure: Figure = views().plot(self)
        return figure

    def _repr_html_(self) -> str:
        page: str = views().page(self)
        return page


class UnitColumn(NamedTuple):
    """A column with its SI unit."""

    values: Column
    unit: str


class Tabular(Displayed):
    """Object with columns over the samples of a run."""

    @property
    @abstractmethod
    def id(self) -> str:
        """Name of the run."""

    @abstractmethod
    def unit_columns(self) -> Mapping[str, UnitColumn]:
        """Return the columns by name, each with its unit."""

    def frame(self) -> "DataFrame":
        """Return the columns as a table of pandas.

        Returns
        -------
        pandas.DataFrame
            One row per sample, numbers in SI, NaN where a sample is missing. ``frame.attrs["units"]`` has the unit of
            each column.
        """
        table: DataFrame = views().frame(self.unit_columns())
        return table

    @overload
    def __getitem__(self, name: str) -> "Series[float]": ...

    @overload
    def __getitem__(self, name: list[str]) -> "DataFrame": ...

    def __getitem__(self, name: str | list[str]) -> "Series[float] | DataFrame":
        """Return a column of ``frame()``, with its unit in ``attrs["units"]``, or a table of several columns.

        Raises ``UnknownNameError``, a ``KeyError``, where there is no such column.
        """
        columns = self.unit_columns()
        names = name if isinstance(name, list) else [name]
        unknown = next((one for one in names if one not in columns), None)
        if unknown is not None:
            raise unknown_name(f"run {self.id}", unknown, columns, "use frame() for all columns in one table")
        if isinstance(name, list):
            table: DataFrame = views().frame({one: columns[one] for one in names})
            return table
        column: Series[float] = views().column(name, columns[name])
        return column

    def __contains__(self, name: object) -> bool:
        return name in self.unit_columns()

    def __iter__(self) -> Iterator[str]:
        return iter(self.unit_columns())

    def keys(self) -> list[str]:
        """Return the names of the columns, so that ``dict(run)`` has them all."""
        return list(self.unit_columns())

    def __array__(self, *_: Any, **__: Any) -> Any:
        """Raise ``TypeError``: an array would have lost the names and units of the columns, or only have the names."""
        raise TypeError(
            f"run {self.id}: found a run in place of an array; expected a table; call frame() to obtain one"
        )

    def _ipython_key_completions_(self) -> list[str]:
        return self.keys()

    if not TYPE_CHECKING:  # A type checker would take every name for an attribute.

        def __getattr__(self, name: str) -> Any:
            """Raise ``UnknownNameError``, which states how a column is asked for."""
            if name.startswith("_") or name in type(self).__annotations__:  # the latter before it is set
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            columns = self.unit_columns()
            own = [known for known in dir(self) if not known.startswith("_")]
            known = own if meant(name, own) else [*columns, *own]
            call = (
                f"columns are items: [{nearest(name, columns) or next(iter(columns), 'time')!r}], and those of frame()"
            )
            raise unknown_name(f"run {self.id}", name, known, call)

    def head(self, rows: int = 5) -> "DataFrame":
        """Return the first rows of ``frame()``."""
        return self.frame().head(rows)

    def describe(self) -> "DataFrame":
        """Return count, mean, standard deviation and quartiles of each column, in SI."""
        return self.frame().describe()

    def to_csv(self, path: str | PathLike[str], *, force: bool = False) -> None:
        """Write the columns as `tribopipe export csv` does: heads are names and units, "depth [m]"; UTF-8, commas.

        Raises ``OutputError`` where something is there already, unless ``force`` has it replaced.
        """
        views().write_csv(self.unit_columns(), path, force=force)

    def to_xarray(self) -> Any:
        """Return the columns as an xarray Dataset over the samples, with the unit of each in its attributes.

        Takes the package xarray: pip install "tribopipe[xarray]".
        """
        return views().dataset(self.unit_columns())


class FittedTo:
    """Inputs of a fit, from which it is plotted. Not a part of the result; neither compared nor pickled."""

    def __init__(self, run: Any = None, curves: Callable[[], Any] | None = None) -> None:
        self.run, self.curves = run, curves

    def __eq__(self, other: object) -> bool:
        return isinstance(other, FittedTo)

    def __hash__(self) -> int:
        return hash(FittedTo)

    def __reduce__(self) -> tuple[type["FittedTo"], tuple[()]]:
        return FittedTo, ()


class FitRecord(Record, Displayed):
    """The result of a fit, which knows the run it was fitted to as long as it is in memory."""

    _fitted_to: FittedTo = PrivateAttr(default_factory=FittedTo)

    def fitted_to(self, run: Any, curves: Callable[[], Any] | None = None) -> Self:
        """Have ``plot`` and ``frame`` know the run of the fit, and how its curves along the run are computed."""
        self._fitted_to = FittedTo(run, curves)
        return self
