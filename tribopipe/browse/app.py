"""The application: its routers, how failures are answered, and the files of the web client for every other address."""

from pathlib import Path

from fastapi import APIRouter, FastAPI, Request
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.responses import FileResponse, Response

from tribopipe.base.errors import QueryError, TribopipeError
from tribopipe.browse.guard import Guard, Key, inside
from tribopipe.browse.h5 import h5_router
from tribopipe.browse.library import Library
from tribopipe.browse.responses import failure
from tribopipe.browse.routes import api_router

BUNDLE = Path(__file__).parent / "static"
_PAGE = "index.html"
_TYPES = {
    ".css": "text/css",
    ".html": "text/html",
    ".js": "text/javascript",
    ".json": "application/json",
    ".map": "application/json",
    ".md": "text/plain",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".ttf": "font/ttf",
    ".txt": "text/plain",
    ".woff": "font/woff",
    ".woff2": "font/woff2",
}
"""Set here, since a registry of Windows may call a script a text."""
NOT_BUILT = (
    "found no web pages in this installation; expected the pages that are built with the package; run `pip install "
    "--force-reinstall tribopipe` on a machine with access to the npm registry, or `npm ci && npm run build` in "
    "tribopipe/browse/ui of a clone"
)


def is_built() -> bool:
    """Return whether the web client is installed."""
    return (BUNDLE / _PAGE).is_file()


def bundle_router() -> APIRouter:
    """Return the route that answers every address which no other one does."""
    router = APIRouter()

    @router.get("/{path:path}")
    def page(path: str) -> Response:
        if path.partition("/")[0] in ("api", "h5"):
            raise HTTPException(
                404,
                f"found no page at /{path}; expected the address of a page or of data; go back to the table of runs",
            )
        if not is_built():
            raise HTTPException(404, NOT_BUILT)
        try:
            found = inside(BUNDLE, path)
        except HTTPException:
            return FileResponse(BUNDLE / _PAGE, media_type="text/html", headers={"Cache-Control": "no-cache"})
        kept = {"Cache-Control": "max-age=31536000, immutable"} if path.startswith("assets/") else None
        return FileResponse(found, media_type=_TYPES.get(found.suffix, "application/octet-stream"), headers=kept)

    return router


def create_app(archive_folder: Path, key: Key) -> FastAPI:
    """Return the application for whoever shows a key; it reads the archive and writes nothing but its catalog."""
    app = FastAPI(openapi_url=None, docs_url=None, redoc_url=None, redirect_slashes=False)
    app.state.library = Library(archive_folder)
    app.include_router(api_router(app.state.library))
    app.include_router(h5_router(archive_folder))
    app.include_router(bundle_router())
    app.add_middleware(Guard, key=key)
    app.add_exception_handler(HTTPException, _http_failure)
    app.add_exception_handler(RequestValidationError, _invalid_request)
    app.add_exception_handler(TribopipeError, _archive_failure)
    app.add_exception_handler(OSError, _file_failure)
    return app


async def _http_failure(_: Request, error: Exception) -> Response:
    status = error.status_code if isinstance(error, HTTPException) else 500
    return failure(status, str(getattr(error, "detail", error)))


async def _invalid_request(_: Request, error: Exception) -> Response:
    first = error.errors()[0] if isinstance(error, RequestValidationError) else {"loc": (), "msg": ""}
    return failure(
        400, f"{first['loc'][-1]}: found {first.get('input')!r:.80}; {first['msg']}; change it in the address"
    )


async def _archive_failure(_: Request, error: Exception) -> Response:
    return failure(400 if isinstance(error, QueryError) else 422, str(error))


async def _file_failure(_: Request, error: Exception) -> Response:
    status, name = 404 if isinstance(error, FileNotFoundError) else 422, getattr(error, "filename", None)
    why = getattr(error, "strerror", None) or error
    return failure(status, f"{name}: cannot be read ({why}); expected a file in the archive; go back to the table")
