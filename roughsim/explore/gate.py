"""Who gets an answer from the server of the page: this computer, by the secret address, for the page itself."""

from __future__ import annotations

import os
from functools import partial
from hmac import compare_digest
from secrets import token_urlsafe
from typing import Any

from bokeh.application import Application
from bokeh.server.tornado import BokehTornado
from bokeh.settings import PrioritizedSetting, settings
from bokeh.util.token import generate_session_id
from tornado.httputil import HTTPHeaders, HTTPServerRequest
from tornado.web import OutputTransform, RequestHandler

_UNUSED = (
    15_000  # ms that a session without a tab is kept: time enough for a reload, and for scripts over a slow tunnel
)
_LOOKS = 2_000  # ms between looks for such sessions
_PINGS = 5_000  # ms between pings: they also end a session whose tab went away before it was there
_ALIVE = 30  # s after which a tab that no longer answers is dropped
_YEAR = 365 * 86_400  # s: a reload hands out the token of the session again, which must not have expired


class Gate(BokehTornado):  # type: ignore[misc]  # Bokeh has no types here
    """A Bokeh application of one session, all of whose paths begin with a random token.

    Every request is looked at before any route is chosen, so that no route, of today or of a later Bokeh, is without
    guard. The host must be this computer by a name that no other machine can take (a foreign name that resolves to
    127.0.0.1 is refused), the origin, where there is one, the page itself, and the path must begin with the token.

    Parameters
    ----------
    application : Application
        What fills a new document.
    port : int
        Where it is served.
    """

    def __init__(self, application: Application, port: int):
        use_no_settings_from_outside()
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
            keep_alive_milliseconds=_PINGS,
            check_unused_sessions_milliseconds=_LOOKS,
            unused_session_lifetime_milliseconds=_UNUSED,
            session_token_expiration=_YEAR,
            use_index=False,
            ico_path="none",
            include_headers=[],
            include_cookies=[],
            transforms=[partial(Headers, hosts=self.hosts)],
            log_function=lambda handler: None,  # what others ask for is no news, and not ours to print
            websocket_ping_interval=_ALIVE,
            websocket_ping_timeout=_ALIVE,
        )

    def find_handler(self, request: HTTPServerRequest, **rest: Any) -> Any:
        """Return what answers a request: a refusal, or what Bokeh has for it, always in the one session."""
        refusal = self._refusal(request)
        if refusal:
            return self.get_handler_delegate(request, Refusal, {"status": refusal})
        request.arguments = {"bokeh-session-id": [self.session.encode()]}
        return super().find_handler(request, **rest)

    def _refusal(self, request: HTTPServerRequest) -> int:
        """The status with which a request is refused; 0 if it is not."""
        hosts, origins = (request.headers.get_list(name) for name in ("Host", "Origin"))
        own = len(hosts) == 1 and hosts[0].lower() in self.hosts
        same = all(origin.lower() in {f"http://{host}" for host in self.hosts} for origin in origins)
        _, token, path = (*request.path.split("/", 2), "", "")[:3]
        known = compare_digest(token.encode(), self.token.encode())
        if not (own and same and known):
            return 403
        if request.method not in ("GET", "HEAD"):
            return 405
        return 0 if path in ("", "ws") or path.startswith("static/") else 404


class Refusal(RequestHandler):  # type: ignore[misc]
    """Says no more than the status."""

    def initialize(self, status: int) -> None:
        """Take the status."""
        self.status = status

    def prepare(self) -> None:
        """Answer, whatever the method."""
        self.set_status(self.status)
        self.set_header("Content-Type", "text/plain")
        self.finish("refused\n")


class Headers(OutputTransform):  # type: ignore[misc]
    """Puts on every answer what keeps the address and the page to itself, and takes off what opens it to others."""

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
        for name in [name for name in headers if name.startswith("Access-Control-") or name == "Server"]:
            del headers[name]
        for name, value in self.headers.items():
            headers[name] = value
        return status_code, headers, chunk


def use_no_settings_from_outside() -> None:
    """Give every setting of Bokeh its default, whatever its environment variable or ~/.bokeh/bokeh.yaml says."""
    for name in [name for name in os.environ if name.startswith("BOKEH_")]:
        del os.environ[name]  # BOKEH_DEV is asked for by itself
    for setting in vars(type(settings)).values():
        if isinstance(setting, PrioritizedSetting) and not isinstance(setting._default, type):
            setting.set_value(setting._default)
    settings.log_level = "error"  # in the browser: figures that wait for their data are no news
    settings.resources = "server"  # scripts come from here, never from a CDN
