"""docs/ as plain HTML: the pages of the extension's help (F1), and of `make docs`. No server, nothing fetched.

    .venv/bin/python scripts/build/help_pages.py     # build/docs/README.html

Covers the Markdown of our pages: headings, paragraphs, lists, tables, code, pictures, links, emphasis, anchors.
search.html holds the text of all pages, and a script of a few lines that finds words in it.
"""

from __future__ import annotations

import html
import json
import os
import re
import shutil
from pathlib import Path

from api_pages import api_pages

ROOT = Path(__file__).resolve().parents[2]

_STYLE = (
    "body{max-width:46rem;margin:2rem auto;padding:0 1rem;font:16px/1.55 system-ui,sans-serif;color:#222}"
    "img{max-width:100%}table{border-collapse:collapse}td,th{border:1px solid #ccc;padding:.3rem .6rem;text-align:left;"
    "vertical-align:top}pre{background:#f4f4f4;padding:.8rem;overflow-x:auto}code{background:#f4f4f4}:target{background:#ffc}"
)
_SEARCH = """<h1>Search</h1>
<input id="words" autofocus placeholder="courtyard gap"><div id="hits"></div>
<script>
const sections = SECTIONS;
const field = document.getElementById("words"), hits = document.getElementById("hits");
field.oninput = () => {
  const words = field.value.toLowerCase().split(/\\s+/).filter(word => word);
  const score = ([title, , text]) => words.every(word => (title + " " + text).toLowerCase().includes(word))
    ? 1 + words.filter(word => title.toLowerCase().includes(word)).length : 0;
  const ranked = words.length ? sections.map(each => [score(each), each]).filter(([points]) => points) : [];
  ranked.sort((a, b) => b[0] - a[0]);
  hits.replaceChildren(...ranked.slice(0, 30).map(([, [title, address, text]]) => {
    const hit = document.createElement("p"), link = document.createElement("a");
    const at = Math.max(0, text.toLowerCase().indexOf(words[0]) - 60);
    link.href = address;
    link.textContent = title;
    hit.append(link, document.createElement("br"), text.slice(at, at + 160));
    return hit;
  }));
};
</script>"""
_INLINE = (
    (r"`([^`]+)`", None),
    (r"!\[([^\]]*)\]\(([^)]+)\)", r'<img alt="\1" src="\2">'),
    (r"\[([^\]]+)\]\(([^)\s]+)\)", r'<a href="\2">\1</a>'),
    (r"\*\*(.+?)\*\*", r"<strong>\1</strong>"),
    (r"(?<![\w*])\*([^*\s](?:[^*]*[^*\s])?)\*(?![\w*])", r"<em>\1</em>"),
)


def write_pages(docs: Path, target: Path) -> list[Path]:
    """Write a page for each file of docs/ and each public name of the solver, and their pictures; return the pages."""
    texts = {source.relative_to(docs): source.read_text(encoding="utf-8") for source in sorted(docs.rglob("*.md"))}
    texts |= api_pages()
    shutil.rmtree(target, ignore_errors=True)
    pages, entries = [], []
    for path, text in texts.items():
        page = (target / path).with_suffix(".html")
        page.parent.mkdir(parents=True, exist_ok=True)
        page.write_text(_without_dead_ends(whole_page(text, _up(path)), path.parent, texts), encoding="utf-8")
        pages.append(page)
        entries += sections(path, text)
        for picture in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text):
            file = docs / path.parent / picture
            if file.is_file():
                (page.parent / picture).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(file, page.parent / picture)
    search = target / "search.html"
    content = _SEARCH.replace("SECTIONS", json.dumps(entries, ensure_ascii=False))
    search.write_text(_page("Search", "", content), encoding="utf-8")
    return [*pages, search]


def _up(path: Path) -> str:
    """The way from a page to the folder of all pages."""
    return "../" * (len(path.parts) - 1)


def sections(path: Path, text: str) -> list[list[str]]:
    """[title, address, words] of the sections of a page, for the search."""
    entries, slugs = [], set()
    title = ""
    for part in re.split(r"^(?=#+ )", re.sub(r"^```.*?^```$", _unmarked, text, flags=re.M | re.S), flags=re.M):
        heading, _, words = part.partition("\n")
        if not heading.startswith("#"):
            continue
        name = re.sub(r"[*`]", "", heading.lstrip("# "))
        title = title or name
        address = f"{path.with_suffix('.html').as_posix()}#{slug(heading.lstrip('# '), slugs)}"
        plain = re.sub(r"\]\([^)]*\)|<[^>]*>|[*`|\[\]!]|-{3,}", " ", words)
        entries.append([name if name == title else f"{title}: {name}", address, " ".join(plain.split())])
    return entries


def _unmarked(code: re.Match) -> str:
    """Code whose comments are no headings."""
    return code[0].replace("#", " ")


def _without_dead_ends(page: str, folder: Path, texts: dict[Path, str]) -> str:
    """Replace links to files that are no pages (the README, sources) by their words."""

    def kept(match: re.Match) -> str:
        target = match.group(1)
        file = Path(os.path.normpath(folder / target.partition("#")[0]))
        leads = file.with_suffix(".md") in texts or file.name == "search.html"
        return match.group(0) if leads or re.match(r"\w+:|#", target) else match.group(2)

    return re.sub(r'<a href="([^"]*)">(.*?)</a>', kept, page)


def whole_page(text: str, up: str = "") -> str:
    """A page of Markdown as HTML; `up` leads to the folder of all pages."""
    title = re.search(r"^# (.+)$", text, re.M)
    return _page(re.sub(r"[*`]", "", title.group(1)) if title else "CMC Form-Finding", up, body(text))


def _page(title: str, up: str, content: str) -> str:
    ways = f'<a href="{up}README.html">Contents</a> · <a href="{up}search.html">Search</a>'
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>'
        f"<style>{_STYLE}</style></head>\n<body>\n<nav>{ways}</nav>\n{content}\n</body></html>\n"
    )


def body(text: str) -> str:
    """HTML of a page's Markdown, block by block."""
    blocks, slugs = [], set()
    lines = re.sub(r"^<!-- .* -->\n?", "", text, flags=re.M).split("\n")
    while lines:
        if not lines[0].strip():
            lines.pop(0)
            continue
        blocks.append(_block(lines, slugs))
    return "\n".join(blocks)


def _block(lines: list[str], slugs: set[str]) -> str:
    """Take a block from the beginning of the lines."""
    first = lines[0]
    if first.startswith("```"):
        code = _take_until(lines[1:], lambda line: line.startswith("```"))
        del lines[: len(code) + 2]
        return _code(code)
    if first.startswith("    "):
        code = _take_until(lines, lambda line: line.strip() != "" and not line.startswith("    "))
        del lines[: len(code)]
        return _code([line[4:] for line in code])
    if heading := re.match(r"(#+) (.+)", first):
        lines.pop(0)
        level, words = len(heading.group(1)), heading.group(2)
        return f'<h{level} id="{slug(words, slugs)}">{inline(words)}</h{level}>'
    paragraph = _take_until(lines, lambda line: not line.strip() or line.startswith(("```", "#")))
    del lines[: len(paragraph)]
    if first.startswith("|"):
        return _table(paragraph)
    if re.match(r"[-*] |\d+\. ", first):
        return _list(paragraph)
    if first.startswith("<a id="):
        return first
    return f"<p>{inline(' '.join(line.strip() for line in paragraph))}</p>"


def _take_until(lines: list[str], ends) -> list[str]:
    taken = []
    for line in lines:
        if ends(line):
            break
        taken.append(line)
    return taken


def _code(lines: list[str]) -> str:
    return f"<pre><code>{html.escape(chr(10).join(lines).strip(chr(10)))}</code></pre>"


def _table(rows: list[str]) -> str:
    cells = [[inline(cell.strip()) for cell in re.split(r"(?<!\\)\|", row.strip().strip("|"))] for row in rows]
    head, rest = cells[0], [row for row in cells[1:] if not all(re.fullmatch(r":?-+:?", cell) for cell in row)]
    parts = ["<tr>" + "".join(f"<th>{cell}</th>" for cell in head) + "</tr>"] if any(head) else []
    parts += ["<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rest]
    return "<table>" + "\n".join(parts) + "</table>"


def _list(lines: list[str]) -> str:
    """Items of one level; indented lines continue their item."""
    tag = "ol" if lines[0][0].isdigit() else "ul"
    items: list[str] = []
    for line in lines:
        if mark := re.match(r"(?:[-*]|\d+\.) ", line):
            items.append(line[mark.end():])
        else:
            items[-1] += " " + line.strip()
    first = re.match(r"(\d+)\.", lines[0])
    start = f' start="{first[1]}"' if first and first[1] != "1" else ""
    return f"<{tag}{start}>" + "\n".join(f"<li>{inline(item)}</li>" for item in items) + f"</{tag}>"


def slug(words: str, taken: set[str]) -> str:
    """The anchor of a heading, as code hosts make it."""
    plain = re.sub(r"[^\w\- ]", "", re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", words).lower()).replace(" ", "-")
    name, count = plain, 0
    while name in taken:
        count += 1
        name = f"{plain}-{count}"
    taken.add(name)
    return name


def inline(text: str) -> str:
    """Links, pictures, code, emphasis; links to other pages of docs/ lead to their HTML."""
    kept: list[str] = []

    def keep(match: re.Match) -> str:
        kept.append(f"<code>{html.escape(match.group(1))}</code>")
        return f"\x00{len(kept) - 1}\x00"

    text = html.escape(re.sub(_INLINE[0][0], keep, text), quote=False)
    for pattern, wanted in _INLINE[1:]:
        assert wanted is not None
        text = re.sub(pattern, wanted, text)
    text = re.sub(r'(href="(?!\w+:)[^"#]*)\.md(#[^"]*)?"', r'\1.html\2"', text)
    return re.sub("\x00(\\d+)\x00", lambda match: kept[int(match.group(1))], text)


if __name__ == "__main__":
    print(f"{len(write_pages(ROOT / 'docs', ROOT / 'build' / 'docs'))} pages in build/docs; begin with README.html")
