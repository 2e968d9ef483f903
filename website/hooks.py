"""What the site has beyond the pages of docs/: formulas as HTML, scripts of the examples, weights for the search."""

from __future__ import annotations

import base64
import hashlib
import html
import io
import os
import re
import subprocess
import sys
import tarfile
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mkdocs.exceptions import PluginError
from mkdocs.plugins import get_plugin_logger
from mkdocs.structure.files import File, Files
from py_mini_racer import JSEvalException, MiniRacer

if TYPE_CHECKING:
    from jinja2 import Environment
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.pages import Page

log = get_plugin_logger("website")

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
EXAMPLES = ROOT / "examples"

KATEX = "0.16.47"
KATEX_SHA512 = "Eeo8Ys1doU1z+x8AZsPpQu+p/QcZBI5PeOo7QGQdy2x2m0MU/hYagBbGOmXwr5KVbEfVuWv9LpnQWeehogurjg=="
KATEX_URL = f"https://registry.npmjs.org/katex/-/katex-{KATEX}.tgz"
CACHE = ROOT / "target" / "website"

MATHS = re.compile(r'<(span|div) class="arithmatex">(.*?)</\1>', re.DOTALL)
ROW = re.compile(r"^\|.*\|$", flags=re.MULTILINE)
CODE = re.compile(r"`[^`]+`")
CELL = re.compile(r"<td\b.*?</td>", flags=re.DOTALL)
NAME = re.compile(r"(?<=<code>)[^<]+(?=</code>)")
# Places at which a name in a table may break.
JOINT = re.compile(r"(::|\w[_/(=](?=\w)|\w\.(?!py\b|rs\b)(?=\w))")
HELP = re.compile(r"<!-- help ?(\w*) -->")
# Resources that a browser fetches by itself when it shows a page.
FETCHED = re.compile(r'<(?:script|img|iframe|source)\b[^>]*\bsrc="(https?:|//)|<link\b[^>]*\brel="stylesheet"[^>]*//')
# Weights of pages in the search, by the first prefix of their path that matches: guides before measurements.
BOOSTS = {
    "guides/rust": 1.0,
    "guides/": 8.0,
    "coming_from": 8.0,
    "reference/": 2.0,
    "development/": 0.3,
    "what_it": 0.3,
    "index": 0.1,
}


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add KaTeX, the style of the site, the figures of plotting.md and the scripts of the examples."""
    with step("KaTeX"):
        dist = katex()
    for path in [dist / "katex.min.css", *sorted((dist / "fonts").glob("*.woff2"))]:
        files.append(File.generated(config, f"katex/{path.relative_to(dist).as_posix()}", abs_src_path=str(path)))
    files.append(File.generated(config, "site.css", abs_src_path=str(HERE / "site.css")))
    with step("figures of plotting.md"):
        add_plotting(files, config)
    add_examples(files, config)
    log.info("pages: reading %d, with the docstrings of the reference", len(files.documentation_pages()))
    return files


def on_env(env: Environment, **_: Any) -> Environment:
    """Log that all pages are read."""
    log.info("pages: writing, with their formulas")
    return env


def on_page_markdown(markdown: str, *, page: Page, **_: Any) -> str:
    """Set the weight in the search; adapt bars in tables, links of the gallery, and options of the command."""
    boost = next((boost for start, boost in BOOSTS.items() if page.file.src_uri.startswith(start)), 1.0)
    page.meta["search"] = {"boost": boost, "exclude": page.file.src_uri.startswith("examples/")}
    # Forges need escaped bars in the code of tables, but Python-Markdown shows the escapes.
    markdown = ROW.sub(lambda row: CODE.sub(lambda code: code[0].replace(r"\|", "|"), row[0]), markdown)
    if page.file.src_uri == "reference/command_line.md":
        return HELP.sub(lambda found: help_of(found[1]), markdown)
    if page.file.src_uri != "gallery.md":
        return markdown
    markdown = markdown.replace("](../examples/data/README.md)", "](examples/data.md)")
    markdown = re.sub(r"\]\(\.\./examples/(\w+)\.py\)", r"](examples/\1.md)", markdown)
    return markdown.replace("](../examples)", "](examples/index.md)")


def on_post_page(output: str, *, page: Page, **_: Any) -> str:
    """Render formulas and allow breaks in long names, after the search index is made; refuse files from other hosts."""
    if fetched := FETCHED.search(output):
        raise PluginError(f"{page.file.src_uri}: the page loads {fetched[0]}...")
    output = CELL.sub(lambda cell: NAME.sub(lambda name: JOINT.sub(r"\1<wbr>", name[0]), cell[0]), output)
    return MATHS.sub(lambda found: formula(found[2], page.file.src_uri), output)


@contextmanager
def step(name: str) -> Iterator[None]:
    """Log the start and the duration of a step."""
    log.info("%s: ...", name)
    start = time.perf_counter()
    yield
    log.info("%s: done, %.1f s", name, time.perf_counter() - start)


def help_of(command: str) -> str:
    """The help of a command, as a block of text no wider than the page."""
    arguments = [sys.executable, "-m", "stiefel_rs", *command.split(), "--help"]
    wide = os.environ | {"COLUMNS": "90", "NO_COLOR": "1"}
    text = subprocess.run(arguments, capture_output=True, text=True, timeout=60, check=True, env=wide).stdout
    return f"```text\n{text}```"


def katex() -> Path:
    """The KaTeX release, downloaded once and checked."""
    folder = CACHE / f"katex-{KATEX}"
    if not folder.exists():
        with urllib.request.urlopen(KATEX_URL, timeout=60) as response:
            content = response.read()
        if base64.b64encode(hashlib.sha512(content).digest()).decode() != KATEX_SHA512:
            raise PluginError(f"{KATEX_URL} is not the release that is expected")
        CACHE.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=CACHE) as partial, tarfile.open(fileobj=io.BytesIO(content)) as archive:
            archive.extractall(partial, filter="data")
            (Path(partial) / "package").rename(folder)
    return folder / "dist"


@cache
def engine() -> MiniRacer:
    """KaTeX in an interpreter."""
    context = MiniRacer()
    context.eval((katex() / "katex.min.js").read_text(encoding="utf-8"))
    return context


@cache
def formula(source: str, where: str) -> str:
    """One formula as HTML and MathML; it is an error if KaTeX cannot parse it."""
    text = html.unescape(source).strip()
    display = text.startswith(r"\[")
    options = {"displayMode": display, "throwOnError": True, "strict": "error"}
    try:
        return str(engine().call("katex.renderToString", text[2:-2], options))
    except JSEvalException as error:
        raise PluginError(f"{where}: {text}\n{error}") from error


def add_plotting(files: Files, config: MkDocsConfig) -> None:
    """Run the script of plotting.md; the files that it writes replace those in docs/figures."""
    page = (ROOT / "docs" / "plotting.md").read_text(encoding="utf-8")
    scripts = re.findall(r"^```python\n(.*?)^```", page, flags=re.DOTALL | re.MULTILINE)
    # Threads of a BLAS that wait for each other on a busy machine take minutes for what one does in a second.
    single = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-c", scripts[0]]
        done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False, cwd=folder, env=single)
        if done.returncode:
            raise PluginError(f"plotting.md: its script failed:\n{done.stderr}")
        for path in sorted(Path(folder).iterdir()):
            name = f"figures/{path.name}"
            if old := files.get_file_from_path(name):
                files.remove(old)
            files.append(File.generated(config, name, content=path.read_bytes()))


def add_examples(files: Files, config: MkDocsConfig) -> None:
    """A page per script, a page with all of them, and the origin of their data."""
    scripts = sorted(EXAMPLES.glob("*.py"))
    for path in scripts:
        text = f"# {path.name}\n\n```python\n{path.read_text(encoding='utf-8')}```\n"
        files.append(File.generated(config, f"examples/{path.stem}.md", content=text))
    rows = "".join(f"- [{path.name}]({path.stem}.md): {first_sentence(path)}\n" for path in scripts)
    files.append(File.generated(config, "examples/index.md", content=f"# Scripts of the gallery\n\n{rows}"))
    data = (EXAMPLES / "data" / "README.md").read_text(encoding="utf-8")
    files.append(File.generated(config, "examples/data.md", content=data))


def first_sentence(path: Path) -> str:
    """The first line of a script's docstring, with a lower-case initial letter."""
    found = re.search(r'"""(.+)', path.read_text(encoding="utf-8"))
    return found[1].strip('"') if found else ""
