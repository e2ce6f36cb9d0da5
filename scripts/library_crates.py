"""Code of the FMU's library by the crate it comes from, for docs/data/library-crates.csv.

    cargo build --release --package gearmesh
    python scripts/library_crates.py target/release/libgearmesh.so

Reads the symbols by binutils' nm, so the library must not be stripped. Code that a generic function of one crate
gives for the types of another one counts for the first.
"""

import re
import subprocess
import sys
from collections import Counter

# Of Rust itself: the standard library, and what reads its own line tables when a panic is told.
STANDARD = {
    "core", "alloc", "std", "std_detect", "hashbrown", "gimli", "addr2line", "object", "miniz_oxide", "memchr",
    "rustc_demangle", "panic_unwind", "compiler_builtins", "__rustc",
}  # fmt: skip
# Address, size, kind, name; t is code, w code that may stand twice.
SYMBOL = re.compile(r"[0-9a-f]+ ([0-9a-f]+) [tTwW] (.*)")
# The crate before the first ::, behind what an implementation stands in.
CRATE = re.compile(r"^[<&\[(]*(?:mut |dyn |\*const |\*mut )*([a-z_][a-z_0-9]*)::")


def bytes_by_crate(library):
    """Bytes of code by crate; those of the interface, whose names have none, are the project's own."""
    listing = subprocess.run(["nm", "-S", "-C", library], check=True, capture_output=True, text=True).stdout
    found = Counter()
    for line in listing.splitlines():
        if symbol := SYMBOL.match(line):
            size, name = int(symbol[1], 16), symbol[2]
            crate = CRATE.match(name)
            if name.startswith("fmi2"):
                found["gearmesh"] += size
            elif crate:
                found["Rust's standard library" if crate[1] in STANDARD else crate[1]] += size
            else:
                found["of no name"] += size
    return found


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    found = bytes_by_crate(sys.argv[1])
    if not found:
        sys.exit(f"{sys.argv[1]} has no symbols; build it as said above")
    print('crate,"code, kB"')
    for crate, size in found.most_common():
        if size >= 1000:
            print(f"{crate},{size / 1000:.0f}")
    print(f"all,{sum(found.values()) / 1000:.0f}")


if __name__ == "__main__":
    main()
