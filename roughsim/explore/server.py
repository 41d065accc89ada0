"""A plain Bokeh server for one run: on this computer only, for its own pages only, nothing fetched from outside."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.server.server import Server
from bokeh.settings import settings

from roughsim.explore.library import Library
from roughsim.explore.page import Page

ADDRESS = "127.0.0.1"
FIRST_PORT = 5006
_TRIED = 20


def start(folder: str | Path, port: int | None = None) -> tuple[Server, str]:
    """Return a started server of the page of a run, and the address of the page.

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
    settings.log_level = "error"  # in the browser: figures that wait for their data are no news
    settings.resources = "server"  # whatever the environment says: scripts come from here, never from a CDN

    def open_page(document: Any) -> None:
        page = Page(library, document)
        document.on_session_destroyed(lambda session_context: page.close())

    application = Application(FunctionHandler(open_page))
    ports = range(FIRST_PORT, FIRST_PORT + _TRIED) if port is None else (port,)
    for number in ports:
        try:
            server = _listen(application, number)
        except OSError as error:
            refusal = error
        else:
            server.start()
            return server, f"http://{ADDRESS}:{number}/"
    taken = f"port = {port} is" if port else f"ports {FIRST_PORT} to {FIRST_PORT + _TRIED - 1} are"
    raise OSError(refusal.errno, f"{taken} not free on {ADDRESS}; choose another with --port")


def _listen(application: Application, port: int) -> Server:
    origins = [f"{ADDRESS}:{port}", f"localhost:{port}"]
    return Server({"/": application}, address=ADDRESS, port=port, allow_websocket_origin=origins)


def serve(folder: str | Path, port: int | None, *, browser: bool, announce: Any) -> None:
    """Serve the page until interrupted; arguments as `start`, and how to tell the address."""
    server, address = start(folder, port)
    announce(address)
    if browser:
        import webbrowser

        server.io_loop.add_callback(webbrowser.open, address)
    server.run_until_shutdown()
