"""The command ``stiefel-rs``."""

from __future__ import annotations

import argparse
import os
import platform
import sys
from typing import Final

import numpy as np

from . import __version__, _core, explore, interpolate
from .reproduce import command as reproduce

EXIT_FAILURE: Final = 1
EXIT_INTERRUPTED: Final = 130
# The exit code that a shell gives a program that ended with SIGPIPE.
EXIT_BROKEN_PIPE: Final = 141


def parser() -> argparse.ArgumentParser:
    """Build the argument parser of the command."""
    top = argparse.ArgumentParser(prog="stiefel-rs", description="Smooth curves on Stiefel manifolds.")
    top.add_argument("--version", action="version", version=f"stiefel-rs {__version__}")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    reproduce.add_parser(commands)
    interpolate.add_parser(commands)
    explore.add_parser(commands)
    commands.add_parser("info", help="versions, threads and CPU features")
    return top


def info() -> int:
    """Print versions, threads and CPU features."""
    lines = {
        "stiefel-rs": __version__,
        "Python": platform.python_version(),
        "NumPy": np.__version__,
        "platform": platform.platform(),
        "threads": _core.num_threads(),
        "SIMD": " ".join(_core.simd_features()) or "none",
    }
    for name, value in lines.items():
        print(f"{name + ':':<12}{value}")
    return 0


def _run(argv: list[str] | None) -> int:
    arguments = parser().parse_args(argv)
    match arguments.command:
        case "info":
            return info()
        case "interpolate":
            arguments.check(arguments)
            return interpolate.run(arguments)
        case "explore":
            arguments.check(arguments)
            return explore.run(arguments)
        case _:
            return reproduce.run(arguments)


def _unwritten(error: OSError) -> int:
    """Report what could not be read or written: a file by its name, or the standard output."""
    if error.filename is None:
        # Otherwise Python tries to write the rest of the output at exit, and fails with a traceback.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            return EXIT_BROKEN_PIPE
    print(f"stiefel-rs: {error.filename or 'standard output'}: {error.strerror or error}", file=sys.stderr)
    return EXIT_FAILURE


def main(argv: list[str] | None = None) -> int:
    """Run the command line `argv` (default: ``sys.argv``) and return its exit code."""
    try:
        try:
            return _run(argv)
        finally:
            # Flushed here, where a failure can be reported. There is no output if it was closed.
            if sys.stdout is not None:
                sys.stdout.flush()
    except KeyboardInterrupt:
        print("stiefel-rs: interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED
    except OSError as error:
        return _unwritten(error)
