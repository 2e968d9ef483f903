#[path = "../tests/common/mod.rs"]
mod common;
use common::*;
use stiefel_rs::RiemannianCubic;
use stiefel_rs::cubic::*;
fn main() {
    let args: Vec<usize> = std::env::args()
        .skip(1)
        .map(|a| a.parse().unwrap())
        .collect();
    let (n, k, count) = (args[0], args[1], args[2]);
    let mut rng = Rng::new(1);
    let s = random_point(n, k, &mut rng);
    let [v, a, j] = [1.0, 2.0, 3.0].map(|x| random_tangent(&s, x, &mut rng));
    let b = Boundary::random((n, k), 1.5, 1.5, &mut rng);
    let mut best = [f64::INFINITY; 2];
    for _ in 0..count {
        let t = std::time::Instant::now();
        let c = RiemannianCubic::from_initial(
            s.as_ref(),
            v.as_ref(),
            a.as_ref(),
            j.as_ref(),
            &IntegrationOptions::default(),
        )
        .unwrap();
        best[0] = best[0].min(t.elapsed().as_secs_f64());
        std::hint::black_box(c);
        if args.len() > 3 {
            let t = std::time::Instant::now();
            let c = RiemannianCubic::from_boundary(
                b.s0.as_ref(),
                b.v0.as_ref(),
                b.s1.as_ref(),
                b.v1.as_ref(),
                &BoundaryOptions::default(),
            )
            .unwrap();
            best[1] = best[1].min(t.elapsed().as_secs_f64());
            if best[1] == 0.0 {
                println!("{:?}", c.report());
            }
        }
    }
    println!(
        "({n},{k}) ivp {:.2} us, bvp {:.2} us",
        best[0] * 1e6,
        best[1] * 1e6
    );
}
