"""`python -m demo`: makes the FMUs of the paper's pair, repeats its simulations and writes a page."""

from __future__ import annotations

import argparse
from pathlib import Path

from . import comparison, figures, page
from .results import compute

ROOT = Path(__file__).resolve().parents[1]


def main() -> None:
    """Parses the arguments and runs everything."""
    parser = argparse.ArgumentParser(prog="python -m demo", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "target" / "demo", help="folder for all files")
    parser.add_argument("--docs", type=Path, help="folder of the pages, whose numbers and pictures are then written, too")
    parser.add_argument("--refinement", help="of the finite elements, as of `gearmesh solve`")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    model = {"cache_dir": arguments.out / "cache", "refinement": arguments.refinement}
    results = compute(ROOT, arguments.out, model)
    figures.draw_all(results, arguments.out)
    index = page.write(results, arguments.out)
    if arguments.docs is not None:
        comparison.write_docs(results, arguments.docs)
    print(f"The FMU is {arguments.out / 'palermo2013.fmu'}; open {index} in a browser.")


if __name__ == "__main__":
    main()
