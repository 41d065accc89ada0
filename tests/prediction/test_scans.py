"""The error of T_flash by the scans of C(q): exact where T_flash is linear in C, and maps cut out of known surfaces."""

import math
from dataclasses import replace

import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction
from roughsim.prediction.scans import long_waves, scan_error, scan_of_hottest
from roughsim.scene.sections import SurfaceSection
from roughsim.surface.topography.measured import combined, levelled, map_spectrum

NAME = "flash_temperature"
Q_MIN, SPEEDS = 6350.0, (0.001, 35.0)
# heights of 10 pm: full contact, in which T_flash ∝ C; none of the waves is much longer than the rest
FLAT = ((1e4, 1e-38), (2e4, 1e-32), (4e4, 1e-32))


@pytest.fixture(scope="module")
def steel():
    scene = rs.load_scene("steel-1.2GPa")
    elastic = replace(scene.body, penetration_hardness=None)
    return replace(scene, body=elastic, sliding=replace(scene.sliding, speed=SPEEDS))


def with_errors(steel, rows, *errors):
    face = SurfaceSection(psd=rows, psd_convention="persson", psd_source="scan", psd_error=errors)
    return replace(steel, surface=face)


def test_what_all_scans_share_changes_the_flash_temperature_as_c_in_full_contact(steel):
    # without one scan C is 10 % higher at every q, without the other 10 % lower: Student t of one degree of freedom
    scene = with_errors(steel, FLAT, *[(0.0, 0.1, -0.1)] * 3)
    expected = math.expm1(12.706 * math.hypot(math.log(1.1), math.log(0.9)))
    found = scan_error(scene)["flash_temperature"]
    np.testing.assert_allclose(found, expected, rtol=0.01)


def test_points_that_were_filled_add_three_times_their_share_of_c(steel):
    # full contact: T_flash ∝ C. The error is one way, and adds to that of the rows
    scene = with_errors(steel, FLAT, *[(0.05,)] * 3)
    alone = scan_error(scene, NAME)[NAME]
    filled = replace(scene, surface=replace(scene.surface, psd_filled=0.02))
    found = scan_error(filled, NAME)[NAME]
    np.testing.assert_allclose((1 + found) / (1 + alone), 1.06, rtol=1e-3)


def test_rows_that_scatter_alone_add_up_as_squares(steel):
    # T_flash ∝ Σ of the parts of the rows, so that the errors of all rows together are those of each, as squares
    zero = ((0.0,), (0.0,), (0.0,))
    alone = []
    for k in range(3):
        errors = [*zero[:k], (0.01,), *zero[k + 1 :]]
        alone.append(np.log1p(scan_error(with_errors(steel, FLAT, *errors), NAME)[NAME]))
    together = np.log1p(scan_error(with_errors(steel, FLAT, *[(0.01,)] * 3), NAME)[NAME])
    np.testing.assert_allclose(together, np.sqrt(np.sum(np.square(alone), axis=0)), rtol=1e-3)
    # all at once would be 1 % of C, and so 1.96 % of T_flash: the parts of the rows add up to that
    np.testing.assert_allclose(
        np.sum(alone, axis=0), 1.96 * 0.01, rtol=0.06
    )  # for steps of 10 % in C


def test_scans_that_differ_by_no_more_than_their_scatter_show_no_difference_of_places(steel):
    one = scan_error(with_errors(steel, FLAT, *[(0.1,)] * 3), NAME)[NAME]
    two = scan_error(with_errors(steel, FLAT, *[(0.1, 0.05, -0.05)] * 3), NAME)[NAME]
    np.testing.assert_allclose(two, one, rtol=1e-9)


def change_of(steel, rows, factors):
    """How ln T_flash changes if C of each row is so many times as large, by the theory."""
    changed = tuple((q, psd * factor) for (q, psd), factor in zip(rows, factors, strict=True))
    own, other = (
        prediction.predictions(with_errors(steel, table, *[(0.0,)] * len(rows)))[NAME]
        for table in (rows, changed)
    )
    return np.log(other / own)


def of_each_row(steel, rows):
    """d ln T_flash / d ln C of each row, over 10 % of C."""
    return np.array([change_of(steel, rows, np.exp(0.1 * row)) / 0.1 for row in np.eye(len(rows))])


def test_the_difference_of_places_is_what_is_beyond_the_scatter_of_the_rows_that_scans_share(steel):
    errors = (
        (0.1, 0.25, -0.25),
        (0.1, 0.25, -0.25),
        (0.1, 0.0, 0.0),
    )  # the last row is of one scan alone
    squares = (0.1 * of_each_row(steel, FLAT)) ** 2
    between = sum(
        change_of(steel, FLAT, factors) ** 2 for factors in ((1.25, 1.25, 1.0), (0.75, 0.75, 1.0))
    )
    within = squares[:2].sum(axis=0)
    assert (between > 3.84 * within).all()  # χ² of one degree of freedom at 5 %
    expected = np.sqrt(1.96**2 * squares.sum(axis=0) + 12.706**2 * (between - within))
    found = scan_error(with_errors(steel, FLAT, *errors), NAME)[NAME]
    np.testing.assert_allclose(np.log1p(found), expected, rtol=1e-3)


@pytest.mark.parametrize(
    ("ratio", "shown"), [(2.6, False), (3.4, True)]
)  # χ² of two degrees of freedom: 5.99 = 2 · 3.0
def test_three_scans_show_a_difference_of_places_at_five_percent(steel, ratio, shown):
    squares = (0.1 * of_each_row(steel, FLAT)) ** 2
    part = math.sqrt(
        ratio * squares.sum(axis=0)[0] / 2
    )  # so that its square, twice, is `ratio` times the scatter
    factors = [math.exp(sign * part) for sign in (1, -1)]  # T_flash ∝ C
    errors = [(0.1, factors[0] - 1, factors[1] - 1, 0.0)] * 3
    found = np.log1p(scan_error(with_errors(steel, FLAT, *errors), NAME)[NAME])
    alone = 1.96 * np.sqrt(squares.sum(axis=0))
    assert (found > 1.5 * alone).tolist() == [shown, shown]
    if not shown:
        np.testing.assert_allclose(found, alone, rtol=1e-3)


def test_waves_that_are_missing_add_to_the_scatter(steel):
    rows = tuple((q, 1e-32 * (q / 1e4) ** -1.0) for q in (1e4, 3e4, 1e5))
    scatter = 1.96 * 0.01 * np.sqrt((of_each_row(steel, rows) ** 2).sum(axis=0))
    own, longer = (
        prediction.predictions(with_errors(steel, table, *[(0.0,)] * len(table)))[NAME]
        for table in (rows, ((1.0, 1e-28), *rows))
    )
    scanned = with_errors(steel, rows, *[(0.01,)] * 3)
    found = np.log1p(scan_error(scanned, NAME)[NAME])
    np.testing.assert_allclose(found - scatter, np.log(longer / own), rtol=0.005)
    # a plan says that at the speed of the highest T_flash
    assert own[1] > own[0]
    assert scan_of_hottest(scanned) == pytest.approx(np.expm1(found[1]))
    assert abs(found[1] / found[0] - 1.0) > 0.01


@pytest.mark.slow
def test_waves_longer_than_the_scan_count_where_c_rises_to_them(steel):
    # T_flash ∝ ∫ q² C/q^k dq: ∝ ∫ q C dq in fast, ∫ q² C dq in slow sliding, so that C ∝ q^−1 has a limit in both
    rows = tuple((q, 1e-32 * (q / 1e4) ** -1.0) for q in (1e4, 3e4, 1e5))
    found = scan_error(with_errors(steel, rows, *[(0.0,)] * 3))["flash_temperature"]
    own, longer = (
        prediction.predictions(with_errors(steel, table, *[(0.0,)] * len(table)))[
            "flash_temperature"
        ]
        for table in (rows, ((1.0, 1e-28), *rows))
    )
    np.testing.assert_allclose(found, longer / own - 1.0, rtol=0.05)
    steep = tuple((q, 1e-32 * (q / 1e4) ** -3.6) for q in (1e4, 3e4, 1e5))
    scene = with_errors(steel, steep, *[(0.0,)] * 3)
    assert np.isnan(scan_error(scene)["flash_temperature"]).all()
    assert math.isnan(scan_of_hottest(scene))
    # ⟨σ²⟩ ∝ ∫ q³ C dq ∝ q^0.4: it has a limit, and lacks 1/(10^0.4 − 1) of what the band from q to 10 q has
    assert scan_error(scene)["pressure_variance"][0] == pytest.approx(1 / (10**0.4 - 1), rel=0.05)


# ten rows per decade, q ∝ 10^(k/10): from 2 to 10 times the second one there are those of k = 4.01 … 11
TEN = 1e4 * 10.0 ** (np.arange(21) / 10)


def test_long_waves_go_on_as_the_rows_above_the_first_with_the_error_of_their_line():
    psd, error = 1e-32 * (TEN / TEN[0]) ** -1.5, np.full(TEN.size, 0.3)
    x = (
        np.log(10) / 10 * np.arange(5, 12)
    )  # of a line through points with equal errors: σ²/Σ(x − x̄)²
    expected = 0.3 / math.sqrt(np.sum((x - x.mean()) ** 2))
    found = long_waves(TEN, psd, error)
    assert found == pytest.approx((1.5, expected, 1e-32), rel=1e-6, abs=0)
    # the first row is lower, as levelling took of it: the law begins above it; where it is higher, it counts
    lower, higher = (np.concatenate([[factor * psd[0]], psd[1:]]) for factor in (0.25, 4.0))
    assert long_waves(TEN, lower, error) == pytest.approx((1.5, expected, 1e-32), rel=1e-6, abs=0)
    assert long_waves(TEN, higher, error) == pytest.approx((1.5, expected, 4e-32), rel=1e-6, abs=0)


def test_rows_of_large_errors_count_little_for_the_long_waves():
    psd, error = 1e-32 * (TEN / TEN[0]) ** -1.5, np.full(TEN.size, 0.1)
    psd[8], error[8] = 5.0 * psd[8], 1e3
    assert long_waves(TEN, psd, error).exponent == pytest.approx(1.5, abs=1e-4)


def test_where_c_ends_at_the_first_rows_they_say_how_it_goes_on():
    # it falls as q² to long waves: what the plane and the window take of rows as long as the map is less than that
    psd = 1e-32 * np.where(TEN[4] > TEN, (TEN / TEN[4]) ** 2.0, (TEN / TEN[4]) ** -3.0)
    x = (
        np.log(10) / 10 * np.arange(5)
    )  # up to twice the second row, and half of the error of that line
    error = 0.5 * 0.3 / math.sqrt(np.sum((x - x.mean()) ** 2))
    assert long_waves(TEN, psd, np.full(TEN.size, 0.3)) == pytest.approx(
        (2.7 - 2.0, error, psd[0]), rel=1e-6, abs=0
    )


def test_the_error_is_unknown_where_an_exponent_steeper_by_its_error_has_no_limit(steel):
    # in full contact slow sliding has T_flash ∝ ∫ q² C dq and fast ∝ ∫ q^2.5 C dq: each decade counts less than half of
    # the one before for exponents below 2.7 and 3.2. C ∝ q^−2.3 with a standard error of 0.2 or of 0.6
    rows = tuple(zip(TEN.tolist(), (1e-34 * (TEN / TEN[0]) ** -2.3).tolist(), strict=True))
    x = np.log(10) / 10 * np.arange(5, 12)
    for scatter, unknown in ((0.2, False), (0.6, True)):
        error = scatter * math.sqrt(np.sum((x - x.mean()) ** 2))
        found = scan_error(with_errors(steel, rows, *[(error,)] * TEN.size), NAME)[NAME]
        assert np.isnan(found).tolist() == [unknown, False]


def test_errors_of_two_faces_add_up_as_squares(steel):
    like = with_errors(
        steel, FLAT, *[(0.01,)] * 3
    )  # the counterface has the same C(q), and moves with it
    keys = {
        key: getattr(like.surface, key)
        for key in ("psd", "psd_convention", "psd_source", "psd_error")
    }
    both = replace(like, counterface=replace(like.counterface, like=None, **keys))
    found, together = (np.log1p(scan_error(scene, NAME)[NAME]) for scene in (both, like))
    np.testing.assert_allclose(
        found, together / math.sqrt(2.0), rtol=0.02
    )  # half of C each, tried in steps of 10 %


def test_the_error_is_unknown_without_that_of_c_and_absent_without_scans(steel):
    unknown = replace(
        steel, surface=replace(with_errors(steel, FLAT, *[(0.0,)] * 3).surface, psd_error=None)
    )
    assert np.isnan(scan_error(unknown)["flash_temperature"]).all()
    assert scan_of_hottest(steel) is None
    assert not scan_error(steel)["flash_temperature"].any()


def test_that_of_the_flash_temperature_alone_is_the_same(steel):
    scene = with_errors(steel, FLAT, (0.1, 0.05, -0.1), (0.2, 0.1, 0.3), (0.1, 0.3, -0.1))
    np.testing.assert_allclose(scan_error(scene, NAME)[NAME], scan_error(scene)[NAME], rtol=1e-9)


def draws(kind, seeds, points, q_max):
    """Whether the stated error holds T_flash of the surface that a map of one longest wave was cut out of."""
    roll_off, exponent = kind
    face = SurfaceSection(
        rms_height=9e-7,
        hurst=0.8,
        q_min=Q_MIN,
        q_roll_off=roll_off,
        q_max=q_max,
        roll_off_exponent=exponent,
    )
    scene = replace(rs.load_scene("steel-1.2GPa"), surface=face)
    scene = replace(scene, sliding=replace(scene.sliding, speed=SPEEDS))
    true = prediction.predictions(scene)["flash_temperature"]
    side = 4 * 2 * math.pi / Q_MIN
    grid, part = (
        rs.Grid((points, points), (side, side)),
        rs.Grid((points // 4, points // 4), (side / 4, side / 4)),
    )
    inside, errors = [], []
    for seed in seeds:
        heights = rs.synthesize(
            scene.faces[0], grid, np.random.default_rng(seed), amplitudes="gaussian"
        )
        spectrum, error = combined(
            [map_spectrum(levelled(heights[: points // 4, : points // 4]), part, periodic=False)]
        )
        rows = tuple(zip(spectrum.q.tolist(), spectrum.psd.tolist(), strict=True))
        scan = with_errors(scene, rows, *map(tuple, error.tolist()))
        found, stated = (
            prediction.predictions(scan)["flash_temperature"],
            scan_error(scan, NAME)[NAME],
        )
        inside.append(~(np.abs(found - true) > stated * found))  # unknown holds everything
        errors.append(stated)
    return np.sum(inside, axis=0), np.array(errors)


@pytest.mark.slow
@pytest.mark.statistical
def test_the_stated_error_of_maps_cut_out_of_a_known_surface_holds():
    inside, errors = draws((9.4e4, 1.5), range(8), 256, 1.5e5)
    assert (inside >= 6).all()  # of 8 at 95 %: fewer than 6 has a probability of 0.6 %
    assert (np.median(errors, axis=0) < (0.8, 0.4)).all()  # and it is no empty statement


@pytest.mark.slow
@pytest.mark.parametrize("kind", [(9.4e4, 1.5), (Q_MIN, 0.0)], ids=["steel", "self-affine"])
def test_the_stated_95_percent_interval_covers_in_90_of_100_draws(kind):
    inside, _ = draws(kind, range(100), 512, 3e5)
    assert (inside >= 90).all()
