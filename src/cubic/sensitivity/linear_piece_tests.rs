//! Tests of linearised cubics: against dual numbers carried along the curve, and against each other.

use faer::Mat;

use super::linear_flow::LinearFlow;
use super::linear_flow::tests::{SHAPES, flow, tangent};
use super::linear_piece::{LinearPiece, PieceVariation};
use super::linear_start::LinearStart;
use super::variation::vary;
use crate::cubic::taylor::initial::Horizontal;
use crate::cubic::taylor::packing::pack;
use crate::interrupt::Interrupt;
use crate::linalg::product::{columns, entries};
use crate::linalg::structure::norm;
use crate::space::Quotient;

/// Tension and speed; the last two curves need several legs. At rest and in tension variations need terms that the curve
/// itself does not.
const CURVES: [(f64, f64); 7] = [
    (0.0, 0.5),
    (4.0, 0.5),
    (0.0, 0.0),
    (25.0, 0.0),
    (25.0, 1e-8),
    (0.0, 3.0),
    (2.0, 4.0),
];

const TIMES: [f64; 6] = [0.3, 0.0, 1.0, 0.71, 0.99, 1e-9];

fn views_of(z: &PieceVariation) -> [&[f64]; 4] {
    z.each_ref().map(Vec::as_slice)
}

fn matrix(n: usize, k: usize, seed: usize) -> Mat<f64> {
    Mat::from_fn(n, k, |i, j| (1.3 * (i + n * j + 7 * seed) as f64).sin())
}

/// Tangent vectors at the ends of a curve.
fn ends(flow: &LinearFlow, piece: &LinearPiece, seed: usize) -> PieceVariation {
    let (n, k) = (flow.frame.nrows(), flow.blocks().k);
    std::array::from_fn(|i| {
        let point = piece.frame(i / 2).subcols(0, k);
        let vector = tangent(flow.data.quotient, point, &matrix(n, k, seed + i));
        entries(vector.as_ref())
    })
}

fn assert_close(found: &[f64], expected: &[f64], bound: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let size = expected.iter().fold(1.0_f64, |size, x| size.max(x.abs()));
    for (x, y) in found.iter().zip(expected) {
        let error = (x - y).abs() / size;
        assert!(error < bound, "{what}: {error:.1e}");
    }
}

fn each_curve(check: impl Fn(&LinearFlow, &str)) {
    for shape in SHAPES {
        for quotient in [Quotient::Frames, Quotient::Subspaces] {
            if quotient == Quotient::Subspaces && shape[0] == shape[1] {
                continue;
            }
            for (tension, speed) in CURVES {
                let what = format!("{shape:?} {quotient:?} {tension} {speed}");
                check(&flow(shape, tension, speed, quotient), &what);
            }
        }
    }
}

/// The changes of the gradient of half the cost are those of the curve that starts with the changes found.
#[test]
fn ends_are_reached() {
    each_curve(|flow, what| {
        let blocks = flow.blocks();
        let piece = LinearPiece::new(LinearStart::of_flow(flow), Interrupt::NEVER).unwrap();
        let z = ends(flow, &piece, 3);
        let start = piece.at_start(views_of(&z));
        let (n, frame) = (flow.frame.nrows(), flow.frame.as_ref());
        let inside = |x: &[f64]| Horizontal::of_tangent(frame, columns(x, n));
        let directions = [[inside(&z[1]), inside(&start[0]), inside(&start[1])]];
        let reached = vary::<1>(&flow.data, 0, &directions, &[1.0], Interrupt::NEVER);
        let reached = reached.unwrap().remove(0);
        let displaced = reached.displaced(&inside(&z[0]));
        let sums = displaced.into_iter().zip(&reached.variations[0]);
        let sums: Vec<Horizontal> = sums.map(|(x, y)| x.plus(1.0, y)).collect();
        let end = &flow.frame * &reached.frame;
        let error = norm((piece.frame(1) - &end).as_ref());
        assert!(error < 1e-12, "{what}, frame: {error:.1e}");
        let coordinates = |x: &[f64]| {
            pack(
                blocks,
                &[Horizontal::of_tangent(piece.frame(1), columns(x, n))],
            )
        };
        let forces = piece.stiffness(views_of(&z));
        let [p, w, a, mut b] = [0, 1, 2, 3].map(|i| pack(blocks, &sums[i..=i]));
        assert_close(&p, &coordinates(&z[2]), 1e-10, what);
        assert_close(&w, &coordinates(&z[3]), 1e-10, what);
        for (b, w) in b.iter_mut().zip(&w) {
            *b = flow.data.tension * w - *b;
        }
        assert_close(&coordinates(&forces[3]), &a, 1e-10, what);
        assert_close(&coordinates(&forces[2]), &b, 1e-10, what);
    });
}

/// Also in rows outside the span.
#[test]
fn points_are_those_of_dual_numbers() {
    each_curve(|flow, what| {
        let n = flow.frame.nrows();
        let piece = LinearPiece::new(LinearStart::of_flow(flow), Interrupt::NEVER).unwrap();
        let z = ends(flow, &piece, 5);
        let [a, b] = piece.at_start(views_of(&z));
        let start = [&z[0], &z[1], &a, &b].map(|x| columns(x, n).to_owned());
        let expected = flow.points(&start, &TIMES, Interrupt::NEVER).unwrap();
        let found = piece.points(views_of(&z), &TIMES);
        for ((found, expected), t) in found.iter().zip(&expected).zip(TIMES) {
            assert_close(
                found,
                &entries(expected.as_ref()),
                1e-10,
                &format!("{what} at {t}"),
            );
        }
    });
}

#[test]
fn pulling_back_is_the_transpose() {
    each_curve(|flow, what| {
        let (n, k) = (flow.frame.nrows(), flow.blocks().k);
        let piece = LinearPiece::new(LinearStart::of_flow(flow), Interrupt::NEVER).unwrap();
        let z = ends(flow, &piece, 5);
        let cotangents: Vec<Mat<f64>> = (0..TIMES.len()).map(|i| matrix(n, k, 20 + i)).collect();
        let loads = TIMES.into_iter().zip(cotangents.iter().map(Mat::as_ref));
        let gradient = piece.pull_back(loads);
        let dot = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(x, y)| x * y).sum() };
        // The inner product of tangent vectors counts each entry of `omega` once.
        let inner = |i: usize| {
            let frame = piece.frame(i / 2);
            let [x, y] =
                [&gradient[i], &z[i]].map(|x| Horizontal::of_tangent(frame, columns(x, n)));
            let along = x.inner(&y);
            let [x, y] = [&gradient[i], &z[i]].map(|x| {
                let x = columns(x, n);
                entries((x - frame * (frame.transpose() * x)).as_ref())
            });
            along + dot(&x, &y)
        };
        let found: f64 = (0..4).map(inner).sum();
        let points = piece.points(views_of(&z), &TIMES);
        let products = points.iter().zip(&cotangents);
        let expected: f64 = products.map(|(x, w)| dot(x, &entries(w.as_ref()))).sum();
        let size = points.iter().map(|x| dot(x, x).sqrt()).sum::<f64>();
        assert!(
            (found - expected).abs() < 1e-11 * (1.0 + size),
            "{what}: {found} {expected}"
        );
    });
}

#[test]
fn eight_abreast_are_what_each_is_alone() {
    for shape in SHAPES {
        let flows = [0.1, 0.3, 0.5, 0.7, 0.2].map(|s| flow(shape, 0.5, s, Quotient::Frames));
        let starts = flows.iter().map(LinearStart::of_flow).collect();
        let all = LinearPiece::all(starts, Interrupt::NEVER).unwrap();
        for (flow, piece) in flows.iter().zip(&all) {
            let alone = LinearPiece::new(LinearStart::of_flow(flow), Interrupt::NEVER).unwrap();
            let z = ends(flow, piece, 1);
            let [found, expected] =
                [piece, &alone].map(|piece| piece.points(views_of(&z), &TIMES).concat());
            assert_close(&found, &expected, 1e-13, "points");
            let [found, expected] =
                [piece, &alone].map(|piece| piece.stiffness(views_of(&z)).concat());
            assert_close(&found, &expected, 1e-12, "stiffness");
        }
    }
}

/// On a circle traversed from rest at its middle, every third coefficient alone differs from zero; along one of constant
/// speed the vectors commute.
#[test]
fn curves_with_few_coefficients_are_resolved() {
    for n in [2, 3, 4] {
        for [v, b] in [[-1.2, 12.0], [0.0, 1.0], [8.0, 0.0], [20.0, 0.0]] {
            let along =
                |i: usize, x: f64| Mat::from_fn(n, 1, |row, _| if row == i { x } else { 0.0 });
            let state = [along(0, 1.0), along(1, v), along(1, -0.5 * b), along(1, b)];
            let views = state.each_ref().map(|x| x.as_ref());
            let flow = LinearFlow::new(views, 0.0, Quotient::Frames).unwrap();
            let piece = LinearPiece::new(LinearStart::of_flow(&flow), Interrupt::NEVER).unwrap();
            let z = ends(&flow, &piece, 5);
            let [a, b] = piece.at_start(views_of(&z));
            let start = [&z[0], &z[1], &a, &b].map(|x| columns(x, n).to_owned());
            let expected = flow.points(&start, &TIMES, Interrupt::NEVER).unwrap();
            let found = piece.points(views_of(&z), &TIMES);
            for (found, expected) in found.iter().zip(&expected) {
                assert_close(
                    found,
                    &entries(expected.as_ref()),
                    1e-11,
                    &format!("{n} {v}"),
                );
            }
            let reached = flow.points(&start, &[1.0], Interrupt::NEVER).unwrap();
            assert_close(
                &z[2],
                &entries(reached[0].as_ref()),
                1e-11,
                &format!("{n} {v}, end"),
            );
        }
    }
}
