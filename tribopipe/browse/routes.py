"""The addresses under /api."""

from math import isfinite
from typing import Annotated, Literal

import h5py
from anyio import CapacityLimiter
from anyio.from_thread import check_cancelled
from anyio.to_thread import run_sync
from fastapi import APIRouter, Depends, Query
from starlette.exceptions import HTTPException
from starlette.responses import HTMLResponse, Response

from tribopipe.archive.catalog.query import Asked
from tribopipe.archive.hdf5_compression import unpacked
from tribopipe.base.errors import TribopipeError
from tribopipe.browse.answers import plot_answer, run_answer, sparkline_answer, study_answer
from tribopipe.browse.guard import REPORT_POLICY
from tribopipe.browse.library import Library
from tribopipe.browse.multi_run_plots import compare, study_plots
from tribopipe.browse.plots import PlotOffer, run_plots
from tribopipe.browse.responses import CSV, Files, JsonAnswer, download
from tribopipe.views.csv_files import csv_kinds, csv_parts
from tribopipe.views.decimation import Window
from tribopipe.views.plot import Plot
from tribopipe.views.run_page import run_page
from tribopipe.views.run_tables import runs_csv
from tribopipe.views.study_page import study_page

_MOST_COMPARED = 50
_REPORTS_AT_ONCE = 2
"""Each keeps a processor busy for seconds."""
_MOST_RUNS = 100_000_000
_HDF5 = "application/x-hdf5"


def _window(
    start: Annotated[float | None, Query(alias="from")] = None,
    end: Annotated[float | None, Query(alias="to")] = None,
    width: Annotated[int, Query(ge=16, le=4000)] = 1000,
) -> Window:
    """Read what of a plot is looked at."""
    if any(edge is not None and not isfinite(edge) for edge in (start, end)):
        raise HTTPException(400, "found a plot limit that is not a number; expected finite limits; click Full range")
    return Window(start, end, width)


Looked = Annotated[Window, Depends(_window)]
Words = Annotated[str, Query(max_length=2000)]


def api_router(library: Library) -> APIRouter:
    """Return the routes of the JSON answers and the downloads."""
    router = APIRouter(prefix="/api")
    _add_lists(router, library)
    _add_comparison(router, library)
    _add_run(router, library)
    files, reports = Files(), CapacityLimiter(_REPORTS_AT_ONCE)
    _add_downloads(router, library, files, reports)
    _add_studies(router, library, files, reports)
    return router


def _add_lists(router: APIRouter, library: Library) -> None:
    @router.get("/archive")
    def archive() -> Response:
        return JsonAnswer(library.about())

    @router.get("/revision")
    def revision() -> Response:
        return JsonAnswer({"revision": library.revision()})

    @router.get("/runs")
    def runs(
        where: Words = "",
        sort: Words = "id",
        search: Words = "",
        columns: Words = "id",
        start: Annotated[int, Query(ge=0, le=_MOST_RUNS)] = 0,
        most: Annotated[int | None, Query(ge=1, le=_MOST_RUNS)] = None,
    ) -> Response:
        return JsonAnswer(library.runs(Asked(where, sort, search, columns), start, most))

    @router.get("/values/{column}")
    def values(column: str, begins: Words = "") -> Response:
        library.revision()
        return JsonAnswer(library.catalogue.values(column, begins))

    @router.get("/runs.csv")
    def runs_as_csv(where: Words = "") -> Response:
        library.revision()
        return download([runs_csv(library.catalogue.runs(where))], "runs.csv", CSV)


def _add_comparison(router: APIRouter, library: Library) -> None:
    @router.get("/compare/{what}")
    def compared(
        what: Literal["wear", "friction", "depth"],
        window: Looked,
        runs: str = "",
        extra: Annotated[str, Query(alias="with")] = "",
        x: str | None = None,
    ) -> Response:
        chosen = list(dict.fromkeys(name for name in runs.split(",") if name))
        if not 1 <= len(chosen) <= _MOST_COMPARED:
            raise HTTPException(
                400, f"found {len(chosen)} runs to compare; expected 1 to {_MOST_COMPARED}; select other runs"
            )
        drawing = compare(what, [library.run(run_id) for run_id in chosen], extra.split(","), x)
        return JsonAnswer(plot_answer(what, drawing, window))


def _add_run(router: APIRouter, library: Library) -> None:
    @router.get("/runs/{run_id}")
    def run(run_id: str) -> Response:
        found = library.run(run_id)
        plots, tables = run_plots(found), csv_kinds(library.archive, run_id)
        told = run_answer(run_id, run_page(library.archive, run_id), plots, tables)
        # The page asks for its first plot next. Its samples are read meanwhile, not before: HDF5 reads one at a time.
        library.aside.submit(_read_ahead, plots)
        return JsonAnswer(told)

    @router.get("/runs/{run_id}/sparkline")
    def sparkline(run_id: str) -> Response:
        try:
            return JsonAnswer(sparkline_answer(run_plots(library.run(run_id))))
        except (HTTPException, TribopipeError, FileNotFoundError):
            # The table asks for rows of a moment ago; that a file is gone or damaged, its list of runs says.
            return JsonAnswer(sparkline_answer([]))

    @router.get("/runs/{run_id}/plots/{name}")
    def run_plot(run_id: str, name: str, window: Looked, x: str | None = None) -> Response:
        return JsonAnswer(plot_answer(name, _drawing(run_plots(library.run(run_id)), name, x), window))


def _drawing(offers: list[PlotOffer], name: str, against: str | None) -> Plot:
    """Draw one of the plots that are offered. Raises ``HTTPException`` where there is none of that name."""
    offer = next((offer for offer in offers if offer.name == name), None)
    if offer is None:
        known = ", ".join(offer.name for offer in offers) or "none"
        raise HTTPException(404, f"found no plot {name!r}; expected one of these: {known}; choose one of them")
    return offer.drawing(against)


def _read_ahead(plots: list[PlotOffer]) -> None:
    """Read what the first plot is drawn from; what stands in its way is given when it is asked for."""
    for first in plots[:1]:
        first.drawing()


def _add_downloads(router: APIRouter, library: Library, files: Files, reports: CapacityLimiter) -> None:
    @router.get("/runs/{run_id}/file")
    def file(run_id: str) -> Response:
        return files.download(library.run(run_id).path, _HDF5)

    @router.get("/runs/{run_id}/sources/{number}")
    def source(run_id: str, number: int) -> Response:
        found = library.run(run_id)
        path = f"/entry/source_files/file_{number}"
        if f"{path}/data" not in found.datasets:
            raise HTTPException(
                404,
                f"found no source file {number} of {run_id}; expected a source file of the run; go back to the page of "
                "the run",
            )
        with library.archive.open(run_id) as opened:
            return download([_bytes(opened[path])], str(opened[path]["file_name"].asstr()[()]))

    @router.get("/runs/{run_id}/csv/{what}")
    def csv(run_id: str, what: str) -> Response:
        library.run(run_id).refuse_foreign()
        return download(csv_parts(library.archive, run_id, what), f"{run_id}-{what}.csv", CSV)

    @router.get("/runs/{run_id}/report")
    async def run_report(run_id: str) -> Response:
        def made() -> str:
            from tribopipe.views.html.document import run_report

            library.run(run_id).refuse_foreign()
            return run_report(library.archive, [run_id], check_cancelled)

        return _report(await run_sync(made, limiter=reports))


def _bytes(note: h5py.Group) -> bytes:
    return unpacked(note["data"]).astype("u1").tobytes()


def _report(text: str) -> Response:
    return HTMLResponse(text, headers={"Content-Security-Policy": REPORT_POLICY})


def _add_studies(router: APIRouter, library: Library, files: Files, reports: CapacityLimiter) -> None:
    @router.get("/studies")
    def studies() -> Response:
        return JsonAnswer(library.studies())

    @router.get("/studies/{study_id}")
    def study(study_id: str) -> Response:
        found = library.study(study_id)
        plots = study_plots(found)
        return JsonAnswer(study_answer(study_id, study_page(library.archive, study_id), plots))

    @router.get("/studies/{study_id}/plots/{name}")
    def study_plot(study_id: str, name: str, window: Looked) -> Response:
        return JsonAnswer(plot_answer(name, _drawing(study_plots(library.study(study_id)), name, None), window))

    @router.get("/studies/{study_id}/file")
    def study_file(study_id: str) -> Response:
        return files.download(library.study(study_id).path, _HDF5)

    @router.get("/studies/{study_id}/report")
    async def study_report(study_id: str) -> Response:
        def made() -> str:
            from tribopipe.views.html.document import study_report

            library.study(study_id).refuse_foreign()
            return study_report(library.archive, study_id, check_cancelled)

        return _report(await run_sync(made, limiter=reports))
