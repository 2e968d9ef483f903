"""Summary of skipped tests: one line per missing tool or other reason, not one per test."""

import re
from collections import Counter

# Messages of pytest.importorskip and of the tests in this folder.
MISSING = [re.compile(text) for text in (r"could not import '(\w+)", r"not installed: (.+)", r"(.+) is not installed")]


def missing(reason):
    """Missing tools that a reason names; empty for other reasons."""
    found = [pattern.match(reason) for pattern in MISSING]
    return next((match[1].split(", ") for match in found if match), [])


def lines(reasons):
    """Lines of the summary, missing tools first, with the number of tests."""
    tools = Counter(tool for reason in reasons for tool in missing(reason))
    others = Counter(reason for reason in reasons if not missing(reason))
    return [
        f"{start}: {name} ({count} {'test' if count == 1 else 'tests'})"
        for start, counter in (("not installed", tools), ("skipped", others))
        for name, count in sorted(counter.items())
    ]


def reasons(reports):
    """Reasons of pytest's reports of skipped tests."""
    return [report.longrepr[2].removeprefix("Skipped: ") for report in reports]
