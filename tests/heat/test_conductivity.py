"""A conductivity that falls (or rises) with temperature: one constant for each speed, the same everywhere."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import roughsim as rs
from roughsim import prediction
from roughsim.charts import curves as chart
from roughsim.comparison.tables import theory_dict, theory_table
from roughsim.explore import content as curves
from roughsim.heat import effective_conductivity, effective_temperature
from roughsim.outputs import run_report as report
from roughsim.scene import SceneError, parse_scene
from theory import flash, partition

COLD, HOT = 300.0, 900.0


def table(*values):
    return {"temperature": list(np.linspace(COLD, HOT, len(values))), "value": list(values)}


def with_tables(scene, conductivity, counter=None, **sliding):
    """The scene with κ over temperature, T₀ = 350 K; a counterface of its own if it has a κ of its own."""
    other = (
        {}
        if counter is None
        else {"like": None, "conductivity": counter, "density": 2700.0, "heat_capacity": 900.0}
    )
    start = 350.0 if isinstance(conductivity, dict) or isinstance(counter, dict) else None
    return replace(
        scene,
        body=replace(scene.body, conductivity=conductivity),
        counterface=replace(scene.counterface, **other),
        sliding=replace(scene.sliding, background_temperature=start, **sliding),
    )


def at_one_speed(scene, k, bodies):
    """The scene at its speed k alone, with numbers for its tables."""
    counterface = scene.counterface
    if not counterface.like:
        counterface = replace(counterface, conductivity=bodies.counter_conductivity)
    return replace(
        scene,
        body=replace(scene.body, conductivity=bodies.conductivity),
        counterface=counterface,
        sliding=replace(scene.sliding, speed=scene.speeds[k], background_temperature=None),
    )


RULES = [
    {"heat_partition": 0.9},
    {"heat_partition": "mean"},
    {"heat_partition": "total", "duration": 2e-5},
    {"heat_partition": "all"},
]


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: str(rule["heat_partition"]))
def test_a_constant_table_is_the_number_to_the_last_bit(quick, rule):
    number, constant = (
        with_tables(quick, 30.0, **rule),
        with_tables(quick, table(30.0, 30.0), **rule),
    )
    grid = rs.Grid((48, 48), (4e-3, 4e-3))
    for result in (
        prediction.predictions,
        lambda s: prediction.mode_sums(s, s.spectrum.truncated(q_max=3e4), grid),
    ):
        expected, found = result(number), result(constant)
        assert all(np.array_equal(found[name], expected[name], equal_nan=True) for name in expected)
    np.testing.assert_array_equal(
        prediction.heat_partition(constant), prediction.heat_partition(number)
    )
    numerics = rs.plan(number)
    one, other = (rs.realize(scene, numerics, seed=1).observables for scene in (number, constant))
    np.testing.assert_array_equal(one.flash_temperature, other.flash_temperature)
    np.testing.assert_array_equal(one.slope_length, other.slope_length)
    np.testing.assert_array_equal(one.resting_flash_temperature, other.resting_flash_temperature)


def line(rows, temperature):
    """κ(T) of two rows, written out."""
    (t0, k0), (t1, k1) = rows
    return k0 + (k1 - k0) * (temperature - t0) / (t1 - t0)


@pytest.mark.parametrize(
    ("mine", "other"), [((60.0, 20.0), (10.0, 25.0)), ((15.0, 70.0), (40.0, 20.0))]
)
@pytest.mark.parametrize("rule", RULES, ids=lambda rule: str(rule["heat_partition"]))
def test_the_constant_is_the_value_at_background_plus_three_quarters_of_the_flash_temperature(
    capped_scene, rule, mine, other
):
    scene = with_tables(capped_scene, table(*mine), table(*other), **rule)
    rows, counter = (tuple(zip((COLD, HOT), pair, strict=True)) for pair in (mine, other))
    heat, counter_heat = scene.body.density * scene.body.heat_capacity, 2700.0 * 900.0
    spectrum = prediction.smoothed_spectrum(scene)
    stress = {
        "nominal_pressure": scene.sliding.nominal_pressure,
        "effective_modulus": scene.effective_modulus,
        "gamma": scene.theory.gamma,
    }

    def excess(temperature, speed):
        kappa, resting = line(rows, temperature), line(counter, temperature)
        bodies = {"conductivity": kappa, "diffusivity": kappa / heat}
        rise = flash.flash_temperature(
            speed,
            spectrum,
            **stress,
            **bodies,
            friction_coefficient=scene.sliding.friction_coefficient,
        )
        share = {"all": 1.0, 0.9: 0.9}.get(rule["heat_partition"])
        if share is None:
            chosen = {"rule": rule["heat_partition"]} | {
                k: v for k, v in rule.items() if k == "duration"
            }
            both = {"resting_conductivity": resting, "resting_diffusivity": resting / counter_heat}
            share = partition.moving_share(speed, spectrum, **stress, **bodies, **both, **chosen)
        flux = share * scene.sliding.friction_coefficient * scene.sliding.nominal_pressure * speed
        background = 2 * flux / kappa * np.sqrt(kappa / heat * rule.get("duration", 0.0) / np.pi)
        return 350.0 + background + 0.75 * share * rise - temperature

    found = prediction.conduction(scene)
    for k, speed in enumerate(scene.speeds):
        root = brentq(excess, 350.0, HOT, args=(speed,), xtol=1e-9, rtol=1e-13)
        assert found.conductivity[k] == pytest.approx(line(rows, root), rel=1e-9)
        assert found.counter_conductivity[k] == pytest.approx(line(counter, root), rel=1e-9)
        assert found.diffusivity[k] == pytest.approx(line(rows, root) / heat, rel=1e-9)
        assert found.counter_diffusivity[k] == pytest.approx(
            line(counter, root) / counter_heat, rel=1e-9
        )


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: str(rule["heat_partition"]))
def test_each_speed_is_the_scene_with_the_numbers_of_that_speed(quick, rule):
    scene = with_tables(quick, table(60.0, 25.0, 20.0), table(10.0, 25.0), **rule)
    grid, numerics = rs.Grid((48, 48), (4e-3, 4e-3)), rs.plan(scene)
    drawn = scene.spectrum.truncated(q_max=3e4)
    predicted, summed = prediction.predictions(scene), prediction.mode_sums(scene, drawn, grid)
    used, measured = (
        prediction.heat_partition(scene),
        rs.realize(scene, numerics, seed=1).observables,
    )
    for k, bodies in enumerate(prediction.conduction(scene).each):
        alone = at_one_speed(scene, k, bodies)
        assert used[k] == prediction.heat_partition(alone)[0]
        for results, expected in (
            (predicted, prediction.predictions(alone)),
            (summed, prediction.mode_sums(alone, drawn, grid)),
        ):
            for name in ("flash_temperature", "flash_laplacian", "slope_length", "heat_partition"):
                assert results[name][k] == pytest.approx(expected[name][0], rel=1e-12)
        single = rs.realize(alone, numerics, seed=1).observables
        for name in (
            "flash_temperature",
            "flash_gradient",
            "flash_width",
            "resting_flash_temperature",
        ):
            assert getattr(measured, name)[k] == getattr(single, name)[0]


def test_a_resting_contact_conducts_as_its_background(capped_scene):
    still = with_tables(capped_scene, table(60.0, 20.0), speed=[0.0, 1.0])
    assert prediction.conduction(still).conductivity[0] == pytest.approx(
        60 - 40 * 50 / 600, rel=1e-14
    )


def test_a_body_on_an_insulating_counterface_takes_a_table_too(capped_scene):
    scene = with_tables(capped_scene, table(60.0, 20.0))
    alone = replace(scene, counterface=None)
    assert np.isnan(prediction.conduction(alone).counter_diffusivity).all()
    assert np.isnan(prediction.predictions(alone)["heat_partition"]).all()
    warm = prediction.conduction(alone).conductivity
    assert (np.diff(warm) < 0.0).all()  # the faster, the hotter
    assert warm[-1] < 55.0


@pytest.mark.slow
def test_a_table_goes_from_the_plan_to_the_comparison(quick, tmp_path):
    """The measured share and the ratios are those of the run with the numbers of each speed."""
    rule = {"heat_partition": "total", "duration": 2e-5}
    scene = with_tables(quick, table(60.0, 20.0), table(10.0, 25.0), **rule)
    plan = rs.plan(scene)
    assert any(
        reason.quantity == "conductivity" and "W/(m K)" in reason.value for reason in plan.reasons
    )
    run = rs.run(scene, tmp_path / "table", max_realizations=3, workers=1)
    assert rs.open_run(tmp_path / "table").scene.identity() == scene.identity()
    comparison = rs.compare(run)
    axes = Figure().subplots()
    entry = chart.Entry("run", run.scene, run, comparison.results)
    chart.draw_over_speed(axes, entry, "flash_temperature")
    speeds, curve = axes.lines[0].get_data()
    whole = [row for row in comparison.rows if row.observable == "flash_temperature"][-1]
    assert curve[-1] == pytest.approx(whole.theory, rel=1e-12)  # the share of the heat included
    assert speeds[-1] == pytest.approx(whole.speed, rel=1e-12)
    k = len(scene.speeds) - 1
    bodies = prediction.conduction(scene).each[k]
    alone = rs.run(
        at_one_speed(scene, k, bodies), tmp_path / "number", max_realizations=3, workers=1
    )
    for name in ("flash_temperature", "heat_partition", "flash_width"):
        assert run.estimate(name).mean[k] == pytest.approx(alone.estimate(name).mean[0], rel=1e-12)
        mine = [row for row in comparison.rows if row.observable == name][k]
        (his,) = [row for row in rs.compare(alone).rows if row.observable == name]
        assert mine.theory == pytest.approx(his.theory, rel=1e-12)
    # a ratio κ₁/κ₂ the wrong way round would be 20 times off
    assert run.estimate("heat_partition").mean[k] == pytest.approx(
        prediction.heat_partition(scene)[k], rel=0.3
    )
    speed = scene.speeds[k]
    (_, warm), (_, same) = (next(iter(r.fields("temperature", speed=speed))) for r in (run, alone))
    np.testing.assert_array_equal(warm, same)
    between = 0.5 * speed  # a speed that the scene does not have
    (_, field) = next(iter(run.fields("temperature", speed=between)))
    conducts = prediction.conduction(scene, [between])
    (_, pressure) = next(iter(run.fields("pressure")))
    expected = rs.sliding_temperature(
        scene.sliding.friction_coefficient * between * pressure,
        run.numerics.grid(0),
        speed=between,
        conductivity=conducts.conductivity[0],
        diffusivity=conducts.diffusivity[0],
    )
    # the share of the run's own contacts, here between its speeds; those of a run at that speed are measured
    there = rs.run(
        scene.with_("sliding.speed", between), tmp_path / "between", max_realizations=3, workers=1
    )
    share = there.estimate("heat_partition").mean[0]
    np.testing.assert_allclose(field / expected, share, rtol=0.01)
    told = theory_dict(scene)
    assert told["conductivity"] == prediction.conduction(scene).conductivity.tolist()
    assert theory_table(scene).columns[-4].title == "κ, W/(m K)"


def test_pages_of_a_run_ask_for_no_speed_beyond_its_tables(quick):
    scene = with_tables(quick, table(60.0, 20.0))
    assert curves.speed_range(scene) == (1e-2, 35.0)
    assert curves.speed_range(quick) == (1e-2, 1e3)
    assert report.diffusivity_text(quick) == "7.595"
    bodies = prediction.conduction(scene).diffusivity * 1e6
    assert report.diffusivity_text(scene) == f"{bodies.max():.4g} … {bodies.min():.4g}"


def test_a_contact_hotter_than_the_table_is_refused_before_any_work(capped_scene):
    scene = with_tables(capped_scene, table(60.0, 20.0), speed=[1.0, 1e4])
    for work in (prediction.predictions, rs.plan, prediction.heat_partition):
        with pytest.raises(
            SceneError, match=r"sliding.speed = 10000 m/s heats the contact to .* beyond 900 K"
        ):
            work(scene)


def test_the_same_scene_is_written_read_and_told_apart(quick):
    scene = with_tables(quick, table(60.0, 25.0, 20.0), table(10.0, 25.0))
    assert parse_scene(scene.to_toml()) == scene
    assert scene.identity()["body.conductivity"] == [[300.0, 60.0], [600.0, 25.0], [900.0, 20.0]]
    assert scene.identity()["sliding.background_temperature"] == 350.0
    assert scene.temperature_range == (300.0, 900.0)
    assert quick.temperature_range == (0.0, np.inf)
    narrow = with_tables(quick, table(60.0, 20.0), {"temperature": [340, 800], "value": [10, 25]})
    assert narrow.temperature_range == (340.0, 800.0)
    assert scene.conduction(450.0).conductivity == 42.5
    assert scene.conduction(450.0).counter_diffusivity == pytest.approx(
        13.75 / (2700 * 900), rel=1e-15
    )
    for ask in (scene.conduction, lambda: scene.conduction(901.0), lambda: scene.conduction(299.0)):
        with pytest.raises(SceneError, match=r"must lie between 300 K and 900 K"):
            ask()


@pytest.mark.parametrize(
    ("conductivity", "start", "words"),
    [
        (
            table(60.0, 20.0),
            None,
            "background_temperature is missing; a conductivity that is a table",
        ),
        (table(60.0, 20.0), 299.0, "= 299 K must lie between 300 K and 900 K"),
        ({"temperature": [300, 900], "value": [1]}, 300.0, "has 2 temperatures and 1 values"),
        ({"temperature": [300], "value": [1]}, 300.0, "has 1 temperatures and 1 values"),
        (
            {"temperature": [300, 300], "value": [1, 2]},
            300.0,
            r"\[1\] has temperature = 300.0 K after 300.0 K",
        ),
        (
            {"temperature": ["300 K", "9 m"], "value": [1, 2]},
            300.0,
            r"temperature\[1\] = \"9 m\" has the dimension",
        ),
        (
            {"temperature": [300, 900], "value": [1, 0]},
            300.0,
            r"value\[1\] = 0 W/\(m K\) must be greater than 0",
        ),
        (
            {"temperature": [-3, 900], "value": [1, 2]},
            300.0,
            r"temperature\[0\] = -3 K must be greater than 0 K",
        ),
        (
            {"temperature": [300, 900], "values": [1]},
            300.0,
            r'values = \[1\] is not a key of a .* mean "value"',
        ),
        (
            {"temperature": 300, "value": 30},
            300.0,
            "temperature = 300 must be a list; a table is written as",
        ),
        ([[300, 1], [900, 2]], 300.0, "must be a valid number in"),
    ],
)
def test_a_table_without_meaning_is_refused_in_one_line(quick, conductivity, start, words):
    with pytest.raises(SceneError, match=words) as refusal:
        replace(
            quick,
            body=replace(quick.body, conductivity=conductivity),
            sliding=replace(quick.sliding, background_temperature=start),
        )
    assert "\n" not in str(refusal.value)


def test_of_several_temperatures_the_one_next_to_the_background_is_taken():
    # T = T₀ + 0.75 T_flash(T) with T_flash = 400 + 0.001 (T − 300)²: 0.00075 x² − x + 300 = 0 with x = T − T₀
    root = 300 + (1 - np.sqrt(1 - 4 * 0.00075 * 300)) / (2 * 0.00075)
    found = effective_temperature(
        lambda t: 400 + 0.001 * (t - 300) ** 2, background_temperature=300.0
    )
    assert found == pytest.approx(root, rel=1e-9)


@pytest.mark.parametrize("slope", [0.5, 1.0, 5.0, 50.0])
def test_a_flash_temperature_that_falls_steeply_is_found_too(slope):
    found = effective_temperature(
        lambda t: 100 - slope * (t - 300) / 0.75, background_temperature=300.0
    )
    assert found == pytest.approx(300 + 75 / (1 + slope), rel=1e-9)


def nonlinear_flash_temperature(kappa, flux):
    """T_flash over T₀ = 300 K of a fast square source: heat by κ(T) straight down for a time 1, ρc = 1.

    Finite volumes in depth; the mean over time is the mean over the source, from its leading to its trailing edge.
    """
    edges = 3.5 * np.sqrt(2 * kappa(300.0)) * np.linspace(0, 1, 121) ** 2
    height, centre = np.diff(edges), 0.5 * (edges[1:] + edges[:-1])

    def rate(_, t):
        down = kappa(0.5 * (t[1:] + t[:-1])) * -np.diff(t) / np.diff(centre)
        return np.diff(np.concatenate([[-flux], -down, [0.0]])) / height

    times = np.linspace(0, 1, 401) ** 2
    start = np.full(height.size, 300.0)
    solved = solve_ivp(rate, (0, 1), start, "LSODA", times, rtol=1e-7, atol=1e-5, lband=1, uband=1)
    surface = solved.y[0] + flux * height[0] / 2 / kappa(solved.y[0])
    return np.trapezoid(np.where(times > 0, surface - 300.0, 0.0), times)


@pytest.mark.parametrize(
    ("cold", "at_900", "error"), [(50, 50, 2e-4), (50, 30, 0.7e-2), (30, 50, 0.9e-2)]
)
def test_the_constant_meets_nonlinear_conduction_within_a_percent(cold, at_900, error):
    flux = 0.75 * 250 * np.sqrt(np.pi * cold)  # 250 K with the cold κ: T_flash = (4/3) q̇ √(t/πκ)
    found = effective_conductivity(
        lambda t: cold + (at_900 - cold) * (t - 300) / 600,
        lambda k: 4 / 3 * flux / np.sqrt(np.pi * k),
        background_temperature=300.0,
    )
    exact = nonlinear_flash_temperature(lambda t: cold + (at_900 - cold) * (t - 300) / 600, flux)
    assert 4 / 3 * flux / np.sqrt(np.pi * found) == pytest.approx(exact, rel=error)
    if cold != at_900:  # and neither the cold κ nor that of the full T_flash does
        full = brentq(
            lambda r: 4 / 3 * flux / np.sqrt(np.pi * (cold + (at_900 - cold) * r / 600)) - r, 1, 590
        )
        assert abs(full / exact - 1) > 2 * error
        assert abs(250 / exact - 1) > 5 * error
