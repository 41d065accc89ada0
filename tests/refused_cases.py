"""Tables of refusals: what each call is refused with, in one line."""

import pytest


def assert_refused(call, words):
    """A call raises a TypeError or a ValueError, whose message is one line and matches the words."""
    with pytest.raises((TypeError, ValueError), match=words) as refused:
        call()
    assert "\n" not in str(refused.value)
