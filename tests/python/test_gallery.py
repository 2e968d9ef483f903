"""`examples/gallery.py` tells which example has run while it writes the page of the gallery."""

import json
import re
from pathlib import Path

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_examples_are_named_when_they_are_done(tmp_path, capsys, monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)
    import gallery  # noqa: PLC0415

    names = ["grand_tour", "attitude"]
    monkeypatch.setattr(gallery, "EXAMPLES", {name: gallery.EXAMPLES[name] for name in names})
    numbers = gallery.run_all(tmp_path)
    # In the order of the page, whichever is done first.
    assert list(numbers) == names
    assert len(list(tmp_path.iterdir())) == 2
    assert numbers["attitude"]["cost"] > 0 and json.dumps(numbers)
    first, second = capsys.readouterr().out.splitlines()
    assert {re.fullmatch(r"[12] of 2: (\w+), \d+ s", line)[1] for line in (first, second)} == set(names)
    assert (first[0], second[0]) == ("1", "2")
