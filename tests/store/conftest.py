"""Times short enough for tests."""

import pytest

from roughsim.ensemble import tasks
from roughsim.store import claims


@pytest.fixture
def soon(monkeypatch):
    """Short times, so that a process that is gone is noticed in a test."""
    monkeypatch.setattr(claims, "LEASE", 0.3)
    monkeypatch.setattr(claims, "RENEWAL", 0.03)
    monkeypatch.setattr(tasks, "PAUSE", 0.01)
