"""What the site has beyond the pages of docs/: formulas as HTML, the gallery run anew, the scripts of the examples."""

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
import urllib.request
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from py_mini_racer import JSEvalException, MiniRacer

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.pages import Page

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
HELP = re.compile(r"<!-- help ?(\w*) -->")
# What a browser fetches by itself when it shows a page.
FETCHED = re.compile(r'<(?:script|img|iframe|source)\b[^>]*\bsrc="(https?:|//)|<link\b[^>]*\brel="stylesheet"[^>]*//')


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add KaTeX's style and fonts, the style of the site, the gallery and the scripts of the examples."""
    dist = katex()
    for path in [dist / "katex.min.css", *sorted((dist / "fonts").glob("*.woff2"))]:
        files.append(File.generated(config, f"katex/{path.relative_to(dist).as_posix()}", abs_src_path=str(path)))
    files.append(File.generated(config, "site.css", abs_src_path=str(HERE / "site.css")))
    add_gallery(files, config)
    add_plotting(files, config)
    add_examples(files, config)
    return files


def on_page_markdown(markdown: str, *, page: Page, **_: Any) -> str:
    """Bars in tables; links of the gallery to the scripts lead to their pages; the command tells its own options."""
    # Forges want bars in the code of tables escaped, Python-Markdown shows the escapes.
    markdown = ROW.sub(lambda row: CODE.sub(lambda code: code[0].replace(r"\|", "|"), row[0]), markdown)
    if page.file.src_uri == "reference/command_line.md":
        return HELP.sub(lambda found: help_of(found[1]), markdown)
    if page.file.src_uri != "gallery.md":
        return markdown
    markdown = markdown.replace("](../examples/data/README.md)", "](examples/data.md)")
    markdown = re.sub(r"\]\(\.\./examples/(\w+)\.py\)", r"](examples/\1.md)", markdown)
    return markdown.replace("](../examples)", "](examples/index.md)")


def on_post_page(output: str, *, page: Page, **_: Any) -> str:
    """Formulas as HTML, after the search index has taken their source; nothing may come from another host."""
    if fetched := FETCHED.search(output):
        raise PluginError(f"{page.file.src_uri}: the page loads {fetched[0]}...")
    return MATHS.sub(lambda found: formula(found[2], page.file.src_uri), output)


def help_of(command: str) -> str:
    """What a command says about itself, as a block of text that is not wider than the page."""
    arguments = [sys.executable, "-m", "stiefel_rs", *command.split(), "--help"]
    wide = os.environ | {"COLUMNS": "90", "NO_COLOR": "1"}
    text = subprocess.run(arguments, capture_output=True, text=True, timeout=60, check=True, env=wide).stdout
    return f"```text\n{text}```"


def katex() -> Path:
    """KaTeX's release, downloaded once and checked."""
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
    """One formula as HTML and MathML; one that KaTeX does not understand is an error."""
    text = html.unescape(source).strip()
    display = text.startswith(r"\[")
    options = {"displayMode": display, "throwOnError": True, "strict": "error"}
    try:
        return str(engine().call("katex.renderToString", text[2:-2], options))
    except JSEvalException as error:
        raise PluginError(f"{where}: {text}\n{error}") from error


def add_gallery(files: Files, config: MkDocsConfig) -> None:
    """Run the examples unless they and the package are as they were; their page and figures replace those of docs/."""
    out = CACHE / f"gallery-{fingerprint()}"
    if not (out / "gallery.md").exists():
        # Threads of a BLAS that wait for each other on a busy machine take minutes for what one does in a second.
        single = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        command = [sys.executable, str(EXAMPLES / "gallery.py"), "--out", str(out)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False, env=single)
        if done.returncode:
            raise PluginError(f"the examples of the gallery failed:\n{done.stderr}")
    for path in sorted(out.rglob("*.*")):
        name = path.relative_to(out).as_posix()
        if old := files.get_file_from_path(name):
            files.remove(old)
        files.append(File.generated(config, name, abs_src_path=str(path)))


def add_plotting(files: Files, config: MkDocsConfig) -> None:
    """Run the script of the page about figures; its figures replace those of docs/."""
    page = (ROOT / "docs" / "plotting.md").read_text(encoding="utf-8")
    scripts = re.findall(r"^```python\n(.*?)^```", page, flags=re.DOTALL | re.MULTILINE)
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-c", scripts[0]]
        done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False, cwd=folder)
        if done.returncode:
            raise PluginError(f"plotting.md: its script failed:\n{done.stderr}")
        drawn = {f"figures/{path.name}": path.read_bytes() for path in sorted(Path(folder).glob("*.svg"))}
    for name, content in drawn.items():
        if old := files.get_file_from_path(name):
            files.remove(old)
        files.append(File.generated(config, name, content=content))


def fingerprint() -> str:
    """A number for the examples, their data, the installed package and the style of its figures."""
    import stiefel_rs  # noqa: PLC0415

    digest = hashlib.sha256()
    package = Path(stiefel_rs.__file__).parent
    kinds = ("*.so", "*.pyd", "figure_*.py", "palette.py")
    for path in [*sorted(EXAMPLES.rglob("*.*")), *(path for kind in kinds for path in sorted(package.glob(kind)))]:
        if path.is_file() and "__pycache__" not in path.parts:
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def add_examples(files: Files, config: MkDocsConfig) -> None:
    """A page for each script, one with all of them, and the origin of their data."""
    scripts = sorted(EXAMPLES.glob("*.py"))
    for path in scripts:
        text = f"# {path.name}\n\n```python\n{path.read_text(encoding='utf-8')}```\n"
        files.append(File.generated(config, f"examples/{path.stem}.md", content=text))
    rows = "".join(f"- [{path.name}]({path.stem}.md): {first_sentence(path)}\n" for path in scripts)
    files.append(File.generated(config, "examples/index.md", content=f"# Scripts of the gallery\n\n{rows}"))
    data = (EXAMPLES / "data" / "README.md").read_text(encoding="utf-8")
    files.append(File.generated(config, "examples/data.md", content=data))


def first_sentence(path: Path) -> str:
    """The first line of a script's docstring, with a small letter."""
    found = re.search(r'"""(.+)', path.read_text(encoding="utf-8"))
    return found[1].strip('"') if found else ""
