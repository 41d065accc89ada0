"""Fields: what was stored comes back, and heat and temperature follow from the stored pressure."""

import shutil
from dataclasses import replace

import h5py
import numpy as np
import pytest
from stored_cases import read_file, split_members, write_member

import roughsim as rs
from roughsim.results.export import export_run
from roughsim.store.member_files import fields_path


def test_fields_stream_what_is_stored(kept_run):
    for column, level in (("smoothed", 0), ("capped", 2), (None, 2)):  # the finest level of each
        for name in ("heights", "pressure"):
            rows = list(kept_run.fields(name, column))
            assert [index for index, _ in rows] == [0, 1]
            for index, field in rows:
                with h5py.File(fields_path(kept_run.folder, level, index)) as stored:
                    np.testing.assert_array_equal(field, stored[f"entry/fields/{name}"][()])
                assert field.dtype == np.float32


def test_heat_flux_carries_the_frictional_power(kept_run):
    # force balance: the mean pressure is 90 MPa, so μσ₀|v| = 0.11 · 90e6 · 35 W/m²; float32 pressure, tolerance 1e-4
    for speed in (35.0, -35.0):
        for _, flux in kept_run.fields("heat_flux", speed=speed):
            assert flux.dtype == np.float32
            assert flux.mean(dtype=float) == pytest.approx(0.11 * 90e6 * 35, rel=1e-4)


def test_temperatures_are_those_of_the_share_of_the_heat(kept_run):
    scene, grid = kept_run.scene, kept_run.numerics.grid(2)
    pressure = dict(kept_run.fields("pressure"))
    for speed in (35.0, 7.0):  # 7 m/s has no moments in this run
        for index, field in kept_run.fields("temperature", speed=speed, direction=0.4):
            flux = 0.11 * speed * pressure[index].astype(float)
            heat = {"conductivity": 30.0, "diffusivity": 30.0 / (7900 * 500), "direction": 0.4}
            whole = rs.sliding_temperature(flux, grid, speed=speed, **heat)
            assert field.dtype == np.float32
            np.testing.assert_allclose(field, 0.9 * whole, atol=1e-5 * np.abs(whole).max())
    assert scene.sliding.heat_partition == 0.9


def test_the_slid_distance_of_the_numerics_is_used(kept_run):
    far = rs.open_run(kept_run.folder)
    far.numerics = replace(far.numerics, slid_distance=1e-5)
    (_, short), (_, half) = (
        next(far.fields("temperature", speed=35.0)),
        next(kept_run.fields("temperature", speed=35.0)),
    )
    assert short.std() < 0.5 * half.std()  # after 10 µm the body is still cold


def test_the_hot_spot_trails_where_the_source_came_from(kept_run):
    # heat lies behind the source: T at a distance behind the contact exceeds T as far ahead
    pressure = next(kept_run.fields("pressure"))[1].astype(float)
    for speed, direction, axis, sign in (
        (35.0, 0.0, 0, 1),
        (-35.0, 0.0, 0, -1),
        (35.0, np.pi / 2, 1, 1),
    ):
        temperature = next(kept_run.fields("temperature", speed=speed, direction=direction))[1]
        behind = (
            temperature * np.roll(pressure, -6 * sign, axis)
        ).mean()  # pressure taken 6 points ahead
        ahead = (temperature * np.roll(pressure, 6 * sign, axis)).mean()
        assert behind > ahead


def test_a_stated_share_is_that_of_all_speeds(kept_run):
    assert [kept_run.heat_share(speed) for speed in (-35.0, 0.01, 7.0, 90.0)] == [0.9] * 4


def test_one_field_is_in_memory_at_a_time(kept_run, calls):
    from roughsim.results import run

    read = calls(run, "read_fields")
    stream = kept_run.fields("pressure")
    assert read == []
    next(stream)
    assert len(read) == 1


WRONG_FIELDS = {
    "unknown": (
        ("temp",),
        {},
        "name = 'temp' is no field; choose one of heights, pressure, heat_flux, temperature",
    ),
    "no speed": (("temperature",), {}, "speed is missing"),
    "useless speed": (("heights",), {"speed": 1.0}, "heights does not depend on it"),
    "speed": (("heat_flux",), {"speed": np.nan}, "speed = nan m/s must be finite"),
    "direction": (("temperature",), {"speed": 1.0, "direction": np.inf}, "direction = inf"),
    "column": (("heights", "elastic"), {}, "column = 'elastic' is not in this run"),
}


@pytest.mark.parametrize("case", WRONG_FIELDS)
def test_wrong_questions_are_refused_before_anything_is_read(kept_run, case):
    words, options, message = WRONG_FIELDS[case]
    with pytest.raises(ValueError, match=message):
        kept_run.fields(*words, **options)  # at once, not at the first next()
    if len(words) == 1:
        with pytest.raises(ValueError, match=message):
            kept_run.field(0, 0, *words, **options)


def test_fields_that_were_not_kept_can_be_had_as_the_error_says(quick, tmp_path):
    scene = replace(quick, numerics=replace(quick.numerics, keep_fields=0))
    run = rs.run(scene, tmp_path / "none", max_realizations=1)
    with pytest.raises(ValueError, match="--keep-fields 1.*rs.realize") as refused:
        run.fields("pressure")
    advice = str(refused.value).partition("recompute one: ")[2]
    one = eval(advice, {"rs": rs, "run": run})  # what the error says can be typed
    assert one.contact.pressure.shape == (32, 32)


def test_a_damaged_field_is_never_shown(quick, tmp_path):
    run = rs.run(quick, tmp_path / "run", max_realizations=1)
    path = fields_path(run.folder, 0, 0)
    content = bytearray(path.read_bytes())
    with h5py.File(path) as stored:
        chunk = stored["entry/fields/pressure"].id.get_chunk_info(0)
    content[chunk.byte_offset] ^= 1
    path.write_bytes(content)
    with pytest.raises(rs.RecordError, match="L0-000000.h5 is damaged .*SHA-256"):
        list(run.fields("pressure"))
    with pytest.raises(rs.RecordError, match="is damaged"):
        export_run(run, tmp_path / "out.h5")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run"]


@pytest.mark.slow
def test_a_run_whose_files_lack_a_field_has_the_others(kept_run, tmp_path):
    shutil.copytree(kept_run.folder, tmp_path / "run")
    for path in (split_members(tmp_path / "run") / "members").glob("L*-000001.h5"):
        member = read_file(path)
        write_member(
            tmp_path / "run", replace(member, fields={"pressure": member.fields["pressure"]})
        )
    part = rs.open_run(tmp_path / "run")
    assert [index for index, _ in part.fields("heights")] == [0]
    assert [index for index, _ in part.fields("temperature", speed=35.0)] == [0, 1]
    np.testing.assert_array_equal(part.field(2, 1, "pressure"), kept_run.field(2, 1, "pressure"))
    with h5py.File(export_run(part, tmp_path / "part.h5")) as file:
        assert file["members/pressure_L2"].shape[0] == 2
        assert "heights_L2" not in file["members"]
