"""The server of a studio: serves the page's files and one websocket a page to a browser that has the token.

Every connection has a model of its own; all models run on one thread. The next message of a page is read when the
reply to the last one is sent, so a page that does not read costs no memory.
"""

import ipaddress
import secrets
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any

from starlette.applications import Starlette
from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.responses import FileResponse, PlainTextResponse, RedirectResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from cnnsim.studio.message import MOST_BYTES, Model, pack, reply_to, unpack
from cnnsim.studio.message import Message as PageMessage
from cnnsim.support import InputError

if TYPE_CHECKING:
    from uvicorn import Server

MOST_PAGES = 4
"""Pages that are open at a time."""
HEADERS = {
    "content-security-policy": (
        "default-src 'self'; object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}


class Guard:
    """ASGI middleware: refuses foreign Host and Origin headers and visitors without the cookie; adds `HEADERS`.

    ``host`` is the address the server listens on; ``port`` is set when it is known. A name in the Host header could be
    anyone's (DNS rebinding), so only addresses, localhost and ``host`` itself are taken.
    """

    def __init__(self, app: ASGIApp, host: str) -> None:
        self.app, self.host, self.port = app, host, 0
        self.token, self._key = secrets.token_urlsafe(24), secrets.token_urlsafe(24)
        self._used = False

    @property
    def cookie(self) -> str:
        """The name of the cookie; cookies of one host are shared by all ports."""
        return f"studio-{self.port}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        refusal = self._refusal(scope, headers)
        if refusal is None and scope["type"] == "http" and scope["path"] == "/":
            refusal = self._entered(Request(scope))
        elif refusal is None and not self._known(headers):
            refusal = PlainTextResponse("403: open the address that the command prints", 403)

        async def send_guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                named = [(name.encode(), value.encode()) for name, value in HEADERS.items()]
                message = {**message, "headers": [*message["headers"], *named]}
            await send(message)

        if refusal is None:
            await self.app(scope, receive, send_guarded)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})  # before it is accepted: the answer is HTTP 403
        else:
            await refusal(scope, receive, send_guarded)

    def _refusal(self, scope: Scope, headers: Headers) -> Response | None:
        host = headers.get("host", "")
        if not self._is_ours(host):
            return PlainTextResponse("421: this host is not served here", 421)
        changes = scope["type"] == "websocket" or scope["method"] not in ("GET", "HEAD")
        if changes and headers.get("origin") != f"http://{host}":
            return PlainTextResponse("403: a page of another origin", 403)
        return None

    def _is_ours(self, host: str) -> bool:
        name, _, port = host.rpartition(":")
        if port != str(self.port):
            return False
        if name in ("localhost", "127.0.0.1", self.host):
            return True
        try:
            address = ipaddress.ip_address(name.strip("[]"))
        except ValueError:
            return False
        return self.host not in ("localhost", "127.0.0.1") and not address.is_unspecified

    def _known(self, headers: Headers) -> bool:
        cookies = (part.strip().partition("=") for part in headers.get("cookie", "").split(";"))
        return any(
            n == self.cookie and secrets.compare_digest(value.encode(), self._key.encode()) for n, _, value in cookies
        )

    def _entered(self, request: Request) -> Response | None:
        """Return the answer to a visit of "/": a cookie for the token, which is valid once; None for a known one."""
        if self._known(request.headers):
            return RedirectResponse("/", 303) if "token" in request.query_params else None
        given = request.query_params.get("token", "")
        if self._used or not secrets.compare_digest(given.encode(), self.token.encode()):
            return PlainTextResponse("403: open the address that the command prints; it is valid once", 403)
        self._used = True
        answer = RedirectResponse("/", 303)
        answer.set_cookie(self.cookie, self._key, httponly=True, samesite="strict")
        return answer


def make_app(make_model: Callable[[], Model], page: Path, host: str = "127.0.0.1") -> Guard:
    """Return the guarded application: "/" is index.html of the folder ``page``, /ws the websocket.

    /page/ has the files of the folder, and those of the playground's page, whose modules other pages import.
    """
    worker = ThreadPoolExecutor(1, "studio")
    pages: set[WebSocket] = set()

    async def index(_request: Request) -> Response:
        return FileResponse(page / "index.html")

    async def talk(socket: WebSocket) -> None:
        await socket.accept()
        if len(pages) >= MOST_PAGES:
            await socket.close(1013, f"{MOST_PAGES} pages are open; close one")
            return
        pages.add(socket)
        try:
            await _talk(socket, make_model, worker)
        except WebSocketDisconnect:
            pass
        finally:
            pages.discard(socket)

    routes = [
        Route("/", index),
        Mount("/page", StaticFiles(directory=page, packages=[("cnnsim.studio", "page")])),
        WebSocketRoute("/ws", talk),
    ]
    return Guard(Starlette(routes=routes), host)


async def _talk(socket: WebSocket, make_model: Callable[[], Model], worker: ThreadPoolExecutor) -> None:
    from asyncio import get_running_loop

    loop = get_running_loop()
    model = await loop.run_in_executor(worker, make_model)
    while True:
        event = await socket.receive()
        if event["type"] == "websocket.disconnect":
            return
        data = event["bytes"] if event.get("bytes") is not None else event["text"]
        reply = await loop.run_in_executor(worker, _answer, model, data)
        if isinstance(reply, str):
            await socket.send_text(reply)
        else:
            await socket.send_bytes(reply)


def _answer(model: Model, data: str | bytes) -> str | bytes:
    try:
        message = unpack(data)
    except InputError as error:
        return pack(PageMessage({"is": "error", "text": str(error)}))
    return pack(reply_to(model, message))


def make_server(make_model: Callable[[], Model], page: Path, host: str, port: int) -> tuple["Server", Any, str]:
    """Return a server, its listening socket (its ``run`` takes a list of them) and the address with the token.

    Port 0 takes a free one.

    Raises:
        InputError: the address cannot be listened on.
    """
    import uvicorn

    app = make_app(make_model, page, host)
    config = uvicorn.Config(
        app, host, port, log_config=None, log_level="critical", access_log=False, lifespan="off",
        ws="websockets-sansio", ws_max_size=MOST_BYTES, ws_per_message_deflate=False, server_header=False,
        timeout_graceful_shutdown=1,
    )  # fmt: skip
    try:
        listening = config.bind_socket()
    except SystemExit as error:  # uvicorn's way to report an OSError
        raise InputError(f"port {port} of {host} cannot be listened on; another one wanted") from error
    app.port = listening.getsockname()[1]
    shown = "127.0.0.1" if host in ("0.0.0.0", "::") else host
    address = f"http://{f'[{shown}]' if ':' in shown else shown}:{app.port}/?token={app.token}"
    return uvicorn.Server(config), listening, address
