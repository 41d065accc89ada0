"""Predictions beyond the highest cut-off that tests set."""

from types import SimpleNamespace

import pytest

from roughsim import prediction


@pytest.fixture
def foretold(monkeypatch):
    """Predictions of contact that follows neither theory nor law, and falls with the exponent .8; tests change them.

    `calls` has the arguments of each but the scene. `exponent` = None: of the scene itself.
    """
    given = SimpleNamespace(calls=[], theory=None, law=None, exponent=0.8, backgrounds=None)
    genuine = {name: getattr(prediction, name) for name in ("usual_exponent", "backgrounds")}

    def continuation(scene, *about):
        given.calls.append(("theory", *about))
        return given.theory(*about) if callable(given.theory) else given.theory

    def calibrated_flash(scene, *about):
        given.calls.append(("law", *about))
        return given.law

    def usual_exponent(scene, q_max):
        given.calls.append(("usual", q_max))
        return given.exponent or genuine["usual_exponent"](scene, q_max)

    def backgrounds(*about):
        return given.backgrounds or genuine["backgrounds"](*about)

    for function in (continuation, calibrated_flash, usual_exponent, backgrounds):
        monkeypatch.setattr(prediction, function.__name__, function)
    return given


@pytest.fixture
def asked(foretold):
    """The calls for predictions: the steel follows neither theory nor law, and falls with the exponent .8."""
    return foretold.calls
