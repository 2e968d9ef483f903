//! Riemannian cubics on any `St(n, k)`, without charts.
//!
//! `St(n,k) = SO(n)/SO(n-k)`, `so(n) = m + h` with `h` the lower right block of size `n - k`. A curve `S` is the first
//! `k` columns of a frame `g` that moves without turning in itself, `g' = g x` with `x` in `m`, and `x` determines
//! velocity, covariant acceleration and covariant jerk:
//!
//! ```math
//! S' = g x,\qquad D_t S' = g x',\qquad D_t D_t S' = g\,(x'' + \tfrac12 [x, x']_m),\qquad
//! x''' = [x'', x]_m - [[x, x']_h, x]
//! ```
//!
//! (`g v` stands for its first `k` columns.) The last equation is that of Riemannian cubics,
//! `D_t^3 S' + R(D_t S', S') S' = 0`.
//!
//! # Source
//! Crouch, Silva Leite (1995), "The dynamic interpolation problem: on Riemannian manifolds, Lie groups, and symmetric
//! spaces", J. Dynamical and Control Systems 1, 177-202; Noakes, Heinzinger, Paden (1989), "Cubic splines on curved
//! spaces", IMA J. Math. Control Inform. 6, 465-473.

mod boundary;
mod continuation;
mod derivative;
mod end_map;
mod guess;
mod homotopy;
pub(crate) mod initial;
mod path;
mod problem;
mod random;
mod reduced;
mod relaxation;
pub mod riemannian_cubic;
mod search;
mod shooting;
mod taylor;
mod variation;

pub use boundary::{BoundaryOptions, BoundaryReport, BoundaryStrategy};
pub use derivative::{BoundaryDerivative, BoundaryVariation, CostGradient, InitialVariation};
pub use riemannian_cubic::{IntegrationOptions, RiemannianCubic};
pub use search::SearchOptions;

#[cfg(test)]
mod speed {
    use super::reduced::{Blocks, Fixed, Sized};
    use super::taylor::*;
    use crate::linalg::dual::*;

    fn time<T: Number, B: Blocks>(blocks: B, name: &str, seed: impl Fn(usize, f64) -> T) {
        let (m, k) = (blocks.m(), blocks.k());
        let r = m + k;
        let mut march = March::<T, B>::new(blocks, Accuracy::FULL);
        let start = |march: &mut March<T, B>| {
            march.time = 0.0;
            march.steps = 0;
            for i in 0..k {
                for l in 0..r {
                    march.series.s[l + r * i] = T::constant(if i == l { 1.0 } else { 0.0 });
                }
            }
            for i in 0..m {
                for l in 0..r {
                    march.series.e[l + r * i] = T::constant(if i + k == l { 1.0 } else { 0.0 });
                }
            }
            for d in 0..3 {
                march.series.omega[d][..k * k].fill(T::ZERO);
                let c = [1.0, 2.0, 3.0][d] / ((m * k) as f64).sqrt();
                for i in 0..m * k {
                    march.series.b[d][i] = seed(i, c * (i as f64 * 0.7 + d as f64).cos());
                }
            }
        };
        let mut best = f64::INFINITY;
        for _ in 0..200 {
            let t = std::time::Instant::now();
            start(&mut march);
            march
                .run(1.0, crate::Interrupt::NEVER, |_, _, _| Ok(()))
                .unwrap();
            best = best.min(t.elapsed().as_secs_f64());
        }
        println!(
            "{name} ({m},{k}): {:.2} us, {} steps",
            best * 1e6,
            march.steps
        );
    }

    #[test]
    fn speed() {
        time::<f64, _>(Fixed::<2, 1>, "fixed f64", |_, x| x);
        time::<f64, _>(Sized { m: 2, k: 1 }, "sized f64", |_, x| x);
        time::<Dual<4>, _>(Fixed::<2, 1>, "fixed dual4", |_, x| Dual::constant(x));
        time::<f64, _>(Fixed::<1, 2>, "fixed f64", |_, x| x);
        time::<Dual<8>, _>(Fixed::<1, 2>, "fixed dual8", |_, x| Dual::constant(x));
        time::<Dual<6>, _>(Fixed::<1, 2>, "fixed dual6", |_, x| Dual::constant(x));
        time::<f64, _>(Sized { m: 7, k: 3 }, "sized f64", |_, x| x);
        time::<Dual<8>, _>(Sized { m: 7, k: 3 }, "sized dual8", |_, x| {
            Dual::constant(x)
        });
        time::<f64, _>(Sized { m: 15, k: 5 }, "sized f64", |_, x| x);
        time::<Dual<1>, _>(Sized { m: 15, k: 5 }, "sized dual1", |_, x| {
            Dual::constant(x)
        });
    }
}
