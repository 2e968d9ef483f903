"""``python -m stiefel_rs``: the same as the command ``stiefel-rs``."""

import sys

from .cli import main

if __name__ == "__main__":
    sys.exit(main())
