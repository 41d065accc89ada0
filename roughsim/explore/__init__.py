"""A local page to look at a run: fields, temperatures at any speed and direction, curves over the theory.

`content` computes the displayed data, without Bokeh. `layout` has the controls and figures of the page, `page` their
callbacks, and `server` serves the page to the browser. The extra `explore` is needed.
"""

import webbrowser
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory


def explore(
    folder: str | Path,
    *,
    port: int | None = None,
    browser: bool = True,
    announce: Callable[[str], None] = print,
) -> None:
    """Serve a page to explore a run, on this computer only, until interrupted. The folder is only read.

    Without a port it takes the first free one from 5006 on. `browser` opens the page in the web browser; `announce` is
    called with its address. ImportError without Bokeh, RecordError if it is no run, OSError for a port in use.
    """
    if find_spec("bokeh") is None:
        raise ImportError(
            "the page needs Bokeh, which is not installed: pip install 'roughsim[explore]'"
        )
    from roughsim.explore import server

    started, address = server.start(folder, server.PORTS if port is None else (port,))
    announce(address)
    with TemporaryDirectory(prefix="roughsim-") as private:
        if browser:
            # all users can see the arguments of a program, so the secret address goes to the browser in a private file
            redirect = Path(private, "page.html")
            redirect.write_text(
                f'<meta http-equiv="refresh" content="0; url={address}">\n', encoding="utf-8"
            )
            started.io_loop.add_callback(webbrowser.open, redirect.as_uri())
        started.run_until_shutdown()
