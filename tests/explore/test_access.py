"""Who gets an answer from the page's server: over real sockets, on every route and method."""

import gc
import http.client
import os
import re
import socket
import subprocess
import sys
import threading
import time
import weakref
from pathlib import Path

import pytest

import roughsim as rs

pytest.importorskip("bokeh")
from bokeh.util import token as jwt
from tornado.ioloop import IOLoop

from roughsim.explore import server

METHODS = ("GET", "HEAD", "POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE")
WIDENING = {
    "BOKEH_ALLOW_WS_ORIGIN": "far.away,*",
    "BOKEH_RESOURCES": "cdn",
    "BOKEH_SECRET_KEY": "known to everybody " * 3,
    "BOKEH_SIGN_SESSIONS": "no",
    "BOKEH_LOG_LEVEL": "trace",
    "BOKEH_PY_LOG_LEVEL": "trace",
    "BOKEH_COOKIE_SECRET": "known",
    "BOKEH_DEV": "true",
    "BOKEH_ROOTDIR": "/tmp",
    "BOKEH_ICO_PATH": "/nowhere.ico",
    "BOKEH_AUTH_MODULE": "/nowhere.py",
    "BOKEH_DEFAULT_SERVER_HOST": "0.0.0.0",
    "BOKEH_CDN_VERSION": "1.0.0",
}


class Served:
    """A page served in a thread of this process."""

    def __init__(self, folder):
        self.folder, self.ready = folder, threading.Event()
        self.thread = threading.Thread(target=self.work)
        self.thread.start()
        assert self.ready.wait(60)

    def work(self):
        import asyncio

        asyncio.set_event_loop(loop := asyncio.new_event_loop())
        self.bokeh, self.address = server.start(self.folder)
        self.gate, self.port = self.bokeh._tornado, self.bokeh.port
        self.loop = IOLoop.current()
        self.loop.add_callback(self.ready.set)
        self.loop.start()
        self.bokeh.stop(wait=False)
        self.bokeh.unlisten()
        loop.run_until_complete(asyncio.sleep(0.05))
        asyncio.set_event_loop(None)
        loop.close()

    def end(self):
        self.loop.add_callback(self.loop.stop)
        self.thread.join(20)

    def ask(self, path, method="GET", **headers):
        """Status, headers and body of an answer; a header that is None is not sent."""
        headers = {name.replace("_", "-"): value for name, value in headers.items()}
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=20)
        connection.putrequest(method, path, skip_host=True)
        for name, value in ({"Host": f"127.0.0.1:{self.port}"} | headers).items():
            if value is not None:
                connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        body = answer.read()
        connection.close()
        return answer.status, dict(answer.getheaders()), body

    def routes(self):
        """An address of every route that the server knows, whatever it is."""
        rules = [rule for outer in self.gate.default_router.rules for rule in outer.target.rules]
        patterns = [rule.matcher.regex.pattern.rstrip("$") for rule in rules]
        assert len(patterns) >= 7
        return [
            p.replace("/?", "/").replace("(.*)", "js/bokeh.min.js").replace("\\", "")
            for p in patterns
        ]

    def sessions(self):
        return self.bokeh.get_sessions()


@pytest.fixture(scope="module")
def served(capped_run):
    running = Served(capped_run.folder)
    yield running
    running.end()


FOREIGN = {
    "a name that resolves to this computer": {"Host": "rebound.far.away:{port}"},
    "a host without the port": {"Host": "127.0.0.1"},
    "another port": {"Host": "localhost:1"},
    "a host that begins like ours": {"Host": "127.0.0.1:{port}.far.away"},
    "a name with a dot": {"Host": "localhost.:{port}"},
    "a user in the host": {"Host": "localhost:{port}@far.away"},
    "an empty host": {"Host": ""},
    "another origin": {"Origin": "http://far.away"},
    "another port as origin": {"Origin": "http://127.0.0.1:1"},
    "no origin to speak of": {"Origin": "null"},
    "an origin with another scheme": {"Origin": "https://127.0.0.1:{port}"},
    "an origin that ends like ours": {"Origin": "http://far.away/http://127.0.0.1:{port}"},
}


@pytest.mark.parametrize("case", FOREIGN)
def test_no_route_answers_a_foreign_host_or_origin(served, case):
    headers = {name: value.format(port=served.port) for name, value in FOREIGN[case].items()}
    for path in served.routes():
        assert served.ask(path, **headers)[0] in (400, 403), (
            path
        )  # 400: tornado refuses a malformed host by itself


def test_no_route_answers_without_the_token_by_any_method(served):
    token = served.gate.token
    assert len(token) >= 40
    wrong = (
        "",
        token[:-1],
        token + "x",
        token.swapcase(),
        "x" * len(token),
        "%00",
        "..",
        f"x/../{token}",
    )
    for path in served.routes():
        for other in wrong:
            assert served.ask(path.replace(f"/{token}", f"/{other}" if other else ""))[0] == 403, (
                path,
                other,
            )
        for method in METHODS:
            status, _, body = served.ask(path.replace(token, "x" * len(token)), method)
            assert status in (403, 405), (method, path)
            assert len(body) < 100
    for path in (
        "/",
        "//",
        f"/?token={token}",
        "/ws",
        "/static/js/bokeh.min.js",
        "/favicon.ico",
        f"//{token}/",
    ):
        assert (
            served.ask(path, Cookie=f"token={token}", Authorization=f"token {token}")[0] == 403
        ), path


def test_two_tokens_are_never_the_same(served, capped_run):
    other = Served(capped_run.folder)
    try:
        assert other.gate.token != served.gate.token
        assert other.ask(f"/{served.gate.token}/")[0] == 403
    finally:
        other.end()


@pytest.mark.slow
def test_with_the_token_the_page_is_read_and_nothing_else_is_done(served):
    root = f"/{served.gate.token}/"
    for name in ("127.0.0.1", "localhost", "LocalHost", "[::1]"):
        status, _, body = served.ask(root, Host=f"{name}:{served.port}")
        assert status == 200
        assert b'rel="icon" href="data:,"' in body
    assert served.ask(root, Origin=f"http://localhost:{served.port}")[0] == 200
    assert served.ask(root + "static/js/bokeh.min.js")[0] == 200
    for path in (
        "autoload.js",
        "metadata",
        "static/../../../../etc/passwd",
        "static/..%2f..%2fsettings.py",
        "other",
    ):
        assert served.ask(root + path)[0] in (403, 404), path
    for method in METHODS[2:]:
        for path in served.routes():
            assert served.ask(path, method)[0] in (403, 405), (method, path)
    assert served.ask(root, Bokeh_Session_Id="mine")[0] == 403
    assert served.ask(root + "?bokeh-session-id=mine")[0] == 200  # the one session, not another
    assert {session.id for session in served.sessions()} == {served.gate.session}


def test_every_answer_keeps_the_address_to_itself(served):
    for path in (*served.routes(), "/", "/unknown", f"/{served.gate.token}/unknown"):
        for method in ("GET", "OPTIONS", "POST"):
            status, headers, _ = served.ask(path, method, Origin=f"http://127.0.0.1:{served.port}")
            said = {name.lower(): value for name, value in headers.items()}
            assert said["referrer-policy"] == "no-referrer", (path, status)
            assert said["cache-control"] == "no-store"
            assert said["x-content-type-options"] == "nosniff"
            assert "frame-ancestors 'none'" in said["content-security-policy"]
            assert "default-src 'self'" in said["content-security-policy"]
            assert not [name for name in said if name.startswith("access-control-")]
            assert "set-cookie" not in said


def shake(served, path=None, protocols=None, **headers):
    """Open the websocket; return the status, or True once the server has greeted."""
    own = f"/{served.gate.token}/"
    if protocols is None:
        protocols = "bokeh, " + re.search(r'"token":"([^"]+)"', served.ask(own)[2].decode())[1]
    lines = {
        "Host": f"127.0.0.1:{served.port}",
        "Upgrade": "websocket",
        "Connection": "Upgrade",
    } | headers
    lines |= {"Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ=="}
    lines |= {"Sec-WebSocket-Protocol": protocols}
    head = "".join(f"{name}: {value}\r\n" for name, value in lines.items())
    with socket.create_connection(("127.0.0.1", served.port), timeout=20) as wire:
        wire.sendall(f"GET {path or own + 'ws'} HTTP/1.1\r\n{head}\r\n".encode())
        said = b""
        while more := wire.recv(4096):
            said += more
            if b'"ACK"' in said:
                return True
            if not said.startswith(b"HTTP/1.1 101"):
                break
        return int(said.split()[1])


def test_the_websocket_opens_for_the_page_alone(served):
    for name in ("127.0.0.1", "localhost", "[::1]"):
        assert shake(served, Origin=f"http://{name}:{served.port}") is True
    assert shake(served) is True
    forged = jwt.generate_jwt_token(
        jwt.generate_session_id(b"x" * 40, signed=True), b"x" * 40, signed=True
    )
    assert shake(served, protocols=f"bokeh, {forged}") == 101  # and closed without a word
    assert {session.id for session in served.sessions()} == {served.gate.session}
    assert shake(served, Origin="http://far.away") == 403
    assert shake(served, Origin="null") == 403
    assert shake(served, Host="rebound.far.away") == 403
    assert shake(served, "/ws") == 403
    assert shake(served, f"/{'x' * 43}/ws") == 403


@pytest.mark.slow
def test_many_visits_make_one_session_which_ends_with_the_last_tab(capped_run, monkeypatch):
    times = {  # ms: the visits of a busy machine lie within the first
        "unused_session_lifetime_milliseconds": 3000,
        "check_unused_sessions_milliseconds": 50,
        "keep_alive_milliseconds": 100,
    }
    monkeypatch.setattr(server, "SESSIONS", times)
    served = Served(capped_run.folder)
    try:
        for _ in range(3):
            assert served.ask(f"/{served.gate.token}/")[0] == 200
        assert len(served.sessions()) == 1
        for _ in range(2):
            document = weakref.ref(served.sessions()[0].document)
            until(lambda: not served.sessions())
            until(
                lambda document=document: gc.collect() >= 0 and document() is None
            )  # with the page and its fields
            assert shake(served) is True
    finally:
        served.end()


def until(true):
    for _ in range(200):
        if true():
            return
        time.sleep(0.05)
    raise AssertionError("it never came")


@pytest.mark.slow
def test_neither_the_environment_nor_a_file_at_home_opens_it_wider(capped_run, tmp_path):
    (tmp_path / ".bokeh").mkdir()
    settings = "".join(
        f"{name.removeprefix('BOKEH_').lower()}: {value!r}\n" for name, value in WIDENING.items()
    )
    (tmp_path / ".bokeh" / "bokeh.yaml").write_text(settings)
    for environment in (WIDENING, {"HOME": str(tmp_path)}):
        command = [
            sys.executable,
            "-m",
            "roughsim",
            "explore",
            str(capped_run.folder),
            "--no-browser",
        ]
        started = subprocess.Popen(
            command,
            stderr=subprocess.PIPE,
            text=True,
            cwd=Path(rs.__file__).parents[1],
            env=os.environ | environment,
        )
        try:
            lines = iter(started.stderr.readline, "")
            address = next(line for line in lines if line.startswith("page: ")).split()[1]
            look_at_another_process(address)
        finally:
            started.terminate()
            started.wait(20)
            started.stderr.close()


def look_at_another_process(address):
    host, token = address.split("/")[2:4]
    seen = Served.__new__(Served)
    seen.port, seen.gate = int(host.split(":")[1]), type("Known", (), {"token": token})
    page = seen.ask(f"/{token}/")[2].decode()
    assert "cdn" not in page
    scripts = re.findall(r'src="([^"]+)"', page)
    refused = [
        shake(seen, Origin=origin)
        for origin in ("http://far.away", f"http://127.0.0.1:{seen.port + 1}")
    ]
    assert refused == [403, 403]
    assert shake(seen) is True
    key = WIDENING["BOKEH_SECRET_KEY"].encode()
    forged = jwt.generate_jwt_token(jwt.generate_session_id(key, signed=True), key, signed=True)
    assert shake(seen, protocols=f"bokeh, {forged}") == 101
    genuine = (Path(server.settings.bokehjs_path()) / "js/bokeh.min.js").read_bytes()
    assert seen.ask(next(path for path in scripts if "bokeh.min.js" in path))[2] == genuine
    assert all(path.startswith(f"/{token}/static/js/") for path in scripts)


def test_the_policy_names_only_sources_that_a_browser_knows(served):
    _, headers, _ = served.ask(f"/{served.gate.token}/")
    policy = headers["Content-Security-Policy"]
    assert f"ws://127.0.0.1:{served.port}" in policy
    assert "[" not in policy  # Chromium reports a source with an IPv6 address as an error
