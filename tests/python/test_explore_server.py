"""The server of `stiefel-rs explore`: its curves, access control, and bad requests."""

import http.client
import json
import re
import socket
import threading
from contextlib import ExitStack

import numpy as np
import pytest
from beside import HANGS
from explore_problem import library, running

from stiefel_rs.explore import page, server

pytest.importorskip("plotly")

GOOD = {"kind": "sphere", "angle": 1.5, "v0": [1, 2], "v1": [1, -2.5]}


@pytest.fixture(scope="module")
def served():
    with running() as made:
        yield made


def ask(served, method="POST", path="/curves", body=None, **changed):
    """Status and content of an answer; `changed` replaces headers, None omits one."""
    headers = {"Host": f"127.0.0.1:{served.server_port}", "X-Token": served.token, "Content-Type": "application/json"}
    headers |= {name.replace("_", "-"): value for name, value in changed.items()}
    connection = http.client.HTTPConnection("127.0.0.1", served.server_port, timeout=HANGS)
    connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
    data = b"" if body is None else body if isinstance(body, bytes) else json.dumps(body).encode()
    if method == "POST" and "Content-Length" not in headers:
        headers["Content-Length"] = str(len(data))
    for name, value in headers.items():
        if value is not None:
            connection.putheader(name, value)
    connection.endheaders(data or None)
    response = connection.getresponse()
    content = response.read()
    connection.close()
    if response.getheader("Content-Type").startswith("application/json"):
        content = json.loads(content)
    return response.status, content, response


def test_curves_of_the_server_are_those_of_the_library(served):
    for request in (GOOD, {"kind": "frame", "angle": 0.8, "v0": [1, 0, 2], "v1": [0, -1, 1.5]}):
        status, found, _ = ask(served, body=request)
        assert status == 200
        *both, M = library(*request.values())
        t = np.array(found["t"])
        for name, curve in zip(("gcp", "cubic"), both, strict=True):
            assert np.array_equal(np.array(found["curves"][name]["points"]).reshape(-1, 3, curve.k), curve(t))
            assert found["curves"][name]["cost"] == curve.cost()
            assert np.array_equal(found["curves"][name]["speed"], M.norm(curve(t), curve.velocity(t)))
        assert np.array_equal(found["distance"], np.linalg.norm(both[0](t) - both[1](t), axis=(1, 2)))


def test_the_page_needs_the_token(served):
    status, content, response = ask(served, "GET", f"/?token={served.token}", X_Token=None)
    assert status == 200
    assert content.decode() == page.served("sphere")
    assert response.getheader("Cache-Control") == "no-store"
    assert response.getheader("Referrer-Policy") == "no-referrer"
    for path in ("/", "/?token=", f"/?token={served.token}x", f"/?token={served.token[:-1]}", "/?token=%ff%F0%9F"):
        status, content, _ = ask(served, "GET", path)
        assert status == 403, path
        assert content == {"error": "wrong token: use the address that stiefel-rs explore printed"}


@pytest.mark.parametrize("token", [None, "", "x", "\u00e9"])
def test_curves_need_the_token(served, token):
    assert ask(served, body=GOOD, X_Token=token)[0] == 403


def test_token_is_long_random_and_compared_in_constant_time(served, monkeypatch):
    with server.Server("sphere") as other:
        assert other.token != served.token
    assert len(served.token) >= 32
    seen, compare = [], server.secrets.compare_digest
    monkeypatch.setattr(server.secrets, "compare_digest", lambda a, b: seen.append((a, b)) or compare(a, b))
    ask(served, body=GOOD, X_Token="wrong")
    assert seen == [(b"wrong", served.token.encode())]


@pytest.mark.parametrize("host", [None, "", "evil.example", "evil.example:80", "127.0.0.1", "127.0.0.1:1"])
def test_other_hosts_are_refused(served, host):
    """A foreign name that resolves to this machine (DNS rebinding) is not accepted."""
    for method, path in (("GET", f"/?token={served.token}"), ("POST", "/curves")):
        status, content, _ = ask(served, method, path, body=GOOD if method == "POST" else None, Host=host)
        assert (status, content) == (403, {"error": "wrong host"})


def test_other_origins_are_refused(served):
    assert ask(served, body=GOOD, Origin="http://evil.example")[0] == 403
    assert ask(served, body=GOOD, Origin="null")[0] == 403
    assert ask(served, body=GOOD, Origin=f"http://localhost:{served.server_port}")[0] == 200


def test_only_this_machine_is_listened_to(served):
    assert served.server_address[0] == "127.0.0.1"


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (b"", "not JSON"),
        (b"{", "not JSON"),
        (b"\xff\xfe", "not JSON"),
        (b"[" * 4000, "not JSON"),
        (b"[]", "an object with angle, kind, v0, v1 expected"),
        (GOOD | {"more": 1}, "an object with"),
        ({"kind": "sphere"}, "an object with"),
        (GOOD | {"kind": "torus"}, "kind: sphere or frame expected"),
        (GOOD | {"kind": ["sphere"]}, "kind: sphere or frame expected"),
        (GOOD | {"angle": "1"}, "angle: finite numbers expected"),
        (GOOD | {"angle": True}, "angle: finite numbers expected"),
        (GOOD | {"angle": -1}, "angle: from 0 (excluded) to pi expected, found -1"),
        (GOOD | {"v0": 1}, "v0: a list of numbers expected"),
        (GOOD | {"v0": [1, None]}, "v0: finite numbers expected"),
        (GOOD | {"v0": [1, [2]]}, "v0: finite numbers expected"),
        (GOOD | {"v0": [1, 2, 3]}, "v0: 2 numbers expected"),
        (GOOD | {"v1": [1, 1e3]}, "v1: at most 20 expected, found 1000"),
        (GOOD | {"v1": [1, 10**400]}, "v1: finite numbers expected"),
        (GOOD | {"v1": [float("nan"), 0]}, "NaN is no number of JSON"),
        (GOOD | {"v1": [float("-inf"), 0]}, "-Infinity is no number of JSON"),
        (json.dumps(GOOD).replace("-2.5", "1e999").encode(), "v1: finite numbers expected"),
    ],
)
def test_bad_requests(served, body, message):
    status, content, _ = ask(served, body=body)
    assert status == 400
    assert content["error"].startswith("InvalidInputError: ")
    assert message in content["error"]


def test_large_requests_are_not_read(served):
    body = json.dumps(GOOD).encode() + b" " * server.MAX_BODY
    for length in (str(len(body)), "9" * 5000):
        status, content, response = ask(served, body=body, Content_Length=length)
        assert (status, content) == (413, {"error": "at most 4096 bytes expected"})
        assert response.getheader("Connection") == "close"


@pytest.mark.parametrize(
    ("changed", "status"),
    [
        ({"Content_Length": None}, 411),
        ({"Content_Length": "-1"}, 411),
        ({"Content_Length": "ten"}, 411),
        ({"Transfer_Encoding": "chunked"}, 411),
        ({"Content_Type": "text/plain"}, 415),
        ({"Content_Type": None}, 415),
        ({"path": "/other"}, 404),
        ({"method": "PUT"}, 501),
    ],
)
def test_unusual_requests(served, changed, status):
    connection_broken = (http.client.RemoteDisconnected, ConnectionResetError)
    try:
        found = ask(served, **({"body": GOOD} | changed))
    except connection_broken:
        pytest.fail("no answer")
    assert found[0] == status


def test_a_page_that_is_not_there(served):
    assert ask(served, "GET", f"/favicon.ico?token={served.token}")[0] == 404


@pytest.mark.parametrize("method", ["GET", "HEAD"])
@pytest.mark.parametrize("address", ["http://[", "//[::1", "http://[x]/?token=1", "http://\u2100/"])
def test_addresses_that_are_none(served, capfd, method, address):
    """A sender without a token gets an answer, and nothing is printed."""
    with socket.create_connection(("127.0.0.1", served.server_port), timeout=HANGS) as connection:
        connection.sendall(f"{method} {address} HTTP/1.1\r\nHost: x\r\n\r\n".encode())
        answer = b"".join(iter(lambda: connection.recv(4096), b""))
    assert re.match(rb"HTTP/1\.1 40[03] ", answer)
    if address == "http://[":
        assert answer.startswith(b"HTTP/1.1 400 ")
    assert capfd.readouterr() == ("", "")


def test_curves_that_do_not_exist_come_as_text(served):
    """Opposite points, and velocities too long for the geometric cubic."""
    status, content, _ = ask(served, body=GOOD | {"angle": np.pi, "v0": [0, 0], "v1": [0, 0]})
    assert status == 200
    assert content["curves"]["gcp"]["error"].startswith("OutsideDomainError: no unique shortest curve joins the points")
    assert content["distance"] is None
    status, content, _ = ask(served, body=GOOD | {"v0": [9, 9]})
    assert status == 200
    assert content["curves"]["gcp"]["error"].startswith("InvalidInputError: ")


def test_connections_wait_until_they_are_accepted():
    """More connections than a browser opens, while none is served yet."""
    with server.Server("sphere") as waiting, ExitStack() as stack:
        for _ in range(32):
            stack.enter_context(socket.create_connection(waiting.server_address, timeout=HANGS))


def test_many_at_once(served):
    found = []
    threads = [threading.Thread(target=lambda: found.append(ask(served, body=GOOD)[:2])) for _ in range(16)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 16
    assert all(answer == found[0] for answer in found)
    assert found[0][0] == 200
