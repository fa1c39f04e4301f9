"""Read-only loopback server for the page, which requires a token.

Each request is checked first. Requests are rejected if the host is not the loopback (DNS rebinding), the origin is
another page, or the token is wrong.
"""

import asyncio
import json
import secrets
import socket
import threading
import warnings
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Mapping, MutableMapping
from contextlib import suppress
from dataclasses import dataclass
from importlib.resources import files
from typing import TYPE_CHECKING, Any, BinaryIO, Final

from tactometry.errors import DeviceFailed, library_needed

from .scenery import Scenery

if TYPE_CHECKING:
    from starlette.applications import Starlette
    from starlette.requests import Request as HttpRequest
    from starlette.responses import Response

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Message, Receive, Send], Awaitable[None]]

LOOPBACK: Final = "127.0.0.1"
HEADERS: Final = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; base-uri 'none'; "
        "form-action 'none'; frame-ancestors 'none'"
    ),
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
}
SERVED: Final = {"page.css": "text/css", "page.js": "text/javascript"}
"""Static files that a browser requests, with their media types."""
LOOK_EVERY_S = 0.5
NO_LIBRARY: Final = "watch: found no library for its page ({error}); pip install 'tactometry[watch]'"


def refusal(headers: Mapping[str, str], path: str, port: int, token: str) -> int | None:
    """Return the HTTP status for a rejected request, or None if allowed.

    - `headers`: Headers by lower-case name.

    >>> refusal({"host": "127.0.0.1:8000"}, "/t/", 8000, "t"), refusal({"host": "127.0.0.1:8000"}, "/", 8000, "t")
    (None, 404)
    >>> refusal({"host": "evil.example:8000"}, "/t/", 8000, "t")
    403
    >>> refusal({"host": "127.0.0.1:8000", "origin": "http://evil.example"}, "/t/", 8000, "t")
    403
    """
    hosts = f"{LOOPBACK}:{port}", f"localhost:{port}"
    origins = None, *(f"http://{host}" for host in hosts)
    sites = None, "same-origin", "none"
    is_ours = (
        headers.get("host") in hosts and headers.get("origin") in origins and headers.get("sec-fetch-site") in sites
    )
    if not is_ours:
        return 403
    given = path.split("/")[1] if "/" in path else ""
    return None if secrets.compare_digest(given.encode(), token.encode()) else 404


def combined(headers: Iterable[tuple[bytes, bytes]]) -> dict[str, str]:
    """Join repeated headers with commas. No valid value contains a comma.

    >>> combined([(b"host", b"127.0.0.1:8000"), (b"origin", b"null"), (b"origin", b"null")])
    {'host': '127.0.0.1:8000', 'origin': 'null, null'}
    """
    values: dict[str, list[str]] = {}
    for name, value in headers:
        values.setdefault(name.decode("latin-1"), []).append(value.decode("latin-1"))
    return {name: ", ".join(each) for name, each in values.items()}


@dataclass(frozen=True)
class Guard:
    """Middleware that rejects requests before the application sees them."""

    app: App
    port: int
    token: str

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
            status = refusal(combined(scope["headers"]), scope["path"], self.port, self.token)
            if status is not None:
                await send({"type": "http.response.start", "status": status, "headers": []})
                await send({"type": "http.response.body", "body": b""})
                return
        await self.app(scope, receive, send)


async def news(scenery: Scenery) -> AsyncIterator[bytes]:
    """Function that yields changed sections as server-sent events."""
    shown: Mapping[str, str] = {}
    while True:
        sections = scenery.sections()
        new = {name: html for name, html in sections.items() if shown.get(name) != html}
        if new:
            yield f"data: {json.dumps(new)}\n\n".encode()
        shown = sections
        await asyncio.sleep(LOOK_EVERY_S)


def application(scenery: Scenery, port: int, token: str) -> "Starlette":
    """Return the application, served at a port under the token's path.

    Raises `DeviceFailed` if the library of the server is not installed.
    """
    with library_needed(NO_LIBRARY):
        from starlette.applications import Starlette
        from starlette.middleware import Middleware
        from starlette.responses import HTMLResponse, Response, StreamingResponse
        from starlette.routing import Mount, Route

    async def page(request: "HttpRequest") -> "Response":
        del request
        return HTMLResponse(scenery.page(), headers=HEADERS)

    async def file(request: "HttpRequest") -> "Response":
        name = request.url.path.rpartition("/")[2]
        text = (files(__package__) / name).read_text("utf-8")
        return Response(text, media_type=SERVED[name], headers=HEADERS)

    async def events(request: "HttpRequest") -> "Response":
        del request
        return StreamingResponse(news(scenery), media_type="text/event-stream", headers=HEADERS)

    routes = [Route("/", page), Route("/events", events), *(Route(f"/{name}", file) for name in SERVED)]
    guard = Middleware(Guard, port=port, token=token)
    return Starlette(routes=[Mount(f"/{token}", routes=routes)], middleware=[guard])


def serve(scenery: Scenery, port: int, tell: Callable[[str], None], until: BinaryIO | None = None) -> None:
    """Serve the page until Ctrl-C or until a stream ends.

    `tell` receives the address, which contains the token.

    Raises `DeviceFailed` if the port is in use, or the library of the server is not installed.

    - `port`: Port to listen at. 0 selects any free port.
    - `until`: Stream whose end stops the server. A thread reads it.
    """
    with library_needed(NO_LIBRARY):
        import uvicorn

    with _bound(port) as listening:
        port, token = listening.getsockname()[1], secrets.token_urlsafe(24)
        config = uvicorn.Config(
            application(scenery, port, token),
            log_config=None,
            log_level="critical",
            access_log=False,
            server_header=False,
            http="h11",
            ws="none",
            loop="asyncio",
            lifespan="off",
            timeout_graceful_shutdown=1,
        )
        server = uvicorn.Server(config)
        if until is not None:
            threading.Thread(target=_end_with, args=(until, server), daemon=True).start()
        # Ctrl-C may arrive before the loop starts. Python then warns of a coroutine that was never awaited.
        with warnings.catch_warnings(action="ignore", category=RuntimeWarning), suppress(KeyboardInterrupt):
            tell(f"http://{LOOPBACK}:{port}/{token}/")
            server.run(sockets=[listening])


def _bound(port: int) -> socket.socket:
    """Return a socket bound to a loopback port."""
    result = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        result.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        result.bind((LOOPBACK, port))
        result.listen()
    except OSError as error:
        result.close()
        raise DeviceFailed(
            f"--port: cannot listen at {LOOPBACK}:{port} ({error.strerror}), expected a free port; leave the option out"
        ) from None
    return result


def _end_with(stream: BinaryIO, server: Any) -> None:
    while stream.read(4096):
        pass
    server.should_exit = True
