//! Variations between given ends: transposes, rows outside the span, conjugate ends.

use super::linear_boundary::LinearBoundary;
use super::linear_terms::CurveAtNodes;
use crate::collocation::lane_nodes::LaneNodes;
use crate::collocation::linear_nodes;
use crate::interrupt::Interrupt;
use crate::solve::gmres::{dot, norm};
use crate::space::{Homogeneous, Kind, Quotient, ScalarField, Shape, in_space};

/// A curve that is no cubic, with frames that are not its own: the equations are linear for any.
struct SampledCurve {
    x: [Vec<f64>; 3],
    last: Vec<f64>,
    frames: Vec<f64>,
    end: Vec<f64>,
}

impl SampledCurve {
    /// Coordinates or blocks of a given size; `zero` entries vanish.
    fn new(nodes: &LaneNodes, size: usize, shape: Shape, zero: impl Fn(usize) -> bool) -> Self {
        let at = |derivative: usize, s: f64| -> Vec<f64> {
            let entry = |p: usize| match zero(p) {
                true => 0.0,
                false => ((p + 1) as f64 * 0.9 + s + 1.1 * derivative as f64).sin(),
            };
            (0..size).map(entry).collect()
        };
        let s = &nodes.nodes.s;
        SampledCurve {
            x: std::array::from_fn(|i| s.iter().flat_map(|s| at(i, *s)).collect()),
            last: at(0, 1.0),
            frames: s.iter().flat_map(|s| frame_of(shape, *s)).collect(),
            end: frame_of(shape, 1.0),
        }
    }

    fn view(&self) -> CurveAtNodes<'_> {
        CurveAtNodes {
            x: self.x.each_ref().map(Vec::as_slice),
            last: &self.last,
            frames: &self.frames,
            end: &self.end,
        }
    }
}

/// A frame of the space, by rows: for complex ones with the blocks of real and imaginary parts of points and normals,
/// of a real frame and phases.
fn frame_of(Shape { r, k, kind }: Shape, s: f64) -> Vec<f64> {
    if kind.field == ScalarField::Real {
        return frame(r, s);
    }
    let (half, columns) = (r / 2, k / 2);
    let real = frame(half, s);
    let parts = |a: usize| match a < columns {
        true => [a, a + columns],
        false => [columns + a, half + a],
    };
    let mut out = vec![0.0; r * r];
    for (at, x) in real.iter().enumerate() {
        let (a, b) = (at / half, at % half);
        let (sin, cos) = (s * (0.3 + b as f64)).sin_cos();
        for (i, row) in parts(a).into_iter().zip([[cos, -sin], [sin, cos]]) {
            for (j, turn) in parts(b).into_iter().zip(row) {
                out[i * r + j] = x * turn;
            }
        }
    }
    out
}

/// A product of plane rotations, by rows, that is the identity at 0.
fn frame(r: usize, s: f64) -> Vec<f64> {
    let mut g: Vec<f64> = (0..r * r)
        .map(|at| f64::from(u8::from(at % (r + 1) == 0)))
        .collect();
    for i in 1..r {
        let (sin, cos) = (s * (0.4 + i as f64).cos()).sin_cos();
        for row in g.chunks_exact_mut(r) {
            (row[i - 1], row[i]) = (
                cos * row[i - 1] - sin * row[i],
                sin * row[i - 1] + cos * row[i],
            );
        }
    }
    g
}

fn numbers(count: usize, seed: f64) -> Vec<f64> {
    let number = |i: usize| (seed + 1.7 * i as f64).sin();
    (0..count).map(number).collect()
}

/// Solves forward and transposed with unrelated numbers; the two must agree.
fn assert_transposed(equations: &LinearBoundary) {
    let (d, count) = (equations.terms.dim(), equations.nodes.count());
    let ends = numbers(4 * d, 0.3);
    let parts: [&[f64]; 4] = std::array::from_fn(|end| &ends[end * d..][..d]);
    let found = equations.solve(parts, Interrupt::NEVER).unwrap().unwrap();
    let by_displacements = numbers(d * count, 0.7);
    let by_start = [numbers(d, 1.1), numbers(d, 1.9)];
    let [by_a, by_b] = by_start.each_ref().map(Vec::as_slice);
    let [a, b] = &found.start;
    let value = dot(&by_displacements, &found.displacements) + dot(by_a, a) + dot(by_b, b);
    let gradient = equations.pull_back(&by_displacements, [by_a, by_b], Interrupt::NEVER);
    let gradient = gradient.unwrap().unwrap().concat();
    let size = norm(&gradient) * norm(&ends);
    let error = (dot(&gradient, &ends) - value).abs() / size;
    assert!(error < 1e-13, "{d}: {error:.1e}");
}

fn shapes() -> impl Iterator<Item = Shape> {
    let sizes = [(2, 1), (3, 1), (3, 2), (3, 3), (5, 2), (7, 3)];
    sizes.into_iter().flat_map(|(r, k)| {
        let kinds = [Quotient::Frames, Quotient::Subspaces].map(Kind::real);
        let kinds = kinds
            .into_iter()
            .filter(move |kind| r > k || *kind == Kind::REAL_FRAMES);
        kinds.map(move |kind| Shape { r, k, kind })
    })
}

fn complex_shapes() -> impl Iterator<Item = Shape> {
    let sizes = [(2, 2), (4, 2), (4, 4), (6, 4), (8, 4)];
    sizes.into_iter().flat_map(|(r, k)| {
        let kinds = [Quotient::Frames, Quotient::Subspaces].into_iter();
        let kinds = kinds.filter(move |quotient| r > k || *quotient == Quotient::Frames);
        kinds.map(move |quotient| {
            let field = ScalarField::Complex;
            let kind = Kind { quotient, field };
            Shape { r, k, kind }
        })
    })
}

#[test]
fn the_transpose_is_one() {
    let speeds = [0.2, 1.0, 5.0].into_iter().cycle();
    for (shape, speed) in shapes().chain(complex_shapes()).zip(speeds) {
        let d = in_space!(shape, |space| space.dim());
        let nodes = linear_nodes(speed).unwrap();
        for tension in [0.0, 3.0] {
            for zero in [0, 2] {
                let curve = SampledCurve::new(&nodes, d, shape, |p| zero > 0 && p % zero == 0);
                let equations = LinearBoundary::in_span(shape, &nodes, curve.view(), tension);
                assert_transposed(&equations);
            }
            let curve = SampledCurve::new(&nodes, shape.r * shape.k, shape, |_| false);
            let equations = LinearBoundary::in_row(shape, &nodes, curve.view(), tension);
            assert_transposed(&equations);
        }
    }
}

/// From rest to rest on a sphere, by the angle `total (3 s^2 - 2 s^3)`.
fn from_rest_to_rest(r: usize, total: f64) -> LinearBoundary {
    let nodes = linear_nodes(1.5 * total).unwrap();
    let along = |x: f64| (1..r).map(move |row| if row == 1 { x } else { 0.0 });
    let s = &nodes.nodes.s;
    let frame = |s: f64| -> Vec<f64> {
        let (sin, cos) = (total * s * s * (3.0 - 2.0 * s)).sin_cos();
        let entry = |at: usize| match (at / r, at % r) {
            (0, 0) | (1, 1) => cos,
            (1, 0) => sin,
            (0, 1) => -sin,
            (i, j) => f64::from(u8::from(i == j)),
        };
        (0..r * r).map(entry).collect()
    };
    let rates: [fn(f64) -> f64; 3] = [|s| 6.0 * s * (1.0 - s), |s| 6.0 - 12.0 * s, |_| -12.0];
    let curve = SampledCurve {
        x: rates.map(|rate| s.iter().flat_map(|s| along(total * rate(*s))).collect()),
        last: vec![0.0; r - 1],
        frames: s.iter().flat_map(|s| frame(*s)).collect(),
        end: frame(1.0),
    };
    let kind = Kind::REAL_FRAMES;
    LinearBoundary::in_span(Shape { r, k: 1, kind }, &nodes, curve.view(), 0.0)
}

/// Antipodes are joined by a circle through every direction, other points by one.
#[test]
fn conjugate_ends_are_not_regular() {
    // In the last one, larger solutions are allowed.
    for r in [3, 4, 6, 12, 70] {
        let is_regular = |total: f64| {
            from_rest_to_rest(r, total)
                .is_regular(Interrupt::NEVER)
                .unwrap()
        };
        assert!(is_regular(2.5), "{r}");
        assert!(!is_regular(std::f64::consts::PI), "{r}");
        assert!(!is_regular(std::f64::consts::PI - 1e-6), "{r}");
    }
}

/// A row outside the span is one more row of the space, in which the curve is zero.
#[test]
fn rows_are_those_of_a_larger_space() {
    for shape in shapes() {
        let Shape { r, k, kind } = shape;
        let larger = Shape { r: r + 1, ..shape };
        let nodes = linear_nodes(2.0).unwrap();
        // The blocks, with a skew `omega` that is zero for subspaces.
        let mut short = SampledCurve::new(&nodes, r * k, shape, |_| false);
        let SampledCurve { x, last, .. } = &mut short;
        let vectors = x.iter_mut().chain([last]);
        for x in vectors.flat_map(|x| x.chunks_exact_mut(r * k)) {
            let b = x.to_vec();
            for at in 0..k * k {
                let (i, j) = (at % k, at / k);
                x[at] = match kind.quotient {
                    Quotient::Frames => b[i + k * j] - b[j + k * i],
                    Quotient::Subspaces => 0.0,
                };
            }
        }
        let row = LinearBoundary::in_row(shape, &nodes, short.view(), 0.5);
        let d = in_space!(larger, |space| space.dim());
        let mut places = vec![0; k];
        let mut coordinates = |blocks: &[f64]| -> Vec<f64> {
            let each = blocks.chunks_exact(r * k).flat_map(|x| {
                let mut coordinates = vec![0.0; d];
                in_space!(larger, |space| space.each_entry(|p, i, j| {
                    match i.checked_sub(k) {
                        None => coordinates[p] = x[i + k * j],
                        Some(i) if i < r - k => {
                            coordinates[p] = x[k * k + i + (r - k) * j];
                        }
                        Some(_) => places[j] = p,
                    }
                }));
                coordinates
            });
            each.collect()
        };
        let larger_frame = |frame: &[f64]| -> Vec<f64> {
            let rows = frame.chunks_exact(r);
            let rows = rows.flat_map(|row| row.iter().copied().chain([0.0]));
            rows.chain((0..=r).map(|i| f64::from(u8::from(i == r))))
                .collect()
        };
        let long = SampledCurve {
            x: short.x.each_ref().map(|x| coordinates(x)),
            last: coordinates(&short.last),
            frames: short
                .frames
                .chunks_exact(r * r)
                .flat_map(larger_frame)
                .collect(),
            end: larger_frame(&short.end),
        };
        let whole = LinearBoundary::in_span(larger, &nodes, long.view(), 0.5);
        let ends = numbers(4 * k, 0.9);
        let short: [&[f64]; 4] = std::array::from_fn(|end| &ends[end * k..][..k]);
        let long = short.map(|end| {
            let mut long = vec![0.0; d];
            for (place, x) in places.iter().zip(end) {
                long[*place] = *x;
            }
            long
        });
        let found = row.solve(short, Interrupt::NEVER).unwrap().unwrap();
        let long = long.each_ref().map(Vec::as_slice);
        let expected = whole.solve(long, Interrupt::NEVER).unwrap().unwrap();
        let expected = expected.displacements.chunks_exact(d);
        for (found, expected) in found.displacements.chunks_exact(k).zip(expected) {
            for (found, place) in found.iter().zip(&places) {
                let expected = expected[*place];
                assert!(
                    (found - expected).abs() < 1e-12,
                    "{shape:?}: {found} {expected}"
                );
            }
        }
    }
}
