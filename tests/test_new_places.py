"""The folders that `tribopipe new` makes get their names all at once, or none of them does."""

from pathlib import Path

import pytest
from test_new_many import export

from tribopipe.base import files
from tribopipe.base.errors import ManifestError
from tribopipe.readers.draft.folder import Wanted, make_planned, planned


def made_in(folder: Path, *names: str) -> list[str]:
    """Make a run of each name; return the names of what is in the folder then."""
    recording = folder.parent / "a.csv"
    recording.write_bytes(export(1))
    wanted = Wanted([recording], into=folder)
    plans = [plan for name in names for plan in planned(Wanted([recording], into=folder, id=name))]
    make_planned(plans, wanted, None, print)
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture
def refusals(monkeypatch) -> list[str]:
    """Names of folders that cannot be given, one for each time; without a wait."""
    left: list[str] = []

    def replace_unless_in_use(part: Path, path: Path) -> Path:
        if path.name in left:
            left.remove(path.name)
            raise PermissionError(13, "Permission denied", str(path))
        return replace(part, path)

    replace = Path.replace
    monkeypatch.setattr(Path, "replace", replace_unless_in_use)
    monkeypatch.setattr(files.time, "sleep", lambda _: None)
    return left


def test_on_windows_a_folder_waits_for_a_program_that_reads_in_it(tmp_path, monkeypatch, refusals):
    monkeypatch.setattr(files, "_IS_WINDOWS", True)
    refusals += ["one", "two", "two"]
    assert made_in(tmp_path / "runs", "one", "two") == ["one", "two"]
    assert refusals == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["one", "two", "three"])
def test_where_one_folder_gets_no_name_none_is_left(tmp_path, refusals, name):
    refusals += [name] * 20
    with pytest.raises(ManifestError, match=rf"{name}: cannot be created \(Permission denied\); expected a folder"):
        made_in(tmp_path / "runs", "one", "two", "three")
    assert list((tmp_path / "runs").iterdir()) == []


def test_where_a_place_was_taken_meanwhile_what_is_there_stays_alone(tmp_path, monkeypatch):
    replace = Path.replace

    def another_is_quicker(part: Path, path: Path) -> Path:
        (tmp_path / "runs" / "two").mkdir()
        return replace(part, path)

    monkeypatch.setattr(Path, "replace", another_is_quicker)
    with pytest.raises(ManifestError, match="two: found an existing folder"):
        made_in(tmp_path / "runs", "one", "two")
    assert [path.name for path in (tmp_path / "runs").iterdir()] == ["two"]
