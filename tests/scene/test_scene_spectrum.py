"""A spectrum by its name in a scene: what it means, and what is refused."""

from __future__ import annotations

import json
import math
from typing import Annotated, Any, Literal

import pytest
from steel_text import STEEL, approx, refusal, with_counterface

from roughsim.extensions import INSIDE
from roughsim.scene import parse_scene
from roughsim.scene.schema import QMax, QMin, Quantity, Record, record

K = {
    "name": "k_correlation",
    "rms_height": 4e-7,
    "hurst": 0.7,
    "q_min": 7e3,
    "q_roll_off": 2e4,
    "q_max": 9e6,
}


def named(**changes: Any) -> str:
    """Steel with a k-correlation spectrum; None leaves a key out."""
    pairs = (
        f"{key} = {json.dumps(value)}" for key, value in (K | changes).items() if value is not None
    )
    start, end = STEEL.index("rms_height"), STEEL.index("[body]")
    return f"{STEEL[:start]}spectrum = {{ {', '.join(pairs)} }}\n{STEEL[end:]}"


def test_a_named_spectrum_is_doubled_added_and_written_as_others_are():
    scene = parse_scene(named(rms_height="0.4 um"))
    assert scene.spectrum.rms_height == approx(4e-7 * math.sqrt(2), 1e-12)
    assert scene.spectrum.breaks == (7e3, 9e6)
    assert parse_scene(scene.to_toml()) == scene
    assert scene.identity()["surface.spectrum"] == K
    two = parse_scene(
        with_counterface(
            f"spectrum = {{ {', '.join(f'{k} = {json.dumps(v)}' for k, v in K.items())} }}"
        )
    )
    assert two.spectrum.rms_height == approx(math.hypot(9e-7, 4e-7), 1e-12)
    other = parse_scene(named(hurst=0.6)).identity()
    assert [key for key, value in scene.identity().items() if other[key] != value] == [
        "surface.spectrum"
    ]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            named(name="k_corelation"),
            'surface.spectrum.name = "k_corelation" is no spectrum; did you mean "k_correlat',
        ),
        (named(name=None), "surface.spectrum = { rms_height = 4e-07"),
        (
            named(name="../topography"),
            f"is no spectrum; the choice is {', '.join(INSIDE['spectra'])}",
        ),
        (named(hurst=None), "surface.spectrum.hurst is missing; write for example hurst = 0.8"),
        (named(hurst=1.2), "surface.spectrum.hurst = 1.2 must be less than or equal to 1"),
        (
            named(hrust=0.8),
            'surface.spectrum.hrust = 0.8 is not a key of a scene; did you mean "hurst"?',
        ),
        (
            named(q_max="5 m"),
            'surface.spectrum.q_max = "5 m" has the dimension [length]; a quantity in rad/m is e',
        ),
        (named(q_max=6e3), "surface.spectrum.q_min = 7000 rad/m must be below q_max = 6000 rad/m"),
        (
            named().replace("[body]", "hurst = 0.8\n[body]"),
            "surface.hurst = 0.8 does not go with spectrum",
        ),
        (
            named().replace("[body]", "rms_slope = 0.8\n[body]"),
            "surface.rms_slope and spectrum are both given",
        ),
        (
            named().replace("[body]", 'psd_convention = "persson"\n[body]'),
            "surface.psd_convention goes with psd_file",
        ),
    ],
)
def test_a_wrong_named_spectrum_is_refused_by_its_key(text, told):
    assert f"scene: {told}" in refusal(text) or told in refusal(text)


@record()
class Other(Record):
    name: Literal["other"]
    hurst: Annotated[float, Quantity("", "2", le=3)]


@record()
class Mine(Record):
    name: Literal["mine"]
    kink: QMin | None = None
    psd_at_q_min: Annotated[float, Quantity("m^4", '"1e-22 m^4"', gt=0)]
    q_min: QMin
    q_max: QMax

    @property
    def breaks(self):
        return self.q_min, self.q_max

    def __call__(self, q):
        return self.psd_at_q_min * (q / self.q_min) ** -3.6


def test_a_key_of_a_named_spectrum_may_not_mean_something_else_than_elsewhere(install):
    install("others", entry_points={"roughsim.spectra": {"other": f"{__name__}:Other"}})
    text = named(name="other", **dict.fromkeys(K.keys() - {"name", "hurst"}))
    assert "surface.spectrum.hurst has another unit or other limits than in [surface]" in refusal(
        text
    )


def test_a_spectrum_of_another_package_is_an_entry_point_and_takes_no_name_of_the_package(install):
    outside = {"mine": f"{__name__}:Mine", "k_correlation": "no"}
    install("others", entry_points={"roughsim.spectra": outside})
    text = named(
        name="mine", psd_at_q_min="1e-22 m^4", hurst=None, rms_height=None, q_roll_off=None
    )
    scene = parse_scene(text)
    assert scene.surface.spectrum == Mine(name="mine", psd_at_q_min=1e-22, q_min=7e3, q_max=9e6)
    assert parse_scene(scene.to_toml()) == scene
    assert "surface.spectrum.psd_at_q_min = -1 m^4 must be greater than 0" in refusal(
        text.replace('"1e-22 m^4"', "-1")
    )
    assert 'did you mean "mine"?' in refusal(text.replace('"mine"', '"mime"'))
    assert parse_scene(named()).surface.spectrum.name == "k_correlation"
