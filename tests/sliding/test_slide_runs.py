"""Scenes with history = "sliding": what a run stores of each slide, the estimate made of it, resuming, and failures."""

import json

import numpy as np
import pytest
from slide_cases import MILLIMETRE, sliding_scene
from stored_cases import member_path, read_member, split_members

import roughsim as rs
from roughsim import prediction
from roughsim.charts.plot import plot_run
from roughsim.ensemble.status import losses
from roughsim.errors import ConvergenceError
from roughsim.planning.realization import slide_problem
from roughsim.results.snapshots import read_snapshots
from roughsim.sliding import member as sliding_member
from roughsim.sliding.path import oblique_path
from roughsim.sliding.spots import SpotLives, survival
from roughsim.surface.synthesis import synthesize

SLIDE = 1  # its level
STEEL = rs.Body(30.0, 30 / (7900 * 500))


@pytest.fixture
def run(sliding_run):
    return sliding_run


def faces(run, index):
    """Both faces of a member, each from a stream of its own."""
    grid, spectrum = run.numerics.grid(SLIDE), run.scene.faces[0].truncated(q_max=2.5e4)
    keys = (SLIDE, index), (SLIDE, index, 1)
    streams = (
        np.random.default_rng(np.random.SeedSequence(run.seed, spawn_key=key)) for key in keys
    )
    return grid, *(synthesize(spectrum, grid, stream) for stream in streams)


def slide(run, index, slid_distance, speed=(1.0, 35.0)):
    grid, resting, moving = faces(run, index)
    return rs.slide(
        resting,
        grid,
        rs.Solid(run.scene.effective_modulus, 1e9),
        nominal_pressure=9e7,
        friction_coefficient=0.11,
        speed=speed,
        moving=STEEL,
        resting=STEEL,
        counter_heights=moving,
        slid_distance=slid_distance,
        tolerance=1e-4,
    )


def test_a_member_holds_the_means_over_the_last_half_of_its_slide(run):
    slid, numbers = slide(run, 1, 1e-3), run.members[SLIDE, 1].numbers
    late = slid.slid_distance > 0.5 * slid.slid_distance[-1]
    assert numbers["sliding_flash_temperature"] == pytest.approx(
        slid.flash_temperature[:, late].mean(axis=1)
    )
    assert numbers["sliding_share"] == pytest.approx(slid.moving_share[:, late].mean(axis=1))


def test_and_those_of_the_same_faces_on_a_coarser_grid(run):
    grid, *waves = faces(run, 1)
    coarse = rs.Grid((24, 24), grid.lengths)
    spectra = [np.fft.fft2(heights) / heights.size for heights in waves]
    # all waves are shorter than the Nyquist wavenumber of both grids: drop the rest of the spectrum
    keep = np.r_[0:12, 20:32]
    resting, moving = (
        np.fft.ifft2(spectrum[np.ix_(keep, keep)] * 24**2).real for spectrum in spectra
    )
    slid = rs.slide(
        resting,
        coarse,
        rs.Solid(run.scene.effective_modulus, 1e9),
        nominal_pressure=9e7,
        friction_coefficient=0.11,
        speed=(1.0, 35.0),
        moving=STEEL,
        resting=STEEL,
        counter_heights=moving,
        slid_distance=1e-3,
        tolerance=1e-4,
    )
    late = slid.slid_distance > 0.5 * slid.slid_distance[-1]
    numbers = run.members[SLIDE, 1].numbers
    for name in ("flash_temperature", "frozen_flash_temperature"):
        expected = getattr(slid, name)[:, late].mean(axis=1)
        assert numbers[f"sliding_coarser_{name}"] == pytest.approx(expected, rel=1e-6)


def test_beside_them_stands_the_frozen_temperature_of_the_same_contacts(run):
    grid, resting, moving = faces(run, 0)
    path, frozen = oblique_path(grid, 1e-3), []
    for offset in path.offsets[1:]:
        heights = resting + np.roll(moving, -offset, axis=(0, 1))
        solid = rs.Solid(run.scene.effective_modulus, 1e9)
        contact = rs.solve_contact(heights, grid, solid, nominal_pressure=9e7, tolerance=1e-6)
        sliding = rs.HeatSource([1.0, 35.0], 0.11, STEEL.conductivity, STEEL.diffusivity)
        frozen.append(rs.measure(contact, grid, sliding).flash_temperature)
    late = path.distance[1:] > 0.5 * path.distance[-1]
    expected = np.mean(np.array(frozen)[late], axis=0)
    # contacts that begin from the last one differ by the tolerance
    assert run.members[SLIDE, 0].numbers["sliding_frozen_flash_temperature"] == pytest.approx(
        expected, rel=1e-3
    )


def test_curves_over_the_distance_are_those_of_the_slide(run):
    slid, curves = slide(run, 0, 1e-3), run.curves()
    assert curves["slid_distance"] == pytest.approx(
        slid.slid_distance
    )  # under 64 steps: all of them
    for name in (
        "flash_temperature",
        "resting_background",
        "contact_temperature",
        "stress_correlation",
    ):
        assert curves[f"slide_{name}"][0] == pytest.approx(getattr(slid, name), rel=1e-9)
    assert curves["slide_spot_survival"][0] == pytest.approx(slid.spot_survival, nan_ok=True)
    assert curves["slide_background"].shape == (
        2,
        2,
        slid.slid_distance.size,
    )  # members, speeds, distances


def test_the_lives_of_spots_are_those_of_the_contacts_on_the_way(run):
    grid, resting, moving = faces(run, 1)
    path, spots, contact = oblique_path(grid, 1e-3), SpotLives(), None
    for n, offset in enumerate(path.offsets):
        heights = resting + np.roll(moving, -offset, axis=(0, 1))
        solid = rs.Solid(run.scene.effective_modulus, 1e9)
        contact = rs.solve_contact(
            heights, grid, solid, nominal_pressure=9e7, tolerance=1e-4, start=contact
        )
        spots.add(path.distance[n], contact.pressure > 0)
    expected = survival(spots.lives(), path.distance[1:])
    assert np.isfinite(expected[:4]).all()
    assert run.curves()["slide_spot_survival"][1] == pytest.approx(expected, nan_ok=True)


def test_the_estimate_is_the_frozen_one_times_the_paired_ratio(run):
    sliding, frozen = (
        np.array([run.members[SLIDE, i].numbers[f"sliding_{name}"] for i in (0, 1)])
        for name in ("flash_temperature", "frozen_flash_temperature")
    )
    coarser, coarser_frozen = (
        np.array([run.members[SLIDE, i].numbers[f"sliding_coarser_{name}"] for i in (0, 1)])
        for name in ("flash_temperature", "frozen_flash_temperature")
    )
    # 24 points a side in place of 32; the error falls with the pixel to a power from 1 to 1.5
    weight = 0.5 / (4 / 3 - 1) + 0.5 / ((4 / 3) ** 1.5 - 1)
    own, other = (
        sliding.mean(axis=0) / frozen.mean(axis=0),
        coarser.mean(axis=0) / coarser_frozen.mean(axis=0),
    )
    ratio = own + weight * (own - other)
    single = run.estimate("flash_temperature")
    e = run.estimate("flash_temperature", "sliding")
    assert e.mean == pytest.approx(single.mean / 0.9 * ratio)
    assert e.budget["bandwidth"] == pytest.approx(
        single.budget["bandwidth"] / 0.9 * ratio, nan_ok=True
    )
    # to first order the scatter of a quotient is that of sliding − ratio·frozen
    rows = (1 + weight) * (sliding - own * frozen) / frozen.mean(axis=0)
    rows -= weight * (coarser - other * coarser_frozen) / coarser_frozen.mean(axis=0)
    error = np.std(rows, axis=0, ddof=1) / np.sqrt(2)
    expected = np.hypot(single.standard_error / 0.9 * ratio, single.mean / 0.9 * error)
    assert e.standard_error == pytest.approx(expected)
    assert (e.budget["slide"] > 0).all()


@pytest.mark.slow
def test_compare_has_a_column_of_what_a_slide_measures(run):
    rows = json.loads(json.dumps(rs.compare(run).to_dict()))["rows"]
    cells = {(row["observable"], row["speed"]): row["sliding"] for row in rows}
    assert (
        cells["flash_temperature", 35.0]["mean"]
        == run.estimate("flash_temperature", "sliding").mean[1]
    )
    share = np.mean([run.members[SLIDE, i].numbers["sliding_share"] for i in (0, 1)], axis=0)
    assert cells["heat_partition", 1.0]["mean"] == pytest.approx(share[0])
    assert cells["contact_fraction", None]["mean"] == run.estimate("contact_fraction").mean[0]
    assert cells["flash_width", 1.0]["mean"] is None
    assert set(cells["flash_width", 1.0]) == set(rows[0]["capped"])


def test_the_theory_of_two_bodies_stands_beside_it(run):
    table = rs.compare(run)
    slid = prediction.sliding_prediction(run.scene)
    told = {
        (row["observable"], row["speed"]): row["sliding_calibrated"]
        for row in table.to_dict()["rows"]
    }
    assert told["flash_temperature", 35.0] == slid.flash_temperature[1]
    assert told["heat_partition", 1.0] == slid.heat_partition[0]
    assert told["flash_width", 1.0] is None
    shown = table.table()
    titles = [column.title for column in shown.columns]
    at = titles.index("sliding")
    assert titles[at + 1] == "sliding, calibrated"
    # within 6 % (docs/sliding.md)
    flash = slid.flash_temperature[1]
    assert shown.cells(at + 1)[1] == f"{flash:.0f} ± {0.06 * flash:.0f}"
    frame = table.to_dataframe()
    assert frame["sliding_calibrated"].iloc[1] == slid.flash_temperature[1]


def test_another_observable_is_refused(run):
    with pytest.raises(
        ValueError,
        match="^observable = 'flash_width' is not in column \"sliding\"; it has flash_temp",
    ):
        run.estimate("flash_width", "sliding")


def test_only_the_first_realizations_slide(run):
    assert run.realizations == 4
    assert sorted(index for level, index in run.members if level == SLIDE) == [0, 1]
    pytest.importorskip("xarray")
    dataset = run.to_xarray()
    assert np.isfinite(dataset.sliding_share[SLIDE].values).all(axis=1).tolist() == [
        True,
        True,
        False,
        False,
    ]


@pytest.mark.slow
def test_a_lost_and_a_damaged_slide_are_computed_again_to_the_bit(run, tmp_path):
    again = rs.run(sliding_scene(), tmp_path / "run", max_realizations=2)
    before = [read_member(again.folder, SLIDE, index) for index in (0, 1)]
    split_members(again.folder)
    paths = [member_path(again.folder, SLIDE, index) for index in (0, 1)]
    paths[0].unlink()
    paths[1].write_bytes(paths[1].read_bytes()[:1000])
    with pytest.warns(RuntimeWarning, match="L1-000001.* it was moved to"):
        rs.run(sliding_scene(), tmp_path / "run", max_realizations=2)
    for index, old in enumerate(before):
        new = read_member(again.folder, SLIDE, index)
        assert all((new.numbers[name] == old.numbers[name]).all() for name in old.numbers)
        for name in old.curves:
            np.testing.assert_array_equal(new.curves[name], old.curves[name])


@pytest.mark.slow
def test_two_processes_make_the_same_members(run, tmp_path):
    both = rs.run(sliding_scene(), tmp_path / "run", workers=2)
    for key, member in run.members.items():
        assert all(
            (both.members[key].numbers[name] == values).all()
            for name, values in member.numbers.items()
        )


def test_a_slide_that_fails_is_told_and_leaves_the_frozen_columns_alone(tmp_path, monkeypatch):
    genuine = sliding_member.solve_slide

    def fail(problem, **options):
        if problem.index == 0:
            raise ConvergenceError("temperatures of the two bodies: none", 1.0, 10)
        return genuine(problem, **options)

    monkeypatch.setattr(sliding_member, "solve_slide", fail)
    run = rs.run(sliding_scene(), tmp_path / "run")
    assert (run.realizations, run.failed, len(run.members.sound(0))) == (4, 0, 4)
    assert losses(run) == [
        "1 members that slide did not converge and are left out of the column sliding"
    ]
    assert run.estimate("heat_partition", "sliding").n == 1


@pytest.mark.slow
def test_with_a_duration_each_speed_is_read_at_its_own_distance(tmp_path):
    # 35 m/s slides 1 mm meanwhile, 14 m/s .4 mm
    history = f'history = "sliding"\nduration = {1e-3 / 35}'
    run = rs.run(
        sliding_scene(history, ("speed = [1, 35]", "speed = [14, 35]")),
        tmp_path / "run",
        max_realizations=1,
    )
    slid = slide(run, 0, 1e-3, speed=(14.0, 35.0))
    late = (slid.slid_distance > 0.2e-3) & (slid.slid_distance < 0.4e-3)
    numbers = run.members[SLIDE, 0].numbers["sliding_flash_temperature"]
    assert numbers[0] == pytest.approx(slid.flash_temperature[0, late].mean())
    # and followed no further: 0.4 mm are 6.3 steps
    curves = run.curves()["slide_flash_temperature"][0]
    assert np.isfinite(curves).sum(axis=1).tolist() == [6, 16]
    assert curves[0, :6] == pytest.approx(slid.flash_temperature[0, :6], rel=1e-12)
    snapshots = read_snapshots(run, 0)
    assert [snapshots.positions(k) for k in (0, 1)] == [6, 16]
    assert plot_run(run, "sliding", tmp_path / "one.svg").exists()


@pytest.mark.slow
def test_after_a_duration_the_column_has_the_background_of_the_slide(tmp_path):
    history = f'history = "sliding"\nduration = {1e-3 / 35}'
    scene = sliding_scene(history, ("speed = [1, 35]", "speed = [14, 35]"))
    run = rs.run(scene, tmp_path / "run", max_realizations=2)
    table = rs.compare(run)
    rows = {(row.observable, row.speed): row for row in table.rows}
    for k, v in enumerate((14.0, 35.0)):
        total, flash = (
            rows[name, v].columns["sliding"]
            for name in ("contact_temperature", "flash_temperature")
        )
        # a share of the heat that hardly changes: 2 q √(Dt/π)/κ; whole steps are not quite the duration
        distance = 0.4e-3 if v == 14.0 else 1e-3
        pixel = oblique_path(run.numerics.grid(SLIDE), 1e-3).distance[1]
        time, flux = (
            round(distance / pixel) * pixel / v,
            0.11 * 9e7 * v * rows["heat_partition", v].columns["sliding"].mean,
        )
        warm = 2 * flux * np.sqrt(STEEL.diffusivity * time / np.pi) / STEEL.conductivity
        assert total.mean - flash.mean == pytest.approx(warm, rel=0.02)
        assert total.total_error > flash.total_error
        slid = [slide(run, i, 1e-3, speed=(14.0, 35.0)) for i in (0, 1)]
        at = round(distance / pixel) - 1
        assert total.mean - flash.mean == pytest.approx(
            np.mean([one.background[k, at] for one in slid]), rel=1e-9
        )
    assert any("but in the column sliding from the slide" in note for note in table.table().notes)


def test_one_rough_face_rests_and_its_one_contact_slides_on(tmp_path, drawn):
    smooth = ('like = "body"', "conductivity = 30\ndensity = 7900\nheat_capacity = 500")
    run = rs.run(
        sliding_scene('history = "sliding"\nslid_distance = "1 mm"', smooth),
        tmp_path / "run",
        max_realizations=1,
    )
    curves = run.curves()
    assert np.ptp(curves["slide_contact_fraction"]) == 0
    assert curves["slide_stress_correlation"] == pytest.approx(1)
    assert np.isnan(curves["slide_spot_survival"]).all()  # none is born, none dies
    snapshots = read_snapshots(run, 0)
    assert snapshots.moving_summits.shape == (16, 0, 2)
    assert (
        snapshots.maps.pressure == snapshots.maps.pressure[0]
    ).all()  # in the frame of the resting body nothing moves
    plot_run(run, "snapshots")
    assert len(drawn) == 1
    assert (
        curves["slide_moving_share"][0, 1, -1] > 0.7
    )  # the moving body runs under hot spots that rest


def test_each_body_carries_its_own_roughness_and_its_own_heat():
    resting = 'rms_height = "0.2 um"\nhurst = 0.5\nq_min = 6350\nq_max = 1e5\n'
    resting += "conductivity = 300\ndensity = 8900\nheat_capacity = 400"
    scene = sliding_scene(MILLIMETRE, ('like = "body"', resting))
    problem = slide_problem(scene, rs.plan(scene))
    whole = rs.SelfAffineSpectrum.from_rms_height(2e-7, hurst=0.5, q_min=6350, q_max=1e5)
    assert problem.resting_spectrum(1e4) == pytest.approx(whole(1e4), rel=1e-9)
    assert problem.moving_spectrum(1e4) == pytest.approx(scene.faces[0](1e4), rel=1e-9)
    for motion, speed in zip(problem.motions, (1.0, 35.0), strict=True):
        assert (motion.speed, motion.friction_coefficient) == (speed, 0.11)
        assert (motion.moving.conductivity, motion.resting.conductivity) == (30, 300)
        assert motion.moving.diffusivity == pytest.approx(30 / (7900 * 500))
        assert motion.resting.diffusivity == pytest.approx(300 / (8900 * 400))


def test_the_slide_is_no_single_contact(run):
    with pytest.raises(ValueError, match="^level = 1 is the slide of one body over the other"):
        rs.realize(run.scene, run.numerics, seed=1, level=SLIDE)


def test_a_frozen_run_has_no_such_column(capped_run):
    with pytest.raises(
        ValueError, match='has no column "sliding": its scene has history = "frozen"$'
    ):
        capped_run.estimate("flash_temperature", "sliding")
    assert "sliding" not in rs.compare(capped_run).to_dict()["rows"][0]


@pytest.mark.slow
def test_the_picture_over_the_distance_has_a_line_for_each_speed(run, tmp_path):
    text = plot_run(run, "sliding", tmp_path / "one.svg").read_text()
    for words in (
        "small capped",
        "2 members",
        "1 m/s",
        "35 m/s",
        "slid distance (mm)",
        "Share of the heat",
    ):
        assert words in text
    with pytest.raises(ValueError, match="sliding is a mean over all"):
        plot_run(run, "sliding", tmp_path / "one.svg", realization=0)
