"""Communication with a timed process."""

from __future__ import annotations

import json
import selectors
import subprocess
import tempfile
from pathlib import Path
from types import TracebackType
from typing import Any

from benchmarks.compare.virtual_environments import UnavailableError, child_environment
from benchmarks.environment import ROOT

# The first answer takes the time of imports; every other that of one call, including compilation, which takes heyoka
# minutes on a busy machine.
ANSWER_SECONDS = 600.0


class LostError(UnavailableError):
    """The process ended, or does not respond."""


class Worker:
    """A process that runs `benchmarks.compare.peers.<module>` and answers requests (see `protocol`)."""

    def __init__(self, python: Path, module: str, rayon_threads: int = 1) -> None:
        self._messages = tempfile.TemporaryFile(mode="w+")
        self._process = subprocess.Popen(
            [str(python), "-m", f"benchmarks.compare.peers.{module}", "--serve"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._messages,
            text=True,
            cwd=ROOT,
            env=child_environment(rayon_threads),
        )
        try:
            self.info = self.ask("info")
        except UnavailableError:
            self.close()
            raise

    def ask(self, do: str, **request: Any) -> dict[str, Any]:
        """One request and its answer.

        Raises
        ------
        UnavailableError
            If the call failed; `LostError` if it took too long or ended the process.
        """
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps({"do": do, **request}) + "\n")
            self._process.stdin.flush()
        except OSError as error:
            raise LostError(self._last_words()) from error
        answer: dict[str, Any] = json.loads(self._line(request.get("name", do)))
        if not answer["ok"]:
            raise UnavailableError(answer["error"])
        return answer

    def _line(self, what: str) -> str:
        assert self._process.stdout is not None
        with selectors.DefaultSelector() as selector:
            selector.register(self._process.stdout, selectors.EVENT_READ)
            if not selector.select(ANSWER_SECONDS):
                self._process.kill()
                raise LostError(f"no answer to {what} within {ANSWER_SECONDS:.0f} s")
        line = self._process.stdout.readline()
        if not line:
            raise LostError(self._last_words())
        return line

    def _last_words(self) -> str:
        self._process.wait()
        self._messages.seek(0)
        lines = [line.strip() for line in self._messages if line.strip()]
        return lines[-1] if lines else f"the process ended with code {self._process.returncode}"

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.communicate()
        self._messages.close()

    def __enter__(self) -> Worker:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
