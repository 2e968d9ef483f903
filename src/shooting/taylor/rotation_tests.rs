//! Series in three dimensions against those of matrices and against differences.

use super::brackets::minus_bracket_into;
use super::rotation_series::{rotation_reached_into, sum_of_brackets};
use super::series::{LegSeries, at_ends};
use super::variation::MiddleVariation;
use crate::linalg::field::{Field, largest, transposed_multiply};
use crate::linalg::lanes::Lanes;
use crate::space::{FixedFrames, Homogeneous, RealSpace, skew};

const ORDER: usize = 40;

/// A vector at both ends.
type VectorsAtEnds = [[f64; 3]; 2];

/// `x, x', x''` at a middle: general, at rest, turning about one axis, and with zeros.
fn middles(d: usize) -> Vec<[Vec<f64>; 3]> {
    let entry = |seed: f64| (0..d).map(|p| (seed + 1.9 * p as f64).sin()).collect();
    let one = |value: f64| (0..d).map(|p| if p == 0 { value } else { 0.0 }).collect();
    vec![
        [1.0, 2.3, 5.7].map(entry),
        [0.0, 0.0, 0.0].map(one),
        [3.0, 1.0, -2.0].map(one),
        [one(1.5), entry(0.4), one(0.0)],
        [one(0.0), one(0.0), entry(1.1)],
    ]
}

/// The rotation between the ends is that of the frames there, for every parity of the order; twenty units in the last place of
/// 1 for sums of forty terms, of both.
#[test]
fn rotations_between_the_ends_are_those_of_the_frames() {
    fn compare(space: impl Homogeneous) {
        for middle in middles(space.dim()) {
            for order in [ORDER, ORDER + 1] {
                let mut series = LegSeries::new(space, order);
                let middle = middle.each_ref().map(Vec::as_slice);
                series.set_curve(space, middle, None, order);
                let [mut found, mut expected, mut first, mut last] = [[0.0; 9]; 4];
                let tail = series.reached_into(space, order, &mut found);
                series.set_frames(space, order);
                let frames = &series.frames[..(order + 1) * 9];
                at_ends(frames, 9, 0, [&mut first, &mut last]);
                transposed_multiply(3, &first, &last, &mut expected);
                for (x, y) in found.iter_mut().zip(expected) {
                    *x -= y;
                }
                assert!(largest(&found) < 4e-15, "{:e}", largest(&found));
                assert!(tail < 1e-14, "{tail:e}");
            }
        }
    }
    compare(FixedFrames::<3, 2>);
    compare(FixedFrames::<3, 1>);
    compare(RealSpace::subspaces(3, 1));
}

/// A constant rate turns by itself, also beyond half turns and by whole ones.
#[test]
fn constant_rates_are_exact() {
    for angle in [0.0, 1e-8, 1.0, std::f64::consts::PI, 6.5, 12.0] {
        let mut matrices = vec![0.0; (ORDER + 3) * 9];
        (matrices[2], matrices[6]) = (angle, -angle);
        let (mut spans, mut found) = (vec![0.0; 2 * ORDER + 8], [0.0; 9]);
        rotation_reached_into(&matrices, ORDER, &mut spans, &mut found);
        let (sin, cos) = angle.sin_cos();
        for (x, y) in found
            .iter_mut()
            .zip([cos, 0.0, sin, 0.0, 1.0, 0.0, -sin, 0.0, cos])
        {
            *x -= y;
        }
        // Terms of alternating sign grow up to this size.
        let bound = 4e-15 + f64::EPSILON * (0.5 * angle).exp();
        assert!(largest(&found) < bound, "{angle}: {:e}", largest(&found));
    }
}

/// The last terms tell how far a short series is from the rotation.
#[test]
fn last_terms_measure_the_truncation() {
    let space = FixedFrames::<3, 2>;
    let middle = [1.0, 2.3, 5.7].map(|seed: f64| [seed.sin(), seed.cos(), 0.4 * seed]);
    let middle = middle.each_ref().map(<[f64; 3]>::as_slice);
    let [mut exact, mut found] = [[0.0; 9]; 2];
    let mut series = LegSeries::new(space, ORDER);
    series.set_curve(space, middle, None, ORDER);
    series.reached_into(space, ORDER, &mut exact);
    for order in [6, 9, 12, 15] {
        let tail = series.reached_into(space, order, &mut found);
        let errors = exact.iter().zip(found).map(|(x, y)| (x - y).abs());
        let error = errors.fold(0.0, f64::max);
        assert!(
            error < tail && tail < 1e4 * error,
            "{order}: {error:e} {tail:e}"
        );
    }
}

/// Variations of rotations, whose sums are written out, are those of differences.
#[test]
fn variations_are_those_of_differences() {
    const H: f64 = 1e-5;
    let space = FixedFrames::<3, 2>;
    for (middle, tension) in middles(3)
        .into_iter()
        .flat_map(|m| [(m.clone(), None), (m, Some(1.7))])
    {
        let mut variation = MiddleVariation::new(space, 3, ORDER - 2);
        let mut series = LegSeries::new(space, ORDER);
        let views = middle.each_ref().map(Vec::as_slice);
        series.set_curve(space, views, tension, ORDER);
        variation.set_changes(space, &series, tension, ORDER - 2);
        for column in 0..9 {
            let [back, on]: [[VectorsAtEnds; 3]; 2] = [-H, H].map(|h| {
                let mut moved = middle.clone();
                moved[column / 3][column % 3] += h;
                series.set_curve(space, moved.each_ref().map(Vec::as_slice), tension, ORDER);
                std::array::from_fn(|derivative| {
                    let [mut first, mut last] = [[0.0; 3]; 2];
                    series.at_ends(3, ORDER + 3, derivative, [&mut first, &mut last]);
                    [first, last]
                })
            });
            for (derivative, ends) in variation.ends.iter().enumerate() {
                for (end, found) in ends.iter().enumerate() {
                    for p in 0..3 {
                        let [back, on] = [back, on].map(|values| values[derivative][end][p]);
                        let (slope, found) = ((on - back) / (2.0 * H), found[p * 9 + column]);
                        assert!(
                            // Central differences: H^2 of a third derivative, and round-off over H.
                            (slope - found).abs() < 2e-7 * (1.0 + slope.abs()),
                            "{slope} {found}"
                        );
                    }
                }
            }
        }
    }
}

/// The changes at the ends from some of the allocated terms, one after the other.
fn changes<T: Field>(middle: &[Vec<f64>; 3], [allocated, terms]: [usize; 2]) -> Vec<f64> {
    let space = FixedFrames::<3, 2>;
    let middle = middle
        .each_ref()
        .map(|x| x.iter().map(|x| T::constant(*x)).collect::<Vec<T>>());
    let mut series = LegSeries::new(space, ORDER);
    series.set_curve(space, middle.each_ref().map(Vec::as_slice), None, ORDER);
    let mut variation = MiddleVariation::new(space, 3, allocated);
    variation.set_changes(space, &series, None, terms);
    let ends = variation.ends.iter().flatten().flatten();
    ends.map(|x| x.lane(T::COUNT - 1)).collect()
}

/// Eight columns of one leg and one column of eight legs have the same sums, in more room than they need too.
#[test]
fn columns_and_lanes_agree() {
    for middle in middles(3) {
        for terms in [1, 5, 14] {
            let expected = changes::<f64>(&middle, [terms, terms]);
            assert_eq!(changes::<f64>(&middle, [14, terms]), expected);
            assert_eq!(changes::<Lanes>(&middle, [14, terms]), expected);
        }
    }
}

/// Small integers are exact in any order of summation.
#[test]
fn sums_of_brackets_are_those_of_all_matrices() {
    let space = FixedFrames::<3, 2>;
    let mut matrices = vec![0.0; 9 * 9 + 8];
    for (i, matrix) in matrices.chunks_exact_mut(9).enumerate() {
        let entry = |j: usize| ((5 * i + 3 * j) % 7) as f64 - 3.0;
        matrix.copy_from_slice(&skew([entry(0), entry(1), entry(2)]));
    }
    for sum in 1..8_usize {
        let pairs = (0..sum.div_ceil(2)).map(|i| {
            let weight = (sum - 2 * i) as f64;
            (weight, &matrices[i * 9..], &matrices[(sum - i) * 9..])
        });
        let mut expected = [0.0; 3];
        minus_bracket_into(space, pairs, &mut expected);
        let product = skew(sum_of_brackets(&matrices, sum));
        let mut found = [0.0; 3];
        space.each_entry(|p, i, j| found[p] = -product[i * 3 + j]);
        assert_eq!(found, expected, "{sum}");
    }
}
