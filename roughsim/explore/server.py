"""The server of the page: for this computer only, at a secret address, and for requests of the page alone."""

import os
import socket
from collections.abc import Callable, Sequence
from functools import partial
from hmac import compare_digest
from pathlib import Path
from secrets import token_urlsafe
from typing import Any

from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from bokeh.settings import PrioritizedSetting, settings
from bokeh.util.token import generate_session_id
from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPHeaders, HTTPServerRequest
from tornado.ioloop import IOLoop
from tornado.web import ErrorHandler, OutputTransform

from roughsim.explore.content import WatchedRun
from roughsim.explore.layout import plain_text
from roughsim.explore.page import Page
from roughsim.explore.study import StudyPage
from roughsim.studies.folder import is_study
from roughsim.studies.study import open_study

ADDRESS = "127.0.0.1"
PORTS = range(5006, 5026)  # the first free one is taken
_LARGEST_BODY = 4096  # bytes of a request; the requests of this page have no body
SESSIONS = {  # ms
    # a session without a tab is kept for a reload, and for scripts over a slow tunnel
    "unused_session_lifetime_milliseconds": 15_000,
    "check_unused_sessions_milliseconds": 2_000,
    # pings also end a session whose tab was closed before it had opened
    "keep_alive_milliseconds": 5_000,
}
_ALIVE = 30  # s after which a tab that does not answer is dropped
_YEAR = (
    365 * 86_400
)  # s: a reload hands out the token of the session again, which must not have expired


def start(folder: str | Path, ports: Sequence[int] = PORTS) -> tuple[BaseServer, str]:
    """Return a started server of the page of a run or a study on the first free port, and its secret address.

    RecordError if the folder is neither; OSError if all ports are taken.
    """
    page = page_of(Path(folder))

    def open_page(document: Any) -> None:
        try:
            page(document)
        except (
            Exception
        ) as error:  # a session that fails to open would keep every later visit waiting
            document.clear()
            document.add_root(plain_text("problems", f"This run cannot be shown: {error}"))

    application = Application(FunctionHandler(open_page))
    for number in ports:
        try:
            listening = socket.create_server((ADDRESS, number), backlog=128)
        except OSError as error:
            refusal = error
            continue
        listening.setblocking(False)
        guarded = _GuardedApplication(application, number)
        http = HTTPServer(guarded, max_body_size=_LARGEST_BODY)
        http.add_socket(listening)
        server = BaseServer(IOLoop.current(), guarded, http)
        server.start()
        return server, f"http://{ADDRESS}:{number}{server.prefix}/"
    taken = f"port = {ports[0]} is" if len(ports) == 1 else f"ports {ports[0]} to {ports[-1]} are"
    raise OSError(refusal.errno, f"{taken} not free on {ADDRESS}; choose another with --port")


def page_of(folder: Path) -> Callable[[Any], object]:
    """Return a function that fills a document with the page of a run or a study; RecordError if it is neither."""
    if is_study(folder):
        open_study(folder)  # refused here, before a page is asked for
        return partial(StudyPage, folder)
    return partial(Page, WatchedRun(folder))


class _GuardedApplication(BokehTornado):  # type: ignore[misc]  # Bokeh has no types here
    """A Bokeh application of one session on a local port; all paths begin with a random token.

    Every request is checked before routing, so that no route of this or a later version of Bokeh is unguarded. The host
    must be a local name of this computer (a foreign name that resolves to 127.0.0.1 is refused), the origin, if given,
    must be the page itself, and the path must begin with the token.
    """

    def __init__(self, application: Application, port: int):
        _ignore_outside_settings()
        self.token = token_urlsafe(32)
        self.hosts = frozenset(f"{name}:{port}" for name in ("127.0.0.1", "localhost", "[::1]"))
        key = token_urlsafe(32).encode()
        self.session = generate_session_id(key, signed=True)
        super().__init__(
            {"/": application},
            prefix=self.token,
            extra_websocket_origins=sorted(self.hosts),
            secret_key=key,
            sign_sessions=True,  # a session that this process has not opened is none
            generate_session_ids=False,
            **SESSIONS,
            session_token_expiration=_YEAR,
            use_index=False,
            ico_path="none",
            include_headers=[],
            include_cookies=[],
            transforms=[partial(_PrivateHeaders, hosts=self.hosts)],
            log_function=lambda handler: None,  # requests of others are not printed
            websocket_ping_interval=_ALIVE,
            websocket_ping_timeout=_ALIVE,
        )

    def find_handler(self, request: HTTPServerRequest, **rest: Any) -> Any:
        """Return the handler of a request: a refusal, or Bokeh's, always in the one session."""
        hosts, origins = (request.headers.get_list(name) for name in ("Host", "Origin"))
        own_host = len(hosts) == 1 and hosts[0].lower() in self.hosts
        own_origin = all(
            origin.lower() in {f"http://{host}" for host in self.hosts} for origin in origins
        )
        _, token, path = (*request.path.split("/", 2), "", "")[:3]
        right_token = compare_digest(
            token.encode(), self.token.encode()
        )  # takes the same time for every wrong token
        if not (own_host and own_origin and right_token):
            status = 403
        elif request.method not in ("GET", "HEAD"):
            status = 405
        elif not (path in ("", "ws") or path.startswith("static/")):
            status = 404
        else:
            request.arguments = {"bokeh-session-id": [self.session.encode()]}
            return super().find_handler(request, **rest)
        return self.get_handler_delegate(request, ErrorHandler, {"status_code": status})


class _PrivateHeaders(OutputTransform):  # type: ignore[misc]
    """Set headers that keep the address and the page private, and remove headers that allow access from other pages."""

    def __init__(self, request: HTTPServerRequest, *, hosts: frozenset[str]):
        # a policy cannot name [::1], and 'self' is enough there
        sockets = " ".join(f"ws://{host}" for host in sorted(hosts) if host[0] != "[")
        policy = (
            "default-src 'self' data: blob: 'unsafe-inline' 'unsafe-eval'; object-src 'none'; base-uri 'none'; "
            f"form-action 'none'; frame-ancestors 'none'; connect-src 'self' {sockets}"
        )
        self.headers = {
            "Content-Security-Policy": policy,
            "X-Frame-Options": "DENY",
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",  # the address holds the token
            "Cache-Control": "no-store",
            "Cross-Origin-Resource-Policy": "same-origin",
            "Cross-Origin-Opener-Policy": "same-origin",
        }

    def transform_first_chunk(
        self, status_code: int, headers: HTTPHeaders, chunk: bytes, finishing: bool
    ) -> tuple[int, HTTPHeaders, bytes]:
        """Change the headers of an answer."""
        for name in [
            name for name in headers if name.startswith("Access-Control-") or name == "Server"
        ]:
            del headers[name]
        for name, value in self.headers.items():
            headers[name] = value
        return status_code, headers, chunk


def _ignore_outside_settings() -> None:
    """Set every setting of Bokeh to its default, against environment variables and ~/.bokeh/bokeh.yaml."""
    for name in [name for name in os.environ if name.startswith("BOKEH_")]:
        del os.environ[name]  # BOKEH_DEV is read apart from the settings
    for setting in vars(type(settings)).values():
        if isinstance(setting, PrioritizedSetting) and not isinstance(setting.default, type):
            setting.set_value(setting.default)
    settings.log_level = "error"  # in the browser: figures that wait for their data are no news
    settings.resources = "server"  # scripts come from here, never from a CDN
