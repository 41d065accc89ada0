"""The server of the page, in this process: where it listens, what it serves, how it ends."""

import asyncio
import gc
import http.client
import re
import signal
import socket
import threading
from pathlib import Path

import pytest

pytest.importorskip("bokeh")
from tornado.ioloop import IOLoop

from roughsim.errors import RecordError
from roughsim.explore import explore, server

# where a port is taken tornado leaves the socket that it could not bind to the collector
pytestmark = pytest.mark.filterwarnings("ignore:unclosed <socket:ResourceWarning")


@pytest.fixture
def held():
    """A port that another program listens on."""
    with socket.socket() as one:
        one.bind((server.ADDRESS, 0))
        one.listen()
        yield one.getsockname()[1]


@pytest.fixture
def loop():
    """An event loop of this thread, closed afterwards."""
    asyncio.set_event_loop(made := asyncio.new_event_loop())
    yield made
    made.run_until_complete(asyncio.sleep(0))
    asyncio.set_event_loop(None)
    made.close()
    gc.collect()


def test_the_first_free_port_is_taken(loop, held, capped_run, monkeypatch):
    monkeypatch.setattr(server, "FIRST_PORT", held)
    started, address = server.start(capped_run.folder)
    try:
        port = started.port
        assert held < port < held + 20
        assert re.fullmatch(rf"http://127\.0\.0\.1:{port}/[\w-]{{43}}/", address)
        assert started.address == "127.0.0.1"
    finally:
        started.stop()


def test_a_port_that_is_taken_is_refused_by_number(loop, held, capped_run, monkeypatch):
    with pytest.raises(OSError, match=rf"^\[Errno \d+\] port = {held} is not free on 127.0.0.1; choose another with"):
        server.start(capped_run.folder, held)
    monkeypatch.setattr(server, "FIRST_PORT", held)
    monkeypatch.setattr(server, "PORTS_TRIED", 1)
    with pytest.raises(OSError, match=f"ports {held} to {held} are not free"):
        server.start(capped_run.folder)


def test_a_folder_that_is_no_run_starts_no_server(tmp_path, monkeypatch):
    monkeypatch.setattr(socket, "create_server", lambda *_, **__: pytest.fail("listens all the same"))
    with pytest.raises(RecordError, match="run.json"):
        server.start(tmp_path)


@pytest.mark.slow
def test_the_page_is_served_with_its_own_scripts_until_it_is_stopped(loop, capped_run, monkeypatch):
    found = {}

    def visit(address):
        """What a browser does, in a thread beside the server."""
        address = re.search('url=(.*)"', Path(address.removeprefix("file://")).read_text())[1]
        host, path = address.removeprefix("http://").split("/", 1)
        connection = http.client.HTTPConnection(host, timeout=20)
        connection.request("GET", f"/{path}")
        found["html"] = connection.getresponse().read().decode()
        connection.close()
        found["names"] = {model.name for model in found["server"].get_sessions()[0].document.models}
        found["loop"].add_callback(found["loop"].stop)

    def opened(address):
        found["loop"] = IOLoop.current()
        found["thread"] = threading.Thread(target=visit, args=(address,))
        found["thread"].start()

    def started(*words):
        found["server"], address = genuine(*words)
        return found["server"], address

    genuine = server.start
    monkeypatch.setattr(server, "start", started)
    monkeypatch.setattr("webbrowser.open", opened)
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    told = []
    try:
        explore(capped_run.folder, announce=told.append)
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
    found["thread"].join(20)
    assert told[0].startswith("http://127.0.0.1:")
    assert "static/js/bokeh" in found["html"]
    assert "cdn.bokeh.org" not in found["html"]
    assert {"temperature", "heights", "pressure"} <= found["names"]
