"""Licence texts of the crates that the FMU's library links, for documentation/licenses in every FMU.

Run `make licenses` after a change of the dependencies; `python scripts/licenses.py --check` fails where the file
is not that of today's Cargo.lock. `--command FILE` writes the texts for the command with its many more crates, which
a release brings.
"""

import hashlib
import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "resources" / "documentation" / "third-party.txt"
# Nothing that only builds or tests.
TREE = ["tree", "--locked", "--edges", "normal,no-proc-macro", "--prefix", "none", "--format", "{p}"]
LIBRARY = ["--package", "gearmesh"]
# On whatever platform.
COMMAND = ["--package", "gearmesh-command", "--target", "all"]
NAMES = ("LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE")


def cargo(*arguments):
    return subprocess.run(["cargo", *arguments], cwd=ROOT, check=True, capture_output=True, text=True).stdout


def linked(selection):
    """(name, version) of every crate in the library or the command but our own."""
    lines = cargo(*TREE, *selection).split("\n")
    found = {tuple(line.split()[:2]) for line in lines if line}
    return sorted((name, version[1:]) for name, version in found if not name.startswith("gearmesh"))


def texts(folder, terms):
    """Name and text of the licence files; where MIT is one of a choice, that one alone."""
    files = sorted(p for p in folder.iterdir() if p.name.upper().startswith(NAMES) and p.is_file())
    chosen = [p for p in files if "MIT" in p.name.upper() and "MIT0" not in p.name.upper()]
    if chosen and " OR " in terms and " AND " not in terms:
        files = chosen
    return [(p.name, p.read_text(encoding="utf-8", errors="replace").strip()) for p in files]


def page(selection, what):
    metadata = json.loads(cargo("metadata", "--locked", "--format-version", "1"))
    packages = {(p["name"], p["version"]): p for p in metadata["packages"]}
    heads, bodies = [], {}
    for key in linked(selection):
        package = packages[key]
        references = []
        for name, text in texts(Path(package["manifest_path"]).parent, package["license"]):
            digest = hashlib.sha256(" ".join(text.split()).encode()).hexdigest()
            number = bodies.setdefault(digest, (len(bodies) + 1, text))[0]
            references.append(f"{name}: text {number}")
        heads.append(
            f"{key[0]} {key[1]}, {package['license']}, {package['repository'] or 'no address'}\n"
            f"    {', '.join(references) or 'no text in the crate: the terms named are those of the SPDX list'}"
        )
    out = f"Crates in this {what}, beside Rust's standard library (MIT or Apache-2.0, rust-lang.org), and the\n"
    out += "headers of the FMI standard (BSD 2-clause, fmi-standard.org). Of a choice of licences any one will do.\n\n"
    out += "\n".join(heads) + "\n"
    for number, text in bodies.values():
        out += f"\n{'=' * 20} text {number} {'=' * 20}\n\n{text}\n"
    return out


def main():
    if sys.argv[1:2] == ["--command"]:
        Path(sys.argv[2]).write_text(page(COMMAND, "program"), encoding="utf-8")
        return
    text = page(LIBRARY, "FMU's library")
    if "--check" in sys.argv[1:]:
        if OUT.read_text(encoding="utf-8") != text:
            sys.exit(f"{OUT.relative_to(ROOT)} is not that of Cargo.lock: run `make licenses`")
        return
    OUT.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
