"""The command `python -m tests.fuzz`."""

import argparse
import collections
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time

from . import case

# Boundary value problems that cannot be solved reach the work limit after about 25 s on St(9, 7), the largest shape
# drawn.
LIMIT = 60.0


def command(arguments):
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description="Random calls of every entry point.")
    parser.add_argument("--minutes", type=float, default=10.0, help="how long (default: 10)")
    parser.add_argument("--cases", type=int, default=2**62, help="how many at most")
    parser.add_argument("--seed", type=int, default=0, help="of the first case; the next ones follow (default: 0)")
    parser.add_argument(
        "--limit", type=float, default=LIMIT, help="seconds of the processor for one case (default: 60)"
    )
    parser.add_argument("--case", type=int, help="run the case of this seed alone, in this process, and print it")
    return parser.parse_args(arguments)


def one(seed):
    made = case.Case(random.Random(seed), lambda line: print(line, flush=True))
    case.elsewhere(made)
    print("outcome:", made.outcome)
    for finding in made.found:
        print("FOUND", finding)
    return 1 if made.found else 0


def search(first, cases, seconds, limit, report=print):
    """Run workers until time or cases are used up; return [(seed, what)], the number of cases, the slow ones."""
    found, slow, seed, last = [], [], first, first + cases
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0 and seed < last:
        begun, finished = seed - 1, False
        with tempfile.TemporaryFile("w+") as errors:
            words = [sys.executable, "-m", "tests.fuzz.worker", str(seed), str(left), str(limit), str(last)]
            # One thread unless a call asks for more: idle threads cost processor time.
            single = os.environ | {"RAYON_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
            with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=errors, text=True, env=single) as worker:
                for line in worker.stdout:
                    what, number, *text = line.split(" ", 2)
                    if what == "begin":
                        begun = int(number)
                    elif what == "done":
                        finished, begun = True, int(number) - 1
                    else:
                        (found if what == "found" else slow).append((int(number), json.loads(text[0])))
                        report(f"{what} {number}: {json.loads(text[0])}")
            code = worker.returncode
            errors.seek(0)
            said = errors.read()
        if not finished:
            hung = "Timeout (" in said or code == -getattr(signal, "SIGPROF", 0)
            kind = "hang" if hung and code else f"process ended with code {code}"
            found.append((begun, f"{kind}\n{said[-3000:]}"))
            report(f"found {begun}: {found[-1][1]}")
            if begun < seed:
                break
        seed = begun + 1
    return found, seed - first, slow


def main(arguments=None):
    options = command(arguments)
    if options.case is not None:
        return one(options.case)
    start = time.monotonic()
    found, count, slow = search(
        options.seed, options.cases, 60 * options.minutes, options.limit, lambda x: print(x, flush=True)
    )
    seeds = sorted({seed for seed, _ in found})
    print(f"{count} cases in {time.monotonic() - start:.0f} s, {len(seeds)} with findings, {len(slow)} above a second")
    for what, number in collections.Counter(text.split("\n")[0][:100] for _, text in found).most_common():
        print(f"{number:6d} {what}")
    for seed in seeds[:50]:
        print(f"again: python -m tests.fuzz --case {seed}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
