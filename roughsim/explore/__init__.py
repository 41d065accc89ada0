"""A local page to look at a run: fields, temperatures at any speed and direction, curves over the theory.

`views`, `specimen`, `curves`, `words` and `library` compute what is shown and know nothing of Bokeh; `figures`, `page`
and `server` show it. Needs the extra `explore`.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path


def explore(
    folder: str | Path, *, port: int | None = None, browser: bool = True, announce: Callable[[str], None] = print
) -> None:
    """Serve a page to explore a run, on this computer only, until interrupted.

    Parameters
    ----------
    folder : str or Path
        Of the run: finished, empty, or still growing. It is only read.
    port : int, optional
        Where the page is served; left out: the first free one from 5006 on.
    browser : bool
        Open the page in the web browser.
    announce : callable
        Called with the address of the page once it can be opened.

    Raises
    ------
    ImportError
        If Bokeh is not installed: ``pip install 'roughsim[explore]'``.
    RecordError
        If the folder is no run.
    OSError
        If the port is taken.
    """
    if find_spec("bokeh") is None:
        raise ImportError("the page needs Bokeh, which is not installed: pip install 'roughsim[explore]'")
    from roughsim.explore.server import serve

    serve(folder, port, browser=browser, announce=announce)
