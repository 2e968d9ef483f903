"""The command line: `reproduce` end to end, its error paths, and `info`."""

import csv
import itertools
import json
import math
import os
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from beside import HANGS

from stiefel_rs import cli
from stiefel_rs.reproduce import experiments, flows, readings

METHODS = ["gcp", "initial_point_ivp", "initial_point_bvp", "midpoint_ivp", "midpoint_bvp"]
ORDERS = [0, 1, 1, 2, 2]
CHART_FREE = ["splitting_2", "splitting_4", "splitting_6", "splitting_8", "exact_bvp"]
EXPERIMENTS = {e.name: e for e in experiments.EXPERIMENTS}
FIGURES = ["figure_1", "figure_3a", "figure_3b", "trajectory_sphere", "trajectory_stiefel_3_2", "error_sphere"]
FIGURES += ["error_stiefel_3_2", "energy", "momentum", "conjecture", "retraction_pairs", "control_points"]
FIGURES += ["exact_sphere", "exact_stiefel_3_2"]
# The panels of the paper's figures, and the columns of its tables.
PANELS = {"a": "sphere", "b": "stiefel_3_2"}
PAPER = ["gcp", "initial_point_bvp", "midpoint_bvp"]
# Mean Frobenius errors by N, in the order of METHODS: independent recomputation in NumPy and mpmath.
INDEPENDENT = {
    "sphere": {
        10: [9.8759e-5, 2.9143e-2, 5.4414e-3, 3.9581e-4, 4.5591e-4],
        20: [1.0347e-4, 1.4644e-2, 2.8290e-3, 9.4350e-5, 1.2061e-4],
        50: [1.0651e-4, 5.8764e-3, 1.1856e-3, 1.4640e-5, 1.9921e-5],
        100: [1.0757e-4, 2.9414e-3, 6.0440e-4, 3.6215e-6, 5.0316e-6],
    },
    "stiefel_3_2": {
        10: [4.1506e-3, 4.0638e-2, 6.2603e-3, 3.3569e-4, 2.5034e-4],
        20: [4.3486e-3, 2.0380e-2, 3.1081e-3, 8.1022e-5, 6.6040e-5],
        50: [4.4766e-3, 8.1680e-3, 1.2745e-3, 1.2682e-5, 1.0899e-5],
        100: [4.5209e-3, 4.0867e-3, 6.4583e-4, 3.1470e-6, 2.7527e-6],
    },
}
WITHOUT_MATPLOTLIB = "import sys; sys.modules['matplotlib'] = None; from stiefel_rs.cli import main; sys.exit(main())"


def run(*arguments, code=None):
    start = ["-m", "stiefel_rs"] if code is None else ["-c", code]
    return subprocess.run(
        [sys.executable, *start, *map(str, arguments)], capture_output=True, text=True, timeout=HANGS, check=False
    )


def read(path):
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return header, rows


def test_quick_ends_well_and_says_where(quick):
    folder, done = quick
    assert done.returncode == 0, done.stderr
    for place in (folder / "tables", folder / "figures", folder / "tables" / "summary.md"):
        assert str(place) in done.stdout
    assert "4.5209e-03" in done.stdout


def test_no_progress_bar_in_a_pipe(quick):
    assert quick[1].stderr == ""
    assert "\r" not in quick[1].stdout


@pytest.mark.parametrize("name", FIGURES)
def test_figures_are_png_svg_and_pdf(quick, name):
    png, svg, pdf = ((quick[0] / "figures" / f"{name}.{suffix}").read_bytes() for suffix in ("png", "svg", "pdf"))
    assert png.startswith(b"\x89PNG\r\n") and len(png) > 20_000
    # The width in pixels, and the resolution in pixels for a metre.
    inches = 3.4 if name in ("figure_3a", "figure_3b") else 7.0
    assert int.from_bytes(png[16:20], "big") == round(200 * inches)
    place = png.index(b"pHYs") + 4
    assert int.from_bytes(png[place : place + 4], "big") == round(200 / 0.0254)
    assert f'width="{72 * inches:g}pt"'.encode() in svg
    assert b"prefers-color-scheme:dark" in svg and b"<dc:date>" not in svg
    assert pdf.startswith(b"%PDF-") and pdf.rstrip().endswith(b"%%EOF")
    assert b"CreationDate" not in pdf


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_error_table(quick, name):
    header, rows = read(quick[0] / "tables" / f"{name}.csv")
    assert header == ["N", "h", *METHODS, *CHART_FREE]
    assert [int(row[0]) for row in rows] == [5, 10, 20, 50, 100]
    table = np.array(rows, dtype=float)
    np.testing.assert_array_equal(table[:, 1], 1 / table[:, 0])
    assert all(repr(float(cell)) == cell for row in rows for cell in row[1:])
    for row in table:
        if row[0] in INDEPENDENT[name]:
            # Four significant digits: half a unit of the fifth printed digit, and its rounding.
            np.testing.assert_allclose(row[2:7], INDEPENDENT[name][row[0]], rtol=1e-4)
    slopes = [np.polyfit(np.log(table[:, 1]), np.log(column), 1)[0] for column in table[:, 2:7].T]
    np.testing.assert_allclose(slopes, ORDERS, atol=0.1)
    # The two largest steps; order 6 is at round-off for the third.
    orders = np.log2(table[0, 7:10] / table[1, 7:10])
    np.testing.assert_allclose(orders, [2, 4, 6], atol=0.2)
    # The error of the reference, 1e-13.
    assert table[:, 10].max() < 1e-13


def test_numbers_of_the_summary_are_those_of_the_independent_table():
    for name, experiment in EXPERIMENTS.items():
        assert {n: list(row) for n, row in experiment.independent.items()} == INDEPENDENT[name]


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_markdown_holds_the_same_numbers(quick, name):
    text = (quick[0] / "tables" / f"{name}.md").read_text(encoding="utf-8")
    numbers = [float(x) for x in re.findall(r"\d\.\d{4}e-\d\d", text)]
    exact = [float(x) for row in read(quick[0] / "tables" / f"{name}.csv")[1] for x in row[2:]]
    np.testing.assert_allclose(numbers, exact, rtol=5e-5)


@pytest.mark.parametrize("panel", PANELS)
def test_tables_of_the_paper_have_its_columns(quick, panel):
    header, rows = read(quick[0] / "tables" / f"figure_2{panel}.csv")
    assert header == ["h", "GCP", "Retraction", "Mid-point Retraction"]
    wide_header, wide = read(quick[0] / "tables" / f"{PANELS[panel]}.csv")
    columns = [wide_header.index(name) for name in ("h", *PAPER)]
    assert rows == [[row[i] for i in columns] for row in wide]
    for suffix in (".md", ".tex"):
        text = (quick[0] / "tables" / f"figure_2{panel}{suffix}").read_text(encoding="utf-8")
        numbers = [float(x) for x in re.findall(r"\d\.\d{4}e-\d\d", text)]
        np.testing.assert_allclose(numbers, [float(x) for row in rows for x in row[1:]], rtol=5e-5)
    assert "\\toprule" in text and text.count("&") == 3 * (1 + len(rows))


def test_timing_table(quick):
    header, rows = read(quick[0] / "tables" / "timing.csv")
    assert header == ["manifold", "method", "N", "seconds_per_curve", "ratio_to_gcp"]
    assert {(row[0], row[1]) for row in rows} == {
        (e, m) for e in EXPERIMENTS for m in [*METHODS, *CHART_FREE, "reference"]
    }
    assert {int(row[2]) for row in rows} == {5, 10, 20, 50, 100}
    assert all(float(row[3]) > 0 for row in rows)
    assert all(float(row[4]) == 1.0 for row in rows if row[1] == "gcp")


HEADINGS = """# arXiv 2404.19407 recomputed: what holds
## The statements of the paper
## The paper's figures and tables
### Figure 1: trajectories on the sphere
### Figure 2a: mean errors, sphere
### Figure 2b: mean errors, St(3,2)
### Figure 3: mean errors against the step
## What the verdicts rest on
### 0.080 % and 0.45 %: the relative mean error of GCP
### Exact where the manifold is flat
### The error and the step
### Near the initial point
### The mid-point map against the initial-point map
### The conjecture as stated
### Times
### The chart challenge
### The challenge of implicit equations
### A submanifold of Euclidean space
## Beyond the paper
### Every pair of retractions, initial and boundary values, orders 1 and 2
### The exact cubic, without charts
### Exact cubics on any St(n,k)
### Times of the methods without charts
### Other control points
### Energy and momentum along the discrete flows
### Independent recomputation (NumPy/mpmath)"""


def test_summary_has_the_paper_first_and_what_is_beyond_last(quick):
    text = (quick[0] / "tables" / "summary.md").read_text(encoding="utf-8")
    assert [line for line in text.splitlines() if line.startswith("#")] == HEADINGS.splitlines()
    assert "A `--quick` run" in text and "N = 5, 10, 20, 50, 100" in text
    assert "nan" not in text.lower()
    # The mean errors over 1, 2 sqrt(k) and pi.
    for values in (("0.0108 %", "0.00538 %", "0.00342 %"), ("0.452 %", "0.16 %", "0.144 %")):
        assert all(value in text for value in values)
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert all(a.count("|") == b.count("|") for a, b in itertools.pairwise(rows) if b.startswith("|:"))


def test_figures_of_the_summary_are_there(quick):
    folder = quick[0] / "tables"
    names = re.findall(r"\]\((.*?)\)", (folder / "summary.md").read_text(encoding="utf-8"))
    assert len(names) == 3 and all((folder / name).is_file() for name in names)


def test_one_n_gives_tables_without_orders(tmp_path):
    done = run("reproduce", "--quick", "--steps", "7,7", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    _, rows = read(tmp_path / "tables" / "sphere.csv")
    assert [row[0] for row in rows] == ["7"]
    assert "None of its N" in (tmp_path / "tables" / "summary.md").read_text(encoding="utf-8")


def test_steps_are_sorted():
    assert cli.parser().parse_args(["reproduce", "--steps", "20, 10,20"]).steps == (10, 20)


@pytest.mark.parametrize("steps", ["0", "-5,10", "1", "ten", "10,", "", "2.5", "10;20", "9999999999999999999999"])
def test_bad_steps(steps, tmp_path):
    done = run("reproduce", f"--steps={steps}", "--out", tmp_path / "out")
    assert done.returncode == 2
    assert "--steps" in done.stderr and "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("arguments", [[], ["unknown"], ["reproduce", "--unknown"]])
def test_bad_arguments(arguments):
    done = run(*arguments)
    assert done.returncode == 2
    assert "usage: stiefel-rs" in done.stderr


def test_folder_that_is_a_file(tmp_path):
    path = tmp_path / "file"
    path.write_text("kept", encoding="utf-8")
    done = run("reproduce", "--quick", "--out", path)
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1 and str(path) in done.stderr
    assert path.read_text(encoding="utf-8") == "kept"


def test_without_matplotlib_the_tables_are_written(tmp_path):
    done = run("reproduce", "--quick", "--steps", "5,10", "--out", tmp_path, code=WITHOUT_MATPLOTLIB)
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1 and "pip install 'stiefel-rs[plot]'" in done.stderr
    assert (tmp_path / "tables" / "summary.md").stat().st_size > 0
    assert len(read(tmp_path / "tables" / "sphere.csv")[1]) == 2


def test_import_leaves_matplotlib_alone():
    code = "import json, sys, stiefel_rs, stiefel_rs.cli; print(json.dumps(sorted(sys.modules)))"
    modules = json.loads(run(code=code).stdout)
    assert "stiefel_rs.reproduce.experiments" in modules
    assert not [name for name in modules if name.startswith(("matplotlib", "mpl_toolkits"))]


@pytest.mark.skipif(os.name != "posix", reason="SIGINT to a child process")
def test_interrupt(tmp_path, spawn):
    arguments = ["-m", "stiefel_rs", "reproduce", "--steps", "500000", "--out", str(tmp_path)]
    process = spawn(*arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    while not (tmp_path / "figures").exists():
        assert process.poll() is None, process.communicate()
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=HANGS)
    assert process.returncode == 130
    assert errors == "stiefel-rs: interrupted\n"


def test_info():
    done = run("info")
    assert done.returncode == 0 and done.stderr == ""
    for name in ("stiefel-rs", "Python", "NumPy", "platform", "threads", "SIMD"):
        assert re.search(rf"^{name}: +\S", done.stdout, re.MULTILINE), name
    assert np.__version__ in done.stdout


@pytest.mark.skipif(sys.platform == "win32", reason="pipes break otherwise there")
@pytest.mark.parametrize("command", ["info", "--help"])
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_that_leaves_ends_the_command_quietly(command, unbuffered):
    process = subprocess.Popen(
        [sys.executable, "-m", "stiefel_rs", command],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONUNBUFFERED": unbuffered},
    )
    process.stdout.close()
    error = process.stderr.read()
    process.stderr.close()
    # argparse hides failures while it prints; later ones are not hidden.
    assert process.wait(timeout=HANGS) == (0 if command == "--help" and unbuffered else cli.EXIT_BROKEN_PIPE)
    assert error == ""


@pytest.mark.skipif(sys.platform == "win32", reason="pipes break otherwise there")
def test_a_reader_that_leaves_is_no_error_of_the_folder():
    code = """
import sys
from stiefel_rs import cli
from stiefel_rs.reproduce import command
def write(*_, **__):
    raise BrokenPipeError(32, "Broken pipe")
command.write = write
sys.exit(cli.main(["reproduce"]))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=HANGS, check=False)
    assert (done.returncode, done.stderr) == (cli.EXIT_BROKEN_PIPE, "")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a file of Linux")
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_full_device_is_an_error_of_the_output(unbuffered):
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "stiefel_rs", "info"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            timeout=HANGS,
            check=False,
            env=os.environ | {"PYTHONUNBUFFERED": unbuffered},
        )
    assert done.returncode == 1
    assert done.stderr == "stiefel-rs: standard output: No space left on device\n"


@pytest.mark.skipif(sys.platform == "win32", reason="a shell of POSIX")
def test_a_closed_output_is_no_error():
    shell = ["sh", "-c", '"$0" -m stiefel_rs info >&-', sys.executable]
    done = subprocess.run(shell, capture_output=True, text=True, timeout=HANGS, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_version():
    done = run("--version")
    assert done.returncode == 0
    assert re.fullmatch(r"stiefel-rs \d+\.\d+\.\d+\S*\n", done.stdout)


@pytest.mark.parametrize("experiment", experiments.EXPERIMENTS, ids=lambda e: e.name)
def test_spatial_momentum_is_conserved_by_the_reference(experiment):
    momentum = flows.spatial_momentum(experiment, experiments.reference(experiment, 20))
    # The error of the reference, 1e-13, times the size of the coefficients.
    np.testing.assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), atol=1e-12)


@pytest.mark.parametrize("experiment", experiments.EXPERIMENTS, ids=lambda e: e.name)
def test_cyclic_momenta_are_conserved_by_the_discrete_flows(experiment):
    for step_map in experiments.MAPS:
        drift = flows.drift(experiment, step_map, 50)
        assert max(values.max() for values in drift.cyclic.values()) < 50 * np.finfo(float).eps
        assert drift.energy[0] == 0.0


def test_covariant_convention_matches_the_coordinate_one_where_the_symbols_vanish():
    # On the equator of the sphere Gamma = 0, so the accelerations agree; the jerks differ by the derivative of Gamma.
    momenta = readings.momenta_by_reading(experiments.SPHERE)
    covariant, coordinate = momenta["covariant derivatives"], momenta[readings.USED]
    np.testing.assert_allclose(covariant[1], coordinate[1], atol=1e-15)
    np.testing.assert_allclose(covariant[0], [-0.1, -0.2], atol=1e-15)


def test_overtaking_is_the_first_n_with_a_smaller_error():
    rows = [experiments.mean_errors(experiments.SPHERE, n) for n in (5, 100)]
    n = experiments.overtakes(experiments.SPHERE, rows, "midpoint_bvp")
    before, at = (experiments.mean_errors(experiments.SPHERE, m).errors for m in (n - 1, n))
    assert before["midpoint_bvp"] >= before["gcp"] and at["midpoint_bvp"] < at["gcp"]
    assert experiments.overtakes(experiments.SPHERE, rows, "initial_point_ivp") is None


def test_diameter_is_the_distance_of_opposite_points():
    for experiment in experiments.EXPERIMENTS:
        point = experiment.chart.embed(experiment.q)
        assert math.isclose(np.linalg.norm(2 * point), experiment.diameter, rel_tol=1e-15)
