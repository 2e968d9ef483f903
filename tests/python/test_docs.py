"""The pages of the documentation: their Python blocks run, the reference has every public name, files exist."""

import ast
import importlib.util
import re
import signal
import textwrap
from pathlib import Path

import matplotlib as mpl
import pytest

import stiefel_rs

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md"))
# Blocks that need one of these are skipped if it is not installed.
OPTIONAL = {"geomstats", "pymanopt", "dask", "distributed", "zarr", "pymor", "spatialmath"}


def text_of(page):
    return (DOCS / page).read_text(encoding="utf-8")


def python_blocks(page):
    """The page's Python blocks, including those in tabs, with their first line numbers."""
    text = text_of(page)
    return [
        (text.count("\n", 0, block.start(2)), textwrap.dedent(block[2]))
        for block in re.finditer(r"^( *)```python\n(.*?)^\1```", text, flags=re.DOTALL | re.MULTILINE)
    ]


def missing_modules(source):
    """Optional modules that a block imports and that are not installed."""
    nodes = list(ast.walk(ast.parse(source)))
    names = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    names |= {node.module for node in nodes if isinstance(node, ast.ImportFrom) and node.module}
    # `stiefel_rs.pymanopt` needs pymanopt as well.
    tops = {part for name in names for part in name.split(".")} & OPTIONAL
    return {top for top in tops if importlib.util.find_spec(top) is None}


@pytest.fixture
def client():
    """A cluster in place of the one to which the page connects."""
    distributed = pytest.importorskip("distributed")
    with distributed.Client(n_workers=2, threads_per_worker=1, dashboard_address=":0") as client:
        yield client


@pytest.mark.skipif(missing_modules("import zarr") != set(), reason="zarr is not installed")
def test_python_blocks_about_clusters_run(client, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {"client": client}
    for line, source in python_blocks("dask.md"):
        # The scheduler belongs to somebody else.
        if "tcp://HOST" not in source:
            exec(compile("\n" * line + source, str(DOCS / "dask.md"), "exec"), names)
    assert (tmp_path / "sweep.zarr").is_dir()
    assert (tmp_path / "again.zarr").is_dir()


@pytest.mark.parametrize("page", [page for page in PAGES if page != "dask.md" and python_blocks(page)])
def test_python_blocks_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mpl.use("Agg")
    handler, names, skipped = signal.getsignal(signal.SIGINT), {}, set()
    try:
        # All blocks of a page share their names, as if typed one after another.
        for line, source in python_blocks(page):
            if missing := missing_modules(source):
                skipped |= missing
                continue
            # Lines of the page appear in tracebacks.
            exec(compile("\n" * line + source, str(DOCS / page), "exec"), names)
    finally:
        signal.signal(signal.SIGINT, handler)
    if skipped:
        pytest.skip(f"not installed: {', '.join(sorted(skipped))}")


def test_pages_with_code_are_there():
    pages = {page for page in PAGES if python_blocks(page)}
    guides = {f"guides/{name}.md" for name in ("join_two_frames", "interpolate_many_points", "integrate")}
    guides |= {"guides/interpolate_rotations_and_poses.md", "guides/interpolate_subspaces_and_complex_frames.md"}
    assert guides | {"index.md", "getting_started.md", "coming_from.md", "guides/compare_with_the_paper.md"} <= pages


def documented():
    """Names documented by the pages of the reference, with the page."""
    found = {}
    for path in sorted((DOCS / "reference").glob("*.md")):
        for name in re.findall(r"^::: (\S+)", path.read_text(encoding="utf-8"), flags=re.MULTILINE):
            assert name not in found, f"{name} is in {found[name]} and in {path.name}"
            found[name] = path.name
    return found


def test_reference_has_every_public_name():
    public = {f"stiefel_rs.{name}" for name in stiefel_rs.__all__ if name != "__version__"}
    names = set(documented())
    assert not public - names, "public, and not in the reference"
    assert not {name for name in names if name.count(".") == 1} - public - {"stiefel_rs.plotting", "stiefel_rs.dask"}


def test_index_of_the_reference_names_everything():
    text = text_of("reference/index.md")
    missing = [name for name in stiefel_rs.__all__ if f"`{name}`" not in text]
    assert not missing


def test_every_public_object_has_a_docstring():
    bare = []
    for name in stiefel_rs.__all__:
        thing = getattr(stiefel_rs, name)
        members = vars(thing) if isinstance(thing, type) and not issubclass(thing, Exception) else {}
        attributes = re.findall(r"^(\w[\w, ]*) : ", thing.__doc__ or "", flags=re.MULTILINE)
        told = {word for line in attributes for word in line.split(", ")}
        bare += [] if thing.__doc__ else [name]
        for member in members:
            if not member.startswith("_") and member not in told and not getattr(thing, member).__doc__:
                bare.append(f"{name}.{member}")
    assert not bare


def test_formulas_name_every_file_that_has_one():
    text = text_of("mathematics.md")
    named = set(re.findall(r"`(src/[\w/]+\.rs)`", text))
    assert not [path for path in named if not (ROOT / path).exists()]
    sources = {path.relative_to(ROOT).as_posix(): path for path in (ROOT / "src").rglob("*.rs")}
    with_formulas = {name for name, path in sources.items() if "```math" in path.read_text(encoding="utf-8")}
    assert len(with_formulas) > 30
    assert not with_formulas - named, "files with formulas that the page does not name"


def entries():
    """The bibliography as (key, fields)."""
    text = text_of("references.bib")
    blocks = re.findall(r"^@(\w+)\{(\w+),\n(.*?)^\}", text, flags=re.DOTALL | re.MULTILINE)
    return {key: dict(re.findall(r"^\s+(\w+) = \{(.*)\},?$", body, flags=re.MULTILINE)) for _, key, body in blocks}


def test_bibliography_is_well_formed():
    text, found = text_of("references.bib"), entries()
    assert len(found) == text.count("\n@") + text.startswith("@")
    assert text.count("{") == text.count("}")
    for key, fields in found.items():
        assert {"author", "title", "year"} <= set(fields), key
        assert re.fullmatch(r"\d{4}", fields["year"]), key
        # The key ends in the year.
        assert re.search(r"\d{4}", key)[0] == fields["year"], key


def plain(name):
    """A family name without diacritics, however they are written."""
    name = re.sub(r"\\.\{?\\?(\w)\}?|[{}]", lambda found: found[1] or "", name)
    table = str.maketrans("üöäğñáéí", "uoagnaei")
    return re.sub(r"(?<=[uoa])e(?=[a-z])", "", name.translate(table))


def cited():
    """(first author, year) of everything that the source code cites as `Name, Name (year)`."""
    pattern = re.compile(
        r"([A-Z][\w-]+(?: [A-Z][\w-]+)?)((?:, (?:de )?[A-Z][\w-]+(?: (?:de )?[A-Z][\w-]+)*)*) \(((?:19|20)\d\d)\)"
    )
    found = set()
    for path in sorted((ROOT / "src").rglob("*.rs")):
        text = re.sub(r"\n\s*//[/!] ?", " ", path.read_text(encoding="utf-8"))
        found |= {(authors[1].split()[-1], authors[3]) for authors in pattern.finditer(text)}
    return found


def test_bibliography_has_every_source_of_the_code():
    known = {
        (plain(word), fields["year"])
        for fields in entries().values()
        for word in re.findall(r"[\w\\\"'{}~^-]+", fields["author"])
    }
    sources = cited()
    assert len(sources) > 50
    assert not {source for source in sources if (plain(source[0]), source[1]) not in known}


def test_navigation_names_pages():
    settings = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    navigation = re.findall(r"[\w/]+\.md", settings.partition("\nnav:\n")[2])
    assert sorted(navigation) == PAGES


def test_citation_file():
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {stiefel_rs.__version__}\n" in text
    assert "2404.19407" in text


# How a page was made and what was rejected is told in docs/development.
NOTES = re.compile(r"[Ww]ritten by `make|could not be run|(?:was|were) tried|tried and|what was rejected|TODO|to-do")


@pytest.mark.parametrize("page", [page for page in PAGES if not page.startswith("development/")])
def test_pages_for_users_have_no_development_notes(page):
    assert NOTES.findall(text_of(page)) == []
