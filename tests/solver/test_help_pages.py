"""The help pages in the extension (F1): every link leads somewhere, every public name has a page."""

from __future__ import annotations

import importlib
import inspect
import json
import re
from pathlib import Path

import pytest

import solver

ROOT = Path(__file__).parents[2]
INDEX = ROOT / "docs" / "reference" / "python.md"


@pytest.fixture(autouse=True)
def build_folder(monkeypatch):
    """The scripts of the build import each other by name."""
    monkeypatch.syspath_prepend(str(ROOT / "scripts" / "build"))


@pytest.fixture
def pages(build_folder):
    return importlib.import_module("help_pages")


@pytest.fixture
def api(build_folder):
    return importlib.import_module("api_pages")


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("# A *b*", '<h1 id="a-b">A <em>b</em></h1>'),
        ("One\ntwo", "<p>One two</p>"),
        ("- a\n  b\n- c", "<ul><li>a b</li>\n<li>c</li></ul>"),
        ("1. a\n2. b", "<ol><li>a</li>\n<li>b</li></ol>"),
        ("| x | y |\n|---|---|\n| 1 | `a|b` |".replace("a|b", "ab"),
         "<table><tr><th>x</th><th>y</th></tr>\n<tr><td>1</td><td><code>ab</code></td></tr></table>"),
        ("| | |\n|---|---|\n| 1 | 2 |", "<table><tr><td>1</td><td>2</td></tr></table>"),
        ("```py\na < b\n\n# c\n```", "<pre><code>a &lt; b\n\n# c</code></pre>"),
        ("    a *b*", "<pre><code>a *b*</code></pre>"),
        ("[x](y.md#z) **b** `*c*`", '<p><a href="y.html#z">x</a> <strong>b</strong> <code>*c*</code></p>'),
        ('<a id="cmc.solve"></a>', '<a id="cmc.solve"></a>'),
        ("![alt](i.png)", '<p><img alt="alt" src="i.png"></p>'),
        ("2 * 3 * 4", "<p>2 * 3 * 4</p>"),
        ("2. b\n3. c", '<ol start="2"><li>b</li>\n<li>c</li></ol>'),
        ("<!-- table: a -->\n| 1 |\n<!-- end -->", "<table><tr><th>1</th></tr></table>"),
    ],
)
def test_blocks(pages, text, wanted):
    assert pages.body(text) == wanted


def test_equal_headings_get_different_anchors(pages):
    taken: set[str] = set()
    assert [pages.slug(words, taken) for words in ("A b, c", "A b c", "F1: what?")] == ["a-b-c", "a-b-c-1", "f1-what"]


def test_all_of_the_docs_and_every_link(pages, tmp_path):
    written = pages.write_pages(ROOT / "docs", tmp_path)
    assert len(written) == len(list((ROOT / "docs").rglob("*.md"))) + len(solver.__all__) + 1
    for page in written:
        text = re.sub(r"<script>.*</script>", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
        for target in re.findall(r'(?:href|src)="([^"]+)"', text):
            if re.match(r"\w+:", target):
                continue
            name, _, anchor = target.partition("#")
            file = (page.parent / name).resolve() if name else page
            assert file.is_file(), f"{page.name}: {target}"
            if anchor:
                assert f'id="{anchor}"' in file.read_text(encoding="utf-8"), f"{page.name}: {target}"


def test_the_search_knows_every_section(pages, tmp_path):
    """Titles, addresses that lead to the heading, and words without markup."""
    pages.write_pages(ROOT / "docs", tmp_path)
    text = (tmp_path / "search.html").read_text(encoding="utf-8")
    found = json.loads(re.search(r"^const sections = (.*);$", text, re.M)[1])
    assert len(found) > 300
    for _, address, _ in found:
        name, _, anchor = address.partition("#")
        assert f'id="{anchor}"' in (tmp_path / name).read_text(encoding="utf-8"), address
    (words,) = [words for title, _, words in found if title == "In Blender: Plans with holes"]
    assert "Keep Holes" in words and "*" not in words and "](" not in words


def source(name: str) -> str:
    """The file that defines a public name; decorated functions are where their code is."""
    value = getattr(solver, name)
    file = inspect.getsourcefile(inspect.unwrap(value) if callable(value) else value)
    return Path(file).relative_to(ROOT).as_posix()


def test_every_public_name_has_a_page(api):
    """Signature, docstring and source; links between public names lead to pages that are made."""
    made = api.api_pages()
    for name in solver.__all__:
        page = made[Path(f"reference/python/{name}.md")]
        value = getattr(solver, name)
        assert page.startswith(f"# {name}\n")
        words = re.sub(r"\[(`\w+`)\]\(\w+\.md\)", r"\1", page)
        assert inspect.getdoc(value).split("\n")[0] in words, name
        assert f"defined in `{source(name)}`" in page
        assert all(Path(f"reference/python/{link}") in made for link in re.findall(r"\]\((\w+\.md)\)", page)), name


def test_a_signature_is_the_one_of_the_function(api):
    page = api.api_pages()[Path("reference/python/solve_cmc.md")]
    signature = page[page.index("def solve_cmc"): page.index("```", page.index("def solve_cmc"))]
    words = re.findall(r"^    (\w+)[:,=]", signature, re.M)
    assert words == list(inspect.signature(solver.solve_cmc).parameters)


def test_the_index_lists_every_public_name_with_its_source():
    """Add a row to docs/reference/python.md for each new name."""
    listed = re.findall(r"^\| \[`(\w+)`\]\(\.\./\.\./(.*?)\)", INDEX.read_text(encoding="utf-8"), re.M)
    assert dict(listed) == {name: source(name) for name in solver.__all__}
    assert len(listed) == len(solver.__all__)
