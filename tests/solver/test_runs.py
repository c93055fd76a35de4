"""Runs over several jobs: resume, processes, JSON, log, progress, Ctrl-C, readers that leave, errors of the program."""

from __future__ import annotations

import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from solver import __main__ as command
from solver.__main__ import main
from solver.jobs import console, job
from solver.jobs.console import Console
from solver.jobs.outcomes import Outcome
from solver.version import PROGRAM

ROOT = Path(__file__).parents[2]
JOB = "[shape]\nkind = 'disc'\nn = {n}\n[default]\ntilt = 20\n[output]\nf_plus = '{name}.obj'\nreport = '{name}.json'\n"


@pytest.fixture
def jobs(tmp_path, monkeypatch) -> list[str]:
    """Three jobs in the current folder."""
    monkeypatch.chdir(tmp_path)
    for number, name in enumerate("abc"):
        Path(f"{name}.toml").write_text(JOB.format(n=100 + number, name=name))
    return ["a.toml", "b.toml", "c.toml"]


def call(*arguments: str, **options) -> subprocess.Popen[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True} | options
    return subprocess.Popen([sys.executable, "-m", "solver", *arguments], env=environment, **pipes)


def made(report: str) -> dict:
    return json.loads(Path(report).read_text())["made"]


def test_a_report_says_where_it_comes_from(jobs):
    Path("plan.obj").write_text((ROOT / "assets/jobs/canopy.obj").read_text())
    Path("m.toml").write_text("mesh = 'plan.obj'\n[[conditions]]\nloop = 0\ntilt = 30\n[output]\nreport = 'm.json'\n")
    assert main(["m.toml"]) == 0
    table = made("m.json")
    assert table["program"] == PROGRAM and table["numpy"] and table["scipy"] and "blender" not in table
    assert list(table["input"]) == ["plan.obj"] and len(table["input"]["plan.obj"]) == 64
    assert table["settings"]["mesh"] == "plan.obj" and table["conditions"] == [{"loop": 0, "tilt": 30}]
    assert abs(time.time() - time.mktime(time.strptime(table["time"], "%Y-%m-%dT%H:%M:%SZ")) + time.timezone) < 60
    assert 0 < table["seconds"] < 60 and table["code"] == 0 and table["files"] == {}


def test_resume_does_the_rest_only(jobs, capsys):
    assert main(["a.toml", "b.toml"]) == 0
    before = {name: Path(name).stat().st_mtime_ns for name in ("a.obj", "a.json", "b.obj")}
    Path("b.obj").write_text("v 0 0 0\n")  # not as it was written
    capsys.readouterr()
    assert main([*jobs, "--resume"]) == 0
    shown = capsys.readouterr().out
    assert "a.toml: done before, skipped." in shown and "b.toml:\n" in shown and "c.toml:\n" in shown
    assert Path("a.obj").stat().st_mtime_ns == before["a.obj"] and Path("a.json").stat().st_mtime_ns == before["a.json"]
    assert Path("b.obj").stat().st_size > 1000


def test_resume_removes_what_was_left_beside_jobs_that_are_done(jobs):
    """A run killed between its last move and its end leaves an empty scratch folder."""
    assert main(jobs) == 0
    Path(".export-left").mkdir()
    assert main([*jobs, "--resume"]) == 0
    assert not Path(".export-left").exists()


@pytest.mark.parametrize("change", ["settings", "files", "version", "mesh"])
def test_what_has_changed_is_done_again(jobs, capsys, change, monkeypatch):
    Path("p.obj").write_text((ROOT / "assets/jobs/canopy.obj").read_text())
    text = "mesh = 'p.obj'\n[[conditions]]\nloop = 0\ntilt = 30\n[output]\nf_plus = 's.obj'\nreport = 'r.json'\n"
    Path("p.toml").write_text(text)
    assert main(["p.toml"]) == 0 and main(["p.toml", "--resume"]) == 0
    assert "skipped" in capsys.readouterr().out
    if change == "settings":
        Path("p.toml").write_text(text.replace("30", "31"))
    elif change == "files":
        Path("s.obj").unlink()
    elif change == "version":
        monkeypatch.setattr("solver.jobs.provenance.PROGRAM", "cmc-formfinding 99")
    else:
        Path("p.obj").write_text(Path("p.obj").read_text() + "# moved\n")
    assert main(["p.toml", "--resume"]) == 0
    assert "skipped" not in capsys.readouterr().out


def test_a_shell_that_is_not_as_asked_keeps_its_code(jobs, capsys):
    Path("a.toml").write_text(JOB.format(n=100, name="a") + "[solver]\ndegree = 3\n")
    assert main(["a.toml"]) == 1
    assert main(["a.toml", "--resume"]) == 1
    assert "done before, skipped; its shell is not as asked, see its report." in capsys.readouterr().out
    assert made("a.json")["code"] == 1


def test_processes_do_the_same(jobs, capsys):
    Path("bad.toml").write_text("[shape]\nkind = 'dsc'\n")
    assert main([*jobs, "bad.toml", "--jobs", "2"]) == 2
    shown = capsys.readouterr()
    assert all(f"{name}.toml:\nDone." in shown.out and Path(f"{name}.obj").exists() for name in "abc")
    assert 'there is no shape "dsc"' in shown.err and "4 of 4" in shown.err


def test_a_process_that_dies_takes_one_job_with_it(jobs, capsys, monkeypatch, tmp_path):
    """The memory of one job may be too much for the machine."""
    site = tmp_path / "site"
    site.mkdir()
    (site / "sitecustomize.py").write_text(
        "import os, pathlib\nread = pathlib.Path.read_bytes\n"
        "def dying(self):\n    if self.name == 'b.toml': os._exit(9)\n    return read(self)\n"
        "pathlib.Path.read_bytes = dying\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(site))
    assert main([*jobs, "--jobs", "2", "--log", "log.txt"]) == 1
    shown = capsys.readouterr()
    assert "b.toml: The process that worked on it ended without a word (exit code 9)" in shown.err
    assert Path("a.obj").exists() and Path("c.obj").exists() and "b.toml: exit code 1" in Path("log.txt").read_text()


def test_json_is_a_line_for_each_plan(jobs, capsys):
    Path("bad.toml").write_text("x = 1")
    assert main([*jobs, "bad.toml", "--json"]) == 2
    shown = capsys.readouterr()
    lines = [json.loads(line) for line in shown.out.splitlines()]
    assert [(line["input"], line["code"], line["formed"]) for line in lines] == [
        ("a.toml", 0, True), ("b.toml", 0, True), ("c.toml", 0, True), ("bad.toml", 2, False),
    ]  # fmt: skip
    assert lines[0]["files"] == {"f+": "a.obj", "report": "a.json"} and "bad.toml" in lines[3]["message"]


def test_progress_and_blocks_with_names(jobs, capsys):
    assert main(jobs) == 0
    shown = capsys.readouterr()
    assert [line for line in shown.err.splitlines() if " of 3" in line][-1] == "3 of 3"
    assert ", 0:" in shown.err and "1 of 3" in shown.err
    assert shown.out.index("a.toml:\n") < shown.out.index("b.toml:\n")
    assert main(["-q", *jobs]) == 0
    assert capsys.readouterr().out == ""


def test_the_time_that_is_left(monkeypatch):
    err = io.StringIO()
    monkeypatch.setattr(console.sys, "stderr", err)
    shown = Console(2, out=io.StringIO(), _started=console.time.monotonic() - 100.0)
    shown.show(Outcome("hall.blend", "A", formed=True, of=80))
    assert err.getvalue() == "1 of 81, 2:13:20 left\n"


def test_two_jobs_that_write_one_file_are_named(jobs, capsys):
    Path("b.toml").write_text(Path("a.toml").read_text().replace("a.json", "b.json"))
    assert main(["a.toml", "b.toml"]) == 1
    assert "b.toml: a.obj was written by a.toml, too, in this run" in capsys.readouterr().err


def test_an_error_of_the_program_is_a_sentence_and_the_next_job_runs(jobs, capsys, monkeypatch):
    real = job.form

    def broken(plan, settings, **options):
        if len(plan.positions) < 60:
            raise ZeroDivisionError("of a length")
        return real(plan, settings, **options)

    monkeypatch.setattr(job, "form", broken)
    Path("a.toml").write_text(JOB.format(n=30, name="a"))
    assert main(["a.toml", "b.toml", "--log", "log.txt"]) == 1
    error = capsys.readouterr().err
    assert "a.toml: An error of the program itself (ZeroDivisionError: of a length); please report it" in error
    assert "Traceback (" not in error and "Traceback (" in Path("log.txt").read_text() and Path("b.obj").exists()
    assert main(["a.toml"]) == 1
    assert "the traceback is in cmc.log" in capsys.readouterr().err and "in broken" in Path("cmc.log").read_text()


def test_ctrl_c_ends_the_whole_run(jobs, capsys, monkeypatch):
    monkeypatch.setattr(command, "run_job", lambda *_, **__: os.kill(os.getpid(), signal.SIGINT))
    assert main(jobs) == 130
    assert capsys.readouterr().err == (
        "cmc: Interrupted; what was finished is written, nothing is half written.\n"
    )
    assert not list(Path().glob(".*")) and not Path("a.obj").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize("delay", [0.8, 3.0])
@pytest.mark.parametrize("processes", ["1", "2"])
def test_ctrl_c_at_any_moment(jobs, delay, processes):
    """While importing, loading, solving: one sentence, exit code 130, no half file."""
    for number in range(30):
        Path(f"j{number}.toml").write_text(JOB.format(n=4000, name=f"j{number}"))
    process = call(*[f"j{number}.toml" for number in range(30)], "-q", "--jobs", processes)
    time.sleep(delay)
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=60)
    assert process.returncode == 130, error
    told = [line for line in error.splitlines() if "Interrupted" in line]
    assert len(told) == 1 and "Traceback" not in error
    assert not list(Path().glob(".export-*"))
    assert all(file.with_suffix(".obj").exists() for file in Path().glob("j*.json"))


@pytest.mark.parametrize("arguments", [["--help"], ["a.toml", "b.toml"], ["a.toml", "--json"]])
def test_a_reader_that_leaves(jobs, arguments):
    process = call(*arguments)
    assert process.stdout is not None
    process.stdout.close()
    _, error = process.communicate(timeout=60)
    assert "Traceback" not in error and "BrokenPipe" not in error and process.returncode == 0
    if "a.toml" in arguments:
        assert Path("a.obj").exists()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="This system has no /dev/full.")
@pytest.mark.parametrize("arguments", [["a.toml"], ["a.toml", "b.toml", "--json"], ["a.toml", "b.toml", "--jobs", "2"]])
def test_an_output_on_a_full_disk(jobs, arguments):
    with open("/dev/full", "w") as full:
        process = call(*arguments, stdout=full)
        _, error = process.communicate(timeout=60)
    assert process.returncode == 1 and "Traceback" not in error and Path("a.obj").exists()
    assert error.count("The output cannot be written: No space left on device.") == 1


@pytest.mark.parametrize("log", ["b.toml", "./a.toml", "plan.obj", "new.blend", "a.json"])
def test_a_log_is_no_file_of_another_kind(jobs, capsys, log):
    before = Path("b.toml").read_text()
    assert main(["a.toml", "b.toml", "--log", log]) == 2
    assert f"The log {Path(log)} would go into a file of another kind" in capsys.readouterr().err
    assert Path("b.toml").read_text() == before and not Path("a.obj").exists()


def test_a_log_is_no_folder(jobs, capsys):
    assert main(["a.toml", "--log", "."]) == 2
    assert "The log . is a folder; name a file in it." in capsys.readouterr().err and not Path("a.obj").exists()


def test_a_log_that_cannot_be_written_is_a_fault(jobs, capsys):
    assert main(["a.toml", "--log", "a.toml/log.txt"]) == 1
    assert "the log cannot be written" in capsys.readouterr().err and Path("a.obj").exists()


def test_a_killed_run_leaves_nothing_half_and_is_resumed(jobs):
    for number in range(30):
        Path(f"j{number:02}.toml").write_text(JOB.format(n=600, name=f"j{number:02}"))
    names = [f"j{number:02}.toml" for number in range(30)]
    process = call(*names, "-q", stderr=subprocess.DEVNULL)
    while not Path("j03.json").exists():
        time.sleep(0.02)
    process.kill()
    process.communicate()
    finished = {name: Path(name).stat().st_mtime_ns for name in sorted(p.name for p in Path().glob("j*.json"))}
    assert 4 <= len(finished) < 30
    assert main([*names, "-q", "--resume"]) == 0
    assert all(Path(name).stat().st_mtime_ns == when for name, when in finished.items())
    assert len(list(Path().glob("j*.obj"))) == 30 and not list(Path().glob(".export-*"))


def test_bad_numbers_of_processes(capsys):
    for text in ("0", "-1", "many", "1000"):
        with pytest.raises(SystemExit):
            main(["a.toml", "--jobs", text])
        assert "from 1 to 256" in capsys.readouterr().err or text == "-1"
