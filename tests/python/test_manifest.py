"""The manifest of `reproduce`: the circumstances of a run, and digests that a second run reproduces."""

import hashlib
import json
import os
import platform
import subprocess
import sys

import numpy as np
import pytest
from beside import HANGS

import stiefel_rs
from stiefel_rs import _core, cli
from stiefel_rs.reproduce import experiments, manifest

TABLES = [
    "any_shape.csv",
    "conjecture.csv",
    "conjecture_outcomes.csv",
    "control_points.csv",
    "cost.csv",
    "near_start.csv",
]
TABLES += ["readings.csv", "run.json"]
TABLES += [f"{name}{suffix}" for name in ("sphere", "stiefel_3_2") for suffix in (".csv", ".md")]
TABLES += [f"figure_2{panel}{suffix}" for panel in "ab" for suffix in (".csv", ".md", ".tex")]
MEASURED = ["any_shape_times.csv", "challenges.csv", "claims.csv", "embedded.csv", "equal_error.csv"]
MEASURED += ["summary.md", "timing.csv"]


@pytest.fixture(scope="module")
def runs(quick, tmp_path_factory):
    """Folder and printed text of two runs, with one thread and with three."""
    folder = tmp_path_factory.mktemp("second")
    words = [sys.executable, "-m", "stiefel_rs", "reproduce", "--quick", "--out", str(folder)]
    env = os.environ | {"RAYON_NUM_THREADS": "3"}
    done = subprocess.run(words, capture_output=True, text=True, timeout=HANGS, check=False, env=env)
    assert done.returncode == 0, done.stderr
    return [(quick[0], quick[1].stdout), (folder, done.stdout)]


def read(folder):
    return json.loads((folder / "manifest.json").read_text(encoding="utf-8"))


def test_two_runs_give_identical_tables(runs):
    first, second = (read(folder) for folder, _ in runs)
    assert sorted(first["tables"]) == sorted(f"tables/{name}" for name in TABLES)
    assert first["tables"] == second["tables"]
    assert (first["run"].pop("threads"), second["run"].pop("threads")) == (1, 3)
    assert first["run"] == second["run"]
    assert first["figures"] == second["figures"]


def test_what_is_measured_by_the_clock_is_kept_apart(runs):
    found = read(runs[0][0])
    assert sorted(found["measured"]) == [f"tables/{name}" for name in MEASURED]
    timing = [json.loads((folder / "manifest.json").read_text())["measured"]["tables/timing.csv"] for folder, _ in runs]
    # If these were equal, nothing would have been timed.
    assert timing[0] != timing[1]


def test_digests_are_those_of_the_files(runs):
    for folder, said in runs:
        found = read(folder)
        named = {**found["tables"], **found["measured"], **found["figures"]}
        for name, digest in named.items():
            assert hashlib.sha256((folder / name).read_bytes()).hexdigest() == digest, name
        there = {path.relative_to(folder).as_posix() for path in folder.rglob("*.*") if path.is_file()}
        assert set(named) == there - {"manifest.json", "tables/old.csv"}
        assert f"manifest: {folder / 'manifest.json'}\n" in said


def test_versions_processor_seed_and_threads(runs):
    found = read(runs[0][0])
    run = found["run"]
    assert found["format"] == 1
    assert run["versions"]["stiefel-rs"] == stiefel_rs.__version__
    assert run["versions"]["numpy"] == np.__version__
    assert run["versions"]["python"] == platform.python_version()
    assert run["processor"]["name"]
    assert run["processor"]["simd"] == list(_core.simd_features())
    settings = {"steps": [5, 10, 20, 50, 100], "repetitions": 3, "curves": 20, "wide_curves": 6, "quick": True}
    assert run["settings"] == {"seed": 20240419, **settings}


def test_a_changed_table_has_another_digest(tmp_path):
    (tmp_path / "tables").mkdir()
    path = tmp_path / "tables" / "sphere.csv"
    digests = []
    for text in ["1.0\n", "1.0000000000000002\n"]:
        path.write_text(text, encoding="utf-8")
        manifest.write(tmp_path, [path, path], {})
        digests.append(read(tmp_path)["tables"])
    assert list(digests[0]) == ["tables/sphere.csv"]
    assert digests[0] != digests[1]


def test_no_manifest_of_a_run_that_did_not_end(tmp_path, monkeypatch):
    (tmp_path / "manifest.json").write_text("{}", encoding="utf-8")

    def stop(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(experiments, "mean_errors", stop)
    assert cli.main(["reproduce", "--quick", "--out", str(tmp_path)]) == 130
    assert not (tmp_path / "manifest.json").exists()
