//! Cotangent lifts of discretization maps.

#[path = "common/curved_map.rs"]
mod curved_map;

use curved_map::Curved;
use nalgebra::{SMatrix, SVector};
use stiefel_rs::chart::discretization::cotangent_lift;
use stiefel_rs::chart::{DiscretizationMap, LinearMap};

/// The lift of a map with numerical derivatives: `DR_d^T (-p_0, p_1) = (pdot, p)`, and symplectic.
#[test]
fn cotangent_lift_is_symplectic() {
    let lift = |map: &dyn Fn(&SVector<f64, 8>) -> SVector<f64, 8>, at: &SVector<f64, 8>| {
        let h = 1e-4;
        SMatrix::<f64, 8, 8>::from_columns(&std::array::from_fn::<_, 8, _>(|i| {
            let moved = |s: f64| {
                let mut moved = *at;
                moved[i] += s * h;
                map(&moved)
            };
            ((moved(1.0) - moved(-1.0)) * 8.0 - (moved(2.0) - moved(-2.0))) / (12.0 * h)
        }))
    };
    let at: SVector<f64, 8> = [0.3, -0.4, 0.7, 0.2, 0.05, -0.1, 0.3, 0.6].into();
    fn apply(map: &impl DiscretizationMap<2>, u: &SVector<f64, 8>) -> SVector<f64, 8> {
        let part = |i: usize| u.fixed_rows::<2>(i).into_owned();
        let [(x0, p0), (x1, p1)] =
            cotangent_lift(map, &part(0), &part(2), &part(4), &part(6)).unwrap();
        SVector::from_column_slice(
            &[x0.as_slice(), p0.as_slice(), x1.as_slice(), p1.as_slice()].concat(),
        )
    }
    // The form of the tangent bundle d(pdot) ^ dx + dp ^ d(xdot); the product form dp_1 ^ dx_1 - dp_0 ^ dx_0.
    let form = |pairs: [(usize, usize, f64); 2]| {
        let mut omega = SMatrix::<f64, 8, 8>::zeros();
        for (x, p, sign) in pairs {
            for i in 0..2 {
                omega[(x + i, p + i)] = sign;
                omega[(p + i, x + i)] = -sign;
            }
        }
        omega
    };
    let (source, target) = (
        form([(0, 6, 1.0), (4, 2, 1.0)]),
        form([(4, 6, 1.0), (0, 2, -1.0)]),
    );
    type Lift<'a> = &'a dyn Fn(&SVector<f64, 8>) -> SVector<f64, 8>;
    let maps: [Lift<'_>; 3] = [
        &|u| apply(&LinearMap::INITIAL_POINT, u),
        &|u| apply(&LinearMap::MIDPOINT, u),
        &|u| apply(&Curved(0.3), u),
    ];
    for (name, map) in ["initial point", "mid-point", "curved"]
        .into_iter()
        .zip(maps)
    {
        let jacobian = lift(map, &at);
        let defect = (jacobian.transpose() * target * jacobian - source).amax();
        assert!(
            defect < 1e-10,
            "{name}: {defect:e} (difference formula of order 4)"
        );
    }
}

#[test]
fn cotangent_lift_of_the_papers_maps() {
    // Midpoint: p = (p_0 + p_1)/2, pdot = p_1 - p_0. Initial point: p = p_1, pdot = p_1 - p_0.
    let [x, p, v, rate] =
        [[0.3, -0.4], [0.7, 0.2], [0.05, -0.1], [0.3, 0.6]].map(SVector::<f64, 2>::from);
    let [(x0, p0), (x1, p1)] = cotangent_lift(&LinearMap::MIDPOINT, &x, &p, &v, &rate).unwrap();
    let defect = (x0 - (x - v / 2.0)).amax() + (x1 - (x + v / 2.0)).amax();
    assert!(defect + (p0 - (p - rate / 2.0)).amax() + (p1 - (p + rate / 2.0)).amax() < 1e-15);
    let [(x0, p0), (x1, p1)] =
        cotangent_lift(&LinearMap::INITIAL_POINT, &x, &p, &v, &rate).unwrap();
    assert!(
        (x0 - x).amax() + (x1 - x - v).amax() + (p1 - p).amax() + (p0 - p + rate).amax() < 1e-15
    );
}
