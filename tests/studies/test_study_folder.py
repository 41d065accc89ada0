"""The folder of a study: one study alone begins there, its points are where they belong, and damage is no dead end."""

import json
import os
import random
import shutil
import time
from contextlib import nullcontext
from dataclasses import replace
from multiprocessing import get_context

import pytest
from some_rows import some
from stored_cases import member_path, split_members
from study_cases import VARY, description_of

import roughsim as rs
from roughsim.cli import main
from roughsim.errors import RecordError
from roughsim.outputs.opened import opened
from roughsim.scene import parse_scene
from roughsim.store.claims import Claims
from roughsim.studies import folder as study_folder
from roughsim.studies import work
from roughsim.studies.folder import read, write

TRIES = 30
TWO = {"sliding.nominal_pressure": VARY["sliding.nominal_pressure"][:2]}


@pytest.fixture(scope="module")
def two_points(small, tmp_path_factory):
    return rs.study(small, vary=TWO, folder=tmp_path_factory.mktemp("studies") / "two")


@pytest.fixture
def copy(done, tmp_path):
    """A copy of the finished study, to be changed."""
    return shutil.copytree(done.folder, tmp_path / "copy")


def numbers(study):
    """The results, in their order."""
    return [
        (row["point"], row["observable"], row["column"], row["speed"], row["value"])
        for row in study.rows()
    ]


def exchange(first, second):
    """Give two folders the names of each other."""
    aside = first.with_name("aside")
    first.rename(aside)
    second.rename(first)
    aside.rename(second)


@pytest.mark.parametrize(
    "reader", ["rows", "str", "save", "chart", "report", "page", "status", "study"]
)
def test_every_reader_refuses_a_study_of_which_two_folders_were_exchanged(
    copy, small, tmp_path, reader
):
    points = copy / "points"
    exchange(
        *(
            points / f"nominal_pressure={load},friction_coefficient=0.1"
            for load in (100000000, 300000000)
        )
    )

    def page():
        pytest.importorskip("bokeh")
        from roughsim.explore.server import page_of

        page_of(copy)(__import__("bokeh.document").document.Document())

    def report():
        rs.report(rs.open_study(copy), tmp_path / "s.html")

    readers = {
        "rows": lambda: list(rs.open_study(copy).rows()),
        "str": lambda: str(rs.open_study(copy)),
        "save": lambda: rs.open_study(copy).save(tmp_path / "s.csv"),
        "chart": lambda: rs.open_study(copy).chart(tmp_path / "s.png"),
        "report": report,
        "page": page,
        "status": lambda: opened(copy).to_dict(),
        "study": lambda: rs.study(small, vary=VARY, folder=copy),
    }
    words = r"sliding.nominal_pressure is 300000000.0 there, not 100000000.0; give each folder in points/ its own name"
    with pytest.raises(RecordError, match=words):
        readers[reader]()


@pytest.mark.slow
def test_the_status_of_a_study_names_the_processes_that_compute_it(copy, done, soon):
    assert "being computed" not in str(rs.status(done))
    (point, *_) = copy.glob("points/*")
    member_path(split_members(point), 0, 11).unlink()
    assert str(rs.status(copy)).endswith("\nnot being computed now; repeat its command to go on")
    with Claims(copy):
        assert f"\nbeing computed by process {os.getpid()} on " in str(rs.status(copy))


def test_a_point_folder_of_another_base_scene_is_refused(copy, quick, tmp_path):
    place = copy / "points" / read(copy).points[0].name
    shutil.rmtree(place)
    rs.run(quick.with_("surface.hurst", 0.7), place, max_realizations=2, until={})
    with pytest.raises(RecordError, match="does not hold the scene of its point"):
        list(rs.open_study(copy).rows())


def begin_again_and_again(folder, scene, barrier):
    """Begin a study in one new folder after another, at the same time as another process; the last half slowly."""
    chance = random.Random(scene)

    def slowed(function):
        def wait_and_do(*rest, **words):
            time.sleep(chance.choice([0.0, 0.0, 0.002, 0.01]))
            return function(*rest, **words)

        return wait_and_do

    description = description_of(parse_scene(scene))
    for k in range(TRIES):
        if k == TRIES // 2:
            for name in ("link", "mkdir", "replace", "open"):
                setattr(os, name, slowed(getattr(os, name)))
        barrier.wait()
        try:
            write(folder / str(k), description)
            answer = ""
        except RecordError as error:
            answer = str(error)
        (folder / f"{k}-{description.scene.surface.hurst}").write_text(answer)


@pytest.mark.slow
def test_of_two_different_studies_begun_at_once_one_has_the_folder_and_the_other_is_refused(
    small, tmp_path
):
    spawn = get_context("spawn")
    barrier = spawn.Barrier(2)
    scenes = {hurst: small.with_("surface.hurst", hurst) for hurst in (0.75, 0.8)}
    processes = [
        spawn.Process(target=begin_again_and_again, args=(tmp_path, scene.to_toml(), barrier))
        for scene in scenes.values()
    ]
    for process in processes:
        process.start()
    try:
        for process in processes:
            process.join()
    finally:
        for process in processes:
            process.kill()
    for k in range(TRIES):
        answers = {hurst: (tmp_path / f"{k}-{hurst}").read_text() for hurst in scenes}
        (winner,) = (hurst for hurst, answer in answers.items() if not answer)
        (refusal,) = (answer for answer in answers.values() if answer)
        assert "holds a study of another scene: surface.hurst is" in refusal
        assert read(tmp_path / str(k)).scene.identity() == scenes[winner].identity()
        written = parse_scene((tmp_path / str(k) / "scene.toml").read_text())
        assert written.identity() == scenes[winner].identity()


def test_a_study_that_waited_for_the_plan_of_another_one_is_refused(small, tmp_path, monkeypatch):
    other = description_of(small.with_("surface.hurst", 0.7))
    plan = work.planning_alone

    def planning_after_the_other(folder):
        write(folder, other)
        return plan(folder)

    monkeypatch.setattr(work, "planning_alone", planning_after_the_other)
    with pytest.raises(
        RecordError, match=r"holds a study of another scene: surface.hurst is 0.7 there"
    ):
        rs.study(small, vary=VARY, folder=tmp_path / "study")
    assert read(tmp_path / "study").scene.surface.hurst == 0.7
    assert not any((tmp_path / "study" / "points").iterdir())


def test_a_study_whose_plan_is_refused_leaves_nothing_and_runs_there_once_it_is_mended(
    small, tmp_path, monkeypatch
):
    plan, planned = work.numerics_of, []

    def refuse_the_second(scene):
        planned.append(scene)
        if len(planned) == 2:
            raise ValueError("this level cannot be")
        return plan(scene)

    monkeypatch.setattr(work, "numerics_of", refuse_the_second)
    scene = replace(small, ensemble=replace(small.ensemble, until={}, max_realizations=2))
    vary = {"surface.hurst": [0.7, 0.8]}  # two plans
    with pytest.raises(ValueError, match="this level cannot be"):
        rs.study(scene, vary=vary, folder=tmp_path / "study")
    assert not (tmp_path / "study").exists()
    mended = scene.with_("sliding.nominal_pressure", "0.11 GPa")
    assert rs.study(mended, vary=vary, folder=tmp_path / "study").finished == 2


def test_a_refused_plan_leaves_an_older_folder_as_it_was(small, tmp_path, monkeypatch):
    monkeypatch.setattr(work, "numerics_of", lambda *_: (_ for _ in ()).throw(ValueError("no")))
    (tmp_path / "study").mkdir()
    with pytest.raises(ValueError, match="no"):
        rs.study(small, vary=VARY, folder=tmp_path / "study")
    assert not any((tmp_path / "study").iterdir())


@pytest.mark.parametrize(
    "damage",
    some(["cut", "lost", "no json", "scene cut", "no scene", "scene lost", "both lost"]),
)
def test_a_study_with_damaged_or_lost_files_goes_on_with_all_that_is_computed(
    two_points, tmp_path, small, damage
):
    copy = shutil.copytree(two_points.folder, tmp_path / "copy")
    description, scene = copy / "study.json", copy / "scene.toml"
    content, before = json.loads(description.read_text()), description.read_bytes()
    {
        "cut": lambda: description.write_bytes(before[: len(before) // 2]),
        "lost": description.unlink,
        "no json": lambda: description.write_bytes(b"\xff\x00"),
        "no scene": lambda: description.write_text(
            json.dumps({k: v for k, v in content.items() if k != "scene"})
        ),
        "scene cut": lambda: scene.write_bytes(scene.read_bytes()[:50]),
        "scene lost": scene.unlink,
        "both lost": lambda: (description.unlink(), scene.unlink()),
    }[damage]()
    moved = {
        "cut": "study.json",
        "no json": "study.json",
        "no scene": "study.json",
        "scene cut": "scene.toml",
    }
    times = {path: path.stat().st_mtime_ns for path in copy.glob("points/*/members.h5")}
    assert len(times) == len(two_points.points)
    name = moved.get(damage)
    says = (
        pytest.warns(RuntimeWarning, match=f"{name} was damaged: it was moved to .*damaged")
        if name
        else nullcontext()
    )
    with says:
        again = rs.study(small, vary=TWO, folder=copy)
    assert numbers(again) == numbers(two_points)
    assert {
        path: path.stat().st_mtime_ns for path in times
    } == times  # no member was computed again
    assert description.read_bytes() == before
    assert parse_scene(scene.read_text()).identity() == small.identity()
    assert [path.name for path in copy.glob("damaged/*")] == ([name] if name else [])


@pytest.mark.parametrize("damage", ["cut", "lost"])
def test_readers_say_how_a_damaged_or_lost_description_is_written_anew(copy, damage):
    path = copy / "study.json"
    path.write_text("{") if damage == "cut" else path.unlink()
    with pytest.raises(
        RecordError, match="study.json is .*give the study again.*roughsim study STUDY -o"
    ):
        opened(copy)


def test_a_lost_description_is_not_written_anew_from_a_study_that_the_points_do_not_fit(
    copy, small
):
    (copy / "study.json").unlink()
    with pytest.raises(RecordError, match="does not hold the scene of its point"):
        rs.study(small.with_("surface.hurst", 0.7), vary=VARY, folder=copy)
    with pytest.raises(
        RecordError, match="holds other files than points of this study.*give the study as it was"
    ):
        rs.study(small, vary={"sliding.nominal_pressure": [5e7]}, folder=copy)
    assert not (copy / "study.json").exists()


def test_a_description_of_a_newer_version_is_never_moved_aside(copy, small):
    content = json.loads((copy / "study.json").read_text())
    (copy / "study.json").write_text(
        json.dumps(content | {"format_version": study_folder.FORMAT + 1})
    )
    with pytest.raises(RecordError, match="has format version 3; this roughsim reads 2: update it"):
        rs.study(small, vary=VARY, folder=copy)
    assert (copy / "study.json").exists()
    assert not (copy / "damaged").exists()


def test_a_study_of_an_older_format_is_no_damaged_one(copy, small):
    path = copy / "study.json"
    content = json.loads(path.read_text())
    older = {key: content[key] for key in ("target_error", "axes", "scene")} | {"format_version": 1}
    path.write_text(json.dumps(older))
    words = r"study.json has the older format 1, and this roughsim reads \d+; read or export it with the roughsim that"
    for call in (lambda: opened(copy), lambda: rs.study(small, vary=VARY, folder=copy)):
        with pytest.raises(RecordError, match=words):
            call()
    assert json.loads(path.read_text()) == older
    assert not (copy / "damaged").exists()


def test_the_command_reads_the_scene_before_it_plans(tmp_path, capsys):
    (tmp_path / "study.toml").write_text('scene = "none.toml"\n[vary]\n"sliding.speed" = [1, 2]\n')
    with pytest.raises(SystemExit) as ended:
        main(["study", str(tmp_path / "study.toml"), "-o", str(tmp_path / "out")])
    assert ended.value.code == 1
    said = capsys.readouterr().err
    assert said.startswith("roughsim: scene file none.toml does not exist")  # and no line on a plan
    assert not (tmp_path / "out").exists()
