//! Outlets in the shape of a closed surface of triangles: which points are inside, flows of all models, messages.

use super::{FlowTotals, block, feed, stream, sum_of};
use crate::meshes::heaps::{self, Heap, torus};
use crate::support::*;
use diptych::case::Case;
use diptych::experiment::{Model, TimeStep};
use diptych::placement::initial_state;
use diptych::scene::{Outlet, OutletShape};
use diptych::simulation::Simulation;
use diptych::walls::{Mesh, Sides};
use diptych::{Particles, Scene, Vector3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::fmt::Write;
use std::sync::Arc;

/// Outlet that consists of the space inside a closed surface of triangles. `sides` tells the side of the triangles on
/// which it lies.
fn inside(heap: &Heap, sides: Sides) -> Outlet {
    let mesh = Mesh::new("made", heap, Some(sides)).unwrap().0;
    Outlet { name: "surface".into(), shape: OutletShape::Mesh(Arc::new(mesh)) }
}

/// Faces of a box between two corners [m], each of 2 n² triangles.
fn cuboid(low: [f64; 3], high: [f64; 3], n: u32) -> Heap {
    let [low, high] = [low, high].map(Vector3::from);
    heaps::block(0.5 * (low + high), 0.5 * (high - low), n)
}

/// Points at random in a box from -2 to 2 m along each axis.
fn points(seed: u64) -> impl Iterator<Item = Vector3<f64>> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    (0..20_000).map(move |_| Vector3::from_fn(|_, _| 4.0 * random.random::<f64>() - 2.0))
}

#[test]
fn a_torus_takes_what_is_in_its_ring_alone() {
    let (large, small, around, across) = (1.3, 0.5, 96, 64);
    let outlet = inside(&torus(Vector3::zeros(), [large, small], around, across), Sides::Outside);
    let (mut within, mut in_the_hole) = (0, 0);
    for point in points(4) {
        let out = point.x.hypot(point.z) - large;
        let depth = small - out.hypot(point.y);
        // triangles are nearer to the circle than the torus by up to r (1 - cos(π/n)), along both ways round
        let sag = |radius: f64, n: u32| radius * (1.0 - (std::f64::consts::PI / f64::from(n)).cos());
        if depth.abs() > sag(large + small, around) + sag(small, across) {
            assert_eq!(outlet.takes(&point), depth > 0.0, "{point:?}");
        }
        within += u32::from(outlet.takes(&point));
        in_the_hole += u32::from(out < -small && point.y.abs() < small);
    }
    // the torus has the volume 2π² R r², 10 % of the box; four standard deviations of the binomial number are 0.9 %
    let share = f64::from(within) / 20_000.0;
    close("share", share, 2.0 * std::f64::consts::PI.powi(2) * large * small * small / 64.0, 0.009);
    assert!(in_the_hole > 100, "the test says nothing about the hole: {in_the_hole}");
}

#[test]
fn cavities_and_sheets_take_nothing() {
    let skin = cuboid([-1.5; 3], [1.5; 3], 2);
    let hollow = [skin.clone(), cuboid([-1.0; 3], [1.0; 3], 3)].concat();
    let thick = inside(&hollow, Sides::Outside);
    let vessel = inside(&skin, Sides::Inside);
    let sheet = inside(&skin, Sides::Both);
    for point in points(5) {
        let farthest = point.amax();
        assert_eq!(thick.takes(&point), farthest > 1.0 && farthest < 1.5, "{point:?}");
        assert_eq!(vessel.takes(&point), farthest < 1.5, "{point:?}");
        assert!(!sheet.takes(&point), "{point:?}");
    }
}

/// Runs a stream of particles with the given outlets. Returns the sums over its inlets and over its outlets, the final
/// particles, and the unexplained share of the energy [-].
fn flow_through(outlets: Vec<Outlet>, model: Model) -> ([FlowTotals; 2], Particles, f64) {
    let inlets = vec![feed(block([0.0, 0.0, 10.0], [10.0, 10.0, 16.0]), 40.0, [0.5, 0.0, 1.0], 2.0)];
    let scene = Scene { outlets, inlets, ..stream(1.0, 40.0) };
    let mut of = experiment(scene, 60, [0.0; 3], 1.0, model, 5);
    of.soft.time_step = TimeStep::Fixed(1e-3);
    let start = initial_state(&of).unwrap();
    let mut simulation = Simulation::new(&of, start.clone());
    let energy = simulation.energy();
    simulation.run(60, 0.05).unwrap_or_else(|why| panic!("{model:?}: {why}"));
    let flow = simulation.through_flow().unwrap();
    let totals = [sum_of(flow.inlets.iter()), sum_of(flow.outlets.iter())];
    let ledger = &simulation.record.ledger;
    let pushed = ledger.gravity_impulse + ledger.wall_impulse + ledger.flow_impulse;
    // each side of the balance is rounded once per window
    let rounding = 1e-13 * 60.0 * (1.0 + ledger.through(energy));
    close("momentum", (simulation.particles.momentum() - start.momentum() - pushed).norm(), 0.0, rounding);
    let (came, left) = (&totals[0], &totals[1]);
    assert_eq!(simulation.particles.len() as u64 + left.count, 60 + came.count, "{model:?}");
    close("flow of momentum", (ledger.flow_impulse - (came.momentum - left.momentum)).norm(), 0.0, rounding);
    let residual = ledger.residual(energy, simulation.energy()) / ledger.through(energy);
    (totals, simulation.state(), residual)
}

/// The outlets are cubes behind both ends of a stream. Cubes from a file of triangles must take the same particles as
/// blocks.
#[test]
fn a_cube_of_triangles_is_a_block_in_every_model() {
    let ends = [([0.0; 3], [10.0, 10.0, 3.0]), ([0.0, 0.0, 27.0], [10.0, 10.0, 30.0])];
    let blocks = ends.map(|(low, high)| Outlet { name: "b".into(), shape: OutletShape::Body(block(low, high)) });
    let meshes = ends.map(|(low, high)| inside(&cuboid(low, high, 3), Sides::Outside));
    for model in [Model::Soft, Model::Hard, Model::Hybrid, Model::Dsmc] {
        let [block, mesh] = [&blocks, &meshes].map(|outlets| flow_through(outlets.to_vec(), model));
        assert!(mesh.0[1].count > 10, "{model:?}: {:?}", mesh.0[1]);
        assert!(block == mesh, "{model:?}: {:?} in place of {:?}", mesh.0, block.0);
        // contacts in 1e-3 s, a 70th of their duration, have (ω_0 Δt)²/4 = 5e-4
        assert!(mesh.2.abs() <= 5e-4, "{model:?}: {}", mesh.2);
    }
}

const CASE: &str = r#"
[domain]
size = ["20 mm", "20 mm", "20 mm"]
periodic = ["x", "z"]
[[particles]]
diameter = "1 mm"
density = "2500 kg/m^3"
at = [{ position = ["5 mm", "15 mm", "5 mm"] }, { position = ["12 mm", "15 mm", "12 mm"] }]
[gravity]
acceleration = ["0 m/s^2", "-9.81 m/s^2", "0 m/s^2"]
[[outlets]]
mesh = { file = "made.stl", unit = "1 mm", position = ["12 mm", "2 mm", "12 mm"] }
[contact]
restitution = 0.9
[run]
model = "hard"
duration = "45 ms"
window = "1 ms"
"#;

/// Triangles as STL in text form.
fn stl(heap: &Heap) -> String {
    let mut text = "solid made\n".to_owned();
    for triangle in heap {
        text += "facet normal 0 0 0\nouter loop\n";
        triangle.iter().for_each(|p| writeln!(text, "vertex {:.6} {:.6} {:.6}", p.x, p.y, p.z).unwrap());
        text += "endloop\nendfacet\n";
    }
    text + "endsolid made\n"
}

/// Experiment of the case with a file of the triangles `heap` in its folder; otherwise the message of the error.
fn read(heap: Option<&Heap>, sets: &[&str]) -> Result<diptych::experiment::Experiment, String> {
    let folder = tempfile::tempdir().unwrap();
    if let Some(heap) = heap {
        std::fs::write(folder.path().join("made.stl"), stl(heap)).unwrap();
    }
    let path = folder.path().join("case.toml");
    std::fs::write(&path, CASE).unwrap();
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let case = Case::read(&path, &sets).map_err(|why| why.to_string())?;
    case.experiment(None, None).map(|(experiment, _)| experiment).map_err(|why| why.to_string())
}

#[test]
fn a_case_names_a_file_and_bad_ones_are_refused_with_a_remedy() {
    let cube = cuboid([-4.0, -1.0, -4.0], [4.0, 1.0, 4.0], 1);
    let good = read(Some(&cube), &[]).unwrap();
    let mut simulation = Simulation::new(&good, initial_state(&good).unwrap());
    // 12 mm of fall to the upper face take 49.5 ms; the face is at 3 mm
    simulation.run(49, 1e-3).unwrap();
    assert_eq!(simulation.particles.len(), 2);
    simulation.run(2, 1e-3).unwrap();
    assert_eq!(simulation.particles.id, [0], "the one beside the outlet stays");
    let open: Heap = cube[1..].to_vec();
    let crossing = [cube.clone(), cuboid([0.0, -0.5, 0.0], [5.0, 0.5, 5.0], 1)].concat();
    let whole = Some(&cube);
    let cases: [(Option<&Heap>, &[&str], &[&str]); 7] = [
        (Some(&open), &[], &["outlets[0].mesh.file", "made.stl", "is not watertight", "3 of its edges", "close it"]),
        (Some(&crossing), &[], &["made.stl", "closed parts that are partly within others", "one outlet for each"]),
        (None, &[], &["outlets[0].mesh.file", "made.stl", "case.toml"]),
        (
            whole,
            &["outlets[0].mesh.position=[\"17 mm\", \"2 mm\", \"12 mm\"]"],
            &["beyond a periodic side: x", "cut it"],
        ),
        (whole, &["outlets[0].mesh.position=[\"12 mm\", \"-3 mm\", \"12 mm\"]"], &["lies outside the domain"]),
        (whole, &["outlets[0].mesh.unit=\"1 m\""], &["did you mean unit"]),
        (whole, &["outlets[0].mesh.inside=true"], &["inside"]),
    ];
    for (heap, set, words) in cases {
        let why = read(heap, set).unwrap_err();
        assert!(words.iter().all(|words| why.contains(words)), "{set:?}: {why}");
    }
    // a body may reach beyond a side that is not periodic
    read(whole, &["outlets[0].mesh.position=[\"12 mm\", \"0 mm\", \"12 mm\"]"]).unwrap();
}
