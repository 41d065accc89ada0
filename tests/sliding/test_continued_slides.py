"""Slides that are followed over a part of their distance and continued by the theory: planned, computed, refused."""

from dataclasses import replace

import pytest
from matplotlib.text import Text
from slide_cases import sliding_scene

import roughsim as rs
from roughsim import prediction
from roughsim.charts.plot import plot_run
from roughsim.scene import SceneError

SLIDE = 1  # its level
WITHOUT = (
    '  { column = "sliding", shape = [32, 32], q_max = 2.5e4, first = 2 },\n',
    "",
)  # numerics without it


def continued_scene(distance, *changes):
    return sliding_scene(f'history = "sliding"\nslid_distance = "{distance}"', *changes)


def test_a_plan_follows_slides_once_around_their_cell():
    # the cell is 2 mm long; further than 16 times the theory does not continue them
    for distance, followed in (("2.9 mm", None), ("8 mm", 2e-3), ("48 mm", 3e-3)):
        assert rs.plan(continued_scene(distance, WITHOUT)).levels[-1].followed == followed
    asks = ("[theory]", "[observables]\ntemperature_distribution = true\n[theory]")
    assert rs.plan(continued_scene("8 mm", WITHOUT, asks)).levels[-1].followed is None
    lawless = ('nominal_pressure = "90 MPa"', 'nominal_pressure = "1 MPa"')
    assert rs.plan(continued_scene("8 mm", WITHOUT, lawless)).levels[-1].followed is None
    reason = next(
        r
        for r in rs.plan(continued_scene("8 mm", WITHOUT)).reasons
        if r.quantity == "slid distance"
    )
    assert reason.value == "2 mm"
    assert reason.text.endswith("; the theory continues it to 8 mm, within 2.5 %")


@pytest.fixture(scope="module")
def continued(tmp_path_factory):
    """A run whose slides are continued from 1 mm to 3 mm, and one that slides 1 mm."""
    folder = tmp_path_factory.mktemp("continued")
    scene = continued_scene("3 mm", ("first = 2 }", "first = 2, followed = 1e-3 }"))
    run = rs.run(scene, folder / "run", max_realizations=2)
    return run, rs.run(sliding_scene(), folder / "followed", max_realizations=2)


def test_a_run_multiplies_what_it_followed_by_the_theory(continued):
    run, followed = continued
    factors = prediction.sliding_continuation(run.scene, 1e-3)
    for name, factor in (
        ("flash_temperature", factors.flash_temperature),
        ("heat_partition", factors.heat_partition),
    ):
        short, whole = (one.estimate(name, "sliding") for one in (followed, run))
        assert whole.mean == pytest.approx(short.mean * factor, rel=1e-12)
        assert (whole.budget["slide"] / whole.mean > short.budget["slide"] / short.mean).all()
    before, after = (one.contact_temperature("sliding").mean for one in (followed, run))
    short = followed.estimate("flash_temperature", "sliding").mean
    expected = short * factors.flash_temperature + (before - short) * factors.background
    assert after == pytest.approx(expected, rel=1e-12)
    assert run.curves()["slid_distance"][-1] == pytest.approx(1e-3, rel=0.05)
    assert rs.open_run(run.folder).numerics.levels[-1].followed == 1e-3


@pytest.mark.slow
def test_chart_and_notes_state_how_far_slides_were_followed(continued, drawn):
    for one in continued:
        plot_run(one, "sliding")
    charts = [
        " ".join(" ".join(text.get_text() for text in figure.findobj(Text)).split())
        for figure in drawn
    ]
    assert "2 members, followed over 1 of 3 mm" in charts[0]
    assert "followed over" not in charts[1]  # where they ended nothing is added
    notes = [" ".join(rs.compare(one).table().notes) for one in continued]
    assert (
        "Slides are followed over 1 of 3 mm; the theory of sliding, calibrated multiplies"
        in notes[0]
    )
    assert "are followed over" not in notes[1]


POOR = (
    'like = "body"',
    "youngs_modulus = 2e11\npoisson_ratio = 0.3\ndensity = 7900\nheat_capacity = 500\n",
)
NEARLY_FLAT = (
    POOR[1]
    + 'conductivity = 30\nrms_height = "RMS um"\nhurst = 0.8\nq_min = 6350\nq_roll_off = 2e4\nq_max = 2e5\n'
)
REFUSED = {
    "further than was compared": (
        "16.1 mm",
        "1e-3",
        (),
        r"is less than 0\.001006 m, which is 1/16 of the slid dist",
    ),
    "under half of the cell": (
        "3 mm",
        "0.9e-3",
        (),
        r"is less than 0\.001 m, .* or 0\.5 of the side of the cell",
    ),
    "on a better conductor": (
        *("8 mm", "2e-3", (POOR[0], POOR[1] + "conductivity = 61")),
        r"conducts 2\.03 times as well as the moving one, over 2 times, .* leave out followed$",
    ),
    "on a flat face": (
        *("8 mm", "2e-3", (POOR[0], NEARLY_FLAT.replace("RMS", "0.19"))),
        r"over 95 % of C\(q\) is on the moving face, .* leave out followed$",
    ),
    "outside the law": (
        "8 mm",
        "2e-3",
        ('nominal_pressure = "90 MPa"', 'nominal_pressure = "1 MPa"'),
        "leave out",
    ),
    "with a distribution": (
        *("8 mm", "2e-3", ("[theory]", "[observables]\ntemperature_distribution = true\n[theory]")),
        "no theory continues the distribution of the temperature, which the scene asks for; leave out followed$",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_slides_that_the_theory_cannot_continue_are_refused_before_any_work(case, tmp_path):
    distance, followed, change, words = REFUSED[case]
    changes = [change] if change else []
    scene = continued_scene(
        distance, ("first = 2 }", f"first = 2, followed = {followed} }}"), *changes
    )
    with pytest.raises(ValueError, match=rf"^followed = .*{words}"):
        rs.plan(scene)
    numerics = replace(rs.plan(continued_scene("3 mm")), levels=scene.numerics.levels)
    with pytest.raises(ValueError, match=rf"^followed = .*{words}"):
        rs.run(scene, tmp_path / "run", numerics=numerics)
    assert not (tmp_path / "run").exists()


def test_slides_on_a_nearly_flat_face_are_planned_to_their_end():
    # of 0.9 µm on the moving face: the part 1/(1 + (0.22/0.9)²) = 0.944 is continued, 1/(1 + (0.19/0.9)²) = 0.957 not
    for rms, followed in (("0.22", 2e-3), ("0.19", None)):
        faces = POOR[0], NEARLY_FLAT.replace("RMS", rms)
        assert rs.plan(continued_scene("8 mm", WITHOUT, faces)).levels[-1].followed == followed


def test_slides_on_a_much_better_conductor_are_planned_to_their_end():
    for conductivity, followed in ((59, 2e-3), (61, None)):
        body = POOR[0], f"{POOR[1]}conductivity = {conductivity}"
        assert rs.plan(continued_scene("8 mm", WITHOUT, body)).levels[-1].followed == followed


def test_a_slide_that_is_followed_further_than_it_slides_is_not_continued():
    scene = continued_scene("3 mm", ("first = 2 }", "first = 2, followed = 5e-3 }"))
    reason = next(r for r in rs.plan(scene).reasons if r.quantity == "slid distance")
    assert (reason.value, "theory" in reason.text) == ("3 mm", False)


def test_too_short_a_distance_is_that_of_the_level():
    # half of the cell is 3 pixels
    level = '{ column = "sliding", shape = [32, 32], q_max = 2.5e4, first = 2 }'
    coarse = level.replace("[32, 32], q_max = 2.5e4", "[6, 6], q_max = 7e3").replace(
        " }", ", followed = 1e-3 }"
    )
    with pytest.raises(rs.ResolutionError, match=r"^followed = 0\.001 m is under 4 pixels of "):
        rs.plan(continued_scene("3 mm", (level, coarse)))


FEW = ("max_realizations = 4", "max_realizations = 1")


@pytest.mark.slow
def test_the_slides_of_a_study_are_followed_as_far_as_the_longest_needs(tmp_path):
    vary = {"sliding.slid_distance": ["2 mm", "8 mm", "48 mm"]}
    study = rs.study(
        continued_scene("8 mm", WITHOUT, FEW), vary=vary, folder=tmp_path / "study", progress=False
    )
    runs = [study.run(point) for point in study.points]
    assert [run.numerics.levels[-1].followed for run in runs] == [3e-3] * 3
    assert [len(run.members.sound(SLIDE)) for run in runs] == [1] * 3
    reason = next(r for r in runs[0].reasons if r.quantity == "slid distance")
    assert reason.value == "3 mm"
    # a later point slides too far for the distance that was planned
    vary["sliding.slid_distance"].append("60 mm")
    with pytest.raises(
        SceneError,
        match=r"^slid_distance=0\.06: followed = 0\.003 m is less than 0\.00375 m.*folder",
    ):
        rs.study(
            continued_scene("8 mm", WITHOUT, FEW),
            vary=vary,
            folder=tmp_path / "study",
            progress=False,
        )
    assert len(rs.open_study(tmp_path / "study").points) == 3


@pytest.mark.slow
def test_a_study_with_a_point_that_no_theory_continues_follows_all_slides_to_their_end(tmp_path):
    vary = {"sliding.nominal_pressure": ["1 MPa", "90 MPa", "100 MPa"]}
    study = rs.study(
        continued_scene("3 mm", WITHOUT, FEW), vary=vary, folder=tmp_path / "study", progress=False
    )
    for point in study.points:
        run = study.run(point)
        assert run.numerics.levels[-1].followed is None
        assert (run.estimate("flash_temperature", "sliding").mean > 0.0).all()
