"""The periodic grid: its modes are those of numpy's transforms, and half a spectrum counts as a whole one."""

import itertools
import pickle

import numpy as np
import pytest

import roughsim as rs
from roughsim.grid import Grid

SHAPES = [(1, 1), (1, 8), (7, 1), (2, 2), (4, 5), (5, 4), (16, 9), (61, 64)]


@pytest.mark.parametrize("shape", SHAPES)
def test_wavevectors_are_those_of_numpys_transform(shape):
    grid = Grid(shape, (3e-3, 2e-3))
    qx, qy = grid.wavevectors
    expected = 2 * np.pi * np.fft.fftfreq(shape[0], 3e-3 / shape[0])
    np.testing.assert_allclose(qx[:, 0], expected, rtol=1e-14)
    np.testing.assert_allclose(
        qy[0], 2 * np.pi * np.fft.rfftfreq(shape[1], 2e-3 / shape[1]), rtol=1e-14
    )
    assert qx.shape == (shape[0], 1)
    assert qy.shape == (1, shape[1] // 2 + 1)
    np.testing.assert_allclose(grid.wavenumbers**2, qx**2 + qy**2, rtol=1e-14)
    assert grid.wavenumbers.shape == grid.half_shape == np.fft.rfft2(np.zeros(shape)).shape


@pytest.mark.parametrize("shape", SHAPES)
def test_the_half_spectrum_counts_every_mode_of_the_plane_once(shape):
    grid = Grid(shape, (1.0, 1.0))
    full = np.hypot(
        *np.meshgrid(np.fft.fftfreq(shape[0]) * shape[0], np.fft.fftfreq(shape[1]) * shape[1])
    )
    counts = np.broadcast_to(grid.multiplicity, grid.half_shape)
    assert counts.sum() == grid.points == full.size
    assert (counts * grid.wavenumbers**2).sum() == pytest.approx(
        (2 * np.pi) ** 2 * (full**2).sum(), rel=1e-13
    )


@pytest.mark.parametrize("shape", SHAPES)
def test_multiplicity_gives_the_mean_square_of_a_field(shape):
    field = np.random.default_rng(3).standard_normal(shape)
    half = np.fft.rfft2(field) / field.size
    assert (Grid(shape, (1.0, 2.0)).multiplicity * abs(half) ** 2).sum() == pytest.approx(
        (field**2).mean(), rel=1e-13
    )


def test_spacing_and_points():
    grid = Grid((4, 10), (2e-3, 1e-3))
    assert grid.spacing == (5e-4, 1e-4)
    assert grid.points == 40


@pytest.mark.parametrize(
    ("shape", "lengths", "nyquist"),
    [
        ((8, 8), (2.0, 2.0), 4 * np.pi),
        ((8, 8), (2.0, 4.0), 2 * np.pi),
        ((8, 4), (2.0, 2.0), 2 * np.pi),
        ((7, 7), (1.0, 1.0), 7 * np.pi),
        ((1, 8), (1.0, 2.0), 4 * np.pi),  # along an axis of one point nothing varies
        ((8, 1), (2.0, 1.0), 4 * np.pi),
        ((1, 1), (1.0, 1.0), np.inf),
    ],
)
def test_nyquist_is_what_both_directions_resolve(shape, lengths, nyquist):
    assert Grid(shape, lengths).nyquist == pytest.approx(nyquist, rel=1e-15)


def test_a_wave_at_the_nyquist_wavenumber_alternates_from_point_to_point():
    grid = Grid((8, 8), (3e-3, 3e-3))
    x = np.arange(8) * grid.spacing[0]
    np.testing.assert_allclose(np.cos(grid.nyquist * x), (-1.0) ** np.arange(8), atol=1e-14)


def test_grids_compare_by_value_and_survive_pickling():
    grid = Grid(np.array([4, 6]), [1, np.float64(2.0)])
    assert grid == Grid((4, 6), (1.0, 2.0)) == pickle.loads(pickle.dumps(grid))
    assert hash(grid) == hash(Grid((4, 6), (1.0, 2.0)))
    assert grid != Grid((6, 4), (1.0, 2.0))
    assert all(type(n) is int for n in grid.shape)


def test_shared_arrays_cannot_be_changed():
    grid = Grid((4, 6), (1.0, 2.0))
    for array in (*grid.wavevectors, grid.wavenumbers, grid.multiplicity):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 5.0


BAD_SHAPES = [
    ((0, 4), ValueError),
    ((4, -2), ValueError),
    ((4.0, 4), TypeError),
    (("4", 4), TypeError),
    ((4,), ValueError),
    ((4, 4, 4), ValueError),
    (64, TypeError),
]
BAD_LENGTHS = [
    ((0.0, 1.0), ValueError),
    ((1.0, -1.0), ValueError),
    ((float("nan"), 1.0), ValueError),
    ((1.0, float("inf")), ValueError),
    (("1", 1.0), TypeError),
    ((1.0, 1j), TypeError),
    ((1.0,), ValueError),
    (1.0, TypeError),
]


@pytest.mark.parametrize(("shape", "error"), BAD_SHAPES)
def test_a_shape_that_is_no_pair_of_counts_is_refused(shape, error):
    with pytest.raises(error, match="shape = "):
        Grid(shape, (1.0, 1.0))


@pytest.mark.parametrize(("lengths", "error"), BAD_LENGTHS)
def test_lengths_that_are_no_pair_of_positive_numbers_are_refused(lengths, error):
    with pytest.raises(error, match="lengths = "):
        Grid((4, 4), lengths)


def test_wavevectors_point_both_ways_along_x_and_forwards_along_y():
    for shape in itertools.product((3, 4), repeat=2):
        qx, qy = Grid(shape, (2 * np.pi, 2 * np.pi)).wavevectors
        assert qx[1, 0] == pytest.approx(1)
        assert qx[-1, 0] == pytest.approx(-1)
        assert (qy >= 0).all()


FIELD = np.zeros((8, 8))
CALLS = {
    "solve_contact": lambda grid, solid: rs.solve_contact(FIELD, grid, solid, nominal_pressure=1e6),
    "follow_loads": lambda grid, solid: list(
        rs.follow_loads(FIELD, grid, solid, nominal_pressures=[1e6])
    ),
    "plastic_deformation": lambda grid, solid: rs.plastic_deformation(None, FIELD, grid, solid),
    "contact_patches": lambda grid, _: rs.contact_patches(FIELD > 0, grid),
    "corrected_area": lambda grid, _: rs.corrected_area(FIELD > 0, grid),
    "measure": lambda grid, _: rs.measure(None, grid, None),
    "sliding_temperature": lambda grid, _: rs.sliding_temperature(
        FIELD, grid, speed=1, conductivity=30, diffusivity=1e-5
    ),
    "half_space_temperature": lambda grid, _: rs.half_space_temperature(
        FIELD, grid, speed=1, conductivity=30, diffusivity=1e-5
    ),
    "partition_heat": lambda grid, _: rs.partition_heat(FIELD, grid, moving=None, resting=None),
    "synthesize": lambda grid, _: rs.synthesize(None, grid, None),
}


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_what_is_no_grid_is_refused_by_name(call):
    with pytest.raises(TypeError, match=r"^grid = 3 must be a Grid, as Grid\("):
        call(3, rs.Solid(effective_modulus=1e11))


@pytest.mark.parametrize("name", ["solve_contact", "follow_loads", "plastic_deformation"])
def test_what_is_no_solid_is_refused_by_name(name):
    with pytest.raises(TypeError, match=r"^solid = 1.0 must be a Solid, as Solid\("):
        CALLS[name](rs.Grid((8, 8), (1.0, 1.0)), 1.0)


@pytest.mark.parametrize(
    "call",
    [
        lambda big: Grid((8, 8), (big, 1.0)),
        rs.Solid,
        lambda big: rs.SelfAffineSpectrum.from_rms_height(big, hurst=0.8, q_min=1, q_max=2),
        lambda big: rs.HeatSource(
            speeds=[big], friction_coefficient=1, conductivity=1, diffusivity=1
        ),
        lambda big: rs.realize("demo", rs.plan("demo"), seed=big),
    ],
)
def test_a_whole_number_beyond_floats_is_refused_as_any_other(call):
    with pytest.raises(ValueError, match="must be (finite|a whole number)"):
        call(10**400)
