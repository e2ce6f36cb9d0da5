"""`python -m scripts.docs.check [SITE]`: holds the figures of the pages to the data.

Figures of docs/data/headlines.csv, links of pages outside the site, and that the pages of SITE load nothing from elsewhere.
"""

from __future__ import annotations

import csv
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def pages() -> dict[str, str]:
    """Every Markdown file of the repository, by path."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.md"]
    names = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()
    return {name: (ROOT / name).read_text(encoding="utf-8") for name in sorted(set(names)) if (ROOT / name).exists()}


def anchors(text: str) -> set[str]:
    """Those that headings make."""
    headings = re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S), re.M)
    return {re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", heading.lower())).strip("-") for heading in headings}


def dead_links(name: str, text: str, texts: dict[str, str]) -> list[str]:
    """Of pages that mkdocs does not see."""
    found = []
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"https?:", target):
            continue
        path, _, anchor = target.partition("#")
        file = ((ROOT / name).parent / path).resolve()
        page = texts.get(file.relative_to(ROOT).as_posix(), "") if file.is_relative_to(ROOT) else ""
        if not file.exists() or (anchor and anchor not in anchors(page)):
            found.append(f"{name}: dead link {target}")
    return found


def cell(file: str, row: str, column: str) -> str:
    """A cell by its column and by cells of its row: FIRST, or COLUMN=VALUE & ..."""
    with (ROOT / "docs/data" / file).open(encoding="utf-8", newline="") as stream:
        table = list(csv.DictReader(stream))
    for line in table:
        conditions = [c.split("=", 1) if "=" in c else (next(iter(line)), c) for c in row.split(" & ")]
        if all(line.get(key) == value for key, value in conditions):
            return line[column]
    raise KeyError(f"{file} has no row {row}")


def headlines(texts: dict[str, str]) -> list[str]:
    """Figures in pages that are not those of their source. In `quote` the figure stands between < and >."""
    found = []
    with (ROOT / "docs/data/headlines.csv").open(encoding="utf-8", newline="") as stream:
        for line in csv.DictReader(stream):
            quote, where = line["quote"], f"{line['page']}: {line['quote']}"
            shown = re.search(r"<(.*?)>", quote)[1]
            if quote.replace("<", "").replace(">", "") not in " ".join(texts[line["page"]].split()):
                found.append(f"{where}: the page does not say so")
                continue
            try:
                value = NUMBER.findall(cell(line["file"], line["row"], line["column"]))[int(line["number"] or 1) - 1]
            except (KeyError, IndexError) as error:
                found.append(f"{where}: {error}")
                continue
            unit = 10.0 ** -len(shown.partition("e")[0].partition(".")[2])
            unit *= 10.0 ** int(shown.partition("e")[2] or 0)
            source = float(value) * float(line["factor"] or 1.0)
            if abs(abs(float(shown)) - abs(source)) > 0.501 * unit:
                found.append(f"{where}: {line['file']} has {source:g}")
    return found


def from_elsewhere(site: Path) -> list[str]:
    """What built pages would load over the network."""
    loads = re.compile(r"""<(?:script|img|link|iframe)\b[^>]*?(?:src|href)=["']?((?:https?:)?//[^"'\s>]+)""")
    found = []
    for page in site.rglob("*.html"):
        for url in loads.findall(page.read_text(encoding="utf-8")):
            found.append(f"{page.relative_to(site)}: loads {url}")
    for sheet in site.rglob("*.css"):
        if re.search(r"url\(['\"]?(?:https?:)?//", sheet.read_text(encoding="utf-8")):
            found.append(f"{sheet.relative_to(site)}: loads something from elsewhere")
    return found


def main() -> int:
    texts = pages()
    found = headlines(texts)
    for name, text in texts.items():
        if not name.startswith("docs/"):
            found += dead_links(name, text, texts)
    if len(sys.argv) > 1:
        found += from_elsewhere(Path(sys.argv[1]))
    for line in found:
        print(f"docs: {line}", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
