"""The command line of the page."""

from __future__ import annotations

import argparse
import sys
import webbrowser
from pathlib import Path
from typing import Any, Final

from tqdm import tqdm  # type: ignore[import-untyped]

from .. import storage
from . import grid, page
from .kinds import FIRST, KINDS
from .server import Server

DESCRIPTION: Final = """\
Drag keyframes or end velocities in the browser, and see the curves follow: splines through points and rotations beside
slerp, the exact Riemannian cubic beside the geometric cubic. A server of this machine alone computes them; Ctrl-C ends
it. With --static a page is written that needs no server: velocities snap to a grid that was computed before.
"""
DEFAULT_FILE: Final = Path("explore.html")


def _port(text: str) -> int:
    if text.isascii() and text.isdigit() and int(text) <= 65535:
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is not a port: a whole number from 0 to 65535")


def add_parser(commands: Any) -> None:
    """Add the command to the subparsers of another."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "explore", help="drag keyframes and velocities of curves in the browser", description=DESCRIPTION
    )
    parser.add_argument("--kind", choices=tuple(KINDS), default=FIRST, help=f"what is shown first (default: {FIRST})")
    parser.add_argument("--static", action="store_true", help="write a page that needs no server")
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help=f"where that goes (default: {DEFAULT_FILE}); implies --static"
    )
    parser.add_argument("--port", type=_port, help="port of the server (default: 0, one that is free)")
    parser.add_argument("--no-browser", action="store_true", help="print the address, open no browser")
    parser.set_defaults(check=lambda arguments: _check(parser, arguments))


def _check(parser: argparse.ArgumentParser, arguments: argparse.Namespace) -> None:
    """Refuse options that would be without effect."""
    if arguments.out is not None:
        arguments.static = True
    if arguments.static and (arguments.port is not None or arguments.no_browser):
        parser.error("--port and --no-browser go with a server, not with --static or --out")


def write(path: Path, kind: str) -> None:
    """Write the page without a server; a file that is there is replaced once the new one is whole."""
    nodes, quiet = sum(map(grid.size, grid.AXES)), not sys.stderr.isatty()
    # Opened before the work, which would be in vain where nothing can be written.
    with storage.replacing(path) as file, tqdm(total=nodes, disable=quiet, desc="explore", leave=False) as bar:
        file.write(page.static(kind, bar.update).encode())


def _serve(kind: str, port: int, open_browser: bool) -> None:
    with Server(kind, port) as server:
        try:
            print(f"{server.url}\nCtrl-C ends it", flush=True)
            if open_browser:
                webbrowser.open(server.url)
            server.serve_forever()
        except KeyboardInterrupt:
            print("stopped")


def run(arguments: argparse.Namespace) -> int:
    """Do what the command line says and return the exit code."""
    if arguments.static:
        path = arguments.out or DEFAULT_FILE
        write(path, arguments.kind)
        print(f"page: {path}")
    else:
        _serve(arguments.kind, arguments.port or 0, not arguments.no_browser)
    return 0
