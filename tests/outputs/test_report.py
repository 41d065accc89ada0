"""The report: one page that needs nothing else, says what the run says, and lets no text of a scene become HTML."""

import base64
import html
import re
import shutil
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from stored_cases import member_path, split_members

import roughsim as rs
from roughsim.cli import main
from roughsim.outputs import run_report as report
from roughsim.outputs.run_report import page
from roughsim.scene import parse_scene
from roughsim.show.markup import digits, html_table, text
from roughsim.show.table import Column, Number, Table

EMPTY = {"meta", "img", "br", "hr", "link", "input"}


class Reader(HTMLParser):
    """Collects elements, attributes and text, and sees that what is opened is closed."""

    def __init__(self, source):
        super().__init__()
        self.open, self.tags, self.attributes, self.said = [], [], [], []
        self.feed(source)
        self.close()
        assert self.open == []

    def handle_starttag(self, name, attributes):
        self.tags.append(name)
        self.attributes += [(name, key, value) for key, value in attributes]
        if name not in EMPTY:
            self.open.append(name)

    def handle_endtag(self, name):
        assert self.open.pop() == name

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("style", "title"):
            self.said.append(data)

    @property
    def words(self):
        return " ".join(" ".join(self.said).split())


HOSTILE = "<script>alert(1)</script>\"><img src=x onerror=alert(2)>&amp;' $body </title>"


@pytest.fixture(scope="module")
def kept_run(capped_scene, tmp_path_factory):
    """Three realizations, the fields of one kept."""
    scene = replace(
        capped_scene, title=HOSTILE, numerics=replace(capped_scene.numerics, keep_fields=1)
    )
    return rs.run(scene, tmp_path_factory.mktemp("report") / "kept", max_realizations=3)


@pytest.fixture(scope="module")
def written(kept_run, tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:  # each takes its time
        patch.setattr(report, "PICTURES", {"pressure": report.PICTURES["pressure"]})
        return rs.report(kept_run, tmp_path_factory.mktemp("page") / "new" / "report.html")


@pytest.fixture
def copy(kept_run, tmp_path):
    """A run of its own, to be spoilt."""
    return split_members(shutil.copytree(kept_run.folder, tmp_path / "copy"))


def test_the_page_needs_nothing_else(written):
    source = written.read_text()
    seen = Reader(source)
    assert not {"script", "link", "iframe", "object", "embed", "form", "base"} & set(seen.tags)
    for name, key, value in seen.attributes:
        assert not key.startswith("on")
        if key == "src":
            assert (name, value[:5]) == ("img", "data:")
        if key == "href":
            assert value.startswith("#")
    assert "url(" not in source
    assert "@import" not in source
    policy = next(
        value for _, key, value in seen.attributes if key == "content" and "default-src" in value
    )
    assert policy.startswith("default-src 'none'; img-src data:")


def images_of(source):
    return re.findall(r'src="data:([^;]+);base64,([^"]+)"', source)


@pytest.mark.slow
def test_all_pictures_are_drawn(kept_run):
    images = images_of(page(kept_run))
    assert [kind for kind, _ in images] == [
        "image/svg+xml",
        *["image/png"] * 3,
        *["image/svg+xml"] * 2,
    ]


@pytest.mark.slow
def test_the_page_of_a_run_that_slides_shows_its_slide_too(sliding_run, tmp_path):
    page = rs.report(sliding_run, tmp_path / "one.html").read_text()
    for caption in (
        "turnover of the contact over the slid distance",
        "at four slid distances of one member",
    ):
        assert page.count(f"{caption}.</figcaption>") == 1
    assert "Not shown" not in page


def test_each_picture_is_inside_the_page_and_needs_nothing_else_either(written):
    images = images_of(written.read_text())
    assert [kind for kind, _ in images] == ["image/svg+xml", "image/png"]
    for kind, content in images:
        data = base64.b64decode(content, validate=True)
        if kind == "image/png":
            assert data.startswith(b"\x89PNG")
        else:
            links = re.findall(rb'(?:href|src)="([^"]*)"', data)
            assert all(link.startswith((b"#", b"data:")) for link in links)
            assert b"<script" not in data


def test_links_lead_to_the_sections(written):
    seen = Reader(written.read_text())
    places = {value for _, key, value in seen.attributes if key == "id"}
    links = [value[1:] for _, key, value in seen.attributes if key == "href"]
    assert links == ["result", "pictures", "comparison", "errors", "plan", "scene", "provenance"]
    assert set(links) <= places


def two_digits(value, error, unknown):
    places = 1 - int(np.floor(np.log10(error)))
    return (" ± ≥" if unknown else " ± ").join(
        f"{round(x, places):.{max(places, 0)}f}" for x in (value, error)
    )


def test_the_page_says_what_the_run_says(kept_run, written):
    words = Reader(written.read_text()).words
    row = next(
        r
        for r in rs.compare(kept_run).rows
        if r.observable == "flash_temperature" and r.speed == 35.0
    )
    for cell in row.columns.values():
        assert two_digits(cell.mean, cell.total_error, cell.unknown) in words
    for ratio in row.ratios.values():
        assert f"= {two_digits(ratio.mean, ratio.total_error, ratio.unknown)}: tests" in words
    assert f"{row.theory:.4g}" in words
    estimate = kept_run.estimate("flash_temperature")
    for part in (*estimate.budget.values(), estimate.bias, estimate.total_error):
        said = html.unescape(digits(Number(abs(float(part[-1])), "K", digits=2)))
        assert re.search(rf"(^| |−){re.escape(said)}( |$)", words)
    width = kept_run.estimate("flash_width")
    for part in width.budget.values():
        said = html.unescape(digits(Number(float(part[-1]), "m", digits=2)))
        assert f" {said} " in words  # in µm
    total = Number(float(width.mean[-1]), "m", float(width.total_error[-1]), width.unknown_at(2))
    assert f" {html.unescape(digits(total))} " in words
    assert all(note in words for note in estimate.notes if not note.startswith("speeds"))
    assert "3 realizations" in words
    assert "0.9 into the moving body" in words


def test_the_scene_in_the_page_gives_the_run_again(kept_run, written):
    shown = re.findall(r"<pre>(.*?)</pre>", written.read_text(), re.DOTALL)
    scene = parse_scene(html.unescape(shown[0]))
    assert scene.identity() == kept_run.scene.identity()
    words = Reader(written.read_text()).words
    member = kept_run.members[2, 0].provenance
    assert f"seed {kept_run.seed}" in words
    for package, version in member["versions"].items():
        assert f"{package} {version}" in words


def test_the_plan_stands_with_its_reasons(kept_run, written):
    words = Reader(written.read_text()).words
    plan = rs.plan(kept_run.scene)
    assert kept_run.reasons == plan.reasons
    for reason in plan.reasons:
        assert " ".join(reason.text.split()) in words


@pytest.mark.usefixtures("no_pictures")
def test_numerics_that_no_plan_made_are_shown_without_reasons(quick, tmp_path):
    numerics = replace(rs.plan(quick), tolerance=1e-3, reasons=())
    words = Reader(
        page(rs.run(quick, tmp_path / "run", numerics=numerics, max_realizations=1))
    ).words
    assert "These numerics were given to the run without a plan" in words
    assert "tolerance 0.001" in words
    assert "32 × 32 to q_c = 4e+04 rad/m" in words


@pytest.mark.usefixtures("no_pictures")
def test_no_text_of_a_scene_becomes_html(quick, tmp_path):
    scene = replace(quick, title=HOSTILE)
    run = rs.run(scene, tmp_path / "<b>run", max_realizations=2)
    failed = replace(run.members[0, 1], failure="<i onload=x>stalled", moments=())
    run.members[0, 1] = failed
    run.damaged[0, 1] = "<u>file</u>"
    seen = Reader(page(run))
    assert not {"script", "i", "u", "b"} & set(seen.tags)
    assert all(key != "onerror" for _, key, _ in seen.attributes)
    assert " ".join(HOSTILE.split()) in seen.words


@pytest.mark.usefixtures("no_pictures")
def test_a_run_that_has_just_begun_has_a_page(copy):
    for path in sorted((copy / "members").glob("*-000002.h5")) + sorted(
        (copy / "members").glob("*-000001.h5")
    ):
        path.unlink()
    one = Reader(page(rs.open_run(copy))).words
    assert "There is nothing to compare yet" in one
    assert re.search(
        r"State when this was written: 1 realizations, .*; not being computed now", one
    )
    for path in (copy / "members").glob("*.h5"):
        path.unlink()
    none = Reader(page(rs.open_run(copy))).words
    assert re.search(
        r"State when this was written: 0 realizations, .*; not being computed now", none
    )
    assert "no sound realization" in none


@pytest.mark.usefixtures("no_pictures")
def test_a_run_of_which_one_column_has_members_yet_has_a_page(copy):
    for path in (copy / "members").glob("L0-*.h5"):
        path.unlink()
    run = rs.open_run(copy)
    assert run.realizations == 3
    assert "There is nothing to compare yet" in Reader(page(run)).words
    assert "<table" not in run._repr_html_()


@pytest.mark.usefixtures("no_pictures")
def test_a_damaged_file_is_named_and_the_others_are_shown(copy, kept_run):
    path = member_path(copy, 1, 1)
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(rs.RecordError, match="L1-000001.h5 is damaged"):
        rs.open_run(copy)
    run = rs.open_run(copy, damaged="skip")
    assert list(run.damaged) == ["L1-000001.h5"]
    assert (run.realizations, run.failed, run.members.sound(0)) == (
        3,
        0,
        [0, 2],
    )  # damaged is not "did not converge"
    words = Reader(page(run)).words
    assert "Damaged files, left out" in words
    assert "L1-000001.h5 is damaged" in words
    # level 1 and, on the same surfaces, level 0 lack the damaged one; the step to level 2 has surfaces of its own
    lowest = np.mean([kept_run.members[1, i].numbers["flash_temperature"][2] for i in (0, 2)])
    steps = [kept_run.members[2, i] for i in range(3)]
    fine, coarse = (
        np.mean([one.moments[below].numbers["flash_temperature"][2] for one in steps])
        for below in (0, 1)
    )
    estimate = run.estimate("flash_temperature")
    np.testing.assert_allclose(
        (estimate.mean + estimate.bias)[2], 0.9 * lowest * fine / coarse, rtol=1e-12
    )


def test_pictures_that_cannot_be_drawn_say_why(quick, tmp_path):
    scene = replace(quick, numerics=replace(quick.numerics, keep_fields=0))
    run = rs.run(scene, tmp_path / "none", max_realizations=2)
    shown = report.figures_section(run)
    assert shown.count("warning") == 1  # once, not for each picture
    assert "--keep-fields 1" in shown


@pytest.mark.slow
def test_the_command_line_writes_the_page(copy, tmp_path, capsys, no_pictures):
    def call(*words):
        with pytest.raises(SystemExit) as ended:
            main([*words])
        return ended.value.code, capsys.readouterr().err

    code, said = call("report", str(copy))
    *steps, last = said.splitlines()
    assert code == 0
    assert last == f"report: {copy}.html, {(tmp_path / 'copy.html').stat().st_size / 1e6:.3g} MB"
    assert steps[0] == f"roughsim: comparing {copy} with the theory"
    assert "roughsim: drawing pressure" in steps
    member_path(copy, 0, 2).write_bytes(b"")
    for verb in (["report", str(copy)], ["status", str(copy)]):
        code, said = call(*verb)
        assert code == 0
        assert re.search(r"left out: .*L0-000002.h5 is damaged", said)
    assert call("compare", str(copy))[0] == 1  # numbers are never made of a part of a run
    code, said = call("report", str(copy), "-o", str(tmp_path / "r.pdf"))
    assert code == 1
    assert "must end in .html" in said
    code, said = call("report", str(tmp_path))
    assert code == 1
    assert "is no run: it has no run.json" in said


NUMBERS = {
    (208.334,): "208.3", (138.0,): "138", (0.0,): "0", (-0.00061234, "1", 0.0, (), 3): "−0.000612",
    (120.0, "1", 0.0, (), 2): "120", (3.0381e7,): "3.038 × 10<sup>7</sup>", (12345.6,): "12350",
    (-2e-12,): "−2 × 10<sup>−12</sup>", (np.nan,): "–", (2.5e-5, "m"): "25",
    (208.334, "K", 0.384): "208.33 ± 0.38", (-13920.4, "1", 12.2): "−13920 ± 12", (np.inf, "1", 1): "–",
    (1.63283e-4, "1", 8.1e-7): "(1.6328 ± 0.0081) × 10<sup>−4</sup>", (0.0, "1", 0.5): "0.00 ± 0.50",
    (2.5, "1", np.inf): "2.5 ± unknown", (0.999984941, "1", 6.4e-9): "0.999985 ± 6.4 × 10<sup>−9</sup>",
    (-2.5e7, "1", 3e5): "(−2.500 ± 0.030) × 10<sup>7</sup>", (2.5, "1", 0.1, ("size",)): "2.50 ± ≥0.10",
}  # fmt: skip


@pytest.mark.parametrize(("number", "written"), NUMBERS.items())
def test_numbers_are_written_with_their_powers_of_ten(number, written):
    assert digits(Number(*number)) == written


def test_names_that_repeat_stand_above_their_rows():
    columns = [Column("what", name=True), Column("m/s", number=True), Column("note")]
    table = Table(
        columns,
        [("a <b>", "1", ""), ("a <b>", Number(2.0), "x"), ("c", "3", "")],
        notes=["± & more"],
    )
    page = html_table(table)
    Reader(page)
    assert re.findall(r"<th[^>]*>(.*?)</th>", page.replace("<thead", "<head")) == [
        "m/s",
        "note",
        "a &lt;b&gt;",
        "c",
    ]
    assert re.findall(r"<td[^>]*>(.*?)</td>", page) == ["1", "", "2", "x", "3", ""]
    assert '<p class="note">± &amp; more</p>' in page
    once = html_table(Table(columns, [("a", "1", ""), ("c", Number(3.0), "")]))
    cells = re.findall(r"<t[hd] [^>]*>(.*?)</t[hd]>", once)
    assert cells == ["what", "m/s", "note", "a", "1", "", "c", "3", ""]
    assert once.count('class="number"') == 3  # the title, and a cell in each row


def test_control_characters_do_not_reach_the_page():
    assert text("p ≤ q\n") == "p ≤ q\n"
    assert text("a\x1b[31m\x00b<") == "a?[31m?b&lt;"


@pytest.mark.slow
def test_a_study_is_a_page_with_its_table_and_charts(quick, tmp_path):
    scene = replace(
        quick, ensemble=replace(quick.ensemble, until={}, max_realizations=4), title="<b>steel</b>"
    )
    study = rs.study(
        scene, vary={"sliding.nominal_pressure": [1e8, 2e8]}, folder=tmp_path / "study"
    )
    page = rs.report(study)
    assert page == tmp_path / "study.html"
    text = page.read_text()
    assert "2 of 2 points finished" in text
    assert "&lt;b&gt;steel" in text
    assert "<b>steel" not in text
    assert text.count("<img") == 2
    with pytest.raises(ValueError, match=r"must end in \.html"):
        rs.report(study, tmp_path / "page.txt")
