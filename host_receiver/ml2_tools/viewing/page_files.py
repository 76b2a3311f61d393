"""The files of the page, and the headers with which they are served."""

from importlib import resources

_TYPES = {
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".txt": "text/plain; charset=utf-8",
}
_START = "index.html"
HEADERS = {
    # The page loads its own files and connects to its own server, and to nothing else.
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self';"
    " connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


def page_files() -> dict[str, tuple[str, bytes]]:
    """Returns content type and content of each file of the page by path; the page itself is "/"."""
    found = {}
    for file in resources.files(__package__).joinpath("page").iterdir():
        path = "/" if file.name == _START else f"/{file.name}"
        found[path] = _TYPES["." + file.name.rpartition(".")[2]], file.read_bytes()
    return found
