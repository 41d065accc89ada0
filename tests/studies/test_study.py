"""A study: ordinary runs for a grid of values, with shared surfaces, one table, and paired trends."""

import csv
import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

import roughsim as rs
from roughsim import pipeline
from roughsim.errors import RecordError
from roughsim.scene import SceneError
from roughsim.show.table import Number
from roughsim.studies.folder import read, study_file, write
from roughsim.studies.study import paired_ratio
from roughsim.studies.tables import study_table, words_of

LOADS = [1e8, 1.2e8, 3e8]
VARY = {"sliding.nominal_pressure": LOADS, "sliding.friction_coefficient": [0.1, 0.2]}


@pytest.fixture(scope="module")
def small(capped_scene):
    levels = [
        {"column": "capped", "shape": [32, 32], "q_max": 3e4},
        {"column": "capped", "shape": [64, 64], "q_max": 6e4},
    ]
    numerics = replace(capped_scene.numerics, levels=levels, keep_fields=None)
    ensemble = replace(capped_scene.ensemble, until={"flash_temperature": 0.5}, max_realizations=16)
    return replace(capped_scene, numerics=numerics, ensemble=ensemble)


@pytest.fixture(scope="module")
def done(small, tmp_path_factory):
    """A finished study; tests only read it."""
    return rs.study(small, vary=VARY, folder=tmp_path_factory.mktemp("studies") / "loads")


def test_every_point_is_an_ordinary_run_with_the_bits_of_its_scene_alone(done, small, tmp_path):
    assert (done.finished, len(done.points)) == (6, 6)
    for point in (done.points[0], done.points[-1]):
        run = rs.open_run(done.folder / "points" / point.name)
        scene = small.with_("sliding.nominal_pressure", point.values["sliding.nominal_pressure"])
        scene = scene.with_("sliding.friction_coefficient", point.values["sliding.friction_coefficient"])
        alone = rs.run(scene, tmp_path / point.name, numerics=run.numerics)
        assert alone.scene.identity() == run.scene.identity()
        assert np.array_equal(alone.estimate("flash_temperature").mean, run.estimate("flash_temperature").mean)


def test_surfaces_are_drawn_and_contacts_solved_once_for_all_points_that_share_them(small, tmp_path, monkeypatch):
    drawn, solved = [], []
    draw, load = pipeline.synthesize, pipeline.loaded
    monkeypatch.setattr(pipeline, "synthesize", lambda *rest: drawn.append(1) or draw(*rest))
    monkeypatch.setattr(pipeline, "loaded", lambda *rest: solved.append(1) or load(*rest))
    study = rs.study(small, vary=VARY, folder=tmp_path / "study")
    members = [len(run.members) for _, run in study.results]
    assert set(members) == {24}  # 12 realizations at two levels
    assert len(drawn) == 24
    assert len(solved) == 24 * len(LOADS)  # points with another friction share them


def test_a_resumed_study_computes_only_what_is_missing_and_may_grow(small, done, tmp_path, monkeypatch):
    folder = tmp_path / "copy"
    shutil.copytree(done.folder, folder)
    lost = next(folder.glob("points/nominal_pressure=300000000,*0.2/realizations/L1-000003.h5"))
    content = lost.read_bytes()
    lost.unlink()
    solved, load = [], pipeline.loaded
    monkeypatch.setattr(pipeline, "loaded", lambda *rest: solved.append(1) or load(*rest))
    rs.study(small, vary=VARY, folder=folder)
    assert len(solved) == 1
    assert rs.open_study(folder).finished == 6
    assert len(lost.read_bytes()) == pytest.approx(len(content), abs=64)
    solved.clear()
    more = rs.study(small, vary=VARY | {"sliding.nominal_pressure": [*LOADS, 2e8]}, folder=folder)
    assert (more.finished, len(more.points)) == (8, 8)
    assert len(solved) == 24
    same = {run.numerics.levels for _, run in more.results}
    assert len(same) == 1


def test_the_folder_of_another_scene_or_of_something_else_is_refused(small, done, tmp_path):
    with pytest.raises(RecordError, match="study of another scene: surface.hurst is"):
        rs.study(small.with_("surface.hurst", 0.7), vary=VARY, folder=done.folder)
    with pytest.raises(RecordError, match="holds a study with target_error = None, here it is 0.05"):
        rs.study(small, vary=VARY, folder=done.folder, target_error="5 %")
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(RecordError, match="holds other files"):
        rs.study(small, vary=VARY, folder=tmp_path)
    with pytest.raises(RecordError, match="is a file"):
        rs.study(small, vary=VARY, folder=tmp_path / "notes.txt")
    with pytest.raises(RecordError, match=r"is no study: it has no study\.json"):
        rs.open_study(tmp_path)


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        ({"sliding.nominal_pressure": [1e8, 5e9]}, r"nominal_pressure=5e\+09.*exceeds body.penetration_hardness"),
        ({"sliding.nominal_presure": [1e8]}, "did you mean"),
        (
            {"body.melting_temperature": [1500.0, 1800.0]},
            "are the same scene: no number of a member depends on what differs",
        ),
    ],
)
def test_a_point_that_cannot_be_is_refused_before_any_work(small, tmp_path, vary, message):
    with pytest.raises(SceneError, match=message):
        rs.study(small, vary=vary, folder=tmp_path / "study")
    assert not (tmp_path / "study").exists()


@pytest.mark.parametrize("target", [0.0, 1.5, "2 m", True])
def test_a_target_that_cannot_be_is_refused(small, tmp_path, target):
    with pytest.raises(ValueError, match="target_error"):
        rs.study(small, vary=VARY, folder=tmp_path / "study", target_error=target)
    assert not (tmp_path / "study").exists()


def test_the_tidy_table_has_the_estimates_of_the_runs(done):
    rows = list(done.rows())
    for point, run in done.results:
        e = run.estimate("flash_temperature")
        mine = [r for r in rows if r["point"] == point.name and r["observable"] == "flash_temperature"]
        capped = {r["speed"]: (r["value"], r["total_error"]) for r in mine if r["column"] == "capped"}
        for k, speed in enumerate(run.scene.speeds):
            if speed:
                assert capped[speed] == (e.mean[k], e.total_error[k])
        theory = [r for r in mine if r["column"] == "theory"]
        assert all(np.isnan(r["total_error"]) for r in theory)
        assert mine[0]["friction_coefficient"] == point.values["sliding.friction_coefficient"]
        assert mine[0]["nominal_pressure"] == point.values["sliding.nominal_pressure"]


def test_flash_temperature_is_exactly_proportional_to_friction(done):
    trends = [t for t in done.trends() if t["key"] == "friction_coefficient" and t["speed"]]
    assert len(trends) == len(LOADS) * sum(speed > 0.0 for speed in done.scene.speeds)
    for trend in trends:
        assert trend["ratio"] == pytest.approx(2.0, rel=1e-12)
        assert trend["exponent"] == pytest.approx(1.0, rel=1e-12)
        assert trend["standard_error"] < 1e-12


def test_flash_temperature_is_exactly_proportional_to_the_share_of_the_heat(quick, tmp_path):
    scene = replace(quick, ensemble=replace(quick.ensemble, until={}, max_realizations=4))
    study = rs.study(scene, vary={"sliding.heat_partition": [0.25, 0.5]}, folder=tmp_path / "study")
    trends = list(study.trends())
    assert trends
    assert [trend["ratio"] for trend in trends] == pytest.approx([2.0] * len(trends), rel=1e-12)


def test_a_trend_is_known_better_than_its_points_for_they_see_the_same_surfaces(done):
    trends = [t for t in done.trends() if t["key"] == "nominal_pressure" and t["speed"] == 35.0]
    assert len(trends) == 4
    trends = [trend for trend in trends if trend["to"] == 1.2e8]
    by_name = {point.name: run for point, run in done.results}
    for trend in trends:
        each = [by_name[trend[end]].estimate("flash_temperature") for end in ("point", "before")]
        k = each[0].mean.size - 1
        relative = [e.standard_error[k] / e.mean[k] for e in each]
        assert trend["standard_error"] / trend["ratio"] < 0.7 * np.hypot(*relative)
        assert trend["ratio"] == pytest.approx(each[0].mean[k] / each[1].mean[k], rel=0.02)
        assert trend["exponent"] == pytest.approx(np.log(trend["ratio"]) / np.log(trend["to"] / trend["from"]))


def test_runs_with_other_surfaces_make_no_pairs(done, small, tmp_path):
    run = next(run for _, run in done.results)
    other = rs.run(replace(small, ensemble=replace(small.ensemble, seed=5)), tmp_path / "other")
    with pytest.raises(ValueError, match="their rows are no pairs"):
        paired_ratio(run, other, "flash_temperature")
    with pytest.raises(ValueError, match="observable = 'heat' is unknown"):
        paired_ratio(run, run, "heat")


def test_the_paired_error_of_a_ratio_is_that_of_the_jackknife(quick, tmp_path):
    # the ratio anew without each realization in turn; one level: nothing is fitted in q_c
    scene = replace(quick, ensemble=replace(quick.ensemble, until={}, max_realizations=60))
    study = rs.study(scene, vary={"sliding.nominal_pressure": [1e8, 2e8]}, folder=tmp_path / "study")
    runs = [run for _, run in study.results]
    ratio, rows = paired_ratio(*runs, "contact_fraction"), runs[0].sound(runs[0].realizations)
    without = []
    for left_out in rows:
        for run in runs:
            run.sound = lambda count, left_out=left_out: [row for row in rows if row != left_out]
        without.append(paired_ratio(*runs, "contact_fraction").mean[0])
    n = len(rows)
    jackknife = np.sqrt((n - 1) / n * np.sum((np.array(without) - np.mean(without)) ** 2))
    assert ratio.standard_error[0] == pytest.approx(jackknife, rel=0.15)


def test_files_of_a_study_hold_the_same_numbers(done, tmp_path):
    rows = list(done.rows())
    with done.save(tmp_path / "t.csv").open() as file:
        read = list(csv.DictReader(file))
    assert [float(r["value"]) for r in read] == [r["value"] for r in rows]
    stored = json.loads(done.save(tmp_path / "t.json").read_text())
    finite = [r["value"] if np.isfinite(r["value"]) else None for r in rows]
    assert [r["value"] for r in stored["rows"]] == finite
    assert stored["finished"] == 6
    import h5py

    with h5py.File(done.save(tmp_path / "t.h5")) as file:
        assert list(file["nominal_pressure"]) == LOADS
        assert file["flash_temperature"].shape == (3, 2, file["column"].size, file["speed"].size)
        names = [file["flash_temperature"].dims[k][0].name for k in range(4)]
        assert names == ["/nominal_pressure", "/friction_coefficient", "/column", "/speed"]
        columns = [name.decode() for name in file["column"][()]]
        value = file["flash_temperature"][2, 1, columns.index("capped"), -1]
        error = file["flash_temperature_total_error"][2, 1, columns.index("capped"), -1]
    e = done.results[-1][1].estimate("flash_temperature")
    assert (value, error) == (e.mean[-1], e.total_error[-1])
    with pytest.raises(ValueError, match="must end in .csv"):
        done.save(tmp_path / "t.txt")


def test_a_study_opens_in_xarray_with_the_varied_keys_as_coordinates(done, tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    dataset = done.to_xarray()
    one = dataset.flash_temperature.sel(nominal_pressure=1e8, friction_coefficient=0.2, column="capped")
    run = done.run(next(p for p in done.points if p.values == dict(zip(VARY, (1e8, 0.2), strict=True))))
    assert np.array_equal(one, run.estimate("flash_temperature").mean)
    with xarray.open_dataset(done.save(tmp_path / "s.nc"), engine="h5netcdf") as stored:
        assert stored.flash_temperature.equals(dataset.flash_temperature)
        assert stored.nominal_pressure.attrs["units"] == "Pa"


def test_a_study_is_a_data_frame_where_pandas_is_there(done, tmp_path):
    pandas = pytest.importorskip("pandas")
    frame = done.to_dataframe()
    assert isinstance(frame, pandas.DataFrame)
    assert len(frame) == len(list(done.rows()))


def test_the_table_for_people_has_a_row_for_each_point_in_readable_units(done):
    table = study_table(done)
    assert [row[0] for row in table.rows] == ["100", "100", "120", "120", "300", "300"]
    assert table.columns[0].title == "nominal pressure, MPa"
    assert isinstance(table.rows[0][-3], Number)
    assert "6 of 6 points finished." in table.notes
    assert "6 of 6 points finished." in str(done)
    assert "<table" in done._repr_html_()
    assert words_of("surface.hurst") == ("hurst", 1.0)
    assert words_of("surface.rms_height") == ("rms height, µm", 1e6)


def test_the_table_says_how_many_points_are_within_the_total_error_asked_for(quick, tmp_path):
    scene = replace(quick, ensemble=replace(quick.ensemble, max_realizations=24))
    study = rs.study(scene, vary={"sliding.nominal_pressure": [1e8, 4e8]}, folder=tmp_path / "study", target_error=0.04)
    worst = {}
    for point, run in study.results:
        estimate = run.estimate("flash_temperature")
        hot = estimate.mean > 0.0
        worst[point.name] = (estimate.total_error[hot] / estimate.mean[hot]).max()
    within = sum(error <= 0.04 for error in worst.values())
    (note,) = (note for note in study_table(study).notes if note.startswith("Total error"))
    assert f"{within} points" in note
    assert f"{100 * max(worst.values()):.3g} %" in note


@pytest.mark.parametrize("observable", ["flash_temperature", "contact_fraction"])
def test_a_study_is_drawn(done, tmp_path, observable):
    done.chart(tmp_path / "s.svg", observable)
    text = (tmp_path / "s.svg").read_text()
    assert "nominal pressure, MPa" in text
    with pytest.raises(ValueError, match="observable = 'heat' is unknown"):
        done.chart(tmp_path / "s.svg", "heat")


@pytest.fixture(scope="module")
def odd(small, tmp_path_factory):
    """A study over a number, words that name an observable, too, and a number that leaves no pairs."""
    vary = {"sliding.nominal_pressure": [1e8, 3e8], "sliding.heat_partition": ["mean", "all"], "ensemble.seed": [1, 2]}
    return rs.study(small, vary=vary, folder=tmp_path_factory.mktemp("studies") / "odd")


def test_a_varied_key_and_an_observable_of_one_name_are_two_things_in_a_file(odd, tmp_path):
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(odd.save(tmp_path / "odd.h5"), engine="h5netcdf") as data:
        assert data["sliding_heat_partition"].values.tolist() == ["mean", "all"]
        share = data["heat_partition"].sel(column="theory", speed=0.0)
        assert np.allclose(share.values, 0.5, rtol=1e-12)  # at rest, of like bodies


def test_points_of_another_seed_have_no_trend_and_the_others_have_theirs(odd):
    assert {trend["key"] for trend in odd.trends()} == {"nominal_pressure"}
    assert "∂ln/∂ln" in str(odd)


def test_a_chart_holds_the_keys_that_it_does_not_show_and_its_title_names_them(odd, tmp_path, monkeypatch):
    drawn = {}
    monkeypatch.setattr(
        "roughsim.charts.study.study_chart", lambda rows, keys, *rest, title: drawn.update(rows=rows, title=title)
    )
    odd.chart(tmp_path / "chart.png")
    assert {row["sliding_heat_partition"] for row in drawn["rows"]} == {"mean"}
    assert {row["seed"] for row in drawn["rows"]} == {1, 2}
    assert drawn["title"].endswith("; heat partition mean")


def test_a_chart_over_load_and_speed_has_all_speeds(small, tmp_path):
    vary = {"sliding.nominal_pressure": [1e8, 2e8, 3e8], "sliding.speed": [1.0, 10.0, 35.0]}
    study = rs.study(small, vary=vary, folder=tmp_path / "study")
    study.chart(tmp_path / "chart.svg")
    text = (tmp_path / "chart.svg").read_text()
    assert all(f">{speed}<" in text for speed in (1, 10, 35))  # the legend


def test_speeds_may_be_varied_one_by_one(small, tmp_path):
    study = rs.study(small, vary={"sliding.speed": [1.0, 35.0]}, folder=tmp_path / "speeds")
    value = study.to_dict()["rows"]
    assert {(row["sliding_speed"], row["speed"]) for row in value if row["speed"]} == {(1.0, 1.0), (35.0, 35.0)}
    assert study.common_speeds() is None
    assert list(study.trends()) == []  # the contacts are one, but the theory of trends needs the same speeds
    study.save(tmp_path / "s.h5")


def test_a_study_file_names_a_scene_beside_it(tmp_path, small):
    (tmp_path / "my.toml").write_text(small.to_toml())
    (tmp_path / "study.toml").write_text('scene = "my.toml"\n[vary]\n"sliding.nominal_pressure" = ["1 MPa"]\n')
    content = study_file(tmp_path / "study.toml")
    assert content["scene"] == tmp_path / "my.toml"
    (tmp_path / "study.toml").write_text('scene = "demo"\ntarget_error = "2 %"\n[vary]\n"sliding.speed" = [1.0]\n')
    assert study_file(tmp_path / "study.toml")["scene"] == "demo"


def test_the_keys_of_a_study_file_need_no_quotes(tmp_path):
    text = 'scene = "demo"\n[vary]\nsliding.speed = [1.0]\nbody.density = { linspace = [1, 2, 3] }\n"title" = ["a"]\n'
    (tmp_path / "study.toml").write_text(text)
    vary = study_file(tmp_path / "study.toml")["vary"]
    assert vary == {"sliding.speed": [1.0], "body.density": {"linspace": [1, 2, 3]}, "title": ["a"]}


def test_a_scene_whose_name_no_file_can_have_is_refused_as_any_other(tmp_path):
    (tmp_path / "study.toml").write_text(f'scene = "{"a" * 5000}"\n[vary]\n"sliding.speed" = [1.0]\n')
    content = study_file(tmp_path / "study.toml")
    with pytest.raises(SceneError, match="is not bundled"):
        rs.study(content["scene"], vary=content["vary"], folder=tmp_path / "study")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('scene = "demo"\n', "vary is missing"),
        ("[vary]\n", "scene is missing"),
        ('scene = 3\n[vary]\n"sliding.speed" = [1.0]\n', "scene must be the name"),
        ('scenes = "demo"\n', "scenes is not a key of a study"),
        ('title = "mine"\n', "title is not a key of a study"),
        ("scene = \n", "not valid TOML"),
    ],
)
def test_a_study_file_that_cannot_be_used_is_refused_in_one_line(tmp_path, text, message):
    (tmp_path / "study.toml").write_text(text)
    with pytest.raises(SceneError, match=message) as refused:
        study_file(tmp_path / "study.toml")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "content",
    ["", "{}", "[]", '{"format_version": 9}', '{"format_version": 1e400}', '{"format_version": 1, "axes": 3}'],
)
def test_a_damaged_description_is_refused(done, tmp_path, content):
    shutil.copy(done.folder / "scene.toml", tmp_path)
    (tmp_path / "study.json").write_text(content)
    with pytest.raises(RecordError, match="study.json"):
        rs.open_study(tmp_path)


def test_a_foreign_description_leads_to_no_other_folder(done, tmp_path):
    shutil.copy(done.folder / "scene.toml", tmp_path)
    content = json.loads((done.folder / "study.json").read_text())
    content["axes"][0] = {"keys": ["../../x"], "values": [[1]]}
    (tmp_path / "study.json").write_text(json.dumps(content))
    with pytest.raises(RecordError, match="cannot be the name of a folder"):
        rs.open_study(tmp_path)


def test_a_foreign_description_of_too_many_points_is_refused_at_once(done, tmp_path):
    shutil.copy(done.folder / "scene.toml", tmp_path)
    content = json.loads((done.folder / "study.json").read_text())
    many = [{"keys": [f"sliding.a{i}"], "values": [[j] for j in range(100)]} for i in range(8)]
    for axes in (many, [], [{"keys": ["sliding.speed"], "values": [[1, 2]]}]):
        (tmp_path / "study.json").write_text(json.dumps(content | {"axes": axes}))
        with pytest.raises(RecordError, match="is damaged"):
            rs.open_study(tmp_path)


def test_a_study_killed_before_its_description_was_written_begins_again(done, tmp_path):
    (tmp_path / "points").mkdir()
    description = read(done.folder)
    write(tmp_path, description)
    assert read(tmp_path) == description
    (tmp_path / "study.json").unlink()
    (tmp_path / "points" / "mine").mkdir()
    with pytest.raises(RecordError, match="holds other files"):
        write(tmp_path, description)
