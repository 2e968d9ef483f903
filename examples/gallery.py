"""All examples: their figures, and docs/gallery.md with their numbers."""

from __future__ import annotations

import argparse
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from textwrap import fill
from typing import Any

import attitude
import camera_path
import grand_tour
import gyro_fit
import moving_subspace
import quantum_gates
import reduced_model
import reduced_order_model
import subspace_curves
import target_in_view
import uneven_keyframes
from figures import FIGURES

WIDTH = 120
DOCS = FIGURES.parent.parent
EXAMPLES = {
    "attitude": attitude.main,
    "uneven_keyframes": uneven_keyframes.main,
    "camera_path": camera_path.main,
    "target_in_view": target_in_view.main,
    "gyro_fit": gyro_fit.main,
    "reduced_order_model": reduced_order_model.main,
    "reduced_model": reduced_model.main,
    "moving_subspace": moving_subspace.main,
    "grand_tour": grand_tour.main,
    "quantum_gates": quantum_gates.main,
}

# Their numbers have the name of the example in the text.
NAMED = ("uneven_keyframes", "camera_path", "target_in_view", "gyro_fit", "reduced_model", "quantum_gates")

TEXT = """\
# Gallery

Each section is a script of [examples/](../examples), shorter than 150 lines. To run one:
`python examples/attitude.py --out attitude.png`, with the package, SciPy and matplotlib installed.

## A satellite turns through keyframes

![Left: azimuth and elevation of the body's first axis along three curves through six keyframes. Right: lengths of
angular velocity and angular acceleration. Below: the axes of the body along two of the
curves](figures/gallery/attitude.svg)

[attitude.py](../examples/attitude.py) joins six orientations in 230 s: two pairs of targets 12 s apart, between slews
of more than a minute with turns of up to {largest_turn:.0f} degrees. The curves are `CubicSpline`, with the
orientations as points of St(3,3), SciPy's `RotationSpline`, and slerp. The natural Riemannian spline makes the
integral of the squared angular acceleration stationary: the torque that a round body needs. Its cost is {cost:.2f}e-3
rad²/s³, `RotationSpline` has {cost_rotation_spline:.2f}e-3, {more:.0f} % more. The angular acceleration of both is
continuous; that of the natural spline is zero at the ends. Its largest value is {largest_acceleration:.2f}
degrees/s², with `RotationSpline` {largest_acceleration_rotation_spline:.2f}. The two curves are up to
{farthest_apart:.0f} degrees apart. Slerp's angular velocity jumps, at one keyframe by {jump_of_slerp_velocity:.1f}
degrees/s, which no finite torque does.

These keyframes were chosen so that the curves differ. Through seven keyframes at nearly even times and with turns of
40 to 65 degrees, also in the script, they are {even_apart:.1f} degrees apart at most, and the costs differ by
{even_more:.0f} %.

## Keyframes at uneven times

![Angular velocity and angular acceleration against time: SciPy's curve slows down from 140 to 20 degrees/s and
speeds up again between two keyframes, the other speeds up once](figures/gallery/uneven_keyframes.svg)

[uneven_keyframes.py](../examples/uneven_keyframes.py) turns a pan/tilt camera through six directions, at times 0.3 s to
3 s apart, with turns of up to {uneven[largest_turn]:.0f} degrees. Between 2.5 s and 4.5 s SciPy's `RotationSpline`
speeds up, almost stops and speeds up again; `stiefel_rs.RotationSpline` speeds up once.

| | cost (rad²/s³) | largest acceleration (degrees/s²) |
|---|---|---|
| `stiefel_rs.RotationSpline` | {uneven[cost]:.1f} | {uneven[peak]:.0f} |
| the same, with SciPy's angular velocities at the ends | {uneven[cost_same_ends]:.1f} | {uneven[peak_same_ends]:.0f} |
| `scipy.spatial.transform.RotationSpline` | {uneven[cost_scipy]:.1f} | {uneven[peak_scipy]:.0f} |

SciPy's spline starts and ends with the mean angular velocities of the first and the last interval. These end conditions
explain a tenth of the difference in cost. The rest is due to the pieces: in SciPy's spline the rotation vector from the
previous keyframe is a cubic polynomial of time, which is close to optimal only while the vector is short. Here it is up
to {uneven[largest_rotation_vector]:.0f} degrees long.

The keyframes were chosen to show this effect. On {uneven[random_many]} random sets of four to six keyframes, with
intervals alternating between 0.3 to 0.5 s and 2 to 6 s and a largest turn of 100 to 150 degrees, the cost of SciPy's
spline is {uneven[random_cost_50]:.1f} times as high in the median ({uneven[random_cost_10]:.1f} to
{uneven[random_cost_90]:.1f} from the 10th to the 90th percentile), and its largest acceleration
{uneven[random_peak_50]:.1f} times as high ({uneven[random_peak_10]:.1f} to {uneven[random_peak_90]:.1f}). SciPy's
spline has the lower cost in {uneven[random_cost_lower]} sets and the lower largest acceleration in
{uneven[random_peak_lower]}. For {uneven[random_failed]} sets `stiefel_rs.RotationSpline` raises `ConvergenceError`.

## A camera moved by hand

![Left and middle: errors of rotations and positions of four curves relative to those of PoseSpline, against the
time between keyframes. Right: the body rate of interpolated and of smoothed poses](figures/gallery/camera_path.svg)

[camera_path.py](../examples/camera_path.py) reads {camera[seconds]:.0f} s of a [recorded camera
path](../examples/data/README.md) (CC BY 4.0), {camera[poses]} poses in a TUM file. It keeps every m-th pose and
measures the root-mean-square (RMS) distance of curves through them to the omitted poses, which are noisy themselves.

{camera_table}

Splines differ little on this path, which turns by less than 20 degrees between keyframes. With every 10th and 20th
pose, `PoseSpline` has the smallest rotation error, by less than 1 %. With every 50th and 100th, SciPy's
`RotationSpline` is 1 to 2 % better, and `PoseSpline` is 4 to 6 % better than a B-spline of the quaternions. Position
errors differ only by the end conditions of the cubic splines, natural for `PoseSpline` and not-a-knot for SciPy. Slerp
and straight lines have up to 4 times larger errors.

With dense poses noise dominates. With every 2nd pose `PoseSpline.smoothing`, with lambda from
generalised cross-validation, has smaller errors than every interpolating spline and the same rotation error as
slerp. Its RMS acceleration is {smooth_angular:.0f} degrees/s² and {smooth_linear:.1f} m/s²; the
interpolating spline has {near_angular:.0f} and {near_linear:.1f}. With every 4th pose it smooths rotations too
much, with a larger rotation error than all interpolating curves, but has the smallest position error. SciPy's smoothing
splines of the quaternion components have larger rotation errors in both cases.

## A target kept in view

![Left: the angle between the camera's axis and the target against time, for two curves. Right: their angular
accelerations, the largest of one a quarter of that of the other](figures/gallery/target_in_view.svg)

[target_in_view.py](../examples/target_in_view.py) flies a camera along a straight line past a target. With keyframes
that point at the target, a `RotationSpline` through 13 of them follows it to {target[pointing][off]:.1f} degrees, and
accelerates by up to {target[pointing][peak]:.0f} degrees/s². If the target may be up to 8 degrees off the centre of the
picture, the keyframes can be optimised: L-BFGS with the gradient of
[`stiefel_rs.jax.rotation_spline`](reference/gradients.md) reduces the integral of the squared angular acceleration from
{target[pointing][cost]:.2f} to {target[optimised][cost]:.2f} rad²/s³, and the largest acceleration to
{target[optimised][peak]:.0f} degrees/s², in {target[iterations]} iterations. Angles above 8 degrees are penalised; the
largest angle is {target[optimised][off]:.2f} degrees.

## Rates and orientations fitted together

![Left: one component of the body rate, true, of a spline through the measured orientations, and fitted. Right: the
misfit of the measurements of each step, falling from 45 to 2](figures/gallery/gyro_fit.svg)

[gyro_fit.py](../examples/gyro_fit.py) uses 20 s of simulated measurements: a gyro at 50 Hz with a bias, and
orientations every half second with an error of {gyro[measured]:.1f} degrees. Adam (optax) fits the 41 keyframes of a
`RotationSpline` and the bias to both, with the gradient of the misfit at 64 random rates and 16 random orientations in
each of 400 steps. The fitted curve has an RMS error of {gyro[fitted]:.1f} degrees; a spline through the measured
orientations, {gyro[through]:.1f}. The bias has an error of {gyro[bias_percent]:.0f} %.

## A reduced model

![Left: temperatures for three positions of the interface. Right: errors of the reduced models against the position of
the interface](figures/gallery/reduced_order_model.svg)

[reduced_order_model.py](../examples/reduced_order_model.py) solves the heat equation on 2000 points for five positions
of the interface between two materials. The six dominant POD modes of each solution are a point of St(2000,6). Modes for
positions in between are interpolated. RMS errors of the reduced model over 49 positions: {nearest:.1e} with the modes
of the nearest position; {entries:.1e} with a natural spline of the matrix entries; {orthonormal:.1e} if its values are
made orthonormal; {spline:.1e} with `CubicSpline` on the manifold, which is {gain_entries:.1f} and
{gain_orthonormal:.1f} times smaller. The modes of each position itself, which need its solution, give {own:.0e}.

The advantage appears only with few, widely spaced positions, and not always. With seven positions the end conditions
matter more than the manifold: natural ends give {spline7:.1e} on the manifold and {orthonormal7:.1e} with
orthonormalised entries; SciPy's not-a-knot ends give {not_a_knot7:.1e} with the latter ({not_a_knot:.1e} with five
positions).

## Subspaces for a reduced model

![Errors of reduced models against the direction of the wind, by ways to have modes in between: left in a quarter of a
circle, right in a full circle](figures/gallery/reduced_model.svg)

[reduced_model.py](../examples/reduced_model.py) models a plume in wind, from a source in the middle of a square, on
1600 points. The parameter is the direction of the wind. Six POD modes are computed for 7 directions in a quarter of a
circle, or for 18 in a full circle, with the signs that the singular value decomposition returns. A reduced model
depends only on their span, so `CubicSpline(winds, modes, manifold=Grassmann(1600, 6))` interpolates the spans. RMS
errors of the reduced models between these directions:

{plume_table}

In a tangent space, the logarithms of all subspaces are interpolated entry by entry ([Amsallem, Farhat
2008](https://doi.org/10.2514/1.35374)). In the quarter circle, where all subspaces are within
{plume[quarter][from_middle]:.0f} degrees of the middle one, this beats `CubicSpline` with natural ends, which assume
zero acceleration. With end velocities taken from the cubic polynomial through the first four subspaces in the tangent
space of the first, the error of the spline is {plume_natural:.1f} times smaller than with natural ends, and
{plume_quarter:.0f} % smaller than that of the spline in the tangent space at the middle.

In the full circle some subspaces are {plume[circle][from_middle]:.0f} degrees from the middle one, and the tangent
space there fails. The tangent space at the Karcher mean works, with all subspaces within
{plume[circle][from_mean]:.0f} degrees, and so does the one at the nearest subspace for each direction, whose curve is
discontinuous. The periodic spline has {plume_mean:.0f} % and {plume_local:.0f} % smaller errors, without choosing a
base point. All of these errors are far above that with the modes of the direction itself, {plume[circle][own]:.1e};
the best approximation by these modes has {plume[circle][floor]:.1e}. More directions help more than another curve:
with 36 directions, 10 degrees apart, the error of the periodic spline is {plume[circle][half_the_step]:.1e}.

Without `manifold=`, `CubicSpline` treats the modes as frames and raises `ConvergenceError`, because a column with the
opposite sign is half a turn away. If each frame is first aligned with the previous one by `Grassmann.align`, frames
give the same error as subspaces in the quarter circle.

SMT {plume[libraries][versions][smt]} and UQpy {plume[libraries][versions][UQpy]} were run separately, by
[subspaces_by_other_libraries.py](../examples/subspaces_by_other_libraries.py). SMT's `PODI.interp_subspaces`
interpolates in a tangent space by Kriging. In the quarter circle it fits its shortest allowed correlation length to
four of six coefficients, so that values between the data fall back to the mean. UQpy's `GrassmannInterpolation`
interpolates linearly in two or more parameters; a dummy second parameter was added.

## A plane that moves

![Left: three entries of a basis of the plane: of noisy windows, smoothed, and true. Right: angle to the true
plane](figures/gallery/moving_subspace.svg)

[moving_subspace.py](../examples/moving_subspace.py) simulates 24 noisy sensors whose signals stay near a plane that
turns by up to {turned:.0f} degrees in a minute. The two largest principal components of windows of one second estimate
the plane with an RMS error of {rms_one_window:.1f} degrees. Longer windows are less noisy but lag behind; the best
length, known only because the truth is, is {best_length} s, with {rms_best_length:.1f} degrees. A `SmoothingSpline` of
the bases of the short windows, aligned as points of St(24,2), has {rms_smoothed:.1f} degrees, with lambda from
generalised cross-validation of the data.

## A grand tour of the penguins

![Eight pictures of the penguins along the tour, and the share of the variance that is between the
species](figures/gallery/grand_tour.svg)

[grand_tour.py](../examples/grand_tour.py) shows six measurements (bill length and depth, flipper length, mass, two
isotope ratios) of {rows} penguins, from the [data of the palmerpenguins package](../examples/data/README.md) (CC0), in
two-dimensional projections, which are points of St(6,2). Along geodesics between seven random projections, at speed 1,
the velocity jumps by {smallest_turn_of_geodesics:.1f} to {largest_turn_of_geodesics:.1f}; the spline through the same
projections is smooth. At t = {best_separation_time:.1f} the projection separates the species best:
{best_separation:.0%} of its variance is between them.

## A path through quantum gates

![Above: Pauli components of the Hamiltonians of four paths through six two-qubit gates. Below: their slew
rates](figures/gallery/quantum_gates.svg)

[quantum_gates.py](../examples/quantum_gates.py) interpolates the gates I, CNOT, CZ, iSWAP, SWAP and controlled
Hadamard, points of U(4) at times 0 to 5. Global phases are chosen so that the geodesic from the previous gate is
shortest. By Schrödinger's equation `i dU/dt = H U`, every path has the Hamiltonian `H = i dU/dt U^H`. Geodesics with
stops have covered the fraction `3 s² - 2 s³` of their length after the fraction `s` of their time.

{gates_table}

The Hamiltonian of geodesics is constant between gates and jumps at gates; that of a spline is continuously
differentiable. `CubicSpline(times, gates, manifold=Stiefel(4, 4, field="complex"))` makes the integral in the third
column stationary, which is twice its `cost()`: the canonical metric of U(4) is bi-invariant, and the covariant
acceleration is `-i dH/dt U`. In this metric all 16 Pauli components of `dH/dt` have the same weight; a device with
terms of different cost would need another metric, which splines do not support. The Hamiltonian of the natural spline
has a norm of up to {gates[natural spline][at_ends]:.1f} at the ends, that of the clamped spline is zero there. Both
need a larger Hamiltonian than geodesics, by {gates_more_natural:.0f} % and {gates_more_clamped:.0f} %. Geodesics with
stops also start and end with zero, and need a larger Hamiltonian and slew rate than the clamped spline.

All Hamiltonians are Hermitian to {gates_hermitian:.0e}. SciPy's `solve_ivp` with a relative tolerance of 1e-12, started
at the first gate, passes all others within {gates_missed:.0e}.
"""


def wrapped(text: str) -> str:
    """Paragraphs in lines of the usual width; headings and tables stay."""
    paragraphs = (
        part if part.startswith(("#", "|")) else fill(part, WIDTH, break_long_words=False, break_on_hyphens=False)
        for part in text.strip().split("\n\n")
    )
    return "\n\n".join(paragraphs) + "\n"


def camera_table(table: dict[str, dict[str, tuple[float, float]]]) -> str:
    """Errors of rotations and positions as a table, a row for each curve."""
    names = list(dict.fromkeys(name for row in table.values() for name in row))
    lines = [f"| every m-th pose | {' | '.join(f'm = {m}' for m in table)} |", "|---" * (len(table) + 1) + "|"]
    for name in names:
        pairs = [row.get(name) for row in table.values()]
        cells = ["" if pair is None else f"{pair[0]:.3f}°, {pair[1]:.2f} mm" for pair in pairs]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def camera_values(numbers: dict[str, Any]) -> dict[str, Any]:
    """Numbers of the camera path as the text names them."""
    near, smooth = (numbers["accelerations"][name] for name in (camera_path.OURS, camera_path.SMOOTHED))
    accelerations = {
        "near_angular": near[0],
        "near_linear": near[1],
        "smooth_angular": smooth[0],
        "smooth_linear": smooth[1],
    }
    return {"camera": numbers, "camera_table": camera_table(numbers["errors"])} | accelerations


def heat_values(numbers: dict[str, dict[str, float]]) -> dict[str, float]:
    """Errors of the reduced models, and how much less that of the spline is."""
    names = {
        "nearest": reduced_order_model.NEAREST,
        "entries": reduced_order_model.ENTRIES,
        "orthonormal": reduced_order_model.ORTHONORMAL,
        "spline": reduced_order_model.SPLINE,
        "own": reduced_order_model.OWN,
        "not_a_knot": reduced_order_model.NOT_A_KNOT,
    }
    five = {key: numbers["five"][name] for key, name in names.items()}
    seven = {f"{key}7": numbers["seven"][name] for key, name in names.items()}
    gains = {f"gain_{key}": five[key] / five["spline"] for key in ("entries", "orthonormal")}
    return five | seven | gains


def plume_table(numbers: dict[str, dict[str, Any]]) -> str:
    """Errors of the plume's reduced models as a table, a row for each way to have modes."""
    versions = numbers["libraries"]["versions"]
    rows = {
        "modes of the nearest direction": subspace_curves.NEAREST,
        "geodesics from one to the next": subspace_curves.GEODESICS,
        "tangent space at the middle, linear": subspace_curves.LINEAR,
        "tangent space at the middle, polynomial": subspace_curves.POLYNOMIAL,
        "tangent space at the middle, spline (not-a-knot, periodic)": subspace_curves.TANGENT,
        "tangent space at the mean, spline (not-a-knot, periodic)": subspace_curves.MEAN,
        "tangent space at the nearest, cubic through four": subspace_curves.LOCAL,
        "`CubicSpline` on the manifold (natural, periodic)": subspace_curves.SPLINE,
        "`CubicSpline` on the manifold, with end velocities": subspace_curves.ENDS,
        "`CubicSpline` of aligned frames (natural)": subspace_curves.ALIGNED,
        "modes of the direction itself": reduced_model.OWN,
        f"SMT {versions['smt']}, tangent space at the middle": "smt",
        f"SMT {versions['smt']}, tangent space at the mean": "smt, mean",
        f"UQpy {versions['UQpy']}, tangent space at the mean": "UQpy",
    }
    lines = ["| | quarter | circle |", "|---|---|---|"]
    for label, name in rows.items():
        found = [(numbers[range_] | numbers["libraries"][range_]).get(name) for range_ in ("quarter", "circle")]
        lines.append(f"| {label} | {' | '.join('' if each is None else f'{each:.2e}' for each in found)} |")
    return "\n".join(lines)


def plume_values(numbers: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Numbers of the plume as the text names them."""
    quarter, circle = numbers["quarter"], numbers["circle"]
    spline = subspace_curves.SPLINE
    return {
        "plume": numbers | {"circle": circle | {"own": circle[reduced_model.OWN]}},
        "plume_table": plume_table(numbers),
        "plume_natural": quarter[spline] / quarter[subspace_curves.ENDS],
        "plume_quarter": 100 * (1 - quarter[subspace_curves.ENDS] / quarter[subspace_curves.TANGENT]),
        "plume_mean": 100 * (1 - circle[spline] / circle[subspace_curves.MEAN]),
        "plume_local": 100 * (1 - circle[spline] / circle[subspace_curves.LOCAL]),
    }


def gates_values(numbers: dict[str, dict[str, float]]) -> dict[str, Any]:
    """Numbers of the quantum gates as the text names them, and a table with a row for each path."""

    def more_than_geodesics(name: str) -> float:
        return 100 * (numbers[name]["largest"] / numbers[quantum_gates.GEODESICS]["largest"] - 1)

    lines = ["| | largest jump of H | largest slew rate | integral of its square | largest absolute eigenvalue of H |"]
    lines.append("|---|---|---|---|---|")
    for name, row in numbers.items():
        smooth = row["jump"] < 1e-9
        rate = (f"{row['slew']:.1f}", f"{row['cost']:.0f}") if smooth else ("infinite", "infinite")
        jump = "0" if smooth else f"{row['jump']:.1f}"
        lines.append(f"| {name} | {jump} | {' | '.join(rate)} | {row['largest']:.2f} |")
    return {
        "gates": numbers,
        "gates_table": "\n".join(lines),
        "gates_more_natural": more_than_geodesics(quantum_gates.NATURAL),
        "gates_more_clamped": more_than_geodesics(quantum_gates.CLAMPED),
        "gates_hermitian": max(row["not_hermitian"] for row in numbers.values()),
        "gates_missed": max(row["farthest"] for row in numbers.values()),
    }


def page(numbers: dict[str, dict[str, Any]]) -> str:
    """The text with its numbers."""
    values = {name: value for example, each in numbers.items() if example not in NAMED for name, value in each.items()}
    gyro = numbers["gyro_fit"]
    values |= {"uneven": numbers["uneven_keyframes"], "target": numbers["target_in_view"]}
    values |= {"gyro": gyro | {"bias_percent": 100 * gyro["bias_off"]}}
    values |= camera_values(numbers["camera_path"])
    costs = numbers["attitude"]["cost"], numbers["attitude"]["cost_rotation_spline"]
    more = 100 * (costs[1] / costs[0] - 1)
    even = numbers["attitude"]["even_cost"], numbers["attitude"]["even_cost_rotation_spline"]
    values |= {"cost": 1e3 * costs[0], "cost_rotation_spline": 1e3 * costs[1], "more": more}
    values |= {"even_more": 100 * (even[1] / even[0] - 1)}
    values |= heat_values(numbers["reduced_order_model"])
    values |= plume_values(numbers["reduced_model"]) | gates_values(numbers["quantum_gates"])
    return wrapped(TEXT.format(**values))


def timed(name: str, figure: Path) -> tuple[dict[str, Any], float]:
    """Numbers of an example, and its duration in seconds."""
    start = time.perf_counter()
    return EXAMPLES[name](figure), time.perf_counter() - start


def run_all(figures: Path) -> dict[str, dict[str, Any]]:
    """Numbers of all examples, run in parallel; a line is printed after each."""
    numbers = {}
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        running = {pool.submit(timed, name, figures / f"{name}.svg"): name for name in EXAMPLES}
        for done in as_completed(running):
            numbers[running[done]], seconds = done.result()
            print(f"{len(numbers)} of {len(EXAMPLES)}: {running[done]}, {seconds:.0f} s", flush=True)
    return {name: numbers[name] for name in EXAMPLES}


def write(folder: Path) -> None:
    """Run all examples; their page and their figures go into the folder."""
    text = page(run_all(folder / FIGURES.relative_to(DOCS)))
    (folder / "gallery.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Run all examples: the page and the figures of the gallery.")
    parser.add_argument("--out", type=Path, default=DOCS, help="folder for gallery.md and figures/")
    write(parser.parse_args().out)
