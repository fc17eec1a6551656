import tempfile
from pathlib import Path

import pytest

from fd2fem.errors import InputError
from fd2fem.output import staged_file, staged_folder


def leftovers(folder):
    return sorted(path.name for path in folder.rglob("*"))


def test_new_folder_appears_whole(tmp_path):
    target = tmp_path / "deep" / "out"
    with staged_folder(target) as stage:
        (stage / "a.txt").write_text("a")
        (stage / "sub").mkdir()
        (stage / "sub" / "b.txt").write_text("b")
        assert not target.exists()
    assert leftovers(target) == ["a.txt", "b.txt", "sub"]
    assert leftovers(tmp_path) == ["a.txt", "b.txt", "deep", "out", "sub"]


def test_failure_leaves_nothing(tmp_path):
    with pytest.raises(RuntimeError), staged_folder(tmp_path / "new" / "out") as stage:
        (stage / "a.txt").write_text("half")
        raise RuntimeError
    assert leftovers(tmp_path) == []


def test_results_join_a_folder_that_holds_other_files(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    with staged_folder(tmp_path) as stage:
        (stage / "a.txt").write_text("a")
    assert leftovers(tmp_path) == ["a.txt", "notes.txt"]


def test_expected_clash_shows_before_the_work(tmp_path):
    (tmp_path / "facade.json").write_text("old")
    with (
        pytest.raises(InputError, match=r"facade.json exists; give another place, or --force"),
        staged_folder(tmp_path, expected=["facade.json"]),
    ):
        pytest.fail("the work was started")
    assert (tmp_path / "facade.json").read_text() == "old"


def test_unexpected_clash_keeps_the_old_result(tmp_path):
    (tmp_path / "a.txt").write_text("old")
    with pytest.raises(InputError, match="exists"), staged_folder(tmp_path) as stage:
        (stage / "a.txt").write_text("new")
        (stage / "b.txt").write_text("new")
    assert leftovers(tmp_path) == ["a.txt"]
    assert (tmp_path / "a.txt").read_text() == "old"


def test_identical_file_is_no_clash(tmp_path):
    (tmp_path / "a.txt").write_text("same")
    with staged_folder(tmp_path) as stage:
        (stage / "a.txt").write_text("same")
        (stage / "b.txt").write_text("new")
    assert leftovers(tmp_path) == ["a.txt", "b.txt"]


def test_results_of_an_earlier_run_do_not_stay_beside_new_ones(tmp_path):
    (tmp_path / "comparison.json").write_text("old verdict")
    (tmp_path / "notes.txt").write_text("mine")
    with staged_folder(tmp_path, stale=["comparison.json"], force=True) as stage:
        (stage / "facade.json").write_text("new")
    assert leftovers(tmp_path) == ["facade.json", "notes.txt"]


def test_link_to_another_file_system(tmp_path):
    with tempfile.TemporaryDirectory(dir="/dev/shm" if Path("/dev/shm").is_dir() else None) as elsewhere:
        link = tmp_path / "out"
        link.symlink_to(elsewhere, target_is_directory=True)
        with staged_folder(link) as stage:
            (stage / "a.txt").write_text("a")
        assert leftovers(Path(elsewhere)) == ["a.txt"]


def test_force_replaces(tmp_path):
    (tmp_path / "a.txt").write_text("old")
    with staged_folder(tmp_path, expected=["a.txt"], force=True) as stage:
        (stage / "a.txt").write_text("new")
    assert (tmp_path / "a.txt").read_text() == "new"


def test_file_in_the_way(tmp_path):
    (tmp_path / "out").write_text("a file")
    with pytest.raises(InputError, match="is a file; give a folder"), staged_folder(tmp_path / "out"):
        pytest.fail("the work was started")
    with (
        pytest.raises(InputError, match="is not a folder"),
        staged_folder(tmp_path / "out" / "deeper"),
    ):
        pytest.fail("the work was started")


def test_file_takes_its_name_at_the_end(tmp_path):
    target = tmp_path / "new" / "mesh.msh"
    with staged_file(target) as stage:
        assert stage.suffix == ".msh"
        stage.write_text("whole")
        assert not target.exists()
    assert target.read_text() == "whole"
    with pytest.raises(InputError, match="exists"), staged_file(target):
        pytest.fail("the work was started")
    with pytest.raises(InputError, match="is a folder"), staged_file(tmp_path):
        pytest.fail("the work was started")


def test_failed_file_leaves_nothing(tmp_path):
    with pytest.raises(RuntimeError), staged_file(tmp_path / "mesh.msh") as stage:
        stage.write_text("half")
        raise RuntimeError
    assert leftovers(tmp_path) == []
