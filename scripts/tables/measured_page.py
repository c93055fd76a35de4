"""Write tables into a page of docs/measured/, between `<!-- table: NAME -->` and `<!-- end -->`."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from pathlib import Path

Tables = dict[str, Callable[[], list[str]]]


def measure(page: Path, tables: Tables) -> None:
    """The command line of a page: names of tables to measure, and --write."""
    parser = argparse.ArgumentParser(description=f"Measure the tables of docs/measured/{page.name}.")
    parser.add_argument("names", nargs="*", choices=[*tables, []], help="which of them (all)")
    parser.add_argument("--write", action="store_true", help="write them into the page")
    arguments = parser.parse_args()
    for name in arguments.names or tables:
        rows = tables[name]()
        print(f"\n{name}", *rows, sep="\n", flush=True)
        if arguments.write:
            page.write_text(_written(page, name, rows), encoding="utf-8")


def _written(page: Path, name: str, rows: list[str]) -> str:
    place = re.compile(rf"(<!-- table: {name} -->\n).*?(<!-- end -->)", flags=re.DOTALL)
    text = page.read_text(encoding="utf-8")
    if not place.search(text):
        raise SystemExit(f"{page.name} has no place for the table {name}; add <!-- table: {name} --> and <!-- end -->.")
    return place.sub(lambda match: match[1] + "\n".join(rows) + "\n" + match[2], text)
