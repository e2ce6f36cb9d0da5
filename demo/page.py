"""Gathers the figures and the comparison in one HTML page that needs nothing else."""

from __future__ import annotations

import base64
import html
from pathlib import Path

from . import comparison
from .figures import FIGURES
from .results import Results

# Pictures of `gearmesh report` that open the page: file, title, caption.
FROM_REPORT = (
    ("teeth-in-mesh", "The pair", "Transverse section at mid-face, a tooth pair touching at the pitch point."),
    (
        "contact-pattern-on-gear-1-at-100-n-m",
        "Contact pattern at 100 N m",
        "Largest pressure that each point of gear 1's flank sees over the mesh cycle. Blue: a tip edge bears.",
    ),
    (
        "static-transmission-error-about-its-mean",
        "Static transmission error over the mesh cycle",
        "On the line of action, less its mean. The modifications are made for 100 N m.",
    ),
    (
        "orders-of-the-ste-over-torque",
        "Orders of the static transmission error over torque",
        "Order 20 is the mesh frequency of gear 1. What an engineer tunes for quiet running is the low point of this curve.",
    ),
)

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.15rem; margin-top: 2.2rem; }
img, svg { max-width: 100%; height: auto; } figure { margin: 0; } figcaption { color: #555; }
table { border-collapse: collapse; font-size: 0.88rem; }
td, th { border-bottom: 1px solid #ddd; padding: 0.35rem 0.6rem; text-align: left; vertical-align: top; }
"""


def _figure(title: str, caption: str, picture: str) -> str:
    return f"<h2>{html.escape(title)}</h2>\n<figure>{picture}<figcaption>{html.escape(caption)}</figcaption></figure>"


def _image(file: Path, title: str) -> str:
    return f'<img src="data:image/png;base64,{base64.b64encode(file.read_bytes()).decode("ascii")}" alt="{html.escape(title)}">'


def _table(results: Results) -> str:
    head = "<tr><th>quantity</th><th>paper</th><th>gearmesh</th><th>reason for the difference</th></tr>"
    body = "\n".join(
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in comparison.rows(results)
    )
    return f"<table>{head}\n{body}</table>"


def write(results: Results, folder: Path) -> Path:
    """Writes index.html into `folder`, where the figures are, and returns its path."""
    drawn = [_figure(title, caption, (folder / "report" / f"{file}.svg").read_text(encoding="utf-8")) for file, title, caption in FROM_REPORT]
    drawn += [_figure(f.title, f.caption, _image(folder / f.file, f.title)) for f in FIGURES]
    figures = "\n".join(drawn)
    text = f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>gearmesh: the paper's pair</title>
<meta name="viewport" content="width=device-width"><style>{STYLE}</style></head><body>
<h1>The gear pair of Palermo et al. (2013), from its drawing to its FMU</h1>
<p>First what <a href="report.html"><code>gearmesh report</code></a> and <code>gearmesh solve</code> say of the pair at rest, then
<code>palermo2013.fmu</code> in motion, driven through fmpy: a run-up at a usual damping, and the paper's simulations, in
which gear 1 turns as imposed, gear 2 turns on a rigid revolute joint and its inertia is integrated outside the FMU. The
run-up is of the unmodified pair. Everything on this page took {results.seconds:.0f} s.</p>
<p>Next: the same for a pair of your own.</p>
<pre>target/release/gearmesh new --teeth 23 81 --module-mm 1.75 --face-width-mm 30 28 --torque-nm 120 -o pair.json
target/release/gearmesh report pair.json -o pair.html
target/release/gearmesh build pair.json -o pair.fmu</pre>
<p>Start: <code>docs/index.md</code>; the FMU in a simulator: <code>docs/fmu.md</code>; run-ups and orders in Python:
<code>docs/python.md</code>.</p>
{figures}
<h2>The paper's numbers and ours</h2>
{_table(results)}
</body></html>
"""
    path = folder / "index.html"
    path.write_text(text, encoding="utf-8")
    return path
