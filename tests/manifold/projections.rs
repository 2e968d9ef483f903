//! Projections to the manifold and to tangent spaces.

use faer::{Mat, MatRef, Scale};
use stiefel_rs::{Error, Stiefel};

use crate::common::{
    EPS, Rng, SIZES, assert_close, assert_within, frobenius, gaussian, identity, orthonormality,
    random_point, random_tangent,
};
use crate::shapes::{each_shape, manifold};

#[test]
fn project_undoes_a_positive_stretch() {
    let mut rng = Rng::new(5);
    for (n, k) in SIZES {
        let s = random_point(n, k, &mut rng);
        let g = gaussian(k, k, &mut rng);
        let stretch = &g * g.transpose() * Scale(1.0 / k as f64) + identity(k) * Scale(0.5);
        let found = manifold(&s).project((&s * stretch).as_ref()).unwrap();
        // Condition number of the polar factor: 1 / smallest stretch = 2; the stretch itself has size about 5.
        assert_close(
            &found,
            &s,
            64.0 * n as f64 * EPS,
            &format!("polar factor of S H, ({n}, {k})"),
        );
    }
}

#[test]
fn project_is_idempotent() {
    each_shape(6, |manifold, s, v, _, place| {
        let once = manifold.project((s + v).as_ref()).unwrap();
        let twice = manifold.project(once.as_ref()).unwrap();
        let bound = 8.0 * s.nrows() as f64 * EPS;
        assert_within(
            orthonormality(&once),
            bound,
            &format!("orthonormal, {place}"),
        );
        assert_close(&twice, &once, bound, &format!("idempotent, {place}"));
    });
}

#[test]
fn project_refuses_a_rank_deficient_matrix() {
    let manifold = Stiefel::new(4, 2).unwrap();
    let error = manifold.project(Mat::full(4, 2, 1.0).as_ref());
    assert!(
        matches!(error, Err(Error::RankDeficient { name: "Y", .. })),
        "{error:?}"
    );
}

#[test]
fn project_tangent_is_the_orthogonal_projection() {
    let mut rng = Rng::new(7);
    for (n, k) in SIZES {
        let s = random_point(n, k, &mut rng);
        let (manifold, z) = (manifold(&s), gaussian(n, k, &mut rng));
        let once = manifold.project_tangent(s.as_ref(), z.as_ref()).unwrap();
        let bound = 8.0 * n as f64 * EPS * frobenius(z.as_ref());
        manifold
            .check_tangent("PZ", s.as_ref(), once.as_ref(), 16.0 * n as f64 * EPS)
            .unwrap();
        let twice = manifold.project_tangent(s.as_ref(), once.as_ref()).unwrap();
        assert_close(&twice, &once, bound, &format!("idempotent, ({n}, {k})"));
        let v = random_tangent(&s, 1.0, &mut rng);
        let rest = z.as_ref() - &once;
        let overlap = trace_of_product(v.as_ref(), rest.as_ref()).abs();
        assert_within(
            overlap,
            2.0 * bound,
            &format!("remainder against a tangent vector, ({n}, {k})"),
        );
    }
}

pub fn trace_of_product(v: MatRef<'_, f64>, w: MatRef<'_, f64>) -> f64 {
    let product = v.transpose() * w;
    (0..product.nrows()).map(|i| product[(i, i)]).sum()
}
