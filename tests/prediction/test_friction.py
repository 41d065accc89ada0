"""A friction coefficient over temperature: one constant for each speed, the same everywhere."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import fsolve
from typer.testing import CliRunner

import roughsim as rs
from roughsim import prediction
from roughsim.cli import app
from roughsim.comparison.tables import theory_dict, theory_table
from roughsim.explore.content import load_fields
from roughsim.prediction.bodies import contact_temperatures
from roughsim.prediction.statements import statements
from roughsim.scene import SceneError, parse_scene
from theory import flash, partition

START = 350.0  # K, the background temperature
RULES = [
    {"heat_partition": 0.9},
    {"heat_partition": "mean"},
    {"heat_partition": "total", "duration": 2e-5},
    {"heat_partition": "all", "duration": 2e-5},
]


def over(temperatures, values):
    """A table of a scene."""
    return {"temperature": [float(t) for t in temperatures], "value": [float(v) for v in values]}


def with_friction(scene, friction, **sliding):
    """The scene with this μ, over a background of 350 K if it is a table."""
    start = START if isinstance(friction, dict) else None
    changed = {"background_temperature": start, "heat_partition": 0.9} | sliding
    return replace(scene, sliding=replace(scene.sliding, friction_coefficient=friction, **changed))


def heat_of_one(scene, speed, bodies=None):
    """(T₀(t), s T_flash), K, with μ = 1, from the formulas."""
    bodies = bodies or scene.conduction()
    kappa, diffusivity = bodies.conductivity, bodies.diffusivity
    stress = {
        "spectrum": prediction.smoothed_spectrum(scene),
        "nominal_pressure": scene.sliding.nominal_pressure,
        "effective_modulus": scene.effective_modulus,
        "gamma": scene.theory.gamma,
    }
    body = {"conductivity": kappa, "diffusivity": diffusivity}
    rule, time = scene.sliding.heat_partition, scene.sliding.duration
    share = {"all": 1.0, 0.9: 0.9}.get(rule)
    if share is None:
        both = {
            "resting_conductivity": bodies.counter_conductivity,
            "resting_diffusivity": bodies.counter_diffusivity,
        }
        share = partition.moving_share(speed, **stress, **body, **both, rule=rule, duration=time)
    rise = share * flash.flash_temperature(speed, **stress, **body, friction_coefficient=1.0)
    flux = share * scene.sliding.nominal_pressure * speed
    return 2 * flux / kappa * np.sqrt(diffusivity * (time or 0.0) / np.pi), rise


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: "-".join(map(str, rule.values())))
def test_a_falling_line_has_its_closed_solution(capped_scene, rule):
    """μ = a − b(T − T_b) and T − T_b = μZ give μ = a/(1 + bZ), with Z of T₀(t) and T_flash together."""
    top, fall = 0.3, 1e-4
    scene = with_friction(
        capped_scene, over([300, 2300], [top + 50 * fall, top - 1950 * fall]), **rule
    )
    for speed, mu in zip(scene.speeds, prediction.friction_coefficient(scene), strict=True):
        assert mu == pytest.approx(top / (1 + fall * sum(heat_of_one(scene, speed))), rel=1e-10)
    assert mu < 0.28


def test_friction_as_the_inverse_of_temperature_solves_a_quadratic(capped_scene):
    """μ = c/T: T(T − T_b) = cZ. Straight lines between rows err in second order of their distance."""
    constant = 60.0
    (speed,) = capped_scene.speeds[-1:]
    heat = sum(heat_of_one(with_friction(capped_scene, 0.1), speed))
    exact = constant / (START / 2 + np.sqrt(START**2 / 4 + constant * heat))
    errors = []
    for count in (25, 50, 100):
        kelvin = np.linspace(300, 1500, count)
        scene = with_friction(capped_scene, over(kelvin, constant / kelvin))
        errors.append(abs(prediction.friction_coefficient(scene)[-1] / exact - 1))
    assert errors[-1] < 2e-4
    assert errors[0] > 8 * errors[-1]
    assert 0.08 < exact < 0.95 * constant / START


# μ rises in a step from 650 to 670 K: of the three solutions between the two speeds the cold one is reached first
STEP = ([300, 650, 670, 3000], [0.1, 0.1, 0.5, 0.5])


@pytest.mark.parametrize(
    ("rise", "expected"), [(200.0, 0.1), (299.9, 0.1), (300.5, 0.5), (400.0, 0.5)]
)
def test_of_several_solutions_the_coldest_is_taken(capped_scene, rise, expected):
    """The contact rises by 3000 K μ at a `rise` of 300 K with μ = 0.1: up to there cold friction is a solution."""
    one = with_friction(capped_scene, 0.1, speed=[35.0])
    _, heat = heat_of_one(one, 35.0)
    pressure = one.sliding.nominal_pressure
    # T_flash is in proportion to μ: the table is scaled so that the cold branch rises by `rise`
    low, high = rise / heat, 5 * rise / heat
    values = [low, low, high, high]
    scene = with_friction(capped_scene, over(STEP[0], values), speed=[35.0])
    assert scene.sliding.nominal_pressure == pressure
    assert START + high * heat > 670.0  # the hot branch is a solution at every one of these
    assert prediction.friction_coefficient(scene)[0] * heat == pytest.approx(
        rise * expected / 0.1, rel=1e-9
    )


@pytest.mark.slow
def test_the_other_solutions_are_stated_with_their_temperatures(capped_scene, tmp_path):
    one = with_friction(capped_scene, 0.1, speed=[1.0, 35.0])
    heats = [heat_of_one(one, speed)[1] for speed in (1.0, 35.0)]
    low, high = (
        200.0 / heats[1],
        1000.0 / heats[1],
    )  # the cold branch rises by 200 K at 35 m/s, the hot one by 1000 K
    scene = with_friction(capped_scene, over(STEP[0], [low, low, high, high]), speed=[1.0, 35.0])
    # between the rows T − 350 = 200 + 800 (T − 650)/20
    middle = (550.0 - 40.0 * 650.0) / (1.0 - 40.0)
    assert contact_temperatures(scene, 35.0) == pytest.approx([550.0, middle, 1350.0], rel=1e-8)
    assert contact_temperatures(scene, 1.0) == pytest.approx([START + low * heats[0]], rel=1e-8)
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml())
    levels = [{"column": "elastic", "shape": [16, 16], "q_max": 1e4}]
    levels = [level | {"column": name} for level in levels for name in ("smoothed", "capped")]
    run = rs.run(
        replace(scene, numerics=replace(scene.numerics, levels=tuple(levels))), tmp_path / "run"
    )
    outputs = [
        CliRunner().invoke(app, [verb, str(path), "--all"]).stdout for verb in ("theory", "plan")
    ]
    outputs.append(CliRunner().invoke(app, ["compare", str(run.folder), "--all"]).stdout)
    for text in outputs:
        (line,) = re.findall(r"contact at 35 m/s.*?first", " ".join(text.split()))
        assert "550 K, the coldest of 3" in line
        assert f"{middle:.4g} and 1350 K solve" in line
        assert "contact at 1 m/s" not in text
    falls = with_friction(capped_scene, over([300, 2000], [0.3, 0.02]))
    assert not any(statement.quantity.startswith("contact at") for statement in statements(falls))


def test_a_solution_between_two_close_rows_is_not_passed_over(capped_scene):
    """A peak of 2 K width lifts friction; beside it, cold and hot, it is the same number."""
    _, heat = heat_of_one(with_friction(capped_scene, 0.1, speed=[35.0]), 35.0)
    level = 100.0 / heat  # the contact is at 450 K
    dip = over(
        [300, 440, 441, 442, 2000],
        [1.5 * level, 1.5 * level, 0.5 * level, 1.5 * level, 1.5 * level],
    )
    scene = with_friction(capped_scene, dip, speed=[35.0])
    # on the falling side T = 440 + x: 90 + x = 150 − 100 x
    contact = 440.0 + 60.0 / 101.0
    assert prediction.friction_coefficient(scene)[0] * heat == pytest.approx(
        contact - START, rel=1e-9
    )


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: "-".join(map(str, rule.values())))
def test_friction_and_conductivity_solve_one_pair_of_equations(capped_scene, rule):
    rows, values, kappas = (300.0, 1200.0), (0.3, 0.1), (60.0, 25.0)
    scene = with_friction(capped_scene, over(rows, values), **rule)
    scene = replace(scene, body=replace(scene.body, conductivity=over(rows, kappas)))
    heat = scene.body.density * scene.body.heat_capacity

    def line(pair, kelvin):
        return pair[0] + (pair[1] - pair[0]) * (kelvin - rows[0]) / (rows[1] - rows[0])

    numbers = replace(scene, body=replace(scene.body, conductivity=30.0))

    def equations(unknown, speed):
        kappa, mu = unknown
        alike = type(scene.conduction(START))(kappa, kappa / heat, kappa, kappa / heat)
        background, rise = heat_of_one(numbers, speed, alike)
        layer, contact = START + mu * (background + 0.75 * rise), START + mu * (background + rise)
        return kappa / line(kappas, layer) - 1, mu / line(values, contact) - 1

    found = prediction.conduction(scene).conductivity, prediction.friction_coefficient(scene)
    for k, speed in enumerate(scene.speeds):
        kappa, mu = fsolve(equations, (50.0, 0.2), args=(speed,), xtol=1e-12)
        assert found[0][k] == pytest.approx(kappa, rel=1e-8)
        assert found[1][k] == pytest.approx(mu, rel=1e-8)
    assert mu < 0.27
    assert kappa < 54


def test_a_table_of_equal_values_is_the_number_to_the_last_bit(quick):
    number, constant = (
        with_friction(quick, 0.11),
        with_friction(quick, over([300, 2000], [0.11, 0.11])),
    )
    grid = rs.Grid((48, 48), (4e-3, 4e-3))
    for result in (
        prediction.predictions,
        lambda s: prediction.mode_sums(s, s.spectrum.truncated(q_max=3e4), grid),
    ):
        expected, found = result(number), result(constant)
        assert all(np.array_equal(found[name], expected[name], equal_nan=True) for name in expected)
    numerics = rs.plan(number)
    one, other = (rs.realize(scene, numerics, seed=1).observables for scene in (number, constant))
    for name in ("flash_temperature", "flash_gradient", "flash_width", "resting_flash_temperature"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.slow
def test_a_run_is_the_runs_of_its_speeds_with_their_numbers(quick, tmp_path):
    """Moments, theory, fields and shares at each speed are those of the scene with μ of that speed as a number."""
    scene = with_friction(
        quick, over([300, 2000], [0.3, 0.02]), heat_partition="total", duration=2e-5
    )
    plan = rs.plan(scene)
    used = prediction.friction_coefficient(scene)
    assert (np.diff(used) < 0.0).all()
    assert used[-1] < 0.8 * used[0]
    (choice,) = [reason for reason in plan.reasons if reason.quantity == "friction_coefficient"]
    assert choice.value == ", ".join(f"{mu:.4g}" for mu in used)
    run = rs.run(scene, tmp_path / "table", max_realizations=3, workers=1)
    rows = rs.compare(run).rows
    member = load_fields(run, 0, 0)
    for k, (speed, mu) in enumerate(zip(scene.speeds, used, strict=True)):
        alone = with_friction(quick, float(mu), heat_partition="total", duration=2e-5, speed=speed)
        his = rs.run(alone, tmp_path / f"number {k}", max_realizations=3, workers=1)
        told = {row.observable: row for row in rs.compare(his).rows}
        for name in (
            "flash_temperature",
            "flash_gradient",
            "flash_laplacian",
            "heat_partition",
            "flash_width",
        ):
            assert run.estimate(name).mean[k] == pytest.approx(
                his.estimate(name).mean[0], rel=1e-12
            )
            (mine,) = [row for row in rows if row.observable == name and row.speed == speed]
            for of in ("theory", "theory_same_modes", "calibrated"):
                assert mine.theories[of] == pytest.approx(
                    told[name].theories[of], rel=1e-12, nan_ok=True
                )
        for name in ("heat_flux", "temperature"):
            (_, warm), (_, same) = (next(iter(r.fields(name, speed=speed))) for r in (run, his))
            np.testing.assert_array_equal(warm, same)
        drawn = member.temperature(speed, 0.0).field
        np.testing.assert_allclose(
            drawn, load_fields(his, 0, 0).temperature(speed, 0.0).field, rtol=1e-6
        )
    told = theory_dict(scene)
    assert told["friction_coefficient"] == used.tolist()
    single = theory_dict(
        with_friction(quick, float(used[1]), heat_partition="total", duration=2e-5)
    )
    assert told["flash_temperature"][1] == pytest.approx(single["flash_temperature"][1], rel=1e-12)
    assert "friction_coefficient" not in theory_dict(quick)
    assert "μ" in [column.title for column in theory_table(scene).columns]
    assert "μ" not in [column.title for column in theory_table(with_friction(quick, 0.11)).columns]


def test_heat_slides_either_way_and_between_the_speeds(quick):
    scene = with_friction(quick, over([300, 2000], [0.3, 0.02]))
    (mu,) = prediction.friction_coefficient(scene, [7.0])
    assert (
        prediction.heat_per_pressure(scene, -7.0)
        == prediction.heat_per_pressure(scene, 7.0)
        == 7.0 * mu
    )
    assert prediction.friction_coefficient(scene, [0.0])[0] == pytest.approx(
        0.3 - 0.28 * 50 / 1700, rel=1e-14
    )


def test_a_contact_hotter_than_the_table_of_friction_is_refused_before_any_work(capped_scene):
    scene = with_friction(capped_scene, over([300, 400], [0.3, 0.3]))
    words = r"sliding.speed = \S+ m/s heats the contact to .* at constant friction_coefficient beyond 400 K"
    for work in (prediction.predictions, rs.plan, prediction.heat_partition):
        with pytest.raises(SceneError, match=words):
            work(scene)
    # κ is taken at a lower temperature than μ: the table of μ ends first
    both = replace(scene, body=replace(scene.body, conductivity=over([300, 1500], [30, 30])))
    with pytest.raises(SceneError, match="beyond 400 K"):
        prediction.predictions(both)


@pytest.mark.parametrize(
    ("rise", "within"), [(49.0, True), (51.0, False), (65.0, False), (68.0, False)]
)
def test_the_whole_flash_temperature_must_lie_within_the_table_of_friction(
    capped_scene, rise, within
):
    """Over 350 K a table ends at 400 K; up to a rise of 67 K the temperature of κ would still be below."""
    _, heat = heat_of_one(with_friction(capped_scene, 0.1, speed=[35.0]), 35.0)
    scene = with_friction(capped_scene, over([300, 400], [rise / heat] * 2), speed=[35.0])
    if within:
        assert prediction.friction_coefficient(scene)[0] == rise / heat
    else:
        with pytest.raises(
            SceneError, match=rf"T_flash = {START + rise:.4g} K at constant friction_coefficient"
        ):
            prediction.friction_coefficient(scene)


def test_the_scene_with_a_table_of_friction_is_written_and_read(quick):
    scene = with_friction(quick, over([300, 600, 900], [0.3, 0.2, 0.1]))
    assert parse_scene(scene.to_toml()) == scene
    assert scene.identity()["sliding.friction_coefficient"] == [
        [300.0, 0.3],
        [600.0, 0.2],
        [900.0, 0.1],
    ]
    assert scene.identity()["sliding.background_temperature"] == START
    assert scene.temperature_range == (300.0, 900.0)
    assert scene.friction_coefficient(450.0) == 0.25
    assert scene.conduction() == quick.conduction()
    for ask in (scene.friction_coefficient, lambda: scene.friction_coefficient(901.0)):
        with pytest.raises(SceneError, match="must lie between 300 K and 900 K"):
            ask()


@pytest.mark.parametrize(
    ("friction", "start", "words"),
    [
        (
            over([300, 900], [0.3, 0.1]),
            None,
            "background_temperature is missing; a friction_coefficient that is a table",
        ),
        (over([300, 900], [0.3, 0.1]), 299.0, "= 299 K must lie between 300 K and 900 K"),
        (
            over([300, 900], [0.3, 0.0]),
            300.0,
            r"sliding.friction_coefficient.value\[1\] = 0.0 must be greater than 0",
        ),
        (over([300, 300], [0.3, 0.1]), 300.0, r"\[1\] has temperature = 300.0 K after 300.0 K"),
        (over([300], [0.3]), 300.0, "has 1 temperatures and 1 values"),
        (
            {"temperature": [300, 900], "value": ["0.3 m", 1]},
            300.0,
            r"has the dimension .* value = \[0.11, ...\]",
        ),
    ],
)
def test_a_table_of_friction_without_meaning_is_refused_in_one_line(quick, friction, start, words):
    with pytest.raises(SceneError, match=words) as refusal:
        with_friction(quick, friction, background_temperature=start)
    assert "\n" not in str(refusal.value)


def test_a_table_with_friction_that_no_solid_has_is_warned_of(quick):
    scene = with_friction(quick, over([300, 2000], [0.3, 7.0]), speed=[1e-3])
    from roughsim.planning.limits import judge

    assert any("friction_coefficient = 7 is not within" in line for line in judge(scene).warnings)
