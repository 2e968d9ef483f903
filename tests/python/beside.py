"""Threads that run, and signals that arrive, while compiled code runs; without clocks, so also on a busy machine."""

import signal
import sys
import threading
import time
from contextlib import contextmanager
from functools import partial

# A process or an answer that takes longer counts as hanging. This says nothing about speed.
HANGS = 600

# Longer than any test: a thread gets the interpreter when the other one releases it, not after a time.
NEVER = 1000.0


def wait_for(condition):
    """Check every hundredth of a second until the condition holds."""
    for _ in range(100 * HANGS):
        if condition():
            return
        time.sleep(0.01)
    raise TimeoutError("waited in vain")


class StoppedError(KeyboardInterrupt):
    """The signal was handled."""


@contextmanager
def beside(other):
    """Run `other` in a thread as soon as the body releases the interpreter lock, which pure Python code does not."""
    gate = threading.Lock()

    def wait():
        with gate:
            other()

    interval = sys.getswitchinterval()
    gate.acquire()
    thread = threading.Thread(target=wait)
    thread.start()
    sys.setswitchinterval(NEVER)
    gate.release()
    try:
        yield
    finally:
        thread.join()
        sys.setswitchinterval(interval)


class Handler:
    """Raises `StoppedError` at the first signal, if it arrives before the calls have ended."""

    def __init__(self):
        self.armed = True

    def __call__(self, *_):
        if self.armed:
            self.armed = False
            raise StoppedError

    def outcome(self, *calls):
        """'stopped' if the calls, made in order, notice a signal; 'finished' if they end without polling for it.

        `map` runs no bytecode between the calls nor before the division by zero: the interpreter cannot notice the
        signal for them.
        """
        try:
            list(map(partial.__call__, [*calls, partial(divmod, 1, 0)]))
        except StoppedError:
            return "stopped"
        except ZeroDivisionError:
            return "finished"
        finally:
            self.armed = False


@contextmanager
def handled():
    """Handle signals by a new handler."""
    handler = Handler()
    before = signal.signal(signal.SIGINT, handler)
    try:
        yield handler
    finally:
        handler.armed = False
        signal.signal(signal.SIGINT, before)


def stopped_while_it_runs(call):
    """The outcome of a call during which a signal arrives, after it has released the interpreter lock."""
    with handled() as handler, beside(partial(signal.raise_signal, signal.SIGINT)):
        return handler.outcome(call)
