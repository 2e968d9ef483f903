//! Boundary values with a guess: the solution near it, and guesses that do not converge.

use faer::{Mat, Scale};
use stiefel_rs::cubic::{BoundaryOptions, IntegrationOptions, RiemannianCubic};
use stiefel_rs::{Curve, Error, Interrupt, Quotient, Result};

use crate::common::{
    Rng, assert_close, assert_within, cubic_from, gaussian, random_orthogonal, random_point,
};
use crate::derivative::vector;
use crate::{SHAPES, boundary_options, horizontal, view};

/// `[Y0, V0, Y1, V1]` of a cubic, the last two in terms of an arbitrary basis, and the cubic.
fn known(
    (n, k): (usize, usize),
    sizes: [f64; 3],
    tension: f64,
    rng: &mut Rng,
) -> ([Mat<f64>; 4], RiemannianCubic) {
    let y = random_point(n, k, rng);
    let [v, a, j] = sizes.map(|size| vector(&y, size, rng));
    let options = IntegrationOptions {
        quotient: Quotient::Subspaces,
        tension,
        ..IntegrationOptions::default()
    };
    let curve = cubic_from([&y, &v, &a, &j], &options);
    let q = random_orthogonal(k, rng);
    let [y1, v1] = [curve.point(1.0), curve.derivative(1.0, 1)].map(|x| x.unwrap() * &q);
    let v1 = horizontal(view(&y1), view(&v1));
    ([y, v, y1, v1], curve)
}

fn between(
    data: &[Mat<f64>; 4],
    guess: Option<[&Mat<f64>; 2]>,
    tension: f64,
) -> Result<RiemannianCubic> {
    let [y0, v0, y1, v1] = data.each_ref().map(view);
    let options = BoundaryOptions {
        guess: guess.map(|[a, j]| (view(a), view(j))),
        tension,
        ..boundary_options()
    };
    RiemannianCubic::from_boundary(y0, v0, y1, v1, &options, Interrupt::NEVER)
}

#[test]
fn the_solution_near_a_guess_is_found_where_without_one_another_is() {
    let mut rng = Rng::new(51);
    let mut others = 0;
    for shape in [&SHAPES[..], &[(2, 1), (40, 4), (13, 3)]].concat() {
        for tension in [0.0, 3.0] {
            let (data, curve) = known(shape, [2.0, 7.0, 30.0], tension, &mut rng);
            let [_, _, a, j] = curve.initial().unwrap();
            let [near_a, near_j] =
                [&a, &j].map(|x| x + vector(&data[0], 1e-3 * x.norm_l2(), &mut rng));
            let found = between(&data, Some([&near_a, &near_j]), tension).unwrap();
            let what = format!("{shape:?}, tension {tension}");
            for t in [0.0, 0.4, 1.0] {
                let [found, known] = [&found, &curve].map(|curve| curve.point(t).unwrap());
                assert_close(&found, &known, 1e-10, &what);
            }
            let report = found.report().unwrap();
            assert!(
                report.converged && report.iterations <= 8,
                "{what}: {report}"
            );
            let cost = found.cost(Interrupt::NEVER).unwrap();
            let other = match between(&data, None, tension) {
                Ok(other) => other.cost(Interrupt::NEVER).unwrap(),
                // Such fast data may exceed the work limit.
                Err(Error::NoConvergence { .. }) => continue,
                Err(error) => panic!("{what}: {error}"),
            };
            others += usize::from((other / cost - 1.0).abs() > 0.01);
        }
    }
    assert!(others >= 12, "only {others} are others");
}

#[test]
fn a_guess_leads_to_either_sense_of_a_line() {
    let mut rng = Rng::new(52);
    for _ in 0..8 {
        let y0 = random_point(4, 1, &mut rng);
        let y1 = random_point(4, 1, &mut rng);
        let [v0, v1] = [&y0, &y1].map(|y| vector(y, 1.0, &mut rng));
        let options = BoundaryOptions::default();
        for sign in [1.0, -1.0] {
            let [end, velocity] = [&y1, &v1].map(|x| x * Scale(sign));
            let on_sphere = RiemannianCubic::from_boundary(
                view(&y0),
                view(&v0),
                view(&end),
                view(&velocity),
                &options,
                Interrupt::NEVER,
            )
            .unwrap();
            let [_, _, a, j] = on_sphere.initial().unwrap();
            let data = [y0.clone(), v0.clone(), y1.clone(), v1.clone()];
            let found = between(&data, Some([&a, &j]), 0.0).unwrap();
            assert_close(&found.point(1.0).unwrap(), &end, 1e-11, "sense");
            let off = found.cost(Interrupt::NEVER).unwrap()
                / on_sphere.cost(Interrupt::NEVER).unwrap()
                - 1.0;
            assert_within(off.abs(), 1e-9, "cost");
        }
    }
}

#[test]
fn guesses_that_lead_nowhere_and_parts_outside_of_the_span() {
    let mut rng = Rng::new(53);
    for shape in SHAPES {
        let (data, _) = known(shape, [0.5, 0.8, 1.0], 0.0, &mut rng);
        let [wild_a, wild_j] = [1e4, 1e6].map(|size| vector(&data[0], size, &mut rng));
        let found = between(&data, Some([&wild_a, &wild_j]), 0.0).unwrap();
        assert!(found.report().unwrap().converged);
        let end = found.point(1.0).unwrap();
        let off = horizontal(view(&data[2]), view(&end)).norm_l2();
        assert_within(off, 1e-11, &format!("{shape:?}"));
    }
    let (data, curve) = known((40, 2), [0.5, 0.8, 1.0], 0.0, &mut rng);
    let [_, _, a, j] = curve.initial().unwrap();
    // Orthogonal to all data: the last columns of an orthonormal basis that begins with them.
    let random = gaussian(40, 2, &mut rng);
    let all = Mat::from_fn(40, 10, |row, col| match col / 2 {
        4 => random[(row, col - 8)],
        matrix => data[matrix][(row, col % 2)],
    });
    let out = all.qr().compute_thin_Q().subcols(8, 2).to_owned();
    let found = between(&data, Some([&(&a + &out * Scale(1e-3)), &j]), 0.0).unwrap();
    assert_close(
        &found.point(0.5).unwrap(),
        &curve.point(0.5).unwrap(),
        1e-11,
        "span",
    );
}

#[test]
fn perpendicular_lines_with_a_guess() {
    let [e1, e2] = [[1.0, 0.0], [0.0, 1.0]].map(|[x, y]| faer::mat![[x], [y]]);
    let rest = Mat::zeros(2, 1);
    let data = [e1, rest.clone(), e2.clone(), rest];
    let found = between(
        &data,
        Some([&(&e2 * Scale(9.0)), &(&e2 * Scale(-18.0))]),
        0.0,
    )
    .unwrap();
    let quarter = std::f64::consts::FRAC_PI_2;
    let off = found.cost(Interrupt::NEVER).unwrap() / (12.0 * quarter * quarter) - 1.0;
    assert_within(off.abs(), 1e-10, "quarter");
}

#[test]
fn bad_guesses_are_refused() {
    let mut rng = Rng::new(54);
    let (data, curve) = known((5, 2), [0.5, 0.8, 1.0], 0.0, &mut rng);
    let [y, _, a, j] = curve.initial().unwrap();
    let error = between(&data, Some([&y, &j]), 0.0).unwrap_err();
    assert!(
        matches!(error, Error::NotHorizontal { name: "A", .. }),
        "{error}"
    );
    let error = between(&data, Some([&a, &Mat::zeros(4, 2)]), 0.0).unwrap_err();
    assert!(matches!(error, Error::Shape { name: "J", .. }), "{error}");
    let mut nan = a.clone();
    nan[(0, 0)] = f64::NAN;
    let error = between(&data, Some([&nan, &j]), 0.0).unwrap_err();
    assert!(
        matches!(error, Error::NonFinite { name: "A", .. }),
        "{error}"
    );
}

#[test]
fn a_guess_in_the_whole_space_and_at_the_same_subspace() {
    let mut rng = Rng::new(55);
    let [first, last] = [(); 2].map(|()| random_orthogonal(3, &mut rng));
    let rest = Mat::zeros(3, 3);
    let data = [first.clone(), rest.clone(), last, rest.clone()];
    let found = between(&data, Some([&rest, &rest]), 0.0).unwrap();
    assert_eq!(found.cost(Interrupt::NEVER).unwrap(), 0.0);
    assert_close(&found.point(1.0).unwrap(), &first, 1e-14, "whole");
    // Coordinate columns, and a permutation of them.
    let y0 = Mat::<f64>::identity(4, 4).subcols(0, 2).to_owned();
    let swapped = Mat::from_fn(4, 2, |i, j| y0[(i, 1 - j)]);
    let rest = Mat::zeros(4, 2);
    let data = [y0.clone(), rest.clone(), swapped, rest.clone()];
    let found = between(&data, Some([&rest, &rest]), 0.0).unwrap();
    assert_within(found.cost(Interrupt::NEVER).unwrap(), 1e-20, "still");
    assert_close(&found.point(1.0).unwrap(), &y0, 1e-14, "permuted");
}
