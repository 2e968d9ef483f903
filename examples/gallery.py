"""All examples: their figures, and docs/gallery.md with their numbers."""

from __future__ import annotations

import argparse
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

Written by `make gallery`, which runs the scripts of [examples/](../examples), each of them shorter than 150 lines. One
alone: `python examples/attitude.py --out attitude.png`, with the package, SciPy and matplotlib installed.

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

[uneven_keyframes.py](../examples/uneven_keyframes.py) turns a pan/tilt camera through six directions, at times 0.3
s to 3 s apart, by up to {uneven[largest_turn]:.0f} degrees from one to the next. Between 2.5 s and 4.5 s SciPy's
`RotationSpline` speeds up, almost stops and speeds up again; ours speeds up once.

| | cost (rad²/s³) | largest acceleration (degrees/s²) |
|---|---|---|
| `stiefel_rs.RotationSpline` | {uneven[cost]:.1f} | {uneven[peak]:.0f} |
| the same, with SciPy's angular velocities at the ends | {uneven[cost_same_ends]:.1f} | {uneven[peak_same_ends]:.0f} |
| `scipy.spatial.transform.RotationSpline` | {uneven[cost_scipy]:.1f} | {uneven[peak_scipy]:.0f} |

SciPy's spline starts and ends with the mean angular velocities of the first and the last interval. These ends
explain a tenth of the difference in cost. The rest is due to its pieces: the rotation vector from the keyframe
before is a cubic polynomial of time, which comes close to the least cost only while that vector is short. Here it
is up to {uneven[largest_rotation_vector]:.0f} degrees long.

The data were chosen to show this. Of {uneven[random_many]} random sets of four to six keyframes, with intervals of
0.3 s to 0.5 s and of 2 s to 6 s in turn and a largest turn of 100 to 150 degrees, SciPy's spline costs
{uneven[random_cost_50]:.1f} times as much in the median ({uneven[random_cost_10]:.1f} to
{uneven[random_cost_90]:.1f} times from the 10th to the 90th percentile), and its largest acceleration is
{uneven[random_peak_50]:.1f} times as large ({uneven[random_peak_10]:.1f} to {uneven[random_peak_90]:.1f}). SciPy's
spline has the lower cost in {uneven[random_cost_lower]} sets and the lower largest acceleration in
{uneven[random_peak_lower]}. For {uneven[random_failed]} sets ours is not found: it raises `ConvergenceError`.

## A camera moved by hand

![Left and middle: errors of rotations and positions of four curves relative to those of PoseSpline, against the
time between keyframes. Right: the body rate of interpolated and of smoothed poses](figures/gallery/camera_path.svg)

[camera_path.py](../examples/camera_path.py) reads {camera[seconds]:.0f} s of a [recorded camera
path](../examples/data/README.md) (CC BY 4.0), {camera[poses]} poses in a TUM file. It keeps every m-th pose and
measures how far curves through them are from the poses left out: roots of the mean squares, in degrees and mm. The
poses left out have noise themselves.

{camera_table}

Splines differ little on this path, which turns by less than 20 degrees between keyframes. `PoseSpline` has the
least error of rotations with every 10th and 20th pose as keyframes, by less than 1 %; with every 50th and 100th
SciPy's `RotationSpline` is 1 to 2 % better, and ours 4 to 6 % better than a B-spline of the quaternions. Errors of
positions differ by the ends alone: both are cubic splines, ours with natural ends, SciPy's not-a-knot. Slerp and
straight lines are up to 4 times worse.

Where the poses are dense, their noise counts. With every 2nd pose `PoseSpline.smoothing`, whose lambda is found by
generalised cross-validation, has less error than every interpolating spline and the same error of rotations as
slerp; its root mean square acceleration is {smooth_angular:.0f} degrees/s² and {smooth_linear:.1f} m/s², where the
spline through the poses has {near_angular:.0f} and {near_linear:.1f}. With every 4th pose it smooths rotations too
much and has more error than all interpolating curves; it still has the least error of positions. SciPy's smoothing
splines of the components of the quaternions have more error of rotations in both cases.

## A target kept in view

![Left: the angle between the camera's axis and the target against time, for two curves. Right: their angular
accelerations, the largest of one a quarter of that of the other](figures/gallery/target_in_view.svg)

[target_in_view.py](../examples/target_in_view.py) flies a camera along a straight line past a target. With keyframes
that point at the target, a `RotationSpline` through 13 of them follows it to {target[pointing][off]:.1f} degrees, and
accelerates by up to {target[pointing][peak]:.0f} degrees/s². Where the target may be 8 degrees off the middle of the
picture, the keyframes can be moved: L-BFGS with the gradient of
[`stiefel_rs.jax.rotation_spline`](reference/gradients.md) lowers the integral of the squared angular acceleration from
{target[pointing][cost]:.2f} to {target[optimised][cost]:.2f} rad²/s³, and the largest one to
{target[optimised][peak]:.0f} degrees/s², in {target[iterations]} iterations. The excess of the angle is a penalty: the
largest angle is {target[optimised][off]:.2f} degrees.

## Rates and orientations fitted together

![Left: one component of the body rate, true, of a spline through the measured orientations, and fitted. Right: the
misfit of the measurements of each step, falling from 45 to 2](figures/gallery/gyro_fit.svg)

[gyro_fit.py](../examples/gyro_fit.py) has 20 s of simulated measurements: a gyro at 50 Hz with a bias, and
orientations every half second with an error of {gyro[measured]:.1f} degrees. The 41 keyframes of a `RotationSpline`
and the bias are fitted to both by Adam from optax, with the gradient of the misfit at 64 rates and 16 orientations
picked at random in each of 400 steps. The fitted curve is off by {gyro[fitted]:.1f} degrees (root of the mean square
over all times); a spline through the measured orientations, by {gyro[through]:.1f}. The bias is found to
{gyro[bias_percent]:.0f} % of its length.

## A reduced model

![Left: temperatures for three positions of the interface. Right: errors of the reduced models against the position of
the interface](figures/gallery/reduced_order_model.svg)

[reduced_order_model.py](../examples/reduced_order_model.py) solves the heat equation on 2000 points for five positions
of the interface between two materials. The six modes (POD) that hold most of a solution are a point of St(2000,6). In
between, modes are needed without solving: those of the nearest position give an error of the reduced model of
{nearest:.1e} (root of the mean square over 49 positions); a natural spline of the entries {entries:.1e}; the same, made
orthonormal, {orthonormal:.1e}; `CubicSpline` on the manifold {spline:.1e}, {gain_entries:.1f} and
{gain_orthonormal:.1f} times less. The modes of each position itself, which need its solution, would give {own:.0e}.

The gain is that of few, far positions, and not always there. With seven positions ends count more than the manifold:
natural ends give {spline7:.1e} on it, {orthonormal7:.1e} by entries made orthonormal, SciPy's not-a-knot ends
{not_a_knot7:.1e} by the latter ({not_a_knot:.1e} with five).

## Subspaces for a reduced model

![Errors of reduced models against the direction of the wind, by ways to have modes in between: left in a quarter of a
circle, right in a full circle](figures/gallery/reduced_model.svg)

[reduced_model.py](../examples/reduced_model.py) has a plume in wind, from a source in the middle of a square, on 1600
points. The parameter is the direction of the wind. The six modes (POD) are computed for 7 directions in a quarter of a
circle, or for 18 in a full one, with the signs that the singular value decomposition returns. A reduced model depends
on their span only, so `CubicSpline(winds, modes, manifold=Grassmann(1600, 6))` joins the spans. Errors of the reduced
models between these directions, as roots of the mean squares:

{plume_table}

In a tangent space, the logarithms of all subspaces are interpolated entry by entry ([Amsallem, Farhat
2008](https://doi.org/10.2514/1.35374)). In the quarter, where all subspaces are within
{plume[quarter][from_middle]:.0f} degrees of the one in the middle, this beats `CubicSpline` with natural ends, which
suppose that the acceleration there is zero. With end velocities, those of the cubic polynomial through the first four
subspaces in the tangent space of the first, the spline has {plume_natural:.1f} times less error than with natural
ends, and {plume_quarter:.0f} % less than the spline in the tangent space at the middle.

In the full circle some subspaces are {plume[circle][from_middle]:.0f} degrees from the one in the middle, and the
tangent space there fails. The one at the Karcher mean does not, with all subspaces within
{plume[circle][from_mean]:.0f} degrees, nor does a new one at the nearest subspace for each direction, whose curve is
not continuous. The periodic spline has {plume_mean:.0f} % and {plume_local:.0f} % less error, without a base to
choose. All of these errors are far above the one with the modes of the direction itself, {plume[circle][own]:.1e}; the
nearest approximation by these modes has {plume[circle][floor]:.1e}. More directions help more than another curve: with
36 of them, 10 degrees apart, the error of the periodic spline is {plume[circle][half_the_step]:.1e}.

`CubicSpline` without `manifold=` takes the modes as frames. With their signs as they are it raises `ConvergenceError`:
a column that changes its sign is half a turn away. Turned by `Grassmann.align`, each to be near to the one before,
frames give the same error as subspaces in the quarter.

SMT {plume[libraries][versions][smt]} and UQpy {plume[libraries][versions][UQpy]} were run separately, by
[subspaces_by_other_libraries.py](../examples/subspaces_by_other_libraries.py). SMT's `PODI.interp_subspaces`
interpolates in a tangent space by Kriging. In the quarter it fits the shortest correlation length that it allows to
four of six coefficients, with which values between the data fall back to their mean. UQpy's `GrassmannInterpolation`
interpolates linearly between points of two or more parameters; the second was made up.

## A plane that moves

![Left: three entries of a basis of the plane: of noisy windows, smoothed, and true. Right: angle to the true
plane](figures/gallery/moving_subspace.svg)

[moving_subspace.py](../examples/moving_subspace.py) has 24 noisy sensors whose signals stay near a plane that turns, by
up to {turned:.0f} degrees in a minute. Windows of one second give it as their two largest principal components, with an
error of {rms_one_window:.1f} degrees (root of the mean square). Longer windows are less noisy and lag behind; the
length that is best, known here since the truth is, is {best_length} s, with {rms_best_length:.1f} degrees.
`SmoothingSpline` through the bases of the short windows, points of St(24,2) turned in their planes to be near to each
other, has {rms_smoothed:.1f} degrees, with a lambda that generalised cross-validation found from the data alone.

## A grand tour of the penguins

![Eight pictures of the penguins along the tour, and the share of the variance that is between the
species](figures/gallery/grand_tour.svg)

[grand_tour.py](../examples/grand_tour.py) looks at the six measurements (bill length and depth, flipper length, mass,
two isotope ratios) of {rows} penguins, from the [data of the palmerpenguins package](../examples/data/README.md)
(CC0), through two-dimensional projections: points of St(6,2). Along shortest curves between seven random ones, at
speed 1, the velocity turns abruptly by {smallest_turn_of_geodesics:.1f} to {largest_turn_of_geodesics:.1f}; the spline
through the same seven moves on smoothly. At t = {best_separation_time:.1f} the picture separates the species best:
{best_separation:.0%} of its variance is between them.

## A path through quantum gates

![Above: Pauli components of the Hamiltonians of four paths through six two-qubit gates. Below: their slew
rates](figures/gallery/quantum_gates.svg)

[quantum_gates.py](../examples/quantum_gates.py) goes through the gates I, CNOT, CZ, iSWAP, SWAP and controlled
Hadamard, points of U(4) at times 0 to 5. Their global phases are chosen so that the geodesic from the gate before is
shortest. By Schrödinger's equation `i dU/dt = H U`, every path has the Hamiltonian `H = i dU/dt U^H`. With stops, the
share `3 s² - 2 s³` of a geodesic is done when the share `s` of its time has passed.

{gates_table}

The Hamiltonian of geodesics is constant between gates and jumps at them; that of a spline is continuous, and so is its
derivative. `CubicSpline(times, gates, manifold=Stiefel(4, 4, field="complex"))` makes the integral in the third column
stationary, twice its `cost()`: the canonical metric of U(4) is bi-invariant, and the covariant acceleration is
`-i dH/dt U`. In this metric all 16 Pauli components of `dH/dt` have the same weight; a device whose terms differ in
what they cost needs another one, which splines do not have. A natural
spline starts and ends with a Hamiltonian that is not zero, of norm {gates[natural spline][at_ends]:.1f} at most, a
clamped one with zero. Both need a larger Hamiltonian than geodesics, by {gates_more_natural:.0f} % and
{gates_more_clamped:.0f} %. Geodesics with stops start and end with zero too, and need a larger Hamiltonian and a
larger slew rate than the clamped spline.

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


def write(folder: Path) -> None:
    """Run all examples; their page and their figures go into the folder."""
    figures = folder / FIGURES.relative_to(DOCS)
    text = page({name: main(figures / f"{name}.svg") for name, main in EXAMPLES.items()})
    (folder / "gallery.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Run all examples: the page and the figures of the gallery.")
    parser.add_argument("--out", type=Path, default=DOCS, help="folder for gallery.md and figures/")
    write(parser.parse_args().out)
