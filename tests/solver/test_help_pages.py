"""The pages that the extension brings along for F1: every block is taken, every link leads somewhere."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def load():
    spec = importlib.util.spec_from_file_location("help_pages", ROOT / "scripts" / "build" / "help_pages.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


pages = load()


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
    ],
)
def test_blocks(text, wanted):
    assert pages.body(text) == wanted


def test_headings_that_are_alike_have_anchors_of_their_own():
    taken: set[str] = set()
    assert [pages.slug(words, taken) for words in ("A b, c", "A b c", "F1: what?")] == ["a-b-c", "a-b-c-1", "f1-what"]


def test_all_of_the_docs_and_every_link(tmp_path):
    written = pages.write_pages(ROOT / "docs", tmp_path)
    assert len(written) == len(list((ROOT / "docs").rglob("*.md")))
    for page in written:
        text = page.read_text(encoding="utf-8")
        for target in re.findall(r'(?:href|src)="([^"]+)"', text):
            if re.match(r"\w+:", target):
                continue
            name, _, anchor = target.partition("#")
            file = (page.parent / name).resolve() if name else page
            assert file.is_file(), f"{page.name}: {target}"
            if anchor:
                assert f'id="{anchor}"' in file.read_text(encoding="utf-8"), f"{page.name}: {target}"
