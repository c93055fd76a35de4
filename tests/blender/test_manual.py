"""F1 leads every operator and setting to a page and a heading that exist; calls on these pages have valid settings."""

from __future__ import annotations

import ast
import re
import shlex
import webbrowser
from pathlib import Path
from urllib.parse import unquote, urlparse

import bpy
import pytest

from .test_tooltips import groups, operators, own_properties

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture
def manual(addon):
    return addon.cmc_addon.operators.manual


def lookup(name: str) -> str | None:
    return bpy.types.WM_OT_doc_view_manual._lookup_rna_url(name, verbose=False)


def anchors(file: Path) -> set[str]:
    text = file.read_text(encoding="utf-8")
    headings = re.findall(r"^#+ (.+)$", text, re.M)
    return {re.sub(r"[^\w\- ]", "", words.lower()).replace(" ", "-") for words in headings} | set(
        re.findall(r'<a id="([^"]+)"', text)
    )


def leads(url: str | None) -> bool:
    """Whether a link into the checkout's docs/ leads to what is there."""
    if url is None:
        return False
    parts = urlparse(url)
    file = Path(unquote(parts.path))
    return parts.scheme == "file" and file.is_file() and (not parts.fragment or parts.fragment in anchors(file))


def test_every_operator_has_its_paragraph():
    links = {name: lookup(f"bpy.ops.{name}") for name in operators()}
    assert {name: link for name, link in links.items() if not leads(link)} == {}
    assert all(link.endswith(f"#{name}") for name, link in links.items())


def test_every_setting_leads_to_its_section():
    names = [f"bpy.types.{rna.identifier}.{p.identifier}" for rna in groups().values() for p in own_properties(rna)]
    links = {name: lookup(name) for name in names}
    assert {name: link for name, link in links.items() if not leads(link)} == {}


def test_the_more_special_comes_first(manual):
    beginnings = list(manual.SETTINGS)
    for k, early in enumerate(beginnings):
        assert not any(late.startswith(early) for late in beginnings[k + 1:]), early


def test_f1_opens_the_page(monkeypatch):
    opened = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    assert bpy.ops.wm.doc_view_manual(doc_id="cmc.solve") == {"FINISHED"}
    assert bpy.ops.wm.doc_view_manual(doc_id="CMC_OT_solve.span") == {"FINISHED"}
    assert [urlparse(url).fragment for url in opened] == ["cmc.solve", "cmc.solve"]
    assert opened[0].startswith("file:///") and "/docs/reference/operators/solve.md" in opened[0]


def test_installed_they_lead_to_the_pages_that_came_along(manual, monkeypatch, tmp_path):
    (tmp_path / "help").mkdir()
    (tmp_path / "blender_manifest.toml").write_text('id = "x"\n')
    monkeypatch.setattr(manual, "ROOT", tmp_path)
    assert lookup("bpy.ops.cmc.solve") == f"{tmp_path.as_uri()}/help/reference/operators/solve.html#cmc.solve"
    (tmp_path / "blender_manifest.toml").write_text('website = "https://example.org/cmc/"\n')
    assert lookup("bpy.ops.cmc.solve") == "https://example.org/cmc/docs/reference/operators/solve.md#cmc.solve"


def test_blenders_own_links_stay():
    assert lookup("bpy.ops.mesh.subdivide").startswith("https://docs.blender.org/")


def test_unregistered_there_are_none(addon):
    addon.unregister()
    try:
        assert lookup("bpy.ops.cmc.solve") is None
    finally:
        addon.register()


def written(pattern: str) -> list[str]:
    """All matches on the pages of docs/."""
    return [match for page in DOCS.rglob("*.md") for match in re.findall(pattern, page.read_text("utf-8"), re.M)]


def test_calls_in_the_documentation_have_these_settings():
    calls = written(r"bpy\.ops\.cmc\.\w+\((?:[^()\n]|\([^()\n]*\))*\)")
    assert len(calls) > 30
    for call in calls:
        node = ast.parse(call, mode="eval").body
        properties = getattr(bpy.ops.cmc, node.func.attr).get_rna_type().properties
        for keyword in node.keywords:
            assert keyword.arg in properties, call
            if properties[keyword.arg].type == "ENUM" and properties[keyword.arg].enum_items:
                assert ast.literal_eval(keyword.value) in properties[keyword.arg].enum_items, call


def test_command_lines_in_the_documentation_are_understood(addon):
    lines = written(r"^blender --command cmc .*$")
    assert len(lines) >= 3
    for line in lines:
        arguments = addon.cmc_addon.headless.cli._parser().parse_args(shlex.split(line)[3:])
        assert arguments.inputs, line
