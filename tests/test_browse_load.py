"""The server waits for nobody without end, sends files piece by piece, and makes two reports at a time."""

import socket
import threading
import time
from contextlib import ExitStack, suppress

import pytest
from browse_client import Client, serving
from waiting import wait_until

from tribopipe.browse import server
from tribopipe.browse.server import HOST

RUN = "si3n4-air-200mN"


@pytest.fixture
def client(archive):
    with serving(archive) as asked:
        yield asked


@pytest.fixture
def lost(monkeypatch):
    """The connections that the server has seen end."""
    ended, ends = [], server.PatientProtocol.connection_lost

    def connection_lost(protocol, exc) -> None:
        ends(protocol, exc)
        ended.append(protocol)

    monkeypatch.setattr(server.PatientProtocol, "connection_lost", connection_lost)
    return ended


def sent(client: Client, text: str, held: ExitStack) -> socket.socket:
    made = held.enter_context(socket.create_connection((HOST, client.port), timeout=20))
    made.sendall(text.encode())
    return made


def request(client: Client, target: str) -> str:
    return f"GET {target} HTTP/1.1\r\nHost: {HOST}:{client.port}\r\nCookie: {client.site.headers['Cookie']}\r\n\r\n"


@pytest.mark.slow
@pytest.mark.parametrize("said", ["", "GET /", "GET / HTTP/1.1\r\nHost: x\r\n"])
def test_a_request_that_does_not_come_is_not_waited_for(client, monkeypatch, said):
    monkeypatch.setattr(server, "_REQUEST_WITHIN", 0.2)
    with ExitStack() as held:
        waiting = sent(client, said, held)
        wait_until(lambda: not is_open(waiting))


@pytest.mark.slow
def test_the_longest_without_a_request_gives_way(client, monkeypatch):
    monkeypatch.setattr(server, "most_connections", lambda: 20)
    with ExitStack() as held:
        waiting = [sent(client, "GET / HTTP/1.1\r\n", held) for _ in range(100)]
        assert client.get("api", "revision").status == 200
        time.sleep(0.2)
        left = [one for one in waiting if is_open(one)]
        assert 10 <= len(left) <= 20
        assert waiting[0] not in left
        assert waiting[-1] in left


def is_open(one: socket.socket) -> bool:
    one.settimeout(0.05)
    try:
        return one.recv(1) != b""
    except TimeoutError:
        return True
    except OSError:
        return False


@pytest.mark.slow
def test_an_answer_that_nobody_takes_ends(archive, monkeypatch, lost):
    (archive / "long.h5").write_bytes(bytes(30 << 20))
    monkeypatch.setattr(server, "_TAKEN_WITHIN", 0.3)
    with serving(archive) as client, ExitStack() as held:
        slow = sent(client, request(client, "/api/runs/long/file"), held)
        wait_until(lambda: len(lost) == 1)
        length = 0
        with suppress(ConnectionError):
            while piece := slow.recv(1 << 20):
                length += len(piece)
        assert length < 30 << 20


def test_a_download_is_the_file_with_its_length(client, archive):
    answer = client.get("api", "runs", RUN, "file")
    assert answer.body == (archive / f"{RUN}.h5").read_bytes()
    assert answer.headers["content-length"] == str(len(answer.body))


def test_two_reports_at_a_time_and_none_for_those_who_left(client, monkeypatch, lost):
    busy, most, made, go = [0], [0], [], threading.Event()

    def report(*_) -> str:
        busy[0] += 1
        most[0] = max(most[0], busy[0])
        made.append(go.wait(60))
        busy[0] -= 1
        return "a report"

    monkeypatch.setattr("tribopipe.views.html.document.run_report", report)
    with ExitStack() as held:
        for _ in range(10):
            sent(client, request(client, f"/api/runs/{RUN}/report"), held)
        wait_until(lambda: busy[0] == 2)
        assert client.get("api", "revision").status == 200
    wait_until(lambda: len(lost) == 11)
    assert client.get("api", "revision").status == 200
    go.set()
    assert client.get("api", "runs", RUN, "report").body == b"a report"
    wait_until(lambda: not busy[0])
    assert (most[0], len(made)) == (2, 3)


@pytest.mark.slow
def test_a_report_that_nobody_waits_for_is_not_finished(client, monkeypatch, lost):
    figures = []

    def report(*given) -> str:
        go_on = given[-1]
        for number in range(100):
            go_on()
            figures.append(number)
            time.sleep(0.05)
        return "a report"

    monkeypatch.setattr("tribopipe.views.html.document.run_report", report)
    with ExitStack() as held:
        sent(client, request(client, f"/api/runs/{RUN}/report"), held)
        wait_until(lambda: bool(figures))
    wait_until(lambda: len(lost) == 1)
    time.sleep(0.3)
    seen = len(figures)
    time.sleep(0.3)
    assert 0 < seen < 50
    assert len(figures) == seen
