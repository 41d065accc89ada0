"""Tasks of a page of `explore` done at once: a test need not wait for threads."""


class Now:
    """Does every task at once, in the thread of the page."""

    def __init__(self, document, failed):
        self.failed = failed

    def ask(self, work, show):
        try:
            result = work()
        except Exception as error:
            self.failed(error)
        else:
            show(result)
