"""Tables in a page that a command writes anew."""

from __future__ import annotations

import re
from pathlib import Path


def replace_table(page: Path, name: str, table: str) -> None:
    """Puts `table` between the comments `begin: NAME` and `end: NAME` of the page."""
    begin, end = f"<!-- begin: {name} -->\n", f"<!-- end: {name} -->\n"
    text = page.read_text()
    pattern = re.compile(re.escape(begin) + ".*?" + re.escape(end), re.S)
    if not pattern.search(text):
        raise SystemExit(f"{page} has no place for the table: {begin.strip()}")
    page.write_text(pattern.sub(lambda _: begin + table + end, text))
