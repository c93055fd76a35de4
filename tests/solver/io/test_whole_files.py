"""Files come whole, together, in their order, or not at all; what was there before stays."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from solver.errors import JobError
from solver.io import whole_files
from solver.io.file_checks import check_file
from solver.io.mesh_files import MeshData, write_mesh
from solver.io.whole_files import Outbox, remove_stale, write_bytes

ROOT = Path(__file__).parents[3]
TRIANGLE = MeshData(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), [np.array([0, 1, 2])])


def texts(folder: Path) -> dict[str, str]:
    return {file.name: file.read_text() for file in folder.iterdir() if file.is_file()}


@pytest.fixture
def old(tmp_path) -> Path:
    (tmp_path / "shell.obj").write_text("old\n")
    (tmp_path / "report.json").write_text("old\n")
    return tmp_path


def test_files_come_together_and_nothing_is_left_over(old):
    with Outbox(seal=old / "report.json") as outbox:
        outbox.write(old / "report.json", b"new\n")
        outbox.write(old / "shell.obj", b"new\n")
        outbox.write(old / "sub" / "more.obj", b"new\n")
        assert texts(old) == {"shell.obj": "old\n", "report.json": "old\n"}
        assert outbox.send()[-1] == old / "report.json"
    assert texts(old) == {"shell.obj": "new\n", "report.json": "new\n"}
    assert texts(old / "sub") == {"more.obj": "new\n"}
    assert not list(old.rglob(".*"))


def test_an_error_before_sending_changes_nothing(old):
    with pytest.raises(ZeroDivisionError), Outbox() as outbox:
        outbox.write(old / "shell.obj", b"new\n")
        raise ZeroDivisionError
    assert texts(old) == {"shell.obj": "old\n", "report.json": "old\n"} and not list(old.rglob(".*"))


def test_half_a_file_is_not_moved(old):
    with pytest.raises(JobError, match=r"shell\.obj cannot be written: only a part"), Outbox() as outbox:
        outbox.write(old / "report.json", b"new\n")
        outbox.at(old / "shell.obj").write_bytes(b"v 0 0 0\nv 1 0")
        outbox.send()
    assert texts(old) == {"shell.obj": "old\n", "report.json": "old\n"}


def test_a_move_that_fails_brings_the_earlier_files_back(old, monkeypatch):
    real = os.replace

    def failing(source, target):
        if Path(target).name == "report.json" and "before-" not in str(source):
            raise OSError(28, "No space left on device", str(target))
        real(source, target)

    monkeypatch.setattr(whole_files.os, "replace", failing)
    with pytest.raises(JobError, match=r"report\.json cannot be written: No space"), Outbox() as outbox:
        outbox.seal = old / "report.json"
        for name in ("report.json", "a.obj", "shell.obj"):
            outbox.write(old / name, b"new\n")
        outbox.send()
    assert texts(old) == {"shell.obj": "old\n", "report.json": "old\n"}


def test_a_report_is_never_beside_other_files(old, monkeypatch):
    """Not even for a moment: the old report goes first, the new one comes last."""
    seen, real = [], os.replace
    monkeypatch.setattr(whole_files.os, "replace", lambda a, b: (real(a, b), seen.append(texts(old)))[0])
    with Outbox(seal=old / "report.json") as outbox:
        for name in ("report.json", "a.obj", "shell.obj"):
            outbox.write(old / name, b"new\n")
        outbox.remove(old / "gone.obj")
        outbox.send()
    assert ["report.json" in names for names in seen] == [False, False, True]


def test_a_folder_of_that_name(tmp_path):
    (tmp_path / "a.obj").mkdir()
    with pytest.raises(JobError, match=r"a\.obj cannot be written: it is a folder"):
        write_bytes(tmp_path / "a.obj", b"v\n")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="This system has no pipes in folders.")
def test_a_pipe_of_that_name_stays(tmp_path):
    os.mkfifo(tmp_path / "a.obj")
    with pytest.raises(JobError, match=r"a\.obj cannot be written: it is a device or a pipe, no file"):
        write_bytes(tmp_path / "a.obj", b"v\n")
    assert (tmp_path / "a.obj").is_fifo()


@pytest.fixture
def linked(old) -> Path:
    """A folder of links: to another folder, by way of another link, and to a file that is not there yet."""
    folder = old / "links"
    folder.mkdir()
    (folder / "shell.obj").symlink_to("../shell.obj")
    (folder / "report.json").symlink_to("next.json")
    (folder / "next.json").symlink_to(old / "report.json")
    (folder / "new.obj").symlink_to("../away/new.obj")
    return folder


def test_links_stay_and_their_files_are_replaced(linked):
    names = ("shell.obj", "new.obj", "report.json")
    with Outbox(seal=linked / "report.json") as outbox:
        for name in names:
            outbox.write(linked / name, b"new\n")
        assert set(outbox.send()) == {linked / name for name in names}
    assert all((linked / name).is_symlink() for name in names)
    assert texts(linked.parent) == {"shell.obj": "new\n", "report.json": "new\n"}
    assert texts(linked.parent / "away") == {"new.obj": "new\n"} and not list(linked.parent.rglob(".*"))


def test_a_move_that_fails_brings_files_behind_links_back(linked, monkeypatch):
    real = os.replace

    def replace(source, target):
        if Path(target).name == "report.json" and "before" not in Path(source).name:
            raise OSError(28, "No space left on device")
        real(source, target)

    monkeypatch.setattr(os, "replace", replace)
    with pytest.raises(JobError, match="No space left"), Outbox(seal=linked / "report.json") as outbox:
        for name in ("shell.obj", "new.obj", "report.json"):
            outbox.write(linked / name, b"new\n")
        outbox.send()
    assert texts(linked.parent) == {"shell.obj": "old\n", "report.json": "old\n"}
    assert texts(linked.parent / "away") == {} and (linked / "report.json").is_symlink()


def test_links_in_a_circle_and_two_links_to_one_file_are_named(old):
    (old / "a.obj").symlink_to("b.obj")
    (old / "b.obj").symlink_to("a.obj")
    with pytest.raises(JobError, match=r"a\.obj cannot be written: it is a link that leads to itself"):
        write_bytes(old / "a.obj", b"new\n")
    (old / "one.obj").symlink_to("shell.obj")
    with pytest.raises(JobError, match=r"one\.obj and .*shell\.obj are one file"), Outbox() as outbox:
        outbox.write(old / "one.obj", b"1\n")
        outbox.write(old / "shell.obj", b"2\n")
        outbox.send()
    assert (old / "shell.obj").read_text() == "old\n"


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".stl", ".glb"])
def test_what_is_written_passes_and_a_part_of_it_does_not(tmp_path, suffix):
    file = tmp_path / f"mesh{suffix}"
    write_mesh(file, TRIANGLE)
    check_file(file)
    data = file.read_bytes()
    file.write_bytes(data[: len(data) // 2] if suffix != ".ply" else data[:20])
    with pytest.raises(JobError, match="only a part"):
        check_file(file)


@pytest.mark.skipif(whole_files.fcntl is None, reason="folders are locked on POSIX only")
def test_what_a_killed_process_left_goes_and_what_is_in_use_stays(tmp_path):
    code = (
        "import os; from pathlib import Path; from solver.io.whole_files import Outbox\n"
        f"Outbox().at(Path({str(tmp_path)!r}) / 'a.obj'); os.kill(os.getpid(), 9)"
    )
    subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": str(ROOT)}, check=False)
    assert len(list(tmp_path.glob(".export-*"))) == 1
    with Outbox() as outbox:
        mine = outbox.at(tmp_path / "b.obj").parent
        remove_stale([tmp_path])
        assert list(tmp_path.glob(".export-*")) == [mine]
