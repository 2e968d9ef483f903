"""The environment of the benchmarks: the root of the project, the machine and its load."""

from __future__ import annotations

import os
import platform
import re
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def cores() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def machine() -> dict[str, str]:
    """Processor, system, load, and relevant environment variables."""
    found = {
        "processor": f"{_processor()}, {cores()} core(s)",
        "system": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        "load average, at the start": load(),
    }
    if forced := os.environ.get("OPENBLAS_CORETYPE"):
        found["`OPENBLAS_CORETYPE`"] = f"`{forced}` in the calling environment, unset for the run"
    return found


def sentence(facts: Mapping[str, str]) -> str:
    """The circumstances of a run as text."""
    text = "; ".join(f"{name}: {value}" for name, value in facts.items())
    return f"{text[0].upper()}{text[1:]}."


def load() -> str:
    """Load average over the last minute."""
    if not hasattr(os, "getloadavg"):
        return "unknown"
    return f"{os.getloadavg()[0]:.1f}"


def _processor() -> str:
    try:
        found = re.search(r"^model name\s*:\s*(.+)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    except OSError:
        found = None
    return found[1] if found else platform.processor() or platform.machine()
