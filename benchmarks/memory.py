"""Memory of this process, as reported by the kernel."""

from __future__ import annotations

import re
from pathlib import Path


def resident(key: str) -> int:
    """Bytes; the key is that of `/proc/self/status`, `VmRSS` for now and `VmHWM` for the peak."""
    found = re.search(rf"{key}:\s*(\d+) kB", Path("/proc/self/status").read_text())
    assert found is not None
    return 1024 * int(found[1])
