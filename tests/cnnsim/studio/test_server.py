"""The server of a studio refuses what does not come from its own page, and survives what comes."""

import json
import time
from collections.abc import Iterator
from contextlib import ExitStack
from socket import SHUT_RDWR
from typing import Any

import pytest

pytest.importorskip("uvicorn", reason="needs the extra studio")
websockets = pytest.importorskip("websockets", reason="needs the extra studio")

from cnnsim.studio.message import Message, pack, unpack  # noqa: E402 - after the check for the extra
from cnnsim.studio.server import MOST_PAGES  # noqa: E402
from tests.kits.studio import Visitor, serving  # noqa: E402


class Echo:
    """A model that sends back what it gets, a megabyte on request, and counts what it was asked."""

    asked = 0

    def receive(self, message: Message) -> Message:
        Echo.asked += 1
        if message.content.get("do") == "fault":
            raise ZeroDivisionError("a fault")
        return Message(message.content, [bytes(2**20)] if message.content.get("do") == "much" else message.buffers)


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    with serving(Echo) as found:
        yield found


@pytest.fixture(scope="module")
def visitor(address: str) -> Visitor:
    one = Visitor(address)
    one.enter()
    return one


def answers(socket: Any) -> bool:
    """Whether the connection still works."""
    socket.send('{"do": "echo"}')
    return bool(unpack(socket.recv()).content == {"do": "echo"})


def refused(visitor: Visitor, **headers: str) -> int:
    with pytest.raises(websockets.exceptions.InvalidStatus) as error:
        visitor.socket(**headers)
    return int(error.value.response.status_code)


def test_the_token_is_taken_once_and_the_cookie_stays(address: str, visitor: Visitor) -> None:
    status, headers, body = visitor.request("/")
    assert (status, b"cnnsim studio" in body) == (200, True)
    assert headers["content-security-policy"].startswith("default-src 'self';")
    assert headers["x-content-type-options"] == "nosniff"
    stranger = Visitor(address)
    assert stranger.request(f"/{stranger.query}")[0] == 403
    assert stranger.request("/")[0] == 403
    assert stranger.request("/page/main.js")[0] == 403
    assert stranger.request("/", Cookie=visitor.cookie[:-1] + "x")[0] == 403
    assert visitor.request(f"/{visitor.query}")[0] == 303
    assert visitor.request("/page/main.js")[0] == 200
    assert visitor.request("/page/../session.py")[0] == 404
    assert visitor.request("/page/%2e%2e/session.py")[0] == 404


def test_the_cookie_is_out_of_reach_of_scripts_and_of_other_sites() -> None:
    with serving(Echo) as address:
        one = Visitor(address)
        _, headers, _ = one.request(f"/{one.query}")
    assert "httponly" in headers["set-cookie"].lower()
    assert "samesite=strict" in headers["set-cookie"].lower()


def test_a_foreign_origin_is_refused(visitor: Visitor) -> None:
    assert refused(visitor, Origin="http://evil.example") == 403
    assert refused(visitor, Origin="null") == 403
    assert refused(visitor, Origin="") == 403
    assert visitor.request("/", "POST")[0] == 403
    assert visitor.request("/", "POST", Origin="http://evil.example")[0] == 403
    assert visitor.request("/", "POST", Origin=f"http://{visitor.host}")[0] == 405


def test_a_host_that_is_rebound_is_refused(visitor: Visitor) -> None:
    port = visitor.host.rsplit(":", 1)[1]
    for host in (f"evil.example:{port}", "127.0.0.1:1", "127.0.0.1", f"8.8.8.8:{port}", ""):
        assert visitor.request("/", Host=host)[0] == 421, host
    assert refused(visitor, Host=f"evil.example:{port}", Origin=f"http://evil.example:{port}") == 403
    assert visitor.request("/", Host=f"localhost:{port}")[0] == 200


def test_without_the_cookie_there_is_no_websocket(visitor: Visitor) -> None:
    assert refused(visitor, Cookie="") == 403


def test_a_message_of_100_megabytes_ends_its_connection_only(visitor: Visitor) -> None:
    with visitor.socket() as other, visitor.socket() as socket:
        try:
            socket.send(bytes(100 * 2**20))
            socket.recv()
        except websockets.exceptions.ConnectionClosed as error:
            assert error.rcvd is None or error.rcvd.code == 1009
        else:
            pytest.fail("it was taken")
        assert answers(other)


@pytest.mark.parametrize(
    "data",
    ["{", "[]", "nothing", '"text"', "[" * 100_000, '{"sizes": [1]}', b"", b"\xff\xff\xff\xff", bytes(5),
     b"\x02\x00\x00\x00{}x", '{"do": "fault"}'],
    ids=range(11),
)  # fmt: skip
def test_a_malformed_message_is_an_error_that_ends_nothing(data: str | bytes, visitor: Visitor) -> None:
    with visitor.socket() as socket:
        socket.send(data)
        assert json.loads(socket.recv())["is"] == "error"
        assert answers(socket)


def test_several_pages_have_models_of_their_own_and_too_many_are_refused(visitor: Visitor) -> None:
    with ExitStack() as pages:
        sockets = [pages.enter_context(visitor.socket()) for _ in range(MOST_PAGES)]
        assert all(map(answers, sockets))
        with visitor.socket() as late, pytest.raises(websockets.exceptions.ConnectionClosed) as error:
            late.recv()
        assert error.value.rcvd.code == 1013
        assert "close one" in error.value.rcvd.reason
    time.sleep(0.1)
    with visitor.socket() as again:
        assert answers(again)


def test_a_page_that_never_reads_is_not_asked_on(visitor: Visitor) -> None:
    with visitor.socket() as greedy, visitor.socket() as other:
        before = Echo.asked
        for _ in range(60):
            greedy.send('{"do": "much"}')
        time.sleep(0.5)
        assert answers(other)
        assert Echo.asked - before < 45  # what it does not read fills the buffers of the system, then nothing is done


def test_a_page_that_is_closed_in_mid_run_leaves_the_others(visitor: Visitor) -> None:
    with visitor.socket() as socket:
        for _ in range(5):
            socket.send('{"do": "much"}')
        socket.socket.shutdown(SHUT_RDWR)
    with visitor.socket() as other:
        assert answers(other)


def test_another_address_is_listened_on_only_if_it_is_asked_for() -> None:
    with serving(Echo, "127.0.0.2") as address:
        assert address.startswith("http://127.0.0.2:")
        one = Visitor(address)
        one.enter()
        with one.socket() as socket:
            assert answers(socket)


def test_messages_are_packed_and_unpacked() -> None:
    message = Message({"do": "x", "n": float("nan"), "list": (1, 2.5)}, [b"ab", b"", b"c"])
    found = unpack(pack(message))
    assert (found.content, found.buffers) == ({"do": "x", "n": None, "list": [1, 2.5]}, [b"ab", b"", b"c"])
    assert unpack(pack(Message({"a": 1}))).content == {"a": 1}
