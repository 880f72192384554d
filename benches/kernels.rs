//! Time per particle of the kernels: `cargo bench`. One thread, so that the numbers add up.

use diptych::drag::{Drag, SchillerNaumann};
use diptych::fluid::{Fluid, Profile, TurbulenceModel};
use diptych::particles::Particles;
use diptych::scene::Species;
use diptych::simulation;
use divan::{Bencher, black_box, counter::ItemsCount};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

const HEIGHT: f64 = 0.03;

fn main() {
    divan::main();
}

fn gas() -> Fluid {
    let nu = 1.515e-5;
    let profile = Profile::k_epsilon_channel(15.9, HEIGHT, nu, TurbulenceModel::WallFunctions).unwrap();
    Fluid { density: 1.205, kinematic_viscosity: nu, profile, drag: Some(Drag::SchillerNaumann(SchillerNaumann)) }
}

fn cloud(count: usize) -> Particles {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut particles = Particles::default();
    for i in 0..count {
        let x = Vector3::from_fn(|_, _| HEIGHT * random.random::<f64>());
        let v = Vector3::new(0.0, 0.0, 13.0) + Vector3::from_fn(|_, _| 2.0 * random.random::<f64>() - 1.0);
        particles.push(x, v, 1e-4, 1e-9, (i % 2) as u16);
    }
    particles
}

fn species() -> [Species; 2] {
    [(406e-6, 1038.0), (1.5e-3, 1032.0)].map(|(diameter, density)| Species { name: String::new(), diameter, density })
}

#[divan::bench(args = [1_000, 8_000, 100_000])]
fn kick(bencher: Bencher, count: usize) {
    let fluid = gas();
    let spheres = species().map(|species| fluid.sphere(&species));
    let mut particles = cloud(count);
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| simulation::kick(black_box(&mut particles), &fluid, &spheres, 1e-8));
}

#[divan::bench(args = [8_000])]
fn profile(bencher: Bencher, count: usize) {
    let fluid = gas();
    let particles = cloud(count);
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| black_box(&particles).position.iter().map(|x| fluid.profile.velocity(x.y)).sum::<f64>());
}
