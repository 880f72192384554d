//! Time per particle of the kernels: `cargo bench`. One thread, so that the numbers add up.

use diptych::drag::{Drag, Kick, SchillerNaumann, Sphere};
use diptych::fluid::{Fluid, Profile, TurbulenceModel};
use diptych::particles::Particles;
use diptych::scene::Species;
use diptych::simulation;
use divan::{Bencher, black_box, counter::ItemsCount};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// [m] width of the channel.
const HEIGHT: f64 = 0.03;
/// The paper's law.
const LAW: Drag = Drag::SchillerNaumann(SchillerNaumann);

fn main() {
    divan::main();
}

fn gas() -> Fluid {
    let nu = 1.515e-5;
    let profile = Profile::k_epsilon_channel(15.9, HEIGHT, nu, TurbulenceModel::WallFunctions).unwrap();
    Fluid { density: 1.205, kinematic_viscosity: nu, profile, drag: Some(LAW) }
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

/// The paper's 406 um and 1.5 mm.
fn spheres(gas: &Fluid) -> [Sphere; 2] {
    [(406e-6, 1038.0), (1.5e-3, 1032.0)]
        .map(|(diameter, density)| gas.sphere(&Species { name: String::new(), diameter, density }))
}

#[divan::bench(args = [1_000, 8_000, 100_000])]
fn kick_by_table(bencher: Bencher, count: usize) {
    kick(bencher, count, Kick::tabulated);
}

#[divan::bench(args = [8_000])]
fn kick_by_law(bencher: Bencher, count: usize) {
    kick(bencher, count, Kick::exact);
}

#[divan::bench]
fn kick_table(bencher: Bencher) {
    let spheres = spheres(&gas());
    bencher.bench(|| Kick::tabulated(LAW, black_box(&spheres), 1e-4));
}

fn kick(bencher: Bencher, count: usize, make: impl Fn(Drag, &[Sphere], f64) -> Kick) {
    let fluid = gas();
    let kick = make(LAW, &spheres(&fluid), 1e-8);
    let mut particles = cloud(count);
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| simulation::kick(black_box(&mut particles), &fluid.profile, &kick));
}

#[divan::bench(args = [8_000])]
fn profile(bencher: Bencher, count: usize) {
    let fluid = gas();
    let particles = cloud(count);
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| black_box(&particles).position.iter().map(|x| fluid.profile.velocity(x.y)).sum::<f64>());
}
