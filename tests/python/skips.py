"""The end of a report: one line for each reason why tests were skipped, however many tests and files that are."""

import re
from collections import Counter

# How pytest says it, and the tests of this folder.
MISSING = [re.compile(text) for text in (r"could not import '(\w+)", r"not installed: (.+)", r"(.+) is not installed")]


def missing(reason):
    """The tools that are missing by a reason, none if it is another one."""
    found = [pattern.match(reason) for pattern in MISSING]
    return next((match[1].split(", ") for match in found if match), [])


def lines(reasons):
    """One line for each missing tool, then one for each other reason, with the number of tests."""
    tools = Counter(tool for reason in reasons for tool in missing(reason))
    others = Counter(reason for reason in reasons if not missing(reason))
    return [
        f"{start}: {name} ({count} {'test' if count == 1 else 'tests'})"
        for start, counter in (("not installed", tools), ("skipped", others))
        for name, count in sorted(counter.items())
    ]


def reasons(reports):
    """Why each of pytest's reports of skipped tests was skipped."""
    return [report.longrepr[2].removeprefix("Skipped: ") for report in reports]
