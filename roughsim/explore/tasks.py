"""Tasks of an open page in threads: only the latest one waits."""

from asyncio import to_thread
from collections.abc import Callable
from functools import partial
from typing import Any

from bokeh.document import Document, without_document_lock


class LatestTask:
    """Runs tasks in a thread, one after the other; a new task replaces one that is still waiting.

    Results are shown by the thread of the page, and there `failed` is called with the error of a task.
    """

    def __init__(self, document: Document, failed: Callable[[Exception], None]):
        self.document, self.failed = document, failed
        self.waiting: tuple[Callable[[], Any], Callable[[Any], None]] | None = None
        self.busy = False

    def ask(self, work: Callable[[], Any], show: Callable[[Any], None]) -> None:
        """Run `work` in a thread, then `show` its result."""
        self.waiting = work, show
        if not self.busy:
            self.busy = True
            self.document.add_next_tick_callback(self.run)

    @without_document_lock  # type: ignore[untyped-decorator]  # Bokeh has no types here
    async def run(self) -> None:
        """Run waiting tasks until there are none."""
        while self.waiting:
            (work, show), self.waiting = self.waiting, None
            try:
                act = partial(show, await to_thread(work))
            except Exception as error:
                act = partial(self.failed, error)
            if self.document.session_context is None:  # the page was closed meanwhile
                return
            self.document.add_next_tick_callback(act)
        self.busy = False
