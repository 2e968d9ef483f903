"""Environment variables and virtual environments of the timed processes."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path

REQUIREMENTS = Path(__file__).resolve().parent
INSTALL_SECONDS = 900


class UnavailableError(Exception):
    """A library cannot be timed here; the message says why."""


def child_environment(rayon_threads: int) -> dict[str, str]:
    """Variables of a timed process: one thread for all (rayon as requested), and OpenBLAS's own choice of kernel."""
    # OPENBLAS_CORETYPE forces a kernel, often a slower one than the processor supports. PYTHONPATH could add packages
    # from outside the virtual environment.
    kept = {key: value for key, value in os.environ.items() if key not in ("OPENBLAS_CORETYPE", "PYTHONPATH")}
    single = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NPROC"), "1")
    return {
        **kept,
        **single,
        "RAYON_NUM_THREADS": str(rayon_threads),
        # NPROC limits XLA's thread pool, the flags limit its matrix products.
        "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
        "JAX_PLATFORMS": "cpu",
        "GEOMSTATS_BACKEND": "numpy",
        "PYTHONWARNINGS": "ignore",
    }


def python_of(peer: str, venvs: Path) -> Path:
    """Interpreter of a library's own virtual environment, which is made if need be.

    Raises
    ------
    UnavailableError
        If the library does not install.
    """
    requirements = REQUIREMENTS / f"requirements-{peer}.txt"
    digest = hashlib.sha256(requirements.read_bytes()).hexdigest()
    home = venvs / peer
    python = home / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    stamp = home / "installed"
    if stamp.is_file() and stamp.read_text() == digest:
        return python
    install = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r", str(requirements)]
    for command in ([sys.executable, "-m", "venv", "--clear", str(home)], install):
        try:
            subprocess.run(command, check=True, capture_output=True, text=True, timeout=INSTALL_SECONDS)
        except subprocess.CalledProcessError as error:
            lines = [line for line in (error.stderr or error.stdout).splitlines() if line.strip()]
            raise UnavailableError(f"does not install: {lines[-1] if lines else error}") from error
        except (OSError, subprocess.TimeoutExpired) as error:
            raise UnavailableError(f"does not install: {error}") from error
    stamp.write_text(digest)
    return python
