//! The equations of the retractions.

use faer::{Mat, Scale};
use stiefel_rs::{Curve, QuasiGeodesic, Retraction};

use crate::common::{
    Actions, Rng, Worst, assert_close, assert_equivariant, assert_within, frobenius, identity,
    orthonormality,
};
use crate::vectors::{apply, each_shape, generator};

#[test]
fn retractions_map_to_points() {
    let mut worst = Worst::new("orthonormality");
    each_shape(&[0.0, 1e-300, 1e-9, 1.0, 10.0], |s, v, place| {
        for retraction in Retraction::ALL {
            let y = apply(retraction, s, v);
            worst.see(orthonormality(&y), || format!("{retraction:?} {place}"));
        }
    });
    worst.assert_at_most(1e-14);
}

#[test]
fn zero_is_mapped_to_the_point_itself() {
    each_shape(&[0.0, 1e-300], |s, v, place| {
        for retraction in Retraction::ALL {
            let y = apply(retraction, s, v);
            assert_close(&y, s, 1e-15 * s.nrows() as f64, place);
        }
    });
}

#[test]
fn quasi_geodesic_is_the_curve_at_one() {
    each_shape(&[1.0, 5.0], |s, v, place| {
        let curve = QuasiGeodesic::from_velocity(s.as_ref(), v.as_ref()).unwrap();
        let y = apply(Retraction::QuasiGeodesic, s, v);
        assert_close(&y, &curve.point(1.0).unwrap(), 1e-14, place);
    });
}

#[test]
fn qr_factor_is_triangular_with_positive_diagonal() {
    each_shape(&[0.5, 1.0, 5.0], |s, v, place| {
        let (y, sum) = (apply(Retraction::Qr, s, v), s + v);
        let r = y.transpose() * &sum;
        let bound = 1e-15 * frobenius(sum.as_ref()) * s.nrows() as f64;
        assert_close(&(&y * &r), &sum, bound, &format!("Q R = S + V, {place}"));
        for j in 0..r.ncols() {
            assert!(
                r[(j, j)] >= 1.0 - bound,
                "{place}: R[{j},{j}] = {}",
                r[(j, j)]
            );
            for i in j + 1..r.nrows() {
                assert_within(
                    r[(i, j)].abs(),
                    bound,
                    &format!("below the diagonal, {place}"),
                );
            }
        }
    });
}

#[test]
fn polar_factor_leaves_the_root_of_the_gram_matrix() {
    each_shape(&[0.5, 1.0, 5.0], |s, v, place| {
        let (y, sum) = (apply(Retraction::Polar, s, v), s + v);
        let p = y.transpose() * &sum;
        let bound = 2e-15 * frobenius(sum.as_ref()) * s.nrows() as f64;
        assert_close(&(&y * &p), &sum, bound, &format!("Y P = S + V, {place}"));
        assert_close(
            &p,
            &p.transpose().to_owned(),
            bound,
            &format!("P symmetric, {place}"),
        );
        let gram = v.transpose() * v + identity(v.ncols());
        let size = frobenius(gram.as_ref());
        assert_close(
            &(&p * &p),
            &gram,
            1e-14 * size,
            &format!("P^2 = I + V^T V, {place}"),
        );
        let eigenvalues = p.self_adjoint_eigenvalues(faer::Side::Lower).unwrap();
        assert!(
            eigenvalues[0] >= 1.0 - bound,
            "{place}: P is not positive: {eigenvalues:?}"
        );
    });
}

#[test]
fn cayley_transform_of_full_size() {
    each_shape(&[0.5, 1.0, 5.0], |s, v, place| {
        let w = generator(s, v, 1.0);
        assert_close(&(&w * s), v, 1e-14, &format!("W S = V, {place}"));
        // Wen and Yin's form of the same matrix.
        let p = identity(s.nrows()) - s * s.transpose() * Scale(0.5);
        let theirs = &p * v * s.transpose() - s * v.transpose() * &p;
        assert_close(&w, &theirs, 1e-14, &format!("W, {place}"));
        let y = apply(Retraction::Cayley, s, v);
        let residual = &y - &w * &y * Scale(0.5) - s - v * Scale(0.5);
        assert_within(
            frobenius(residual.as_ref()),
            2e-15 * s.nrows() as f64,
            &format!("(I - W/2) Y = (I + W/2) S, {place}"),
        );
    });
}

#[test]
fn retractions_are_equivariant() {
    let mut rng = Rng::new(72);
    each_shape(&[1.0], |s, v, place| {
        for retraction in Retraction::ALL {
            let function = |a: &[Mat<f64>]| vec![apply(retraction, &a[0], &a[1])];
            let what = format!("{retraction:?} {place}");
            assert_equivariant(Actions::Left, &[s, v], function, 3e-14, &what, &mut rng);
        }
    });
}
