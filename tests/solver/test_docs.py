"""docs/ and README are true: examples run, jobs load, every key is described, links and commands lead somewhere."""

from __future__ import annotations

import inspect
import re
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from solver.domain.sites import SITES
from solver.errors import Status
from solver.gauss.conditions import KINDS
from solver.gauss.energies import ENERGIES
from solver.gauss.methods import METHODS
from solver.jobs.close_table import KEYS as CLOSE_KEYS
from solver.jobs.complete_table import KEYS as COMPLETE_KEYS
from solver.jobs.fit_table import ANCHOR_KEYS
from solver.jobs.fit_table import KEYS as FIT_KEYS
from solver.jobs.outputs import SHEET_KEYS
from solver.jobs.selection import WAYS
from solver.jobs.shape_table import SHAPES
from solver.shells import plan
from solver.surface.averaging import AVERAGINGS
from solver.surface.cmc_surface import COMBINATORICS
from solver.surface.placement import GROUNDS, SIZES

ROOT = Path(__file__).parents[2]
DOCS = sorted((ROOT / "docs").rglob("*.md"))
PAGES = [ROOT / "README.md", *DOCS]
IDS = [str(page.relative_to(ROOT)) for page in PAGES]
LINK = re.compile(r"\]\(([^)\s]+)\)")
MEASURED = ROOT / "docs" / "measured"


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_python_examples_run(page, tmp_path, monkeypatch, capsys):
    """The examples of a page run from top to bottom, unchanged, where `assets` is; their files go elsewhere."""
    (tmp_path / "assets").symlink_to(ROOT / "assets")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for example in blocks(page, "python"):
        exec(compile(example, str(page), "exec"), names)


def test_there_are_examples():
    assert len(blocks(ROOT / "docs" / "how-to" / "from-python.md", "python")) >= 8
    assert blocks(ROOT / "README.md", "python") and blocks(ROOT / "README.md", "toml")


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_commands_exist(page):
    """Modules, files and targets of make in console examples; files of an example's own have no folder."""
    text = page.read_text(encoding="utf-8")
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert set(re.findall(r"(?:`|^    )make ([\w-]+)", text, flags=re.MULTILINE)) <= set(targets)
    commands = "\n".join(blocks(page, "console")) + "\n".join(re.findall(r"`([^`\n]+)`", text))
    for module in re.findall(r"-m (scripts[\w.]*)", commands) + re.findall(r"`(scripts\.[\w.]+)", text):
        assert (ROOT / module.replace(".", "/")).with_suffix(".py").is_file(), module
    for file in re.findall(r"\b(?:assets|tests|scripts|solver)/[\w./-]*\w(?:/|\.\w+)", commands):
        assert (ROOT / file).exists(), file


def test_tables_stand_where_a_script_writes_them():
    """Every table of docs/measured belongs to the script that writes its page, and no other page has any."""
    marks = {page: re.findall(r"^<!-- table: (\w+) -->$", page.read_text(encoding="utf-8"), re.M) for page in PAGES}
    written = {}
    for script in (ROOT / "scripts" / "tables").glob("measure_*.py"):
        text = script.read_text(encoding="utf-8")
        page = re.search(r'"measured" / "(\w+\.md)"', text)[1]
        written[MEASURED / page] = re.findall(r'"(\w+)": \w+', text[text.index("TABLES: Tables"):])
        words = " ".join((MEASURED / page).read_text(encoding="utf-8").split())
        assert f"`.venv/bin/python -m scripts.tables.{script.stem} --write`" in words
    assert {page: sorted(names) for page, names in marks.items() if names} == {
        page: sorted(names) for page, names in written.items()
    }


def described() -> set[str]:
    """Words in back-quotes on the page about job files, without quotes."""
    words = re.findall(r"`([^`\n]+)`", (ROOT / "docs" / "reference" / "job-file.md").read_text(encoding="utf-8"))
    return {word.strip('"') for word in words}


def job_keys() -> set[str]:
    """Every key and every name that a job file may have."""
    parameters = {parameter.name for kind in KINDS.values() for parameter in kind.parameters}
    shapes = {name for make in SHAPES.values() for name in inspect.signature(make).parameters}
    placing = {"rotate", "flip", "ground", "sheet", "side"} | set(SIZES) - {"match_plan"} | set(GROUNDS)
    elsewhere = {"default_kind", "default_tilt", "size", "value", "close"}
    solving = {field.name for field in fields(plan.Settings)} - elsewhere
    tables = {"[shape]", "[[conditions]]", "[default]", "[size]", "[solver]", "[output]", "[fit]", "[complete]"}
    files = {*SHEET_KEYS, "report", "mesh", "up", "start"} | tables | {"[close]", *CLOSE_KEYS}
    start = {"normals", "edges", "lengths"}
    names = {*SITES, *ENERGIES, *METHODS, *COMBINATORICS, *AVERAGINGS}
    words = {*WAYS, *KINDS, "curve", "curvature", *SHAPES, "kind", "scale", *plan.SHEETS}
    fitting = {*FIT_KEYS, *ANCHOR_KEYS, "[[fit.anchors]]"} - {"anchors"}
    completing = {*COMPLETE_KEYS, "flipped_corners"}
    return words | parameters | shapes | placing | solving | files | start | names | fitting | completing


def test_every_key_of_a_job_is_described():
    assert job_keys() - described() == set()


def test_no_key_is_described_that_is_none():
    """Keys stand in the first column of the tables."""
    text = (ROOT / "docs" / "reference" / "job-file.md").read_text(encoding="utf-8")
    rows = [line.split("|")[1] for line in text.splitlines() if line.startswith("| `")]
    keys = {word for cell in rows for word in re.findall(r"`([^`]+)`", cell)}
    assert keys and keys - job_keys() == set()


def test_kinds_and_statuses_are_described():
    text = (ROOT / "docs" / "reference" / "conventions.md").read_text(encoding="utf-8")
    for name in [*KINDS, *(status.value for status in Status), *SIZES, *GROUNDS, *plan.SHEETS]:
        assert f"`{name}`" in text, name


def anchors(page: Path) -> set[str]:
    """Valid fragments of a link to a page: its headings as GitHub writes them, and its explicit anchors."""
    text = page.read_text(encoding="utf-8")
    headings = re.findall(r"^#+ (.*)$", text, flags=re.MULTILINE)
    slugs = {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}
    return slugs | set(re.findall(r'<a id="([^"]+)"></a>', text))


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_links_lead_somewhere(page):
    """To files that are there, and to headings or anchors in them."""
    targets = LINK.findall(page.read_text(encoding="utf-8"))
    for target in targets:
        if target.startswith("http"):
            continue
        file, _, anchor = target.partition("#")
        there = (page.parent / file).resolve() if file else page
        assert there.exists(), target
        if anchor:
            assert anchor in anchors(there), target


def test_every_operator_has_a_paragraph():
    """With an anchor of its name, to which F1 leads; no paragraph describes an operator that does not exist."""
    folder = ROOT / "docs" / "reference" / "operators"
    pages = [page for page in folder.glob("*.md") if page.name != "README.md"]
    described = {name for page in pages for name in anchors(page) if name.startswith("cmc.")}
    sources = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "cmc_addon").rglob("*.py"))
    assert described == set(re.findall(r'bl_idname = "(cmc\.\w+)"', sources))
    listed = (folder / "README.md").read_text(encoding="utf-8")
    for page in pages:
        for name in anchors(page):
            assert not name.startswith("cmc.") or f"({page.name}#{name})" in listed, name


def test_every_picture_is_used_small_and_made_here():
    """By a script of scripts/gallery. Pictures of the window are many, so they have to be smaller."""
    images = ROOT / "docs" / "images"
    scripts = "".join(script.read_text(encoding="utf-8") for script in (ROOT / "scripts" / "gallery").glob("*.py"))
    used = {
        (page.parent / target).resolve() for page in PAGES for target in LINK.findall(page.read_text(encoding="utf-8"))
    }
    for picture in images.rglob("*.*"):
        assert picture.resolve() in used, picture.name
        assert f'"{picture.name}"' in scripts or f'"{picture.stem}"' in scripts, picture.name
        assert picture.stat().st_size < (150_000 if picture.parent.name == "window" else 300_000), picture.name


def test_the_nodoid_of_the_page_is_the_exact_one():
    """h = (2/√c) K(-1/c) at c = ½."""
    from scipy.special import ellipk

    height = 2 / np.sqrt(0.5) * ellipk(-2.0)
    assert f"{height:.10f}" in (ROOT / "docs" / "how-to" / "from-python.md").read_text(encoding="utf-8")
