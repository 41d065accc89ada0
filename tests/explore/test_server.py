"""The server of the page, in this process: where it listens, what it serves, how it ends."""

import asyncio
import gc
import http.client
import re
import signal
import socket
import stat
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


def test_the_first_free_port_is_taken(loop, held, capped_run):
    started, address = server.start(capped_run.folder, range(held, held + 20))
    try:
        port = started.port
        assert held < port < held + 20
        assert re.fullmatch(rf"http://127\.0\.0\.1:{port}/[\w-]{{43}}/", address)
        assert started.address == "127.0.0.1"
    finally:
        started.stop()


def test_a_port_that_is_taken_is_refused_by_number(loop, held, capped_run):
    with pytest.raises(
        OSError,
        match=rf"^\[Errno \d+\] port = {held} is not free on 127.0.0.1; choose another with",
    ):
        server.start(capped_run.folder, (held,))
    with pytest.raises(OSError, match=f"ports {held} to {held} are not free"):
        server.start(capped_run.folder, (held, held))


def test_a_folder_that_is_no_run_starts_no_server(tmp_path, held):
    with pytest.raises(RecordError, match="run.json"):  # not that the port is taken
        server.start(tmp_path, (held,))


@pytest.mark.slow
def test_the_browser_opens_a_file_that_others_cannot_read_and_the_page_has_its_own_scripts(
    loop, capped_run, monkeypatch
):
    seen = {}

    def visit(address):
        """Fetch the page, as a browser does, in a thread beside the server."""
        host, path = address.removeprefix("http://").split("/", 1)
        connection = http.client.HTTPConnection(host, timeout=20)
        connection.request("GET", f"/{path}")
        seen["html"] = connection.getresponse().read().decode()
        connection.close()
        seen["loop"].add_callback(seen["loop"].stop)

    def opened(address):
        path = Path(address.removeprefix("file://"))
        seen["path"] = path
        seen["others"] = stat.S_IMODE(path.parent.stat().st_mode) & 0o077
        seen["loop"] = IOLoop.current()
        seen["address"] = re.search('url=(.*)"', path.read_text())[1]
        seen["thread"] = threading.Thread(target=visit, args=(seen["address"],))
        seen["thread"].start()

    monkeypatch.setattr("webbrowser.open", opened)
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    told = []
    try:
        explore(capped_run.folder, announce=told.append)
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
    seen["thread"].join(20)
    assert told == [seen["address"]]
    assert seen["address"].startswith("http://127.0.0.1:")
    assert seen["others"] == 0
    assert not seen["path"].exists()
    assert "static/js/bokeh" in seen["html"]
    assert "cdn.bokeh.org" not in seen["html"]
