"""The README's Python example runs unchanged."""

import re
from pathlib import Path

README = Path(__file__).parents[2] / "README.md"


def test_readme_example_runs():
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert len(blocks) == 1, f"one Python block expected, found {len(blocks)}"
    exec(compile(blocks[0], str(README), "exec"), {})


def test_readme_is_short():
    lines = README.read_text(encoding="utf-8").count("\n")
    assert lines < 150, f"{lines} lines"
