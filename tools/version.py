"""Check that a tag is the version of the crate, of the changelog and of the citation: ``version.py v1.2.3``."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def first(pattern: str, name: str) -> str:
    """The first group of the first match in a file of the project."""
    found = re.search(pattern, (ROOT / name).read_text(encoding="utf-8"), flags=re.MULTILINE)
    return found[1] if found else "none"


def problems_of(tag: str) -> list[str]:
    """Versions that do not agree with the tag."""
    versions = {
        "tag": tag.removeprefix("v"),
        "Cargo.toml": first(r'^version = "(.*)"$', "Cargo.toml"),
        "CITATION.cff": first(r"^version: (.*)$", "CITATION.cff"),
        # With its date: a version that is not released yet has none.
        "CHANGELOG.md": first(r"^## \[(\d.*)\] - \d{4}-\d\d-\d\d$", "CHANGELOG.md"),
    }
    expected = versions["Cargo.toml"]
    return [f"{name}: {found}, not {expected}" for name, found in versions.items() if found != expected]


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: version.py TAG")
    sys.exit("\n".join(problems_of(sys.argv[1])))
