"""The application: what is asked of an archive, and the pages that ask."""

from pathlib import Path

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.responses import Response

from tribopipe.base.errors import QueryError, TribopipeError
from tribopipe.browse.bundle import bundle_router
from tribopipe.browse.guard import Guard
from tribopipe.browse.h5 import h5_router
from tribopipe.browse.json_answer import failure
from tribopipe.browse.key import Key
from tribopipe.browse.library import Library
from tribopipe.browse.routes import api_router


def create_app(archive_folder: Path, key: Key) -> FastAPI:
    """Return the application for whoever shows a key; it reads the archive and writes nothing but its catalog."""
    app = FastAPI(openapi_url=None, docs_url=None, redoc_url=None, redirect_slashes=False)
    app.state.library = Library(archive_folder)
    app.include_router(api_router(app.state.library))
    app.include_router(h5_router(archive_folder))
    app.include_router(bundle_router())
    app.add_middleware(Guard, key=key)
    app.add_exception_handler(HTTPException, _told)
    app.add_exception_handler(RequestValidationError, _misunderstood)
    app.add_exception_handler(TribopipeError, _unreadable)
    app.add_exception_handler(OSError, _gone)
    return app


async def _told(_: Request, error: Exception) -> Response:
    status = error.status_code if isinstance(error, HTTPException) else 500
    return failure(status, str(getattr(error, "detail", error)))


async def _misunderstood(_: Request, error: Exception) -> Response:
    first = error.errors()[0] if isinstance(error, RequestValidationError) else {"loc": (), "msg": ""}
    return failure(
        400, f"{first['loc'][-1]}: found {first.get('input')!r:.80}; {first['msg']}; change it in the address"
    )


async def _unreadable(_: Request, error: Exception) -> Response:
    return failure(400 if isinstance(error, QueryError) else 422, str(error))


async def _gone(_: Request, error: Exception) -> Response:
    status, name = 404 if isinstance(error, FileNotFoundError) else 422, getattr(error, "filename", None)
    why = getattr(error, "strerror", None) or error
    return failure(status, f"{name}: cannot be read ({why}); expected a file of the archive; go back to the table")
