"""docs/*.md as plain HTML pages, which the extension brings along for F1: no server, no script, nothing fetched.

Knows the Markdown that our pages use: headings, paragraphs, lists, tables, code, pictures, links, emphasis, anchors.
"""

from __future__ import annotations

import html
import re
import shutil
from pathlib import Path

_STYLE = (
    "body{max-width:46rem;margin:2rem auto;padding:0 1rem;font:16px/1.55 system-ui,sans-serif;color:#222}"
    "img{max-width:100%}table{border-collapse:collapse}td,th{border:1px solid #ccc;padding:.3rem .6rem;text-align:left;"
    "vertical-align:top}pre{background:#f4f4f4;padding:.8rem;overflow-x:auto}code{background:#f4f4f4}:target{background:#ffc}"
)
_INLINE = (
    (r"`([^`]+)`", None),
    (r"!\[([^\]]*)\]\(([^)]+)\)", r'<img alt="\1" src="\2">'),
    (r"\[([^\]]+)\]\(([^)\s]+)\)", r'<a href="\2">\1</a>'),
    (r"\*\*(.+?)\*\*", r"<strong>\1</strong>"),
    (r"(?<![\w*])\*([^*\s](?:[^*]*[^*\s])?)\*(?![\w*])", r"<em>\1</em>"),
)


def write_pages(docs: Path, target: Path) -> list[Path]:
    """Make a page of every file of docs/, with its pictures, in another folder; returns the pages."""
    shutil.rmtree(target, ignore_errors=True)
    pages = []
    for source in sorted(docs.rglob("*.md")):
        page = target / source.relative_to(docs).with_suffix(".html")
        page.parent.mkdir(parents=True, exist_ok=True)
        text = source.read_text(encoding="utf-8")
        page.write_text(_without_dead_ends(whole_page(text), source.parent, docs), encoding="utf-8")
        pages.append(page)
        for picture in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text):
            file = source.parent / picture
            if file.is_file():
                (page.parent / picture).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(file, page.parent / picture)
    return pages


def _without_dead_ends(page: str, folder: Path, docs: Path) -> str:
    """Links to files that are no pages (the README, sources) become plain words."""

    def kept(match: re.Match) -> str:
        target = match.group(1)
        file = (folder / target.partition("#")[0]).resolve()
        leads = file.is_relative_to(docs.resolve()) and file.with_suffix(".md").is_file()
        return match.group(0) if leads or re.match(r"\w+:|#", target) else match.group(2)

    return re.sub(r'<a href="([^"]*)">(.*?)</a>', kept, page)


def whole_page(text: str) -> str:
    title = re.search(r"^# (.+)$", text, re.M)
    name = html.escape(re.sub(r"[*`]", "", title.group(1))) if title else "CMC Form-Finding"
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{name}</title>'
        f"<style>{_STYLE}</style></head>\n<body>\n{body(text)}\n</body></html>\n"
    )


def body(text: str) -> str:
    """HTML of a page's Markdown, block by block."""
    blocks, slugs = [], set()
    lines = text.split("\n")
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
    """Items of one level; what is indented goes on with its item."""
    tag = "ol" if lines[0][0].isdigit() else "ul"
    items: list[str] = []
    for line in lines:
        if mark := re.match(r"(?:[-*]|\d+\.) ", line):
            items.append(line[mark.end():])
        else:
            items[-1] += " " + line.strip()
    return f"<{tag}>" + "\n".join(f"<li>{inline(item)}</li>" for item in items) + f"</{tag}>"


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
