"""Seconds from Ctrl-C to the exception: `python -m benchmarks.interrupts --busy 4`.

Every call of `interrupt_calls.py` runs repeatedly in a separate process and is interrupted after a random time. The
columns are the longest time from the signal to KeyboardInterrupt, and the processor time that the abandoned work takes
afterwards. `--busy` starts processes that only compute. Fails if an entry of the first column exceeds one second.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import time
from typing import Final

from .interrupt_calls import CALLS, LARGE

LIMIT: Final = 1.0
# The signal arrives between the start of the call and this many seconds later.
LATEST: Final = 2.0
# Abandoned work that takes longer is not waited for.
PATIENCE: Final = 20.0
ALL: Final = CALLS | LARGE
BUSY: Final = "while True: pass"


def child(name: str) -> None:
    """Run a call until Ctrl-C, and report when it arrived."""
    call = ALL[name]()
    print("ready", flush=True)
    try:
        while True:
            call()
    except KeyboardInterrupt:
        print(time.monotonic(), flush=True)
    print(abandoned(), flush=True)
    os._exit(0)


def abandoned() -> float:
    """Processor time of the process until it is idle."""
    start = last = time.process_time()
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        time.sleep(0.3)
        now = time.process_time()
        if now - last < 0.01:
            break
        last = now
    return last - start


def interrupt(name: str, delay: float) -> tuple[float, float]:
    """Seconds to the exception, and of abandoned work."""
    command = [sys.executable, "-m", "benchmarks.interrupts", "--child", name]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        if process.stdout.readline() != "ready\n":
            raise RuntimeError(f"{name}: the process ended too early")
        time.sleep(delay)
        sent = time.monotonic()
        process.send_signal(signal.SIGINT)
        seen, rest = map(float, process.stdout.read().split())
    return seen - sent, rest


def table(names: list[str], repeat: int, seed: int) -> float:
    """Print one line per call; return the longest time."""
    rng, longest = random.Random(seed), 0.0
    print(f"{'call':22} {'seconds':>8} {'abandoned':>10}")
    for name in names:
        found = [interrupt(name, rng.uniform(0.0, LATEST)) for _ in range(repeat)]
        seconds, rest = map(max, zip(*found, strict=True))
        print(f"{name:22} {seconds:8.2f} {rest:10.2f}", flush=True)
        longest = max(longest, seconds)
    return longest


def main(arguments: list[str] | None = None) -> int:
    """Measure, and return whether all times are below the limit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--busy", type=int, default=0, help="processes that compute beside it")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="*", choices=list(ALL), default=list(ALL))
    parser.add_argument("--child", choices=list(ALL), help=argparse.SUPPRESS)
    given = parser.parse_args(arguments)
    if given.child:
        child(given.child)
    # A shell that starts a job in the background makes it ignore Ctrl-C, and children inherit that.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    load = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(given.busy)]
    try:
        longest = table(given.only, given.repeat, given.seed)
    finally:
        for process in load:
            process.kill()
            process.wait()
    print(f"longest: {longest:.2f} s, limit {LIMIT:.0f} s")
    return int(longest > LIMIT)


if __name__ == "__main__":
    sys.exit(main())
