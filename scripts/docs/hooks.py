"""What mkdocs makes of the pages beyond Markdown: parts taken from elsewhere, and equations as MathML.

    <!-- commands -->                      the help of every subcommand of target/release/gearmesh
    <!-- variables: input|output|parameter -->   the variables of modelDescription.xml
    <!-- data -->                          all CSV files of docs/data
    [text](data/NAME.csv)                  alone in its paragraph: the table, folded
    $...$ and $$...$$                      equations
"""

from __future__ import annotations

import csv
import html
import os
import re
import subprocess
import textwrap
from pathlib import Path

import fmpy
from latex2mathml.converter import convert
from mkdocs.exceptions import PluginError

ROOT = Path(__file__).resolve().parents[2]
SPACE = '<mspace width="0.12em"/>'
GEARMESH = Path(os.environ.get("GEARMESH", ROOT / "target/release/gearmesh"))


def table(head: list[str], rows: list[list[str]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def folded(title: str, content: str) -> str:
    """Content under a heading that opens."""
    return f'??? note "{title}"\n\n' + "\n".join(f"    {line}" for line in content.splitlines())


def csv_table(match: re.Match, page: Path) -> str:
    """The folded table of a CSV file, with a link to it."""
    text, target = match[1], match[2]
    with (page.parent / target).open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    content = f"{table(head, rows)}\n\n[{Path(target).name}]({target})"
    return folded(f"{text} ({len(rows)} rows)", content)


def wrapped(text: str) -> str:
    """Lines of at most 92 characters, each with its indent."""
    lines = []
    for line in text.rstrip().splitlines():
        indent = line[: len(line) - len(line.lstrip())]
        lines += textwrap.wrap(line, 92, subsequent_indent=indent, break_on_hyphens=False) or [""]
    return "\n".join(lines)


def run(*arguments: str) -> str:
    if not GEARMESH.exists():
        raise PluginError(f"{GEARMESH} is missing: run `make build` first")
    return subprocess.run([GEARMESH, *arguments], check=True, stdout=subprocess.PIPE, text=True).stdout


def commands() -> str:
    """A section for every subcommand, in the order of the help."""
    listed = run("--help").partition("Commands:\n")[2].partition("\n\n")[0]
    names = [name for name in re.findall(r"^  ([\w-]+)", listed, re.M) if name != "help"]
    return "\n\n".join(f"## gearmesh {name}\n\n```text\n{wrapped(run(name, '--help'))}\n```" for name in names)


def meaning_of(variable) -> str:
    """What a variable means: of a vector or of both gears at once, and of an enumeration with its items."""
    text = variable.description
    if variable.name.endswith("[1]"):
        text = re.sub("^x of (the )?", "", text).replace(", component w of the", ", w x y z of a")
        text = text.replace("Cardan angle 1", "Cardan angles").replace("gear 1", "the gear")
    if variable.type == "Enumeration":
        text += ". " + "; ".join(f"`{item.name}`: {item.description}" for item in variable.declaredType.items)
    return text[0].upper() + text[1:]


def variables(causality: str) -> str:
    """Variables of the FMU: name, unit, start value, meaning. Components of a vector and both gears share a row."""
    every = [v for v in fmpy.read_model_description(str(ROOT)).modelVariables if v.causality == causality]
    rows = []
    for variable in every:
        name, _, index = variable.name.partition("[")
        if index not in ("", "1]") or name.startswith("gear2."):
            continue
        size = sum(v.name.startswith(f"{name}[") for v in every)
        start, unit = variable.start or "", variable.unit or "1"
        if variable.type == "Enumeration":
            start = variable.declaredType.items[int(start) - 1].name
        if name.endswith(".quaternion"):
            start = "1 0 0 0"
        shown = f"`{name}[1..{size}]`" if index else f"`{name}`"
        if name.startswith("gear1."):
            shown += f", `{name.replace('gear1', 'gear2')}[…]`"
        cells = [shown, "" if unit == "1" else unit.replace(".", " ")]
        rows.append([*cells, *([] if causality == "output" else [start]), meaning_of(variable)])
    head = ["name", "unit", *([] if causality == "output" else ["start"]), "meaning"]
    return "\n\n".join(table(head, rows[first : first + 12]) for first in range(0, len(rows), 12))


def data(page: Path) -> str:
    """All CSV files, by folder: rows and columns."""
    parts, rows, before = [], [], None
    for file in sorted((page.parent / "data").rglob("*.csv"), key=lambda f: (f.parent != page.parent / "data", f)):
        if file.parent != before and rows:
            parts.append(table(["file", "rows", "columns"], rows))
            rows = []
        before = file.parent
        with file.open(encoding="utf-8", newline="") as stream:
            head, *lines = csv.reader(stream)
        name = file.relative_to(page.parent).as_posix()
        rows.append([f"[{name.removeprefix('data/')}]({name})", str(len(lines)), "; ".join(filter(None, head))])
    return "\n\n".join([*parts, table(["file", "rows", "columns"], rows)])


def on_page_markdown(markdown: str, page, **_) -> str:
    """Parts from elsewhere."""
    source = Path(page.file.abs_src_path)
    markdown = markdown.replace("<!-- commands -->", commands() if "<!-- commands -->" in markdown else "")
    markdown = markdown.replace("<!-- data -->", data(source) if "<!-- data -->" in markdown else "")
    markdown = re.sub(r"<!-- variables: (\w+) -->", lambda m: variables(m[1]), markdown)
    return re.sub(r"^\[([^\]\n]+)\]\(([^)\n]+\.csv)\)$", lambda m: csv_table(m, source), markdown, flags=re.M)


def on_page_content(content: str, **_) -> str:
    """Equations as MathML, and numbers of tables to the right."""

    def mathml(match: re.Match) -> str:
        block = match[1] == "div"
        latex = html.unescape(match[2]).strip().removeprefix(r"\(").removeprefix(r"\[")
        result = convert(latex.removesuffix(r"\)").removesuffix(r"\]"), display="block" if block else "inline")
        # Functions keep a distance from what follows and precedes them.
        result = re.sub(r"<mi>(tan|cos|sin|ln|inv)</mi>", rf"<mrow>{SPACE}<mi>\1</mi>{SPACE}</mrow>", result)
        return f'<div class="equation">{result}</div>' if block else result

    content = re.sub(r'<(span|div) class="arithmatex">(.*?)</\1>', mathml, content, flags=re.S)
    return re.sub(r"<td>([-+]?\d[^<a-zA-Z]{0,20})</td>", r'<td class="number">\1</td>', content)
