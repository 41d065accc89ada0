"""Each file of a member is read once, and what is read is what was written, however members come."""

import os
import random
import shutil
import sys
from dataclasses import replace

import numpy as np
import pytest
from some_rows import some
from stored_cases import member_path, read_file, read_member, split_members, write_member
from summary_cases import COUNT, bits

import roughsim as rs


def test_a_comparison_opens_the_file_of_each_member_once(folder):
    opened, watching = [], [True]

    def watched(event, arguments):
        if event == "open" and str(arguments[0]).endswith(".h5") and watching:
            opened.append(os.path.basename(arguments[0]))

    sys.addaudithook(watched)  # sees what NumPy opens too
    rs.compare(rs.open_run(folder)).to_dict()
    watching.clear()
    names = sorted(path.name for path in (folder / "members").iterdir())
    assert sorted(name for name in opened if name in names) == names


def test_samples_are_those_of_the_files(folder):
    run = rs.open_run(folder)
    for sample in run.samples():
        files = [read_member(folder, sample.level, index) for index in sample.rows]
        np.testing.assert_array_equal(sample.spectrum, [one.moments[0].spectrum for one in files])
        for name in ("flash_temperature", "contact_fraction"):
            np.testing.assert_array_equal(
                sample.numbers[name], [one.numbers[name] for one in files]
            )
            if sample.below is not None:
                np.testing.assert_array_equal(
                    sample.below.numbers[name], [one.moments[1].numbers[name] for one in files]
                )


@pytest.mark.parametrize("seed", some(range(3)))
def test_rounds_are_the_same_in_whatever_order_members_come(whole, tmp_path, seed):
    run = rs.run(whole.scene, tmp_path / "run", numerics=whole.numerics, max_realizations=1)
    run.max_realizations = COUNT
    paths = sorted((whole.folder / "members").iterdir())
    random.Random(seed).shuffle(paths)
    seen = []
    for path in paths:
        shutil.copy(path, run.folder / "members")
        run.refresh()
        seen.append(run.counts)
    assert seen == sorted(seen)  # no round is taken back
    assert (run.rounds, bits(run)) == (whole.rounds, bits(whole))
    assert run.finished


def test_members_beyond_a_gap_or_a_round_do_not_count(folder, whole):
    one = read_member(folder, 1, 0)
    write_member(folder, replace(one, index=whole.counts[1]))  # computed ahead
    run = rs.open_run(folder)
    assert run.members.available[1] == whole.counts[1] + 1
    assert (run.counts, bits(run)) == (whole.counts, bits(whole))
    member_path(folder, 0, 4).unlink()
    run = rs.open_run(folder)
    assert run.counts == (4, 6)  # what is there of the first round
    assert (0, 5) in run.members
    assert (run.members.available[0], run.counts) == (4, (4, 6))


def test_fewer_members_of_each_level_can_count(folder):
    whole = rs.open_run(folder)
    whole.count((5, 3))
    assert [len(sample.rows) for sample in whole.samples()] == [5, 3]
    values = whole.values("contact_fraction")
    assert len(values.influence[0]) == 5
    assert np.isfinite(values.value).all()


def test_a_run_none_of_whose_contacts_converge_has_ended(folder):
    for path in (folder / "members").glob("L0-*"):
        write_member(folder, replace(read_file(path), failure="stalled", moments=()))
    run = rs.open_run(folder)
    assert (run.finished, run.target_met, run.failed) == (True, False, COUNT)
    assert "no contact of its lowest level has converged" in run.rounds.verdict.why
    with pytest.raises(ValueError, match="no sound realization yet"):
        run.estimate("flash_temperature")


def test_members_that_did_not_converge_are_left_out_and_counted(folder):
    for level, index in ((0, 3), (1, 0), (1, 5)):
        one = read_member(folder, level, index)
        write_member(folder, replace(one, failure=f"stalled at {index}", moments=()))
    run = rs.open_run(folder)
    assert run.failed == 3
    run.count((9, 6))
    assert [sample.rows.tolist() for sample in run.samples()] == [
        [0, 1, 2, 4, 5, 6, 7, 8],
        [1, 2, 3, 4],
    ]
    assert run.members[0, 3].failure == "stalled at 3"


def test_a_failed_member_that_does_not_count_leaves_its_surface_to_the_other_column(capped_run):
    run = rs.open_run(capped_run.folder)
    smoothed, capped = (run.numerics.of_column(column)[0] for column in ("smoothed", "capped"))
    counts = run.counts
    last = counts[smoothed] - 1
    run.members[smoothed, last] = replace(
        run.members[smoothed, last], failure="not converged", moments=()
    )
    assert last not in run.members.sound(capped)
    run.members.counts = tuple(
        last if level == smoothed else count for level, count in enumerate(counts)
    )
    assert run.members.sound(capped) == [*range(counts[capped])]


@pytest.mark.slow
def test_the_last_member_of_a_round_counts_with_those_of_later_rounds(folder, whole):
    longer = rs.run(whole.scene, folder, max_realizations=30)
    split_members(folder)
    path = member_path(folder, 0, 4)
    content = path.read_bytes()
    path.unlink()
    run = rs.open_run(folder)
    assert not run.finished
    path.write_bytes(content)
    run.refresh()
    assert (run.rounds, bits(run)) == (longer.rounds, bits(longer))
    assert run.rounds.number > 0
