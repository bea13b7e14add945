"""A studio that serves in a thread, and a visitor to it without a browser."""

import http.client
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from cnnsim.studio.message import Message, pack
from cnnsim.studio.session import Session

FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync"]  # fmt: skip
"""Options of Chromium where it has no display, no network and no sandbox."""

GRID = (12, 16)


def ask(session: Session, do: str, *buffers: bytes, **content: Any) -> Message:
    """Return the reply of a session; it can be sent."""
    reply = session.receive(Message({"do": do, **content}, list(buffers)))
    pack(reply)
    return reply


@contextmanager
def serving(make_model: Callable[[], Any], host: str = "127.0.0.1", page: Path | None = None) -> Iterator[str]:
    """Serve in a thread and yield the address with the token; ``page`` is the playground's if not given."""
    pytest.importorskip("uvicorn", reason="needs the extra studio")
    from cnnsim.studio import PAGE
    from cnnsim.studio.server import make_server

    server, listening, address = make_server(make_model, page or PAGE, host, 0)
    thread = threading.Thread(target=lambda: server.run(sockets=[listening]), daemon=True)
    thread.start()
    until = time.monotonic() + 20
    while not server.started and time.monotonic() < until:
        time.sleep(0.01)
    yield address
    server.should_exit = True
    thread.join(10)
    assert not thread.is_alive()


class Visitor:
    """Requests without a browser, with any headers."""

    def __init__(self, address: str) -> None:
        self.host, self.query = address.removeprefix("http://").split("/", 1)
        self.cookie = ""

    def request(self, path: str, method: str = "GET", **headers: str) -> tuple[int, dict[str, str], bytes]:
        """Return status, headers and body."""
        name, port = self.host.rsplit(":", 1)
        connection = http.client.HTTPConnection(name, int(port), timeout=20)
        connection.putrequest(method, path, skip_host=True)
        for key, value in {"Host": self.host, "Cookie": self.cookie, **headers}.items():
            connection.putheader(key, value)
        connection.endheaders()
        answer = connection.getresponse()
        found = answer.status, {key.lower(): value for key, value in answer.getheaders()}, answer.read()
        connection.close()
        return found

    def enter(self) -> None:
        """Take the cookie for the token."""
        status, headers, _ = self.request(f"/{self.query}")
        assert status == 303, status
        self.cookie = headers["set-cookie"].split(";")[0]

    def socket(self, **headers: str) -> Any:
        """Open a websocket; the headers replace those of the page itself."""
        from websockets.sync.client import connect

        given = {"Cookie": self.cookie, "Origin": f"http://{self.host}", **headers}
        host, extra = given.pop("Host", self.host), {key: value for key, value in given.items() if value}
        name, port = self.host.rsplit(":", 1)
        plain = socket.create_connection((name, int(port)), timeout=20)
        return connect(f"ws://{host}/ws", sock=plain, additional_headers=extra, compression=None, max_size=None,
                       close_timeout=0.2)  # fmt: skip
