"""Checks of releases: licences of dependencies, contents of distributions."""

import re

import pytest

import stiefel_rs
from tools import contents, licences, publish_readme, version

# The contents of a distribution are the files that git knows.
needs_git = pytest.mark.skipif(not (contents.ROOT / ".git").exists(), reason="not a checkout of git")
ALLOWED = {"MIT", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "Unicode-3.0"}


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("MIT", True),
        ("GPL-3.0-only", False),
        ("MIT/GPL-3.0-only", True),
        ("GPL-3.0-only OR Apache-2.0", True),
        ("GPL-3.0-only AND MIT", False),
        ("(MIT OR GPL-3.0-only) AND Unicode-3.0", True),
        ("(MIT OR Apache-2.0) AND GPL-3.0-only", False),
        # AND binds closer than OR.
        ("MIT OR Apache-2.0 AND GPL-3.0-only", True),
        ("GPL-3.0-only AND MIT OR GPL-2.0-only", False),
        ("Apache-2.0 WITH LLVM-exception", True),
        ("MIT WITH LLVM-exception", False),
    ],
)
def test_expressions(expression, expected):
    assert licences.is_allowed(expression, ALLOWED) is expected


@pytest.mark.parametrize("expression", ["", "MIT OR", "(MIT", "MIT)", "AND MIT", "MIT Apache-2.0", "MIT WITH"])
def test_what_is_no_expression_is_refused(expression):
    with pytest.raises(ValueError, match="not a licence expression"):
        licences.is_allowed(expression, ALLOWED)


def test_packages_without_licence_or_from_elsewhere_are_found():
    package = {"name": "a", "version": "1.0.0", "license": "MIT", "source": licences.REGISTRY}
    assert licences.problems_of(package, ALLOWED) == []
    assert licences.problems_of(package | {"license": None}, ALLOWED) == ["a 1.0.0: no licence"]
    assert licences.problems_of(package | {"license": "MIT OR"}, ALLOWED) == [
        "a 1.0.0: not a licence expression: 'MIT OR'"
    ]
    source = "git+https://example.org/a"
    assert licences.problems_of(package | {"source": source}, ALLOWED) == [f"a 1.0.0: from {source}"]


def test_list_of_licences_is_read():
    allowed = licences.allowed_licences()
    assert {"MIT", "Apache-2.0"} <= allowed
    assert not any(re.search("GPL|MPL", name) for name in allowed)


def wheel_names():
    """File names of a correct wheel."""
    metadata = "stiefel_rs-0.1.0.dist-info"
    licence_files = {f"{metadata}/licenses/{name}" for name in contents.LICENCES}
    return contents.package_files() | licence_files | {"stiefel_rs/_core.abi3.so", f"{metadata}/METADATA"}


@needs_git
def test_package_has_its_types_and_the_files_of_the_page():
    assert {"stiefel_rs/py.typed", "stiefel_rs/_core.pyi"} <= contents.package_files()
    page = {f"stiefel_rs/explore/web/{name}" for name in ("page.html", "page.css", "main.js")}
    assert page <= contents.package_files()


@needs_git
def test_a_good_wheel_has_no_problems():
    assert contents.wheel_problems(wheel_names()) == []


@needs_git
@pytest.mark.parametrize(
    "missing",
    ["stiefel_rs/py.typed", "stiefel_rs/_core.abi3.so", "stiefel_rs-0.1.0.dist-info/licenses/LICENSE-MIT"],
)
def test_missing_files_of_a_wheel_are_found(missing):
    assert len(contents.wheel_problems(wheel_names() - {missing})) == 1


@needs_git
@pytest.mark.parametrize("more", ["stiefel_rs/__pycache__/cli.pyc", "tests/conftest.py", "stiefel_rs/_core.abi3.pyd"])
def test_foreign_files_of_a_wheel_are_found(more):
    assert len(contents.wheel_problems(wheel_names() | {more})) == 1


@needs_git
def test_source_distribution_needs_its_files_and_no_others():
    names = {f"python/{name}" for name in contents.package_files()} | contents.tracked("src") | contents.LICENCES
    names |= {"Cargo.toml", "Cargo.lock", "README.md", "pyproject.toml", "PKG-INFO"}
    full = {f"stiefel_rs-0.1.0/{name}" for name in names}
    assert contents.source_problems(full) == []
    assert contents.source_problems(full - {"stiefel_rs-0.1.0/Cargo.lock"}) == ["missing: Cargo.lock"]
    foreign = "python/stiefel_rs/_core.abi3.so"
    assert contents.source_problems(full | {f"stiefel_rs-0.1.0/{foreign}"}) == [f"not of the distribution: {foreign}"]


def test_version_of_a_tag(monkeypatch, tmp_path):
    monkeypatch.setattr(version, "ROOT", tmp_path)
    (tmp_path / "Cargo.toml").write_text('[package]\nname = "a"\nversion = "1.2.3"\nrust-version = "1.89"\n')
    (tmp_path / "CITATION.cff").write_text("cff-version: 1.2.0\nversion: 1.2.3\n")
    changes = tmp_path / "CHANGELOG.md"
    changes.write_text("## [Unreleased]\n\n## [1.2.3] - 2027-01-31\n\n## [1.2.2] - 2026-12-01\n")
    assert version.problems_of("v1.2.3") == []
    assert version.problems_of("v1.2.4") == ["tag: 1.2.4, not 1.2.3"]
    changes.write_text("## [1.2.3] - unreleased\n")
    assert version.problems_of("v1.2.3") == ["CHANGELOG.md: none, not 1.2.3"]


def test_crate_and_citation_have_the_same_version():
    assert all(line.startswith("CHANGELOG.md") for line in version.problems_of(f"v{stiefel_rs.__version__}"))


def test_readme_for_registries_has_absolute_addresses():
    text = (contents.ROOT / "README.md").read_text(encoding="utf-8")
    found = publish_readme.absolute(text, "https://forge.example/us/it/", "v1.2.3")
    assert "](docs/" not in found and "](src/" not in found and "](LICENSE" not in found
    assert "](https://forge.example/us/it/raw/v1.2.3/docs/figures/keyframes.svg)" in found
    assert "](https://forge.example/us/it/blob/v1.2.3/docs/benchmarks.md)" in found
    assert "](https://arxiv.org/abs/2404.19407)" in found
    # Nothing else changes, and a second time nothing does.
    assert re.sub(r"https://forge.example/us/it/(raw|blob)/v1.2.3/", "", found) == text
    assert publish_readme.absolute(found, "https://forge.example/us/it/", "v1.2.3") == found
