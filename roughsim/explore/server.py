"""A plain Bokeh server for one run: on this computer only, by a secret address, nothing fetched from outside."""

from __future__ import annotations

import gc
import socket
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.server.server import BaseServer
from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop

from roughsim.explore.gate import Gate
from roughsim.explore.layout import words
from roughsim.explore.library import Library
from roughsim.explore.page import Page

ADDRESS = "127.0.0.1"
FIRST_PORT = 5006
_TRIED = 20
_REST = 5.0  # s until threads have ended, too
_LARGEST_BODY = 4096  # bytes of a request: nothing of this page has any


def start(folder: str | Path, port: int | None = None) -> tuple[BaseServer, str]:
    """Return a started server of the page of a run, and the address of the page, a secret.

    Parameters
    ----------
    folder : str or Path
        Of the run.
    port : int, optional
        Where it listens; left out: the first free one from 5006 on.

    Raises
    ------
    RecordError
        If the folder is no run.
    OSError
        If the port is taken.
    """
    library = Library(folder)
    _ = library.theory  # pages open with it

    def open_page(document: Any) -> None:
        try:
            page = Page(library, document)
        except Exception as error:  # a session that is never born would keep every later visit waiting
            document.clear()
            document.add_root(words("problems", f"This run cannot be shown: {error}"))
            return

        def close(session_context: Any) -> None:
            page.close()
            IOLoop.current().call_later(_REST, gc.collect)  # a page is a knot of cycles

        document.on_session_destroyed(close)

    application = Application(FunctionHandler(open_page))
    ports = range(FIRST_PORT, FIRST_PORT + _TRIED) if port is None else (port,)
    for number in ports:
        try:
            server = _listen(application, number)
        except OSError as error:
            refusal = error
        else:
            server.start()
            return server, f"http://{ADDRESS}:{number}{server.prefix}/"
    taken = f"port = {port} is" if port else f"ports {FIRST_PORT} to {FIRST_PORT + _TRIED - 1} are"
    raise OSError(refusal.errno, f"{taken} not free on {ADDRESS}; choose another with --port")


def _listen(application: Application, port: int) -> BaseServer:
    listening = socket.create_server((ADDRESS, port), backlog=128)
    listening.setblocking(False)
    gate = Gate(application, port)
    http = HTTPServer(gate, max_body_size=_LARGEST_BODY)
    http.add_socket(listening)
    return BaseServer(IOLoop.current(), gate, http)


def serve(folder: str | Path, port: int | None, *, browser: bool, announce: Any) -> None:
    """Serve the page until interrupted; arguments as `start`, and how to tell the address."""
    server, address = start(folder, port)
    announce(address)
    with TemporaryDirectory(prefix="roughsim-") as private:
        if browser:
            import webbrowser

            # all users see the words that a program is started with: a file that none of them can read holds the secret
            door = Path(private, "page.html")
            door.write_text(f'<meta http-equiv="refresh" content="0; url={address}">\n', encoding="utf-8")
            server.io_loop.add_callback(webbrowser.open, door.as_uri())
        server.run_until_shutdown()
