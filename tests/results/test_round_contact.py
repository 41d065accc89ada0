"""A round nominal contact in scenes, runs and warnings: the balance of both bodies with its mean temperatures."""

import re
from math import pi

import numpy as np
import pytest
from small_scene import CAPPED
from steel_text import STEEL

import roughsim as rs
from roughsim import prediction
from roughsim.prediction.statements import statements
from roughsim.scene import SceneError, parse_scene
from theory import flash, hertz
from theory.disc import mean_rise

SPEEDS = np.array([0.1, 35.0])
RADIUS, HOTTER = 2e-3, 40.0
KAPPA, OTHER_KAPPA = 30.0, 60.0
D, OTHER_D = KAPPA / (7900 * 500), OTHER_KAPPA / (7900 * 500)
FLUX = 0.11 * 90e6 * SPEEDS
BRASS = "youngs_modulus = 100e9\npoisson_ratio = 0.3\nconductivity = 60\ndensity = 7900\nheat_capacity = 500"


def scene_with(keys, body="", other=""):
    """A scene of unlike bodies whose columns end where C(q) does."""
    text = CAPPED.replace("heat_partition = 0.9", keys).replace('like = "body"', BRASS + other)
    text = text.replace("[0, 0.1, 35]", "[0.1, 35]").replace("q_max = 2e5", "q_max = 5e4")
    text = text.replace("density = 7900\n", f"density = 7900\n{body}\n", 1)
    levels = [
        f'{{ column = "{one}", shape = [64, 64], q_max = 5e4 }}' for one in ("smoothed", "capped")
    ]
    text = f"{text[: text.index('levels =')]}levels = [{', '.join(levels)}]"
    return parse_scene(text.replace("max_realizations = 6", "max_realizations = 2"))


ROUND = f'heat_partition = "total"\ncontact_radius = {RADIUS}\n'


@pytest.fixture(scope="module", params=[0.0, HOTTER, -HOTTER], ids=["like", "hotter", "colder"])
def run(request, tmp_path_factory):
    other = f"\ntemperature = {300 + request.param}"
    scene = scene_with(ROUND, "temperature = 300", other)
    return rs.run(scene, tmp_path_factory.mktemp("round") / "run")


def warm():
    """R of both bodies, steady, with all the heat, K."""
    moving = FLUX * RADIUS / KAPPA * hertz.disc_mean_temperature(SPEEDS * RADIUS / D)
    return moving, FLUX * RADIUS / OTHER_KAPPA * 8 / (3 * pi)


def test_shares_make_total_temperatures_equal(run):
    difference = run.scene.temperature_difference
    moving, resting = warm()
    for level, column in enumerate(("smoothed", "capped")):
        numbers = [run.members[level, index].numbers for index in range(run.realizations)]
        hot = np.mean([one["flash_temperature"] for one in numbers], axis=0)
        cold = np.mean([one["resting_flash_temperature"] for one in numbers], axis=0)
        cold *= KAPPA / OTHER_KAPPA
        share = run.share(column)
        side = (1 - share) * (resting + cold) + difference
        np.testing.assert_allclose(share * (moving + hot), side, rtol=1e-8)
        total = run.contact_temperature(column).mean
        np.testing.assert_allclose(total, share * (moving + hot), rtol=1e-8)
    assert (share > 1.0).tolist() == [difference > 0.0, False]
    assert (share < 0.0).tolist() == [difference < 0.0, False]


def test_theories_make_total_temperatures_equal(run):
    scene, (moving, resting) = run.scene, warm()
    spectrum = prediction.smoothed_spectrum(scene)
    given = {"effective_modulus": scene.effective_modulus, "nominal_pressure": 90e6, "gamma": 0.3}
    hot = flash.flash_temperature(
        SPEEDS, spectrum, **given, friction_coefficient=0.11, conductivity=KAPPA, diffusivity=D
    )
    slow = flash.flash_temperature(
        1e-9,
        spectrum,
        **given,
        friction_coefficient=0.11,
        conductivity=OTHER_KAPPA,
        diffusivity=OTHER_D,
    )
    cold = slow / 1e-9 * SPEEDS
    share = prediction.heat_partition(scene)
    side = (1 - share) * (resting + cold) + scene.temperature_difference
    np.testing.assert_allclose(share * (moving + hot), side, rtol=1e-7)
    table = rs.compare(run)
    rows = [row for row in table.rows if row.observable == "contact_temperature"]
    np.testing.assert_allclose(
        [row.theories["theory"] for row in rows], share * (moving + hot), rtol=1e-7
    )
    # over the modes of a cell the same balance holds with their own sums
    shares = [
        row.theories["theory_same_modes"]
        for row in table.rows
        if row.observable == "heat_partition"
    ]
    assert shares == pytest.approx(share, rel=0.15)


def test_error_of_a_share_between_unlike_temperatures(tmp_path):
    # leave-one-out of s = (R' + T' + ΔT)/(R + T + R' + T')
    scene = scene_with(ROUND, "temperature = 300", f"\ntemperature = {300 + HOTTER}")
    run = rs.run(scene, tmp_path / "errors", max_realizations=5)
    numbers = [run.members[1, index].numbers for index in range(5)]
    hot = np.array([one["flash_temperature"] for one in numbers])
    cold = np.array([one["resting_flash_temperature"] for one in numbers]) * KAPPA / OTHER_KAPPA
    moving, resting = warm()

    def share(hot, cold):
        return (resting + cold + HOTTER) / (moving + resting + hot + cold)

    left = [share(*(np.delete(x, k, 0).mean(0) for x in (hot, cold))) for k in range(5)]
    jackknife = np.sqrt(4 * np.var(left, axis=0))
    assert run.estimate("heat_partition").standard_error == pytest.approx(jackknife, rel=0.1)


def test_time_and_track_enter_the_background():
    scene = scene_with(
        "heat_partition = 0.5\ncontact_radius = 2e-3\ntrack_radius = 4e-3\nduration = 0.2"
    )
    for speed, found in zip(SPEEDS, prediction.background(scene), strict=True):
        rise = mean_rise(0.2 * D / RADIUS**2, speed * RADIUS / D, 2.0)
        assert found == pytest.approx(0.11 * 90e6 * speed * RADIUS / KAPPA * rise, rel=1e-12)
    assert np.all(prediction.background(scene_with("heat_partition = 0.5")) == 0.0)


def test_track_takes_its_part_of_the_share():
    keys = f"{ROUND}duration = 0.2\n"
    straight, ring = scene_with(keys), scene_with(f"{keys}track_radius = {2 * RADIUS}")
    # (1 − s)/s is the temperature of the moving body over that of the resting one, each with all the heat
    odds, others = (1 / prediction.heat_partition(one) - 1 for one in (straight, ring))
    rises = [
        [mean_rise(0.2 * D / RADIUS**2, v * RADIUS / D, track) for v in SPEEDS]
        for track in (np.inf, 2.0)
    ]
    warm_straight, warm_ring = FLUX * RADIUS / KAPPA * np.array(rises)
    hot = prediction.predictions(straight)["flash_temperature"]
    np.testing.assert_allclose(others / odds, (warm_ring + hot) / (warm_straight + hot), rtol=1e-9)
    assert (warm_ring > 1.05 * warm_straight)[-1]


def test_table_of_conductivity_is_at_the_warmed_contact():
    table = "{ temperature = [200, 3000], value = [50, 22] }"
    text = STEEL.replace('"30 W/(m K)"', table).replace(
        "heat_partition = 0.938", "heat_partition = 0.5"
    )
    text = text.replace(
        "[theory]", 'background_temperature = 300\ncontact_radius = "5 mm"\n[theory]'
    )
    scene = parse_scene(text).with_("sliding.speed", [10.0])
    bodies = prediction.conduction(scene)
    warmed = 0.5 * (
        prediction.background(scene) + 0.75 * prediction.predictions(scene)["flash_temperature"]
    )
    at = scene.conduction(float(300 + warmed[0]))
    assert bodies.conductivity[0] == pytest.approx(at.conductivity, rel=1e-9)
    assert prediction.background(scene)[0] > 10.0


ROUND_STEEL = 'heat_partition = "total"\ncontact_radius = "3 mm"'
REFUSED = {
    "sliding.track_radius = 0.025 m is of a round contact": 'track_radius = "25 mm"',
    "sliding.track_radius = 0.001 m must be at least the contact_radius of 0.003 m": f'{ROUND_STEEL}\ntrack_radius = "1 mm"',
    "sliding.contact_radius = ": 'contact_radius = "-3 mm"',
    'sliding.heat_partition = "total" needs the time': 'heat_partition = "total"',
    "sliding.contact_radius = 0.003 m is too small: heat spreads": f"{ROUND_STEEL}\n",
}


def steel(keys, body="", other=""):
    """Steel with other keys of [sliding], a number for its share unless they have a rule."""
    text = re.sub(r"(?m)^heat_partition = .*\n", "", STEEL)
    if "speed" in keys:
        text = re.sub(r"(?m)^speed = .*\n", "", text)
    share = "" if "heat_partition" in keys else "heat_partition = 0.5\n"
    text = text.replace("[theory]", f"{share}{keys}\n[theory]")
    return parse_scene(text.replace("[counterface]", f"{body}\n[counterface]\n{other}"))


@pytest.mark.parametrize("words", REFUSED)
def test_round_contacts_that_are_refused(words):
    skin = 'skin = { thickness = "0.3 mm", conductivity = 3 }' if "too small" in words else ""
    with pytest.raises(SceneError) as refused:
        prediction.background(steel(REFUSED[words], skin))
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


HOT, COLD = "temperature = 400", "temperature = 300"
REFUSED_TEMPERATURES = {
    "counterface.temperature = 400 K needs the temperature of the other body": (
        ROUND_STEEL,
        "",
        HOT,
    ),
    "sliding.background_temperature = 300 K is of both bodies": (
        f"{ROUND_STEEL}\nbackground_temperature = 300",
        COLD,
        HOT,
    ),
    'only sliding.heat_partition = "total" weighs': ('contact_radius = "3 mm"', COLD, HOT),
    'history = "sliding" does not follow': (
        f'{ROUND_STEEL}\nhistory = "sliding"\nslid_distance = 1',
        COLD,
        HOT,
    ),
    "does not go with sliding.speed = 0 m/s": (f"{ROUND_STEEL}\nspeed = 0", COLD, HOT),
    "body.temperature = ": (ROUND_STEEL, "temperature = -3", HOT),
}


@pytest.mark.parametrize("words", REFUSED_TEMPERATURES)
def test_temperatures_of_bodies_that_are_refused(words):
    keys, body, other = REFUSED_TEMPERATURES[words]
    with pytest.raises(SceneError) as refused:
        steel(keys, body, other)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_temperatures_need_a_second_body_that_conducts():
    alone = STEEL.replace('[counterface]\nlike = "body"', "").replace("heat_partition = 0.938", "")
    with pytest.raises(
        SceneError, match=r"but \[counterface\] is missing; give sliding.background"
    ):
        parse_scene(alone.replace("[body]", "[body]\ntemperature = 300"))


def test_body_temperature_stands_for_the_background():
    scene = steel(ROUND_STEEL, HOT)
    assert (scene.background_temperature, scene.temperature_difference) == (400.0, 0.0)
    both = steel(ROUND_STEEL, HOT, COLD)
    assert (both.background_temperature, both.temperature_difference) == (400.0, -100.0)
    assert both.identity() == scene.identity()  # no member of a run depends on them
    assert parse_scene(both.to_toml()) == both


def warnings_of(scene):
    return [str(one) for one in rs.theory(scene).judged.remarks]


@pytest.mark.filterwarnings("ignore::roughsim.SceneWarning")
def test_warnings_of_planes_and_small_contacts():
    planes = warnings_of(steel('heat_partition = "total"\nduration = "1 s"\nspeed = 35'))
    assert any(
        "and is of endless planes; right within 5 % only for a contact of radius above 5 v·duration = 1.8e+02 m and 12 "
        "√(D·duration) = 0.033 m" in one
        for one in planes
    )
    assert any("and T₀ = " in one and "no material is solid there" in one for one in planes)
    disc = warnings_of(steel(f"{ROUND_STEEL}\nspeed = 35"))
    assert not any("endless planes" in one or "longest wave" in one for one in disc)
    small = warnings_of(steel(ROUND_STEEL.replace("3 mm", "0.9 mm")))
    assert any(
        "sliding.contact_radius = 0.0009 m is below the longest wave" in one for one in small
    )
    hot = warnings_of(steel(f"{ROUND_STEEL}\nspeed = 0.01", COLD, HOT))
    assert any("the hotter counterface heats [body]" in one for one in hot)


def test_statement_of_a_round_contact():
    given = f'{ROUND_STEEL}\ntrack_radius = "25 mm"\nhistory = "sliding"\nduration = 1'
    (said,) = (one for one in statements(steel(given)) if one.quantity == "nominal contact")
    words = f"{said.value}: {said}"
    for part in (
        "radius 3 mm",
        "track of radius 25 mm",
        "after 1 s",
        "sliding warms endless planes",
    ):
        assert part in words
