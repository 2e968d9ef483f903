"""Runs cases one after another and announces each: `python -m tests.fuzz.worker FIRST SECONDS LIMIT`.

A line `begin SEED` precedes each case, and `found SEED TEXT` follows a case that failed. So the seed is known even if a
signal or the watchdog stops the process.
"""

import faulthandler
import json
import os
import signal
import sys
import tempfile
import time

import numpy as np

from . import case

SLOW = 1.0
# How far the wall clock may run ahead of this process on a busy machine.
PATIENCE = 60.0


def watch(limit):
    """End the process after `limit` seconds of processor time, or a longer wall time; never if 0."""
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_PROF, limit)
    if limit:
        faulthandler.dump_traceback_later(PATIENCE * limit, exit=True)
    else:
        faulthandler.cancel_dump_traceback_later()


def work(first, seconds, limit, last):
    np.seterr(all="ignore")
    if hasattr(signal, "SIGPROF"):
        faulthandler.register(signal.SIGPROF, chain=True)
    end = time.monotonic() + seconds
    seed = first
    while time.monotonic() < end and seed < last:
        print("begin", seed, flush=True)
        watch(limit)
        start = time.process_time()
        made = case.run(seed)
        for finding in made.found:
            print("found", seed, json.dumps(str(finding)), flush=True)
        if (took := time.process_time() - start) > SLOW:
            print("slow", seed, json.dumps(f"{took:.1f} s: {made.trace[-1][:300]}"), flush=True)
        seed += 1
    watch(0.0)
    print("done", seed, flush=True)


if __name__ == "__main__":
    # Curves are saved under any name, in a temporary folder.
    with tempfile.TemporaryDirectory() as folder:
        here = os.getcwd()
        os.chdir(folder)
        work(int(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4]))
        os.chdir(here)
