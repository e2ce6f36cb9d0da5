"""Gathers the figures and the comparison in one HTML page that needs nothing else."""

from __future__ import annotations

import base64
import html
from pathlib import Path

from . import comparison
from .figures import FIGURES
from .results import Results

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.15rem; margin-top: 2.2rem; }
img { max-width: 100%; } figure { margin: 0; } figcaption { color: #555; }
table { border-collapse: collapse; font-size: 0.88rem; }
td, th { border-bottom: 1px solid #ddd; padding: 0.35rem 0.6rem; text-align: left; vertical-align: top; }
"""


def _figure(folder: Path, file: str, title: str, caption: str) -> str:
    image = base64.b64encode((folder / file).read_bytes()).decode("ascii")
    return (
        f"<h2>{html.escape(title)}</h2>\n<figure>"
        f'<img src="data:image/png;base64,{image}" alt="{html.escape(title)}">'
        f"<figcaption>{html.escape(caption)}</figcaption></figure>"
    )


def _table(results: Results) -> str:
    head = "<tr><th>quantity</th><th>paper</th><th>gearmesh</th><th>reason for the difference</th></tr>"
    body = "\n".join(
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in (r.quantity, r.paper, r.ours, r.reason)) + "</tr>"
        for r in comparison.rows(results)
    )
    return f"<table>{head}\n{body}</table>"


def write(results: Results, folder: Path) -> Path:
    """Writes index.html into `folder`, where the figures are, and returns its path."""
    figures = "\n".join(_figure(folder, f.file, f.title, f.caption) for f in FIGURES)
    text = f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>gearmesh: the paper's pair</title>
<meta name="viewport" content="width=device-width"><style>{STYLE}</style></head><body>
<h1>The gear pair of Palermo et al. (2013) through its FMU</h1>
<p>The first pictures are a run-up at a usual damping, the others the paper's simulations. Static curves come from <code>gearmesh solve</code>. Everything else is <code>palermo2013.fmu</code> (run-ups: the
unmodified pair) driven through fmpy: gear 1 turns as imposed, gear 2 turns on a rigid revolute joint and its inertia
is integrated outside the FMU; in the first pictures both turn freely. Everything on this page took {results.seconds:.0f} s.</p>
{figures}
<h2>The paper's numbers and ours</h2>
{_table(results)}
</body></html>
"""
    path = folder / "index.html"
    path.write_text(text, encoding="utf-8")
    return path
