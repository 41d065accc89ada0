"""The texture of maps: the lay of their slopes, and how far their heights are from Gaussian ones."""

import math
import warnings
from itertools import product

import numpy as np
import pytest
from some_rows import some

import roughsim as rs
from roughsim.surface.topography.measured import levelled
from roughsim.surface.topography.reading import read_scan
from roughsim.surface.topography.texture import Texture, texture_of
from roughsim.surface.topography.writing import encoded

SIDE = 1e-3


def drawn(shape, rng, *, hurst=0.8, longest=4.0, roll_off=1.0, lengths=(SIDE, SIDE)):
    """A Gaussian map, isotropic in its own lengths, with random amplitudes."""
    grid, q = rs.Grid(shape, lengths), 2 * math.pi / SIDE * longest
    law = rs.SelfAffineSpectrum.from_rms_height(
        1e-6, hurst=hurst, q_min=q, q_roll_off=roll_off * q, q_max=0.95 * grid.nyquist
    )
    return rs.synthesize(law, grid, rng, amplitudes="gaussian")


def grooves(grid, angle, stretch, rng, waves=1500):
    """Plane waves, `stretch` times as long along an angle as across, not periodic."""
    x, y = (np.arange(n) * step for n, step in zip(grid.shape, grid.spacing, strict=True))
    q, phi = (
        2 * math.pi / SIDE * np.exp(rng.uniform(math.log(6), math.log(40), waves)),
        rng.uniform(0, 2 * math.pi, waves),
    )
    along, across = q * np.cos(phi) / stretch, q * np.sin(phi)
    qx = along * math.cos(angle) - across * math.sin(angle)
    qy = along * math.sin(angle) + across * math.cos(angle)
    phase = np.exp(1j * rng.uniform(0, 2 * math.pi, waves)) * q**-0.8
    one, other = phase[:, None] * np.exp(1j * qx[:, None] * x), np.exp(1j * qy[:, None] * y)
    return 1e-7 * np.real(one.T @ other)


def stretched(ratio, angle, rng, *, side=128, longest=4.0, part=1.0, octave=None):
    """A Gaussian map of C(q′), q⃗′ = (√γ q along, q across/√γ), on square pixels; of an octave alone if asked."""
    points = round(side / part)
    x, y = (2 * math.pi / SIDE * part * points * np.fft.fftfreq(points) for _ in range(2))
    along = x[:, None] * math.cos(angle) + y * math.sin(angle)
    across = y * math.cos(angle) - x[:, None] * math.sin(angle)
    root = math.sqrt(ratio)
    if octave is not None:
        number = np.hypot(along, across) * SIDE / (2 * math.pi)
        root = np.where((number >= octave) & (number < 2 * octave), root, 1.0)
    q = np.hypot(along * root, across / root)
    size = np.where(q >= 2 * math.pi / SIDE * longest, np.maximum(q, 1.0) ** -1.8, 0.0)
    heights = np.fft.ifft2(np.fft.fft2(rng.standard_normal((points, points))) * size).real
    return levelled(1e-6 * heights / heights.std())[:side, :side], rs.Grid(
        (side, side), (SIDE, SIDE)
    )


def off_by(found, angle):
    """Angle between two axes, degrees."""
    return (math.degrees(found - angle) + 90) % 180 - 90


@pytest.mark.statistical
@pytest.mark.parametrize("ratio", some([1.5, 3.0, 10.0], 2))
def test_texture_gives_stretch_and_angle(ratio):
    rng = np.random.default_rng(12)
    logs, angles = [], []
    for angle in (0.0, 0.4, 1.1, math.pi / 2, 2.2, 3.0):
        heights, grid = stretched(ratio, angle, rng, longest=8.0)
        found = texture_of(heights, grid, periodic=True)
        logs.append(math.log(found.ratio / ratio))
        angles.append(off_by(found.angle, angle))
        assert not found.isotropic
    # a factor 1.06 over eight seeds and several C(q); the mean of six within three standard errors
    assert abs(np.mean(logs)) < 0.07
    assert np.std(logs) < 0.12
    assert np.sqrt(np.mean(np.square(angles))) < 4.0 / (ratio - 1.0)


@pytest.mark.parametrize("ratio", [3.0, 10.0])
def test_texture_of_a_part_of_a_map_has_its_stretch(ratio):
    heights, grid = stretched(ratio, 0.6, np.random.default_rng(13), part=0.5)
    found = texture_of(levelled(heights), grid, periodic=False)
    assert found.ratio == pytest.approx(ratio, rel=0.25)
    assert abs(off_by(found.angle, 0.6)) < 2.0


def test_texture_names_the_octave_with_another_lay():
    heights, grid = stretched(6.0, 1.0, np.random.default_rng(14), side=256, octave=64)
    found = texture_of(heights, grid, periodic=True)
    assert found.ratio < 2.0
    assert 2.0 < found.band_ratio < 8.0  # half of the octaves beside it counts too
    assert off_by(found.band_angle, 1.0) == pytest.approx(0.0, abs=3.0)
    assert found.band_low == pytest.approx(2 * math.pi / SIDE * 64, rel=1e-9)
    assert "in waves of 7.8 to 16 µm" in found.waves()


@pytest.mark.parametrize(("angle", "rows"), [(0.0, True), (1.55, True), (0.3, False)])
def test_a_lay_along_a_scan_axis_may_be_rows(angle, rows):
    heights, grid = stretched(3.0, angle, np.random.default_rng(15))
    found = texture_of(heights, grid, periodic=True)
    assert found.of_instrument == rows
    said = [str(remark) for remark in found.warnings("surface")]
    assert any("rows of the instrument" in line for line in said) == rows


def test_rows_of_older_scenes_have_ratios_of_slopes():
    older = [1.4, 0.3, 2.5, 0.4, 1e4, 2e4, 0.0, 3.0, 0.0, 1.0]
    found = Texture.of_row(older)
    assert found[:10] == (1.0, *older[1:])  # isotropic maps had up to 1.5
    assert not found.isotropic
    assert Texture.of_row([*found]) == found
    with pytest.raises(TypeError):
        Texture.of_row(older[1:])


def test_oblique_waves_have_their_lay_across_them():
    grid = rs.Grid((48, 48), (SIDE, SIDE))
    x, y = (2 * math.pi * np.arange(48) / 48 for _ in range(2))
    found = texture_of(1e-7 * np.cos(4 * x[:, None] + 3 * y), grid, periodic=True)
    assert abs(off_by(found.angle, math.atan2(3, 4) + math.pi / 2)) < 2.0
    assert found.ratio > 10.0  # straight grooves
    assert not found.isotropic


@pytest.mark.parametrize("angle", some([0.0, 12.0, 45.0, 90.0, 160.0], 2))
@pytest.mark.parametrize(
    ("shape", "lengths"), [((128, 128), (SIDE, SIDE)), ((96, 200), (SIDE, 1.4 * SIDE))]
)
def test_grooves_at_any_angle_on_any_grid_show_stretch_and_angle(angle, shape, lengths):
    grid = rs.Grid(shape, lengths)
    heights = grooves(grid, math.radians(angle), 5.0, np.random.default_rng(3))
    found = texture_of(levelled(heights), grid, periodic=False)
    assert found.ratio == pytest.approx(5.0, rel=0.2)
    assert abs(off_by(found.angle, math.radians(angle))) < 3.0
    assert found.gaussian


def test_a_quarter_turn_turns_the_lay_and_leaves_the_ratio():
    grid = rs.Grid((96, 128), (SIDE, SIDE * 1.2))
    heights = grooves(grid, 0.3, 3.0, np.random.default_rng(4))
    found = texture_of(heights, grid, periodic=False)
    # a turn by 90° takes (x, y) to (−y, x)
    turned = texture_of(
        np.rot90(heights, -1).T[::-1].T, rs.Grid((128, 96), (SIDE * 1.2, SIDE)), periodic=False
    )
    assert turned.ratio == pytest.approx(found.ratio, rel=0.01)  # the search ends within
    mirrored = (math.pi / 2 - found.angle) % math.pi, (found.angle + math.pi / 2) % math.pi
    assert min(abs(turned.angle - angle) for angle in mirrored) < 0.01


def test_fine_isotropic_noise_does_not_hide_long_grooves():
    rng = np.random.default_rng(5)
    grid = rs.Grid((256, 256), (SIDE, SIDE))
    heights = grooves(grid, 0.0, 5.0, rng)
    noise = rng.standard_normal(grid.shape) * 0.2 * heights.std()
    found = texture_of(levelled(heights + noise), grid, periodic=False)
    assert found.ratio == pytest.approx(5.0, rel=0.25)
    assert not found.isotropic
    assert abs(math.sin(found.lay)) < 0.1


def test_a_tilt_that_is_taken_off_and_oblong_pixels_make_no_lay():
    rng = np.random.default_rng(6)
    fine = drawn((256, 256), rng)
    coarse, grid = (
        fine[::2][:, :],
        rs.Grid((128, 256), (SIDE, SIDE)),
    )  # pixels twice as long along x
    tilted = coarse + 30 * fine.std() * np.linspace(0, 1, 128)[:, None]
    found = texture_of(levelled(tilted), grid, periodic=False)
    assert found.isotropic
    assert found.gaussian


@pytest.mark.statistical
@pytest.mark.parametrize(
    ("roll_off", "side", "hurst"), some([*product((4.0, 1.0), (128, 256), (0.3, 0.8, 1.0))], 8)
)
def test_parts_of_isotropic_gaussian_surfaces_are_hardly_ever_taken_for_others(
    roll_off, side, hurst
):
    # 40 quarters of surfaces whose longest wave is the cell, or four times shorter with a plateau: at most 1 warns
    rng = np.random.default_rng(7)
    grid = rs.Grid((side // 2, side // 2), (SIDE / 2, SIDE / 2))
    wrong = 0
    for _ in range(40):
        whole = drawn((side, side), rng, hurst=hurst, longest=roll_off, roll_off=roll_off)
        found = texture_of(levelled(whole[: side // 2, : side // 2]), grid, periodic=False)
        wrong += not (found.isotropic and found.gaussian)
    assert wrong <= 1


def test_spikes_dust_flattened_tops_and_bent_heights_are_not_gaussian():
    rng = np.random.default_rng(8)
    grid = rs.Grid((256, 256), (SIDE, SIDE))
    heights = drawn(grid.shape, rng, roll_off=4.0)
    rms, places = heights.std(), rng.choice(heights.size, 10, replace=False)
    assert texture_of(heights, grid, periodic=True).gaussian
    for depth in (-70.0, -30.0, 20.0):
        other = heights.copy()
        other.flat[places] = depth * rms
        found = texture_of(other - other.mean(), grid, periodic=True)
        assert not found.gaussian
        assert found.outlying == pytest.approx(10 / heights.size)
        standard = (other - other.mean()) / other.std()
        assert found.kurtosis == pytest.approx(np.mean(standard**4), rel=1e-9)
        assert found.skewness == pytest.approx(np.mean(standard**3), rel=1e-9)
    for share in (0.05, 0.1, 0.3):  # honed down to this bearing area
        found = texture_of(
            np.minimum(heights, np.quantile(heights, 1 - share)), grid, periodic=True
        )
        assert found.slope_of_tops < 0.5
        assert not found.gaussian
    for bent in (
        -np.exp(-0.6 * heights / rms),
        -((heights / rms) ** 2),
        np.exp(0.6 * heights / rms),
    ):
        assert not texture_of(rms * (bent - bent.mean()), grid, periodic=True).gaussian


def test_the_slope_of_the_tops_is_that_of_a_roof_on_steep_walls_whatever_the_pixels():
    # walls of slope 3 along x carry a roof of slope 2 along y; around them all is level. The top 5 % lie on the roof
    grid = rs.Grid((300, 900), (3.0, 3.0))
    x, y = (
        (np.arange(n) + 0.5) * step - 1.5 for n, step in zip(grid.shape, grid.spacing, strict=True)
    )
    roof, walls = (
        1.0 + 2.0 * np.abs((y + 1.5) % 0.5 - 0.25),
        np.maximum(3.0 * (1.0 - np.abs(x)), 0.0)[:, None],
    )
    heights = np.minimum(roof, walls)
    squares = np.where(walls > roof, 4.0, np.where(walls > 0.0, 9.0, 0.0))
    found = texture_of(heights - heights.mean(), grid, periodic=True)
    assert found.slope_of_tops == pytest.approx(
        2.0 / math.sqrt(squares.mean()), rel=0.03
    )  # edges of the roof


def test_a_file_with_undefined_points_has_the_texture_of_the_whole_map(tmp_path):
    rng = np.random.default_rng(9)
    grid = rs.Grid((128, 128), (SIDE, SIDE))
    heights = grooves(grid, 0.5, 4.0, rng)
    holes = heights.copy()
    holes[40:52, 60:90] = np.nan
    np.save(tmp_path / "map.npy", holes)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        found = read_scan(tmp_path / "map.npy", size=(SIDE, SIDE), unit=1.0).texture
    whole = texture_of(levelled(heights), grid, periodic=False)
    assert found.ratio == pytest.approx(4.0, rel=0.1)
    assert found.angle == pytest.approx(whole.angle, abs=0.05)
    assert found.gaussian


def scene_of(tmp_path, heights):
    """A scene of one map with its size."""
    grid = rs.Grid(heights.shape, (SIDE, SIDE))
    (tmp_path / "map.nc").write_bytes(encoded(heights, grid, ".nc"))
    return {
        "surface": {"topography": str(tmp_path / "map.nc")},
        "body": {
            "youngs_modulus": 2e11,
            "poisson_ratio": 0.3,
            "penetration_hardness": 2e9,
            "conductivity": 30.0,
            "density": 7900.0,
            "heat_capacity": 500.0,
        },
        "sliding": {"nominal_pressure": 5e7, "friction_coefficient": 0.11, "speed": [1.0, 35.0]},
    }


@pytest.mark.slow
def test_plan_and_theory_name_the_texture_and_warn_and_the_error_of_the_scan_is_unknown(tmp_path):
    from roughsim.planning.limits import judge
    from roughsim.prediction.scans import scan_of_hottest

    rng = np.random.default_rng(10)
    plain = drawn((128, 128), rng, roll_off=3.0)
    spiked = plain.copy()
    spiked.flat[rng.choice(plain.size, 5, replace=False)] = -70 * plain.std()
    ground = rs.synthesize(
        rs.SelfAffineSpectrum.from_rms_height(
            5e-7, hurst=0.8, q_min=2.5e4, q_roll_off=1e5, q_max=2e5
        ),
        rs.Grid((128, 128), (SIDE / 5, SIDE)),
        rng,
    )
    for heights, word in ((plain, None), (spiked, "not Gaussian"), (ground, None)):
        scene = rs.load_scene(scene_of(tmp_path, heights))
        known = judge(scene)
        stated = {remark.quantity: remark.value for remark in known.sizes}
        uneven = heights is ground
        assert ("times as long along" if uneven else "as long in all directions") in stated[
            "texture"
        ]
        assert "kurtosis" in stated["heights"]
        assert known.to_dict()["scene_facts"]["textures"]["surface"][0]["ratio"] > 0
        said = [line for line in known.warnings if "not Gaussian:" in line]
        assert [word in line for line in said] == [True] * bool(word)
        assert all("roughsim press" in line for line in said)
        assert ["write nan for them" in line for line in said] == [word == "not Gaussian"] * bool(
            word
        )
        unknown = [line for line in known.warnings if "its error is unknown" in line]
        ends = ["unknown: the map is not isotropic or not Gaussian; press the map"] * bool(word)
        assert all(line.endswith(end) for line, end in zip(unknown, ends, strict=True))
        assert math.isnan(scan_of_hottest(scene)) == (word is not None)
        # what a run stores says the same
        from roughsim.scene import parse_scene

        assert parse_scene(scene.to_toml()).surface.psd_texture == scene.surface.psd_texture


def test_a_direction_is_read_with_its_unit_and_said_to_change_nothing_on_drawn_surfaces():
    from roughsim.planning.limits import judge

    scene = rs.load_scene("demo", {"sliding.direction": "30 deg"})
    assert scene.sliding.direction == pytest.approx((math.pi / 6,))
    assert any("direction = 30°" in line and "isotropic" in line for line in judge(scene).warnings)
    with pytest.raises(ValueError, match='must be .* "30 deg"'):
        rs.load_scene("demo", {"sliding.direction": 30.0})
