"""The source keeps to the rules of CONTRIBUTING.md: layers, names, sizes of files."""

import re
from collections import defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = sorted((ROOT / "src").rglob("*.rs"))

pytestmark = pytest.mark.skipif(not SOURCES, reason="the source is not here")

LONGEST = 500


def rooms():
    """Files and folders of the map, in its order."""
    table = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").split("## Map of the source")[1]
    rows = re.findall(r"^\| \d \| ([^|]*) \|", table, re.MULTILINE)
    return [path.rstrip("/") for row in rows for path in re.findall(r"`(src/[^`]*)`", row.split(", on ")[0])]


def imported(text):
    """Modules below `crate` that a file names, as paths."""
    text = re.sub(r"^\s*//.*$", "", text, flags=re.MULTILINE)
    text = re.split(r"#\[cfg\(test\)\]\n(?:pub\S* )?mod \w+ \{", text)[0]
    # No groups of rooms, and no types of the root, which would hide the room.
    assert not re.search(r"\bcrate::[{A-Z]", text)
    return set(re.findall(r"\bcrate::([a-z_]+)::", text))


def test_a_file_imports_only_from_rooms_above_it_in_the_map():
    order = rooms()

    def row(path):
        inside = [i for i, room in enumerate(order) if path == room or path.startswith(room + "/")]
        return max(inside, key=lambda i: len(order[i])) if inside else None

    wrong, checked = [], 0
    for source in SOURCES:
        path = source.relative_to(ROOT).as_posix()
        here = row(path)
        if here is None or path.endswith("tests.rs"):
            continue
        for module in imported(source.read_text(encoding="utf-8")):
            name = f"src/{module}" if (ROOT / "src" / module).is_dir() else f"src/{module}.rs"
            there = row(name)
            checked += there is not None
            if there is not None and there > here:
                wrong.append(f"{path} imports {name}")
    assert checked > 500
    assert not wrong, wrong


def test_no_two_types_share_a_name():
    # Associated types are indented; inside modules of tests names are private.
    names = defaultdict(list)
    for source in SOURCES:
        text = source.read_text(encoding="utf-8")
        for name in re.findall(r"^(?:pub(?:\([^)]*\))? )?(?:struct|enum|trait|type) (\w+)", text, re.MULTILINE):
            names[name].append(source.relative_to(ROOT).as_posix())
    assert len(names) > 500
    assert not {name: files for name, files in names.items() if len(files) > 1}


def test_no_file_is_longer_than_500_lines():
    folders = ["src", "python", "tests", "benches", "benchmarks", "examples", "tools", "website"]
    lines = {
        path.relative_to(ROOT).as_posix(): len(path.read_text(encoding="utf-8").splitlines())
        for folder in folders
        for path in (ROOT / folder).rglob("*")
        if path.suffix in {".rs", ".py"} and path.is_file() and not path.name.startswith(".")
    }
    assert len(lines) > 800
    assert not {path: count for path, count in lines.items() if count > LONGEST}
