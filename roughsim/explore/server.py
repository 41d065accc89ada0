"""A plain Bokeh server for one run: on this computer only, by a secret address, nothing fetched from outside."""

from __future__ import annotations

import gc
import socket
from pathlib import Path
from typing import Any

from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.server.server import BaseServer
from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop

from roughsim.explore.access import GuardedApplication
from roughsim.explore.layout import plain_text
from roughsim.explore.page import Page
from roughsim.explore.watched_run import WatchedRun

ADDRESS = "127.0.0.1"
FIRST_PORT = 5006
PORTS_TRIED = 20
REST = 5.0  # s until threads have ended, too
LARGEST_BODY = 4096  # bytes of a request: nothing of this page has any


def start(folder: str | Path, port: int | None = None) -> tuple[BaseServer, str]:
    """Return a started server of the page of a run, and the address of the page, a secret.

    Without a port it takes the first free one from 5006 on. RecordError if the folder is no run; OSError if the port is
    taken.
    """
    run = WatchedRun(folder)
    _ = run.theory  # computed once, before the first page opens

    def open_page(document: Any) -> None:
        try:
            page = Page(run, document)
        except Exception as error:  # a session that fails to open would keep every later visit waiting
            document.clear()
            document.add_root(plain_text("problems", f"This run cannot be shown: {error}"))
            return

        def close(session_context: Any) -> None:
            page.close()
            IOLoop.current().call_later(REST, gc.collect)  # the objects of a page refer to each other in circles

        document.on_session_destroyed(close)

    application = Application(FunctionHandler(open_page))
    for number in range(FIRST_PORT, FIRST_PORT + PORTS_TRIED) if port is None else (port,):
        try:
            listening = socket.create_server((ADDRESS, number), backlog=128)
        except OSError as error:
            refusal = error
            continue
        listening.setblocking(False)
        guarded = GuardedApplication(application, number)
        http = HTTPServer(guarded, max_body_size=LARGEST_BODY)
        http.add_socket(listening)
        server = BaseServer(IOLoop.current(), guarded, http)
        server.start()
        return server, f"http://{ADDRESS}:{number}{server.prefix}/"
    taken = f"port = {port} is" if port else f"ports {FIRST_PORT} to {FIRST_PORT + PORTS_TRIED - 1} are"
    raise OSError(refusal.errno, f"{taken} not free on {ADDRESS}; choose another with --port")
