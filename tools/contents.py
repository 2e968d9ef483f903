"""Check the contents of source distributions and wheels: ``python tools/contents.py dist/*``.

A wheel has exactly the files of ``python/stiefel_rs`` that git knows, the compiled module and the metadata. A source
distribution has these, the crate, and no files that a run leaves behind.
"""

import subprocess
import sys
import tarfile
import zipfile
from fnmatch import fnmatch
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).parents[1]
LICENCES = {"LICENSE-APACHE", "LICENSE-MIT"}
MODULE = ("stiefel_rs/_core*.so", "stiefel_rs/_core*.pyd")
# Additional files of the source distribution, besides the Python package.
SOURCE = (
    "src/*",
    "tests/*.rs",
    "tests/data/*",
    "benches/*.rs",
    "docs/*.md",
    "Cargo.toml",
    "Cargo.lock",
    "pyproject.toml",
    "PKG-INFO",
    "README.md",
    "CHANGELOG.md",
    "CITATION.cff",
    *sorted(LICENCES),
)


def tracked(folder: str) -> set[str]:
    """Files below a folder that git knows, relative to the root."""
    command = ["git", "ls-files", "-z", "--", folder]
    answer = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return {name for name in answer.split("\0") if name}


def package_files() -> set[str]:
    """Files of the Python package, relative to ``python``."""
    return {name.removeprefix("python/") for name in tracked("python/stiefel_rs")}


def matches(name: str, patterns: tuple[str, ...]) -> bool:
    """Whether one of the patterns matches."""
    return any(fnmatch(name, pattern) for pattern in patterns)


def wheel_problems(names: set[str]) -> list[str]:
    """Files missing from a wheel, and files that should not be in it."""
    metadata = {name for name in names if PurePosixPath(name).parts[0].endswith(".dist-info")}
    modules = {name for name in names if matches(name, MODULE)}
    rest, expected = names - metadata - modules, package_files()
    found = {PurePosixPath(name).name for name in metadata if "/licenses/" in name}
    problems = [f"missing: {name}" for name in sorted(expected - rest)]
    problems += [f"not of the package: {name}" for name in sorted(rest - expected)]
    problems += [f"missing licence: {name}" for name in sorted(LICENCES - found)]
    if len(modules) != 1:
        problems.append(f"one compiled module expected, found {sorted(modules)}")
    return problems


def source_problems(names: set[str]) -> list[str]:
    """Files missing from a source distribution, and files that should not be in it."""
    inner = {str(PurePosixPath(*PurePosixPath(name).parts[1:])) for name in names}
    package = {f"python/{name}" for name in package_files()}
    expected = package | tracked("src") | LICENCES | {"Cargo.lock", "Cargo.toml", "README.md", "pyproject.toml"}
    problems = [f"missing: {name}" for name in sorted(expected - inner)]
    others = {name for name in inner - package if not matches(name, SOURCE)}
    return problems + [f"not of the distribution: {name}" for name in sorted(others)]


def problems_of(path: Path) -> list[str]:
    """Problems of a file of ``dist``."""
    if path.suffix == ".whl":
        with zipfile.ZipFile(path) as wheel:
            return wheel_problems({name for name in wheel.namelist() if not name.endswith("/")})
    with tarfile.open(path) as source:
        return source_problems({member.name for member in source.getmembers() if member.isfile()})


def main(paths: list[str]) -> int:
    """Print the problems of the files; return 1 if there are any, or if there are no files."""
    if not paths:
        print("no files given", file=sys.stderr)
        return 1
    wrong = False
    for path in map(Path, paths):
        problems = problems_of(path)
        wrong |= bool(problems)
        print(f"{path.name}: {path.stat().st_size / 1e6:.1f} MB, {'as expected' if not problems else 'wrong'}")
        for problem in problems:
            print(f"  {problem}", file=sys.stderr)
    return int(wrong)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
