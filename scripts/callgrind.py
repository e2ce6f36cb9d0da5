"""Instructions per evaluation of kernels, element and contact at run time, counted by valgrind: the same on a noisy machine.

    python scripts/callgrind.py [--record]

Counts each case of `target/release/instructions` twice, with N and 2 N evaluations; the
difference over N is free of start-up. Compares with benches/instructions.json and fails if a case got more
than 3 % worse; `--record` writes that file. Counts belong to a compiler version: under another one than the
recorded one they are printed but not judged. The recorded ones are those of a processor with AVX.

Valgrind 3.19 knows `vmovq` between registers in one of its two forms only. In a copy of the program, which is what is counted,
`vmovaps` stands for the other: as long, and different in the upper half of the register, which code with one number in it
does not use.
"""

import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

PROGRAM = Path("target/release/instructions")
RECORD = Path("benches/instructions.json")
EVALUATIONS = 2048
TOLERANCE = 0.03


def countable(program, copy):
    """Writes a copy of the program that valgrind can run."""
    code = bytearray(program.read_bytes())
    listing = subprocess.run(["objdump", "-d", "-F", program], capture_output=True, text=True, check=True).stdout
    offset = 0
    for line in listing.splitlines():
        if function := re.match(r"([0-9a-f]+) <.*> \(File Offset: 0x([0-9a-f]+)\):", line):
            offset = int(function[2], 16) - int(function[1], 16)
        elif vmovq := re.match(r" *([0-9a-f]+):\tc5 [7f]9 d6 [c-f][0-9a-f] ", line):
            at = offset + int(vmovq[1], 16)
            code[at + 1] -= 1
            code[at + 2] = 0x29
    copy.write_bytes(code)
    copy.chmod(0o755)


def total(program, case, times):
    """Instructions of a whole run."""
    run = subprocess.run(
        ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, case, str(times)],
        capture_output=True,
        text=True,
        check=True,
    )
    return int(re.search(r"Collected : (\d+)", run.stderr).group(1))


def main(record, folder):
    if shutil.which("valgrind") is None:
        print("skipped: no valgrind on this machine (Debian: apt install valgrind)")
        return 0
    compiler = subprocess.run(["rustc", "--version"], capture_output=True, text=True, check=True)
    compiler = compiler.stdout.strip()
    cases = subprocess.run([PROGRAM], capture_output=True, text=True, check=True).stdout.split()
    known = json.loads(RECORD.read_text()) if RECORD.exists() else {"compiler": None, "counts": {}}
    judged = known["compiler"] == compiler and not record
    program = Path(folder) / PROGRAM.name
    countable(PROGRAM, program)
    counts, worse = {}, []
    for case in cases:
        counts[case] = round((total(program, case, 2 * EVALUATIONS) - total(program, case, EVALUATIONS)) / EVALUATIONS)
        before = known["counts"].get(case)
        change = "" if before is None else f"{100 * (counts[case] / before - 1):+.1f} %"
        print(f"{case:55} {counts[case]:8} {change}", flush=True)
        if judged and before is not None and counts[case] > (1 + TOLERANCE) * before:
            worse.append(case)
    if record:
        unfinished = RECORD.with_suffix(".unfinished")
        unfinished.write_text(json.dumps({"compiler": compiler, "counts": counts}, indent=2) + "\n")
        unfinished.rename(RECORD)
    elif not judged:
        print(f"not judged: recorded with {known['compiler']}, this is {compiler}")
    if worse:
        print(f"more than {100 * TOLERANCE:.0f} % worse: {', '.join(worse)}")
    return 1 if worse else 0


if __name__ == "__main__":
    if sys.argv[1:] not in ([], ["--record"]):
        raise SystemExit(__doc__)
    with tempfile.TemporaryDirectory() as folder:
        raise SystemExit(main("--record" in sys.argv, folder))
