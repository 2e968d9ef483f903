"""Check the licences of all crates in ``Cargo.lock`` against the list in ``deny.toml``, without a network.

``cargo deny check`` does this too, and looks up advisories, for which it needs their database.
"""

import ast
import json
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[1]
REGISTRY = "registry+https://github.com/rust-lang/crates.io-index"


def allowed_licences() -> set[str]:
    """The list ``allow`` of ``deny.toml``."""
    text = (ROOT / "deny.toml").read_text(encoding="utf-8")
    found = re.search(r"^\[licenses\]\n.*?^allow = (\[.*?^\])", text, flags=re.DOTALL | re.MULTILINE)
    if found is None:
        raise ValueError("deny.toml: no list of licences")
    return set(ast.literal_eval(found[1]))


def is_allowed(expression: str, allowed: set[str]) -> bool:
    """Whether an SPDX expression can be satisfied with the allowed licences; ``/`` is the old way to write ``OR``."""
    tokens = re.findall(r"[()]|[^\s()]+", expression.replace("/", " OR "))

    def either() -> bool:
        result = both()
        while tokens and tokens[0] == "OR":
            tokens.pop(0)
            result = both() or result
        return result

    def both() -> bool:
        result = single()
        while tokens and tokens[0] == "AND":
            tokens.pop(0)
            result = single() and result
        return result

    def single() -> bool:
        if not tokens or tokens[0] in {")", "OR", "AND", "WITH"}:
            raise ValueError(f"not a licence expression: {expression!r}")
        name = tokens.pop(0)
        if name == "(":
            result = either()
            if not tokens or tokens.pop(0) != ")":
                raise ValueError(f"not a licence expression: {expression!r}")
            return result
        if tokens[:1] == ["WITH"] and len(tokens) > 1:
            name = f"{name} WITH {tokens[1]}"
            del tokens[:2]
        return name in allowed

    result = either()
    if tokens:
        raise ValueError(f"not a licence expression: {expression!r}")
    return result


def problems_of(package: dict[str, str | None], allowed: set[str]) -> list[str]:
    """Problems with the licence and the source of a package of ``cargo metadata``."""
    name, licence, source = f"{package['name']} {package['version']}", package["license"], package["source"]
    problems = [] if source in {None, REGISTRY} else [f"{name}: from {source}"]
    if licence is None:
        return [*problems, f"{name}: no licence"]
    try:
        met = is_allowed(licence, allowed)
    except ValueError as error:
        return [*problems, f"{name}: {error}"]
    return problems if met else [*problems, f"{name}: {licence} is not in the list"]


def main() -> int:
    """Print the licences and problems; return 1 if there are any problems."""
    command = ["cargo", "metadata", "--locked", "--all-features", "--format-version", "1"]
    answer = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    packages, allowed = json.loads(answer)["packages"], allowed_licences()
    for licence, count in Counter(str(package["license"]) for package in packages).most_common():
        print(f"{count:4}  {licence}")
    problems = [problem for package in packages for problem in problems_of(package, allowed)]
    for problem in problems:
        print(problem, file=sys.stderr)
    print(f"{len(packages)} crates, {len(problems)} problems")
    return int(bool(problems))


if __name__ == "__main__":
    sys.exit(main())
