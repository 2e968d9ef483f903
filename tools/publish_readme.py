"""Give the README absolute addresses of its links and images, as registries need: ``publish_readme.py``.

The address is `repository` in Cargo.toml, and the tag that of its version. Without an address nothing changes.
"""

import re

from tools.version import ROOT, first

# Links and images of Markdown whose target is a path of the repository.
TARGET = re.compile(r"(?P<image>!?)\[(?P<text>[^\]]*)\]\((?!https?://|#)(?P<path>[^)\s]+)\)")


def absolute(text: str, repository: str, tag: str) -> str:
    """The text with absolute addresses: images as files, everything else as pages of the forge."""

    def replaced(link: re.Match[str]) -> str:
        kind = "raw" if link["image"] else "blob"
        return f"{link['image']}[{link['text']}]({repository.rstrip('/')}/{kind}/{tag}/{link['path']})"

    return TARGET.sub(replaced, text)


def main() -> None:
    """Rewrite README.md of the project in place."""
    repository = first(r'^repository = "(.*)"$', "Cargo.toml")
    if repository == "none":
        print("Cargo.toml has no repository: the README keeps its relative links")
        return
    path = ROOT / "README.md"
    version = first(r'^version = "(.*)"$', "Cargo.toml")
    path.write_text(absolute(path.read_text(encoding="utf-8"), repository, f"v{version}"), encoding="utf-8")


if __name__ == "__main__":
    main()
