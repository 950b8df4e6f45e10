"""The client: files that were built with the package, and its one page for every other address."""

from pathlib import Path

from fastapi import APIRouter
from starlette.exceptions import HTTPException
from starlette.responses import FileResponse, Response

from tribopipe.browse.guard import inside

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
    "found no web pages in this installation; expected those that are built with the package; run `pip install "
    "--force-reinstall tribopipe` where the npm registry can be reached, or `npm ci && npm run build` in "
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
                404, f"found no answer at /{path}; expected an address of the server; go back to the table"
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
