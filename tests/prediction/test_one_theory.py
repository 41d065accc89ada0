"""One theory: table, chart, page, `theory` and the JSON say the same number, and a cell changes it little."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from soft_scene import RUBBER

import roughsim as rs
from roughsim import prediction
from roughsim.charts import curves as chart
from roughsim.comparison.tables import theory_dict
from roughsim.estimate import cell_size
from roughsim.outputs import run_report as report
from roughsim.scene import parse_scene
from roughsim.show.markup import digits, html_table
from roughsim.show.table import Number
from roughsim.surface.spectrum import TruncatedSpectrum

# two faces with different C(q), 2 µm rough, and a load so light that contact is lost within the first waves
TWO_FACES = """
title = "two faces"
[surface]
rms_height = "2 um"
hurst = 0.8
q_min = 6350
q_roll_off = 9.4e4
q_max = 4.15e7
roll_off_exponent = 1.5
[body]
youngs_modulus = "200 GPa"
poisson_ratio = 0.3
penetration_hardness = "1.2 GPa"
conductivity = 30
density = 7900
heat_capacity = 500
[counterface]
rms_height = "0.5 um"
hurst = 0.6
q_min = 2e4
q_roll_off = 2e5
q_max = 4.15e7
youngs_modulus = "200 GPa"
poisson_ratio = 0.3
conductivity = 30
density = 7900
heat_capacity = 500
[sliding]
nominal_pressure = "10 MPa"
friction_coefficient = 0.11
speed = [0.01, 35]
heat_partition = 0.938
[theory]
gamma = 0.294
"""
TOYS = {
    "demo": (
        {"column": "smoothed", "shape": [32, 32], "q_max": 2.4e4},
        {"column": "capped", "shape": [32, 32], "q_max": 2.4e4},
    ),
    "rubber": ({"column": "elastic", "shape": [32, 32], "q_max": 1.9e3},),
    "two faces": (
        {"column": "smoothed", "shape": [64, 64], "q_max": 4.7e4},
        {"column": "capped", "shape": [64, 64], "q_max": 4.7e4},
    ),
}


def scene_of(name):
    if name == "two faces":
        return parse_scene(TWO_FACES)
    return rs.load_scene(RUBBER if name == "rubber" else name)


@pytest.fixture(
    scope="module",
    params=[pytest.param(n, marks=[pytest.mark.slow] if n == "two faces" else []) for n in TOYS],
)
def compared(request, tmp_path_factory):
    scene = scene_of(request.param)
    side = 8 * np.pi / scene.spectrum.breaks[0]
    numerics = replace(
        scene.numerics, levels=TOYS[request.param], lengths=scene.numerics.lengths or (side, side)
    )
    toy = replace(
        scene, numerics=numerics, ensemble=replace(scene.ensemble, until={}, max_realizations=2)
    )
    return rs.compare(rs.run(toy, tmp_path_factory.mktemp("toys") / "run"))


def test_table_chart_page_and_theory_say_the_same_number(compared, no_pictures):
    scene = compared.run.scene
    said = theory_dict(scene)["flash_temperature"]
    rows = [row for row in compared.rows if row.observable == "flash_temperature"]
    assert [row.theory for row in rows] == said
    whole = [
        x["theory"] for x in compared.to_dict()["rows"] if x["observable"] == "flash_temperature"
    ]
    assert whole == said
    table = compared.table()
    (theory,) = (
        table.cells(k) for k, column in enumerate(table.columns) if column.title == "theory"
    )
    assert theory[: len(said)] == [f"{value:.4g}" for value in said]
    assert f'class="value">{digits(Number(said[-1]))}<small> K' in report.answer(compared)
    assert f">{digits(Number(said[0]))}</td>" in html_table(table)
    axes = Figure().subplots()
    entry = chart.Entry("run", compared.run.scene, compared.run, compared.results)
    chart.draw_over_speed(axes, entry, "flash_temperature")
    speed, line = axes.get_lines()[0].get_data()
    np.testing.assert_allclose([line[list(speed).index(v)] for v in scene.speeds], said, rtol=1e-12)
    bands = [line.half_width for line in axes.get_lines() if hasattr(line, "half_width")]
    for column, half in zip(compared.run.numerics.columns, bands, strict=True):
        np.testing.assert_array_equal(
            half, compared.run.estimate("flash_temperature", column).total_error
        )


def test_the_ratio_is_to_the_theory_of_the_same_modes_and_a_note_says_so(compared):
    run = compared.run
    column = run.numerics.columns[0]
    row = [row for row in compared.rows if row.observable == "flash_temperature"][-1]
    ratio = row.ratios[f"{column}_over_theory"]
    measured = np.mean(
        [run.members[0, i].numbers["flash_temperature"][-1] for i in (0, 1)]
    )  # all heat in the body
    assert ratio.mean == pytest.approx(
        measured * run.heat_partition[-1] / row.theories["theory_same_modes"], rel=1e-12
    )
    table = compared.table()
    assert f"{column}_over_theory" in [column.title for column in table.columns]
    assert any("The ratio to theory is over the modes of the cell" in note for note in table.notes)


def test_a_value_that_the_run_cannot_continue_to_q_max_is_marked_at_q_c(compared):
    unknown = {
        row.note
        for row in compared.rows
        if any("bandwidth" in x.unknown for x in row.columns.values())
    }
    assert unknown <= {"at q_c", "identity"}
    if compared.run.scene.elastic:
        assert unknown == {"at q_c"}
        known = [
            row.note
            for row in compared.rows
            if not any("bandwidth" in x.unknown for x in row.columns.values())
        ]
        assert set(known) == {""}


@pytest.mark.parametrize(
    "name",
    [
        "two faces",
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in ("demo", "steel-1.2GPa", "granite")
        ),
    ],
)
def test_the_sum_over_the_modes_of_a_planned_cell_is_the_integral(name):
    scene = scene_of(name)
    lengths, _ = cell_size.choose_lengths(scene, 0.01)
    q_c = 90 * 2 * np.pi / lengths[0]
    spectrum = TruncatedSpectrum(prediction.smoothed_spectrum(scene), q_c)
    summed = prediction.mode_sums(scene, spectrum, rs.Grid((180, 180), lengths))
    integral = prediction.predictions(scene, spectrum.breaks[-1])
    for observable in ("flash_temperature", "pressure_variance"):
        np.testing.assert_allclose(summed[observable], integral[observable], rtol=0.006)
