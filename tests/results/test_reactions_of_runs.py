"""The distribution of the temperature of a run: stored, estimated and compared where the scene asks, else not."""

import json
from dataclasses import replace

import h5py
import numpy as np
import pytest

import roughsim as rs
from roughsim.errors import RecordError
from roughsim.observables.catalogue import observables_of
from roughsim.observables.distribution import BIN_AREAS, LEVELS
from roughsim.store.member_files import BINS, member_path, read_member, write_member

ASKS = {
    "sliding.background_temperature": 500.0,
    "surface.q_roll_off": 3e4,
    "surface.q_max": 8e4,
    "sliding.speed": [0.0, 10.0],
    "sliding.heat_partition": 0.5,
    "observables.heat_above": [560.0],
    "reaction.activation_energy": ["0 eV", "1 eV"],
    "reaction.prefactor": 1e13,
    "reaction.contact_length": 1e-3,
    "ensemble.until": {},
    "numerics.lengths": [2e-3, 2e-3],
    "numerics.levels": [
        {"column": "capped", "shape": [48, 48], "q_max": 4e4},
        {"column": "capped", "shape": [96, 96], "q_max": 8e4},
    ],
}
NAMES = [f"temperature_quantile_{of}{name}" for of in ("", "area_") for name in LEVELS]


@pytest.fixture(scope="module")
def asked(tmp_path_factory):
    scene = rs.load_scene("steel-1.2GPa", ASKS)
    return rs.run(scene, tmp_path_factory.mktemp("asked") / "run", max_realizations=5)


def test_members_store_quantiles_and_bins_of_both_levels(asked):
    path = member_path(asked.folder, 1, 0)
    member = read_member(path)
    for moments in member.moments:
        assert {*NAMES} < {*moments.numbers}
        assert moments.bins.temperature.shape == (2, BIN_AREAS.size)
        heat = BIN_AREAS * moments.bins.pressure  # T_flash is the mean weighted by the heat, up to the width of bins
        flash = (heat * moments.bins.temperature).sum(axis=1) / heat.sum(axis=1)
        np.testing.assert_allclose(flash, moments.numbers["flash_temperature"], rtol=0.02)
        # heat is set free where the pressure is high and hot
        assert np.all(moments.numbers["temperature_quantile_area_50"] < moments.numbers["temperature_quantile_50"])
    with h5py.File(path, "r") as file:
        assert file["bin_temperature"].dims[2].keys() == ["contact_area"]
        np.testing.assert_array_equal(file["contact_area"], BIN_AREAS)
        assert [file[name].attrs["units"] for name in BINS] == ["K", "Pa", "Pa", "1"]


def test_a_scene_that_does_not_ask_stores_and_estimates_nothing_of_it(tmp_path, asked):
    quiet = {key: value for key, value in ASKS.items() if key.split(".")[0] not in ("reaction", "observables")}
    del quiet["sliding.background_temperature"]
    run = rs.run(rs.load_scene("steel-1.2GPa", quiet), tmp_path / "run", max_realizations=2)
    member, loud = (read_member(member_path(one.folder, 1, 0)) for one in (run, asked))
    assert member.bins is None
    assert not {*NAMES} & {*member.numbers}
    assert {*loud.numbers} == {*member.numbers} | {*NAMES}
    np.testing.assert_array_equal(member.numbers["flash_temperature"], loud.numbers["flash_temperature"])
    assert {*run.estimates()} == {*observables_of(distribution=False)} == {*asked.estimates()} - {*NAMES}
    with pytest.raises(ValueError, match=r"is not in this run, whose scene lacks \[observables\] temp"):
        run.estimate("temperature_quantile_99")
    assert run.reactions() == []


def test_quantiles_ascend_and_bracket_the_flash_temperature(asked):
    for of in ("", "area_"):
        means = np.array([asked.estimate(f"temperature_quantile_{of}{name}").mean for name in LEVELS])
        assert np.all(means[:, 0] == 0.0)
        assert np.all(np.diff(means[:, 1]) > 0.0)
    flash = asked.estimate("flash_temperature")
    quantile = asked.estimate("temperature_quantile_50")
    assert quantile.mean[1] == pytest.approx(flash.mean[1], rel=0.1)
    assert quantile.unit == "K"
    assert quantile.total_error[1] > 0.0
    assert {*quantile.budget} >= {"statistical", "bandwidth", "pixel", "size", "solver"}


def test_rows_of_a_reaction_have_their_energy_in_ev(asked):
    table = rs.compare(asked)
    rows = json.loads(json.dumps(table.to_dict()))["rows"]
    about = [(row["observable"], row["energy"], row["speed"]) for row in rows if "energy" in row]
    of_energy = [
        (name, speed) for name in ("reaction_rate", "activation_temperature", "conversion") for speed in (0, 10)
    ]
    assert about == [(name, energy, speed) for energy in (0.0, 1.0) for name, speed in of_energy]
    (still, moving) = [row for row in rows if row["observable"] == "heat_share_above"]
    assert still["temperature"] == moving["temperature"] == 560.0
    assert still["capped"]["mean"] == 0.0
    assert 0.0 < moving["capped"]["mean"] < 1.0
    assert "reaction_rate, 1 eV, 1/s" in str(table)
    assert "heat_share_above 560 K" in str(table)


def found(run, name, energy):
    return next(
        one.estimate
        for one in run.reactions()
        if one.estimate.observable == name and one.energy == pytest.approx(energy)
    )


def test_without_a_barrier_the_rate_is_that_of_the_contact_area(asked):
    area = asked.estimate("contact_fraction")
    rate = found(asked, "reaction_rate", 0.0)
    np.testing.assert_allclose(rate.mean, 1e13 * area.mean[0], rtol=1e-9)
    np.testing.assert_allclose(rate.standard_error, 1e13 * area.standard_error[0], rtol=1e-6)


def test_at_rest_the_contact_reacts_at_the_background_temperature(asked):
    warm, rate = found(asked, "activation_temperature", 1.0), found(asked, "reaction_rate", 1.0)
    assert warm.mean[0] == pytest.approx(500.0, rel=1e-9)
    area = asked.estimate("contact_fraction").mean[0]
    arrhenius = 1e13 * np.exp(-1.602176634e-19 / (1.380649e-23 * warm.mean))  # the definition
    assert rate.mean[0] / area == pytest.approx(arrhenius[0], rel=1e-6)
    assert rate.mean[1] / area == pytest.approx(arrhenius[1], rel=0.05)  # of levels by their ratios
    # Jensen: the rate exceeds that at the mean temperature, so its temperature exceeds T₀ + s T_flash
    assert warm.mean[1] > 500.0 + asked.estimate("flash_temperature").mean[1]
    assert warm.unit == "K"
    # errors of the rate and of its temperature belong together: dT = k T² d ln rate / E
    slope = 1.380649e-23 * warm.mean[1] ** 2 / 1.602176634e-19
    assert warm.standard_error[1] == pytest.approx(slope * rate.standard_error[1] / rate.mean[1], rel=0.5)


def test_the_conversion_in_a_pass_follows_from_the_rate(asked):
    rate, conversion = found(asked, "reaction_rate", 1.0), found(asked, "conversion", 1.0)
    assert conversion.mean[0] == 1.0  # a pass at rest never ends
    assert conversion.mean[1] == pytest.approx(-np.expm1(-rate.mean[1] * 1e-3 / 10.0), rel=1e-9)


def test_bins_of_another_size_are_damage(tmp_path, asked):
    member = read_member(member_path(asked.folder, 0, 0))
    (tmp_path / "realizations").mkdir()
    write_member(tmp_path, replace(member, bins=member.bins._replace(pressure=np.ones((2, 7)))))
    with pytest.raises(RecordError, match="is damaged"):
        read_member(member_path(tmp_path, 0, 0))
