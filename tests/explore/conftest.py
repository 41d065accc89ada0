"""Pages of a finished run, without a browser."""

import pytest
from tasks_at_once import Now

from roughsim.explore.content import WatchedRun


@pytest.fixture(scope="session")
def watched(capped_run):
    return WatchedRun(capped_run.folder)


@pytest.fixture
def opened():
    """Opens the page of another folder."""
    from bokeh.document import Document

    from roughsim.explore.page import Page

    def open_page(folder):
        return Page(WatchedRun(folder), Document(), Now)

    return open_page


@pytest.fixture(scope="session")
def shared(watched):
    from bokeh.document import Document

    from roughsim.explore.page import Page

    return Page(watched, Document(), Now)


@pytest.fixture
def page(shared):
    """A page as it opens."""
    layout = shared.layout
    layout.controls.colours_of.active = 0
    layout.x_range.update(start=0.0, end=2.0)
    layout.y_range.update(start=0.0, end=2.0)
    layout.controls.level.value, layout.controls.member.value = "2", "0"
    shared.choose(35.0, 0.0)
    shared.say("")
    return shared
