"""Instructions per evaluation of kernels and element, counted by valgrind: the same on a noisy machine.

    python scripts/callgrind.py [--record]

Counts each case of `target/release/instructions` twice, with N and 2 N evaluations; the
difference over N is free of start-up. Compares with benches/instructions.json and fails if a case got more
than 3 % worse; `--record` writes that file. Counts belong to a compiler version: under another one than the
recorded one they are printed but not judged. The recorded ones are those of a processor with AVX.
"""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

PROGRAM = Path("target/release/instructions")
RECORD = Path("benches/instructions.json")
EVALUATIONS = 2048
TOLERANCE = 0.03


def total(case, times):
    """Instructions of a whole run."""
    run = subprocess.run(
        ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", PROGRAM, case, str(times)],
        capture_output=True,
        text=True,
        check=True,
    )
    return int(re.search(r"Collected : (\d+)", run.stderr).group(1))


def main(record):
    if shutil.which("valgrind") is None:
        print("skipped: no valgrind on this machine (Debian: apt install valgrind)")
        return 0
    compiler = subprocess.run(["rustc", "--version"], capture_output=True, text=True, check=True)
    compiler = compiler.stdout.strip()
    cases = subprocess.run([PROGRAM], capture_output=True, text=True, check=True).stdout.split()
    known = json.loads(RECORD.read_text()) if RECORD.exists() else {"compiler": None, "counts": {}}
    judged = known["compiler"] == compiler and not record
    counts, worse = {}, []
    for case in cases:
        counts[case] = round((total(case, 2 * EVALUATIONS) - total(case, EVALUATIONS)) / EVALUATIONS)
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
    raise SystemExit(main("--record" in sys.argv))
