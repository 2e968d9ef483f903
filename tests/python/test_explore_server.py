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
from explore_problem import floats, library, running, spline

from stiefel_rs.explore import answers, page, server
from stiefel_rs.explore.kinds import KINDS

GOOD = {"kind": "sphere", "angle": 1.5, "v0": [1, 2], "v1": [1, -2.5]}


SPLINE = answers.first_request("points")


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
        both, M = library(*request.values())
        t, profile = floats(found["t"]).astype(float), floats(found["profile_t"]).astype(float)
        for name, curve in both.items():
            answered = found["curves"][name]
            # Times are rounded too.
            assert np.allclose(floats(answered["points"]), curve(t).ravel(), atol=1e-6)
            assert np.allclose(floats(answered["speed"]), M.norm(curve(profile), curve.velocity(profile)), rtol=1e-5)
            assert answered["cost"] == curve.cost()
        assert len(floats(found["angle"])) == len(t)


@pytest.mark.parametrize("kind", ["points", "rotations"])
def test_splines_of_the_server_are_those_of_the_library(served, kind):
    request = answers.first_request(kind) | {"ends": "clamped"}
    status, found, _ = ask(served, body=request)
    assert status == 200
    curve, t = spline(kind, request["t"], request["values"], "clamped"), floats(found["t"]).astype(float)
    assert np.allclose(floats(found["curves"]["spline"]["points"]), curve(np.clip(t, *curve.t_span)).ravel(), atol=1e-6)
    assert found["curves"]["spline"]["cost"] == curve.cost()
    assert found["curves"]["slerp"]["cost"] is None and found["curves"]["slerp"]["acceleration"] is None
    times = floats(found["profile_t"])
    assert all(np.sum(times == np.float32(knot)) == 2 for knot in request["t"][1:-1])


@pytest.mark.parametrize("kind", KINDS)
def test_every_scene_opens_with_its_curves(served, kind):
    status, found, _ = ask(served, body=answers.first_request(kind))
    assert status == 200
    assert list(found["curves"]) == list(KINDS[kind].described()["curves"])
    assert not any("error" in curve for curve in found["curves"].values())


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
        (b"[]", "an object expected"),
        (GOOD | {"more": 1}, "an object with angle, kind, v0, v1 expected"),
        ({"kind": "sphere"}, "an object with"),
        (GOOD | {"kind": "points"}, "an object with ends, kind, t, values expected"),
        (GOOD | {"kind": "torus"}, "kind: points or rotations or sphere or frame expected"),
        (GOOD | {"kind": ["sphere"]}, "kind: points or rotations or sphere or frame expected"),
        ({}, "kind: points or rotations or sphere or frame expected"),
        (SPLINE | {"ends": "periodic"}, "ends: natural or clamped expected"),
        (SPLINE | {"t": 1}, "t: a list of numbers expected"),
        (SPLINE | {"values": [1, 0, 0]}, "values: a list of numbers expected"),
        (SPLINE | {"values": 1}, "values: a list of lists expected"),
        (SPLINE | {"values": [[True, 0, 0]]}, "values: finite numbers expected"),
        (SPLINE | {"t": [0, 1, 9, 10, 11]}, "t: increasing times from 0 to 6 expected"),
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


def test_curves_that_do_not_exist_come_as_words(served):
    """Points that are opposite to each other; and velocities that are too long for the geometric cubic."""
    for changed in ({"angle": np.pi, "v0": [0, 0], "v1": [0, 0]}, {"v0": [9, 9]}):
        status, content, _ = ask(served, body=GOOD | changed)
        assert status == 200
        assert content["curves"]["gcp"]["error"].startswith("No geometric cubic: ")
        assert content["angle"] is None


def test_head_and_body_of_an_answer_leave_together(served):
    """Apart, the body would wait for the receipt of the head."""
    body = json.dumps(GOOD).encode()
    head = f"POST /curves HTTP/1.1\r\nHost: 127.0.0.1:{served.server_port}\r\nX-Token: {served.token}\r\n"
    head += f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n"
    with socket.create_connection(("127.0.0.1", served.server_port), timeout=HANGS) as connection:
        connection.sendall(head.encode() + body)
        assert b"\r\n\r\n{" in connection.recv(65536)


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
