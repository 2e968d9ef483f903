"""Threads that run while compiled code runs, and signals that arrive then: without clocks, so on a busy machine too."""

import signal
import sys
import threading
import time
from contextlib import contextmanager
from functools import partial

# A process or an answer that is waited for longer hangs. No statement on speed.
HANGS = 600

# Longer than any test: a thread gets the interpreter where the other one gives it up, not after a time.
NEVER = 1000.0


def wait_for(condition):
    """Look every hundredth of a second until the condition holds."""
    for _ in range(100 * HANGS):
        if condition():
            return
        time.sleep(0.01)
    raise TimeoutError("waited in vain")


class StoppedError(KeyboardInterrupt):
    """The signal was handled."""


@contextmanager
def beside(other):
    """Run `other` in a thread as soon as the body gives the interpreter lock up, which Python code does not."""
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
    """Raises `StoppedError` at the first signal, if that comes before the calls have ended."""

    def __init__(self):
        self.armed = True

    def __call__(self, *_):
        if self.armed:
            self.armed = False
            raise StoppedError

    def outcome(self, *calls):
        """'stopped' if the calls, one after the other, notice a signal; 'finished' if they end without a look at it.

        `map` runs no bytecode between the calls nor before the division by zero: the interpreter cannot notice the
        signal in their place.
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
    """The outcome of a call during which a signal arrives: once it has given up the interpreter lock."""
    with handled() as handler, beside(partial(signal.raise_signal, signal.SIGINT)):
        return handler.outcome(call)
