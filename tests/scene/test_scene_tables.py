"""Measured spectra in a scene: however they are stored, and what is no spectrum."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from steel_text import ROWS, approx, refusal, table_scene, with_counterface

import roughsim as rs
from roughsim.scene import SceneError, load_scene, parse_scene


@pytest.mark.parametrize("separator", [" ", "\t", ",", " ; "])
def test_a_table_counts_by_content_however_it_is_stored(tmp_path, separator):
    text = "\n".join(f"{q!r}{separator}{psd!r}" for q, psd in ROWS)
    (tmp_path / "psd.csv").write_text(f"# measured\nq{separator}C\n{text}\n\n")
    (tmp_path / "s.toml").write_text(table_scene('psd_file = "psd.csv"'))
    scene = load_scene(tmp_path / "s.toml")
    assert scene.surface.psd == ROWS
    assert scene == parse_scene(table_scene("psd = [[1e4, 3e-23], [1e5, 7e-27], [2.5e5, 1e-29]]"))
    assert scene.spectrum(1e5) == approx(2 * 7e-27, rel=1e-12)


def test_surfacetopography_s_spectrum_is_4_pi_squared_larger():
    rows = "psd = [[1e4, 3e-23], [1e5, 7e-27], [2.5e5, 1e-29]]"
    persson, other = (
        parse_scene(table_scene(rows)),
        parse_scene(table_scene(rows, "surfacetopography")),
    )
    assert persson.spectrum(1e5) / other.spectrum(1e5) == approx(39.47841760435743, rel=1e-12)


def test_a_table_over_the_spatial_frequency_is_the_density_in_the_plane_of_frequencies():
    # white from f₁ to f₂: ⟨h²⟩ = ∫ C d²f = πC(f₂² − f₁²), and ⟨|∇h|²⟩ = ∫ (2πf)² C d²f = 2π³C(f₂⁴ − f₁⁴); two faces
    low, high, density = 1e4, 3e5, 2e-26
    scene = parse_scene(
        table_scene(f"psd = [[{low}, {density}], [{high}, {density}]]", "frequency")
    )
    assert scene.spectrum.rms_height == approx(
        math.sqrt(2 * math.pi * density * (high**2 - low**2)), rel=1e-9
    )
    assert scene.spectrum.rms_slope == approx(
        math.sqrt(4 * math.pi**3 * density * (high**4 - low**4)), rel=1e-9
    )
    assert scene.spectrum.breaks[-1] == approx(2 * math.pi * high, rel=1e-12)
    assert parse_scene(scene.to_toml()) == scene


def test_the_spatial_frequency_is_that_of_a_drawn_map(tmp_path):
    grid = rs.Grid((128, 128), (1e-3, 1e-3))
    spectrum = rs.SelfAffineSpectrum.from_rms_height(1e-6, hurst=0.8, q_min=1.5e4, q_max=3e5)
    maps = [
        rs.synthesize(spectrum, grid, np.random.default_rng(seed), amplitudes="fixed")
        for seed in range(4)
    ]
    # the periodogram per unit area of the plane of frequencies, mean over rings of f
    power = np.mean([np.abs(np.fft.fft2(heights)) ** 2 for heights in maps], axis=0) / 128**4 * 1e-6
    f = np.hypot(*np.meshgrid(*[np.fft.fftfreq(128, 1e-3 / 128)] * 2))
    edges = np.geomspace(3e3, 4.4e4, 16)
    ring = np.digitize(f, edges)
    rows = [[f[ring == k].mean(), power[ring == k].mean()] for k in range(1, 16)]
    text = "\n".join(f"{x!r}, {y!r}" for x, y in np.array(rows).tolist())
    (tmp_path / "psd.csv").write_text(text)
    (tmp_path / "s.toml").write_text(table_scene('psd_file = "psd.csv"', "frequency"))
    found = load_scene(tmp_path / "s.toml").spectrum
    q = np.array([3e4, 6e4, 1.2e5, 2e5])
    assert found(q) == approx(
        2 * spectrum(q), rel=0.1
    )  # rings are wide, and C falls by 3 across one


@pytest.mark.slow
def test_the_longest_tables_still_fit_into_a_scene_file(tmp_path):
    rng = random.Random(3)
    rows = [
        [1e4 * 1.005**i * (1 + 1e-4 * rng.random()), 1e-20 * 1.1**-i * rng.random()]
        for i in range(1200)
    ]
    scene = parse_scene(table_scene(f"psd = {rows}"))
    (tmp_path / "s.toml").write_text(scene.to_toml())
    assert load_scene(tmp_path / "s.toml") == scene
    face = with_counterface("").replace(
        "[sliding]", f'psd = {rows[:700]}\npsd_convention = "persson"\n[sliding]'
    )
    both = face.replace(
        face[face.index("rms_height") : face.index("[body]")],
        f'psd = {rows[:501]}\npsd_convention = "persson"\n',
    )
    assert "counterface.psd and surface.psd together have 1201 rows" in refusal(both)


def test_files_that_are_no_table_are_refused(tmp_path):
    (tmp_path / "s.toml").write_text(table_scene('psd_file = "psd.txt"'))
    with pytest.raises(
        SceneError, match=r"surface\.psd_file = \"psd\.txt\": the table .* does not exist"
    ):
        load_scene(tmp_path / "s.toml")
    for content, words in (
        ("1e4 3e-23\n1e5", 'line 2: "1e5" must be two numbers'),
        ("# q C\nq C\n\n1e4 3e-23\n1e5 x", 'line 5: "1e5 x" must be two numbers'),
        ("1e4 3e-23 5", 'line 1: "1e4 3e-23 5" must be two numbers'),
        ("# nothing", "surface.psd = 0 rows"),
    ):
        (tmp_path / "psd.txt").write_text(content)
        with pytest.raises(SceneError, match=words):
            load_scene(tmp_path / "s.toml")


def test_where_a_table_comes_from_is_kept_in_the_file_and_is_no_part_of_the_identity():
    text = table_scene("psd = [[1e4, 3e-23], [1e5, 7e-27]]")
    stated, scanned = (
        parse_scene(text),
        parse_scene(text.replace("psd_conv", 'psd_source = "scan"\npsd_conv')),
    )
    assert (stated.scanned, scanned.scanned) == (False, True)
    assert parse_scene(scanned.to_toml()).scanned
    assert stated.identity() == scanned.identity()
