"""Faces with a lay in runs: exact cases, symmetries, and the axis of directions of the results."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from small_scene import CAPPED, FULL

import roughsim as rs
from roughsim import prediction
from roughsim.planning.realization import level_problem
from roughsim.scene import parse_scene
from roughsim.scene.numerics import Level, Numerics

LENGTHS = "lengths = [2e-3, 2e-3]\n"
FREE = CAPPED.replace(LENGTHS, "")
LEVELS = parse_scene(CAPPED).numerics.levels


def solved(text, lay="", level=1, **scene):
    """A member of a scene, on the levels and the cell of the isotropic one."""
    loaded = parse_scene(text.replace("[surface]\n", f"[surface]\n{lay}\n", 1))
    numerics = Numerics(parse_scene(CAPPED).numerics.levels, (2e-3, 2e-3), tolerance=1e-6)
    return rs.realize(loaded, numerics, seed=3, level=level)


def test_lay_of_one_gives_the_bits_of_today():
    plain, one = solved(FREE), solved(FREE, "lay = 1\nlay_direction = 0.3")
    np.testing.assert_array_equal(one.contact.pressure, plain.contact.pressure)
    for name in ("flash_temperature", "flash_gradient", "flash_laplacian"):
        np.testing.assert_array_equal(
            getattr(one.observables, name), getattr(plain.observables, name)
        )


def test_lay_stretches_the_same_surface():
    plain, grooved = solved(FREE), solved(FREE, "lay = 3")
    np.testing.assert_array_equal(grooved.heights, plain.heights)
    assert grooved.grid.lengths == pytest.approx((2e-3 * sqrt(3), 2e-3 / sqrt(3)))


def test_hardness_alone_knows_no_lay():
    rigid = FREE.replace('youngs_modulus = "200 GPa"', "youngs_modulus = 1e16")
    plain, grooved = solved(rigid), solved(rigid, "lay = 4")
    np.testing.assert_array_equal(grooved.contact.pressure > 5e8, plain.contact.pressure > 5e8)
    np.testing.assert_allclose(grooved.contact.pressure, plain.contact.pressure, atol=1e3)


def by_modes(scene, surface, lengths):
    """Return T_flash of full contact in the directions and at the speeds of a scene."""
    # in full contact σ_q = E*|q|h_q/2; its heat has run through half of the cell
    heights = np.fft.fft2(surface) / surface.size
    qx, qy = (2 * pi * np.fft.fftfreq(96, length / 96) for length in lengths)
    qx, qy = np.meshgrid(qx, qy, indexing="ij")
    square = qx**2 + qy**2
    square[0, 0] = 1.0
    stress = (0.5 * scene.effective_modulus) ** 2 * square * np.abs(heights) ** 2
    stress[0, 0] = 0.0
    diffusivity = 30 / (7900 * 500)
    expected = []
    for angle in scene.directions:
        ux, uy = cos(angle), sin(angle)
        chord = min(lengths[0] / max(abs(ux), 1e-9), lengths[1] / max(abs(uy), 1e-9))
        for speed in (1.0, 35.0):
            root = np.sqrt(square - 1j * speed / diffusivity * (ux * qx + uy * qy))
            grown = _erf(root * sqrt(diffusivity * chord / (2 * speed)))
            heating = 0.11 * speed / (30 * scene.sliding.nominal_pressure)
            expected.append(heating * float(np.sum(stress * (grown / root).real)))
    return expected


def test_full_contact_sums_its_modes(monkeypatch):
    text = FULL.replace(LENGTHS, "").replace("hurst", "lay = 4\nhurst")
    scene = parse_scene(text.replace("speed = [0, 0.001, 1, 35]", "speed = [1, 35]"))
    numerics = Numerics(scene.numerics.levels, (2e-3, 2e-3), tolerance=1e-12)
    member = rs.realize(scene, numerics, seed=3)
    expected = by_modes(scene, member.heights, (2e-3 * 2, 2e-3 / 2))
    np.testing.assert_allclose(member.observables.flash_temperature, expected, rtol=1e-6)
    # the theory of the same modes, and its other moments: amplitudes are those of C(q)
    summed = prediction.mode_sums(scene, scene.spectrum, numerics.grid(0))
    for name in ("flash_temperature", "flash_gradient", "flash_laplacian"):
        measured = getattr(member.observables, name)
        np.testing.assert_allclose(summed[name], measured, rtol=1e-7, err_msg=name)
    monkeypatch.setattr("roughsim.prediction.modes._DENSE", 10.0)
    integral = prediction.mode_sums(scene, scene.spectrum, numerics.grid(0))
    for name in ("flash_temperature", "flash_gradient", "flash_laplacian"):
        np.testing.assert_allclose(integral[name], summed[name], rtol=3e-3, err_msg=name)
    assert np.isnan(summed["heat_partition"]).all()


def scanned(text, gamma=3.0):
    """Return a scene whose C(q⃗) has directions: γ at 30° in long waves, and at 100° in short ones."""
    angles = np.arange(90) * (pi / 90)
    rows = []
    for q, lay in ((2e4, 0.5), (5e4, 1.7)):
        turned = angles - lay
        row = (gamma * np.cos(turned) ** 2 + np.sin(turned) ** 2 / gamma) ** -1.8
        rows.append([q, *row.tolist()])
    table = "psd = [[6283.1853, 3e-28], [2e4, 3e-28], [1e5, 9e-31]]"
    keys = f"{table}\npsd_convention = 'persson'\npsd_directions = {rows}\n"
    head, _, rest = text.partition("[surface]\n")
    return parse_scene(f"{head}[surface]\n{keys}[body]{rest.partition('[body]')[2]}")


def test_full_contact_of_scan_sums_its_modes(monkeypatch):
    scene = scanned(FULL.replace("[0, 0.001, 1, 35]", "[1, 35]"))
    assert len(scene.directions) == 3
    numerics = Numerics(scene.numerics.levels, (2e-3, 2e-3), tolerance=1e-12)
    member = rs.realize(scene, numerics, seed=3)
    assert member.contact.contact_fraction == 1.0
    expected = by_modes(scene, member.heights, (2e-3, 2e-3))
    summed = prediction.mode_sums(scene, scene.spectrum, numerics.grid(0))
    np.testing.assert_allclose(summed["flash_temperature"], expected, rtol=1e-6)
    names = "flash_temperature", "flash_gradient", "flash_laplacian"
    for name in names:
        measured = getattr(member.observables, name)
        np.testing.assert_allclose(summed[name], measured, rtol=1e-7, err_msg=name)
    monkeypatch.setattr("roughsim.prediction.modes._DENSE", 20.0)
    rings = prediction.mode_sums(scene, scene.spectrum, numerics.grid(0))
    for name in names:
        np.testing.assert_allclose(rings[name], summed[name], rtol=4e-3, err_msg=name)
    assert np.isnan(summed["heat_partition"]).all()


@pytest.mark.parametrize(
    "hardness", ["", pytest.param("penetration_hardness = 2e3\n", marks=pytest.mark.slow)]
)
def test_modes_of_scan_approach_the_integral(hardness):
    # light contact: W falls in the frame of the slopes
    text = FULL.replace('"2 MPa"', '"200 Pa"').replace("[0, 0.001, 1, 35]", "[0.1, 35]")
    text = text.replace("conductivity = 30\n", hardness + "conductivity = 30\n")
    text = text[: text.index("levels")] if hardness else text
    scene = scanned(text)
    spectrum = prediction.smoothed_spectrum(scene)
    grid = rs.Grid((520, 520), (1.6e-2, 1.6e-2))
    summed, integral = prediction.mode_sums(scene, spectrum, grid), prediction.predictions(scene)
    # rows of the frame round off the sharp end of C(q): with four times as many it is 1e-3
    limits = {"flash_temperature": 4e-3, "flash_gradient": 8e-3, "flash_laplacian": 2e-2}
    for name, limit in limits.items():
        np.testing.assert_allclose(summed[name], integral[name], rtol=limit, err_msg=name)


def test_theory_of_full_contact_has_its_slopes():
    # σ_q = E*|q|h_q/2 of all waves, so that ⟨σ²⟩ − σ₀² = (E*ξ/2)² with the rms slope ξ
    scene = parse_scene(FULL.replace(LENGTHS, "").replace("hurst", "lay = 4\nhurst"))
    slope = scene.spectrum.rms_slope * sqrt((4 + 1 / 4) / 2)
    found = prediction.predictions(scene)["pressure_variance"]
    assert found == pytest.approx((0.5 * scene.effective_modulus * slope) ** 2, rel=1e-6)


def _erf(z):
    """erf by its own series and asymptotic form, beside the product's."""
    from scipy.special import wofz

    return 1 - np.exp(-(z**2)) * wofz(1j * z)


def test_problem_has_the_lay_of_its_scene():
    scene = parse_scene(FREE.replace("[surface]\n", "[surface]\nlay = 3\n"))
    numerics = Numerics(LEVELS, (2e-3, 2e-3))
    problem = level_problem(scene, numerics, 1)
    assert problem.grid == numerics.grid(1)
    assert problem.cell == numerics.grid(1).stretched(3.0)
    assert problem.sliding.direction == scene.headings
    assert problem.sliding.from_rest


@pytest.fixture(scope="module")
def grooved_run(tmp_path_factory):
    text = FREE.replace("[surface]\n", "[surface]\nlay = 3\n").replace(
        "speed = [0, 0.1, 35]", 'speed = [0.1, 1, 35]\ndirection = ["0 deg", "90 deg"]'
    )
    scene = parse_scene(text.replace("max_realizations = 6", "max_realizations = 4"))
    return rs.run(scene, tmp_path_factory.mktemp("grooved") / "run", progress=False)


def test_results_have_an_axis_of_directions(grooved_run):
    found = grooved_run.estimate("flash_temperature")
    assert found.dims == ("direction", "speed")
    np.testing.assert_allclose(found.coords["direction"], [0.0, pi / 2])
    along, across = found.mean[:, 2]
    assert along > 1.2 * across > 0.0


def test_comparison_has_rows_by_direction(grooved_run):
    rows = [
        row for row in rs.compare(grooved_run).to_dict()["rows"]
        if row["observable"] == "flash_temperature"
    ]  # fmt: skip
    places = [(row["direction"], row["speed"]) for row in rows]
    assert places == [(angle, speed) for angle in (0.0, pi / 2) for speed in (0.1, 1.0, 35.0)]
    found = grooved_run.estimate("flash_temperature").mean.ravel()
    assert [row["capped"]["mean"] for row in rows] == found.tolist()
    assert all(row["calibrated"] > 0.0 for row in rows)
    assert all(row["theory_same_modes"] > 0.0 for row in rows)


def test_members_are_exported_by_direction(grooved_run):
    dataset = grooved_run.to_xarray()
    assert dataset.flash_temperature.dims == ("level", "realization", "direction", "speed")
    assert (dataset.sizes["direction"], dataset.sizes["speed"]) == (2, 3)
    stored = grooved_run.members[2, 0].numbers["flash_temperature"]
    np.testing.assert_array_equal(dataset.flash_temperature[2, 0].values.ravel(), 0.9 * stored)


def test_fields_have_the_stretched_cell(grooved_run):
    level = grooved_run.picture()
    x, y = grooved_run.grid(level).lengths
    assert x / y == pytest.approx(3.0 * np.divide(*grooved_run.numerics.lengths))
    assert grooved_run.samples()[0].reach == pytest.approx(0.5 * np.hypot(*grooved_run.sides))


def test_other_speeds_are_in_the_first_direction(grooved_run):
    scene, speeds = grooved_run.scene, np.array([2.0, 3.0])
    first = prediction.over_speed(scene.towards(0.0), speeds)["flash_temperature"]
    found = prediction.over_speed(scene, speeds)["flash_temperature"]
    np.testing.assert_array_equal(found, first)
    assert (
        found[0]
        > 1.1 * prediction.over_speed(scene.towards(pi / 2), speeds)["flash_temperature"][0]
    )


def test_modes_with_a_skin_at_rest_know_no_direction():
    skin = 'heat_capacity = 500\nskin = { thickness = "0.3 um", conductivity = 3 }\n'
    text = FREE.replace("heat_capacity = 500\n", skin).replace("0, 0.1, 35", "0, 1e-3")
    plain, spectrum = parse_scene(text), parse_scene(FREE).spectrum
    faint = parse_scene(text.replace("[surface]\n", "[surface]\nlay = 1.0000001\n"))
    grid = rs.Grid((128, 128), (2e-3, 2e-3))
    isotropic, found = (prediction.mode_sums(one, spectrum, grid) for one in (plain, faint))
    np.testing.assert_allclose(found["flash_width"][0], isotropic["flash_width"][0], rtol=1e-6)
    # slowly the start from rest is far away
    np.testing.assert_allclose(
        found["flash_temperature"][1], isotropic["flash_temperature"][1], rtol=1e-3
    )


@pytest.mark.parametrize(
    "rule",
    [
        {"heat_partition": '"mean"'},
        {"heat_partition": '"total"', "duration": 1e-3},
        pytest.param({"heat_partition": '"total"', "contact_radius": 3e-3}, marks=pytest.mark.slow),
    ],
)
def test_theory_of_a_faint_lay_is_isotropic(rule):
    keys = "".join(f"{key} = {value}\n" for key, value in rule.items())
    text = FREE.replace("heat_partition = 0.9\n", keys).replace(
        "[0, 0.1, 35]", "[0.1, 35]" if len(rule) == 1 else "[35]"
    )
    faint = parse_scene(text.replace("[surface]\n", "[surface]\nlay = 1.0000001\n"))
    for function in (
        prediction.heat_partition,
        prediction.calibrated_share,
        lambda scene: prediction.predictions(scene)["flash_temperature"],
        lambda scene: prediction.predictions(scene)["slope_length"],
        lambda scene: prediction.calibrated_predictions(scene)["flash_temperature"],
    ):
        isotropic = function(parse_scene(text))
        np.testing.assert_allclose(function(faint), np.tile(isotropic, 3), rtol=1e-6)


def test_theory_has_arrays_over_direction_and_speed(grooved_run):
    values = rs.theory(grooved_run.scene).to_dict()
    assert np.shape(values["calibrated"]["flash_temperature"]) == (2, 3)
    assert np.shape(values["flash_temperature"]) == (2, 3)
    assert (values["lay"], values["lay_direction"]) == (3.0, 0.0)
    assert values["direction"] == [0.0, pi / 2]
    assert values["speed"] == [0.1, 1.0, 35.0]


def test_first_screen_has_directions_in_order(grooved_run):
    rows = rs.theory(grooved_run.scene).summary().rows
    turned = [[float(cell) for cell in row[:2]] for row in rows]
    assert turned == sorted(turned, key=lambda row: (-row[1], row[0]))
    assert len({direction for direction, _ in turned}) > 1


def test_explanation_names_the_directions(grooved_run):
    text = grooved_run.estimate("flash_temperature").explain()
    assert "speeds 0.1, 1, 35 m/s, at each of the directions 0, 90°" in text


@pytest.mark.slow
@pytest.mark.statistical
def test_two_equal_lays_on_square_pixels_are_a_stretched_cell():
    shape = 'rms_height = "0.9 um"\nhurst = 0.8\nq_min = 2e4\nq_roll_off = 3e4\nq_max = 8.5e4\n'
    bodies = FREE[FREE.index("[body]") : FREE.index("[numerics]")].replace("0, 0.1, ", "")
    heat, found = "conductivity = 30\ndensity = 7900\nheat_capacity = 500", {}
    for gamma, q_max in ((2.0, 8.5e4), (2.000001, 1.17e5)):  # equal, and equal but for rounding
        other = bodies.replace('like = "body"', f"{shape}lay = {gamma}\n{heat}")
        scene = parse_scene(f"[surface]\n{shape}lay = 2\n{other}")
        numerics = Numerics((Level("capped", (192, 192), q_max),), (2e-3, 2e-3), tolerance=1e-3)
        drawn = [rs.realize(scene, numerics, seed=5, index=k).observables for k in range(8)]
        found[scene.lay] = np.array([one.flash_temperature for one in drawn])
    assert set(found) == {1.0, 2.0}
    mean, error = found[1.0].mean(axis=0), 3 * found[1.0].std(axis=0) * sqrt(2 / 8)
    # the pixels are √2 longer and shorter, which makes a percent
    assert (np.abs(mean - found[2.0].mean(axis=0)) < error + 0.01 * mean).all()
    assert mean[0] > 1.15 * mean[1] > 1.15 * mean[2]
