//! Results must not depend on frames of reference, mirrors, orders, periodic images or tilted walls. In any scene, no
//! touch is missed, spheres do not overlap, neighbour lists are complete, and starts are valid.

use crate::support::*;
use diptych::domain::Domain;
use diptych::engine::Engine;
use diptych::engine::hard::Hard;
use diptych::experiment::{Integrator, Model};
use diptych::neighbours::NeighbourList;
use diptych::particles::Particles;
use diptych::placement::initial_state;
use diptych::scene::Scene;
use diptych::simulation::Simulation;
use nalgebra::Vector3;
use proptest::prelude::*;
use std::f64::consts::PI;

fn at_phi(count: usize, phi: f64, restitution: f64, friction: f64, seed: u64) -> (Scene, Particles) {
    let scene = empty([edge(count, 1.0, phi); 3], [true; 3], unit(), surface(restitution, friction));
    let particles = random(&scene, count, 1.0, seed);
    (scene, particles)
}

/// Soft engine with the stiffness 1e4 and 20 uniform steps per contact, for spheres of unit mass.
fn stiff() -> Box<dyn Engine> {
    soft(1e4, PI * (0.5f64 / 1e4).sqrt() / 20.0, Integrator::VelocityVerlet)
}

/// Soft engine with the stiffness 1e4 and 20 local steps per contact (steps only for particles in contact), for
/// spheres of unit mass.
fn stiff_local() -> Box<dyn Engine> {
    local(1e4, PI * (0.5f64 / 1e4).sqrt() / 20.0, Integrator::VelocityVerlet)
}

/// Largest difference between two states, of the positions of a particle [m] (by nearest image) or of its velocities
/// [m/s].
fn apart(scene: &Scene, a: &Particles, b: &Particles) -> f64 {
    let x = a
        .position
        .iter()
        .zip(&b.position)
        .map(|(a, b)| scene.domain.separation(&scene.domain.wrap(a), &scene.domain.wrap(b)).norm());
    let v = a.velocity.iter().zip(&b.velocity).map(|(a, b)| (a - b).norm());
    x.chain(v).fold(0.0, f64::max)
}

/// Dissipative gas of 64 spheres with friction, and about 50 collisions in all. Neighbouring trajectories diverge by a
/// factor of about 10 per collision of a sphere, and each sphere has fewer than two collisions on average. The
/// tolerance 1e-9 is sufficient for five collisions.
#[test]
fn changes_of_view_change_nothing() {
    let engines = [("hard", hard as fn() -> Box<dyn Engine>), ("soft", stiff), ("local", stiff_local)];
    // without friction, local stepping solves isolated contacts by another method
    for ((name, engine), friction) in engines.into_iter().flat_map(|engine| [(engine, 0.2), (engine, 0.0)]) {
        let (scene, start) = at_phi(64, 0.15, 0.9, friction, 6);
        let size = scene.domain.size;
        let duration = 0.6;
        let plain = run(&scene, start.clone(), engine(), duration, 3);
        println!("{name}: {} collisions", plain.record.pairs.count);
        assert!((40..200).contains(&plain.record.pairs.count), "{}", plain.record.pairs.count);
        let check = |what: &str, mut seen: Particles, back: &dyn Fn(&mut Vector3<f64>, &mut Vector3<f64>)| {
            for (x, v) in seen.position.iter_mut().zip(&mut seen.velocity) {
                back(x, v);
            }
            let off = apart(&scene, &plain.particles, &seen);
            println!("{name}, {what}: {off:.1e}");
            assert!(off < 1e-9, "{name}, {what}: {off:.1e}");
        };
        // a velocity added to all spheres
        let boost = Vector3::new(3.0, -2.0, 5.0);
        let mut moved = start.clone();
        moved.velocity.iter_mut().for_each(|v| *v += boost);
        check("boost", run(&scene, moved, engine(), duration, 3).particles, &|x, v| {
            *x -= boost * duration;
            *v -= boost;
        });
        // a shift by half a period
        let half = 0.5 * size;
        let mut moved = start.clone();
        moved.position.iter_mut().for_each(|x| *x += half);
        check("half a period", run(&scene, moved, engine(), duration, 3).particles, &|x, _| *x -= half);
        // a mirror image and exchanged axes
        let swap = |v: &Vector3<f64>| Vector3::new(v.z, -v.x, v.y);
        let mut moved = start.clone();
        for (x, v) in moved.position.iter_mut().zip(&mut moved.velocity) {
            *x = swap(x) + Vector3::new(0.0, size.x, 0.0);
            *v = swap(v);
        }
        check("mirror", run(&scene, moved, engine(), duration, 3).particles, &|x, v| {
            *x = Vector3::new(size.x - x.y, x.z, x.x);
            *v = Vector3::new(-v.y, v.z, v.x);
        });
        // other windows: hard spheres have no step; soft spheres have the same step if windows are multiples of it
        if name == "hard" {
            check("eleven windows", run(&scene, start.clone(), engine(), duration, 11).particles, &|_, _| ());
        }
    }
}

#[test]
fn order_of_the_particles_changes_nothing() {
    // oracle E6: in reversed order only rounding differs; the tolerance is 1e-12 for soft spheres over a short time,
    // and 1e-9 for hard spheres
    let (scene, start) = at_phi(64, 0.15, 0.9, 0.2, 6);
    let engines = [(stiff as fn() -> Box<dyn Engine>, 0.3, 1e-12), (stiff_local, 0.3, 1e-12), (hard, 0.6, 1e-9)];
    for (engine, duration, tolerance) in engines {
        let plain = run(&scene, start.clone(), engine(), duration, 3);
        assert!(plain.record.pairs.count > 10);
        let mut reversed = Particles::default();
        for k in (0..start.len()).rev() {
            reversed.push(start.position[k], start.velocity[k], start.radius[k], start.mass[k], start.species[k]);
        }
        let mut end = run(&scene, reversed, engine(), duration, 3).particles;
        end.position.reverse();
        end.velocity.reverse();
        let off = apart(&scene, &plain.particles, &end);
        println!("reversed: {off:.1e}");
        assert!(off < tolerance, "{off:.1e}");
    }
}

#[test]
fn collisions_across_a_periodic_side() {
    // one pair, in the middle of the box, and across a side, an edge and a corner
    let scene = empty([5.0; 3], [true; 3], unit(), surface(0.8, 0.3));
    let velocity = [[0.5, 0.1, -0.2], [-0.5, 0.0, 0.3]];
    let start = [[1.7, 2.4, 2.6], [3.3, 2.6, 2.4]];
    for engine in [hard as fn() -> Box<dyn Engine>, stiff] {
        let go = |shift: [f64; 3]| {
            let shift = Vector3::from(shift);
            let at = |k: usize| (scene.domain.wrap(&(Vector3::from(start[k]) + shift)).into(), velocity[k]);
            let mut end = run(&scene, placed(&scene, &[at(0), at(1)]), engine(), 2.0, 5);
            assert_eq!(end.record.pairs.count, 1);
            end.particles.position.iter_mut().for_each(|x| *x -= shift);
            end.particles
        };
        let plain = go([0.0; 3]);
        for shift in [[2.5, 0.0, 0.0], [0.0, -2.5, 0.0], [0.0, 0.0, 2.5], [2.5, 2.5, 0.0], [2.5, 2.5, 2.5]] {
            // rounding decides in which step a soft contact is detected: the error is that of one step
            assert!(apart(&scene, &plain, &go(shift)) < 1e-9, "{shift:?}");
        }
    }
}

#[test]
fn boxes_of_a_few_diameters() {
    // the box length is between 2 d and 7 d, and windows are long: a pair may meet through any image, after crossing
    // the box more than once. The reference is a brute-force method that tries all 27 images at every event, over the
    // first collisions
    let mut total = 0;
    for (k, edge) in [2.05, 2.3, 2.6, 3.0, 3.5, 4.0, 7.0].into_iter().enumerate() {
        let scene = empty([edge; 3], [true; 3], unit(), surface(1.0, 0.0));
        for seed in 0..5u64 {
            let a = Vector3::new(0.1, 0.2, 0.3);
            let angle = 1.0 + seed as f64 + 10.0 * k as f64;
            let velocity = Vector3::new(angle.sin(), angle.cos(), (2.0 * angle).sin());
            let b = a + Vector3::new(0.5, 0.49, 0.51) * edge;
            let list = [(a.into(), velocity.into()), (b.into(), (-0.6 * velocity).into())];
            // after eight collisions, rounding errors have grown too much for a comparison
            let times = brute_force_pair(a - b, 1.6 * velocity, edge, 100.0);
            let count = times.len().min(8);
            let until = if times.len() > 8 { 0.5 * (times[7] + times[8]) } else { 100.0 };
            total += count;
            for windows in [1, 2, 12, 40, 400] {
                let end = run(&scene, placed(&scene, &list), hard(), until, windows);
                let what = format!("L = {edge} d, seed {seed}, {windows} windows until {until}");
                assert_eq!(end.record.pairs.count, count as u64, "{what}");
                assert!(smallest_gap(&scene, &end.particles) > -1e-12, "{what}");
            }
        }
    }
    println!("{total} collisions");
    assert!(total > 100);
}

/// Times until `until` at which two elastic unit spheres collide in a periodic cube with edges `l`. They start with
/// the separation `r` and the relative velocity `u`. All images are tested, in intervals in which the spheres move by
/// a quarter of a period.
fn brute_force_pair(mut r: Vector3<f64>, mut u: Vector3<f64>, l: f64, until: f64) -> Vec<f64> {
    let mut time = 0.0;
    let mut times = Vec::new();
    loop {
        let mut next: Option<(f64, Vector3<f64>)> = None;
        let leap = 0.25 * l / u.norm();
        r = r.map(|x| x - l * (x / l).round());
        for code in 0..27i32 {
            let image =
                r + l * Vector3::new(f64::from(code % 3 - 1), f64::from(code / 3 % 3 - 1), f64::from(code / 9 - 1));
            let closing = -image.dot(&u);
            let discriminant = closing * closing - u.norm_squared() * (image.norm_squared() - 1.0);
            if closing > 1e-14 && discriminant >= 0.0 {
                let t = ((image.norm_squared() - 1.0) / (closing + discriminant.sqrt())).max(0.0);
                if t < leap && next.is_none_or(|(best, _)| t < best) {
                    next = Some((t, image));
                }
            }
        }
        let (t, hit) = next.map_or((leap, None), |(t, image)| (t, Some(image)));
        time += t;
        if time > until {
            return times;
        }
        r += u * t;
        if let Some(image) = hit {
            let n = (image + u * t).normalize();
            u -= 2.0 * u.dot(&n) * n;
            times.push(time);
        }
    }
}

#[test]
fn no_overlap_after_any_window() {
    for (phi, restitution) in [(0.05, 1.0), (0.3, 1.0), (0.3, 0.9), (0.5, 1.0)] {
        let (scene, start) = at_phi(500, phi, restitution, 0.1, 2);
        let mut simulation = Simulation::with_engine(scene.clone(), start, hard());
        let mut least: f64 = f64::INFINITY;
        for _ in 0..40 {
            simulation.run(1, 0.05).unwrap();
            least = least.min(smallest_gap(&scene, &simulation.particles));
        }
        println!("phi {phi}: smallest gap {least:.1e}, {} collisions", simulation.record.pairs.count);
        assert!(least > -1e-12, "phi {phi}: {least:.1e}");
    }
}

#[test]
fn a_light_particle_that_becomes_fast_misses_nothing() {
    // a heavy sphere hits a light one at rest, which leaves at almost twice the speed. The light sphere moves far
    // beyond the range of the neighbour list, and must hit a third sphere. A mixture follows, as a test for overlaps
    let mut scene = empty([60.0, 20.0, 20.0], [false; 3], unit(), surface(1.0, 0.0));
    scene.walls = vec![plane([59.0, 0.0, 0.0], [-1.0, 0.0, 0.0], surface(1.0, 0.0))];
    for windows in [1, 3, 40] {
        let mut particles = Particles::default();
        particles.push(Vector3::new(2.0, 10.0, 10.0), Vector3::new(1.0, 0.0, 0.0), 0.5, 1000.0, 0);
        particles.push(Vector3::new(4.0, 10.0, 10.0), Vector3::zeros(), 0.5, 1.0, 0);
        particles.push(Vector3::new(12.0, 10.0, 10.0), Vector3::zeros(), 0.5, 1e-3, 0);
        particles.push(Vector3::new(40.0, 10.0, 10.0), Vector3::zeros(), 0.5, 1e-3, 0);
        // the first touch is at t = 1; the light sphere then takes 7/1.998 to the next sphere, which leaves at almost
        // 4, and so on
        let v1 = 2.0 * 1000.0 / 1001.0;
        let v2 = 2.0 * v1 / 1.001;
        let (t1, t2) = (1.0, 1.0 + 7.0 / v1);
        let t3 = t2 + 27.0 / v2;
        let t4 = t3 + (59.0 - 0.5 - 40.0) / v2;
        let end = run(&scene, particles.clone(), hard(), t4 + 0.01, windows);
        assert_eq!((end.record.pairs.count, end.record.walls.count), (3, 1), "{windows} windows, {t1} {t2} {t3} {t4}");
        let v: Vec<f64> = end.particles.velocity.iter().map(|v| v.x).collect();
        close("last", v[3], -v2, 1e-12);
        close("place", end.particles.position[3].x, 58.5 - v2 * 0.01, 1e-10);
    }
    // within one window, a chain of lighter and lighter spheres reaches a speed of 8. The last sphere must hit a sphere
    // far outside the list made for speeds of 1; a bed of spheres at rest keeps the range of the list short
    scene.walls.clear();
    let mut particles = Particles::default();
    let mut x = 2.0;
    for k in 0..4 {
        let v = Vector3::x() * if k == 0 { 1.0 } else { 0.0 };
        particles.push(Vector3::new(x, 10.0, 15.0), v, 0.5, 1e-3f64.powi(k), 0);
        x += 1.2;
    }
    particles.push(Vector3::new(x - 0.2 + 12.0, 10.0, 15.0), Vector3::zeros(), 0.5, 1e3, 0);
    for (k, j, i) in (0..3).flat_map(|k| (0..17).flat_map(move |j| (0..52).map(move |i| (k, j, i)))) {
        let place = Vector3::new(f64::from(i), f64::from(j), f64::from(k)) * 1.1 + Vector3::repeat(0.6);
        particles.push(place, Vector3::zeros(), 0.5, 1.0, 0);
    }
    // touches are at 0.2, 0.3, 0.35 and 1.85; the last sphere does not return before 2.2
    for (by_islands, engine) in [(true, Hard::with_islands()), (false, Hard::with_one_calendar())] {
        let end = run(&scene, particles.clone(), Box::new(engine), 2.2, 1);
        assert_eq!(end.record.pairs.count, 4, "the last collision was missed");
        let counters = end.counters();
        let provoked = !by_islands || counters.islands_redone > 0;
        assert!(provoked, "nothing was cut or done again: the test provokes nothing");
        assert!(end.particles.velocity[3].x < -7.9, "{}", end.particles.velocity[3].x);
    }
    // a mixture with a mass ratio of 10000, in which the heavy spheres move: light spheres become about a hundred times
    // faster
    let scene = empty([14.0; 3], [true; 3], unit(), surface(1.0, 0.0));
    let mut particles = random(&scene, 300, 0.01, 4);
    for k in 0..30 {
        particles.mass[k] = 1e4;
        particles.velocity[k] *= 100.0;
    }
    let energy = particles.kinetic_energy();
    let mut restarts = 0;
    for (windows, by_islands) in [(1, true), (10, true), (1, false), (10, false)] {
        let engine = if by_islands { Hard::with_islands() } else { Hard::with_one_calendar() };
        let mut simulation = Simulation::with_engine(scene.clone(), particles.clone(), Box::new(engine));
        for _ in 0..windows {
            simulation.run(1, 30.0 / f64::from(windows)).unwrap();
            let gap = smallest_gap(&scene, &simulation.particles);
            assert!(gap > -1e-12, "{windows} windows: {gap:.1e}");
        }
        close("energy", simulation.particles.kinetic_energy() / energy, 1.0, 1e-12);
        assert!(simulation.record.pairs.count > 500);
        restarts += if by_islands { simulation.counters().neighbour_builds } else { 0 };
    }
    assert!(restarts > 4, "no window was cut: the test provokes nothing");
}

#[test]
fn starts_are_clean_and_repeat() {
    for phi in [0.01, 0.3, 0.5] {
        let (scene, start) = at_phi(5000, phi, 1.0, 0.0, 17);
        assert_eq!(start.len(), 5000);
        let gap = smallest_gap(&scene, &start);
        println!("phi {phi}: smallest gap {gap:.1e}");
        assert!(gap > 0.0);
        assert!(start.position.iter().all(|x| scene.domain.contains(x)));
        assert_eq!(start.id, (0..5000).collect::<Vec<u32>>());
        assert!(start == random(&scene, 5000, 1.0, 17), "same seed, other bits");
        assert!(start != random(&scene, 5000, 1.0, 18), "other seed, same bits");
    }
    // a start between walls
    let mut scene = empty([20.0, 10.0, 20.0], [true, false, true], unit(), surface(1.0, 0.0));
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(1.0, 0.0)),
        plane([0.0, 10.0, 0.0], [0.0, -1.0, 0.0], surface(1.0, 0.0)),
    ];
    let start = random(&scene, 3000, 1.0, 1);
    assert!(smallest_gap(&scene, &start) > 0.0);
    assert!(start.position.iter().all(|x| (0.5..=9.5).contains(&x.y)));
}

#[test]
fn a_dense_start_of_a_hundred_thousand_is_found() {
    // placement stops after a fixed number of rounds, so that it ends on any machine
    let (scene, start) = at_phi(100_000, 0.5, 1.0, 0.0, 3);
    assert_eq!(start.len(), 100_000);
    let mut list = NeighbourList::default();
    let mut still = start;
    still.velocity.iter_mut().for_each(|v| *v = Vector3::zeros());
    list.build(&mut still, &scene, 1.0);
    let mut slots = Vec::new();
    list.overlapping(&still, &scene, &mut slots);
    assert!(slots.is_empty());
}

#[test]
fn velocities_of_a_start_are_gaussian() {
    // moments of 3 x 20000 values: mean and variance are exact; the tolerances of skewness and excess are 3 sqrt(6/n)
    // and 3 sqrt(24/n)
    let scene = empty([200.0; 3], [true; 3], unit(), surface(1.0, 0.0));
    let start = initial_state(&experiment(scene, 20_000, [1.0, -2.0, 12.0], 0.5, Model::Hard, 7)).unwrap();
    let n = 20_000.0;
    for (axis, mean) in [1.0, -2.0, 12.0].into_iter().enumerate() {
        let values: Vec<f64> = start.velocity.iter().map(|v| (v[axis] - mean) / 0.5).collect();
        let moment = |p: i32| values.iter().map(|v| v.powi(p)).sum::<f64>() / n;
        close("mean", moment(1), 0.0, 1e-12);
        close("variance", moment(2), 1.0, 1e-12);
        close("third", moment(3), 0.0, 3.0 * (6.0f64 / n).sqrt());
        close("fourth", moment(4) - 3.0 * moment(2).powi(2), 0.0, 3.0 * (24.0f64 / n).sqrt());
    }
}

#[test]
fn velocities_of_a_start_have_the_mean_and_spread_asked_for() {
    let scene = empty([50.0; 3], [true; 3], unit(), surface(1.0, 0.0));
    for (count, fluctuation) in [(2, 0.5), (3, 1e-3), (10, 1e5), (1000, 0.5), (10, 0.0), (10, 1e-300)] {
        let start =
            initial_state(&experiment(scene.clone(), count, [1.0, 0.0, -3.0], fluctuation, Model::Hard, 5)).unwrap();
        for (axis, mean) in [1.0, 0.0, -3.0].into_iter().enumerate() {
            let values = start.velocity.iter().map(|v| v[axis]);
            let found = values.clone().sum::<f64>() / count as f64;
            let spread = (values.map(|v| (v - found).powi(2)).sum::<f64>() / count as f64).sqrt();
            // rounding error of a sum of so many terms of this size
            let rounding = f64::EPSILON * count as f64 * (3.0 + fluctuation);
            close(&format!("mean of {count}"), found, mean, rounding);
            close(&format!("spread of {count}"), spread, fluctuation, rounding);
        }
    }
}

#[test]
fn one_sphere_keeps_the_velocity_it_draws() {
    let scene = empty([50.0; 3], [true; 3], unit(), surface(1.0, 0.0));
    let one = |fluctuation: f64, seed: u64| {
        initial_state(&experiment(scene.clone(), 1, [1.0, 2.0, 3.0], fluctuation, Model::Hard, seed)).unwrap().velocity
            [0]
    };
    assert_eq!(one(0.0, 1), Vector3::new(1.0, 2.0, 3.0));
    assert_ne!(one(0.5, 1), one(0.5, 2));
    // 200 draws of three components: their variance has the standard error sqrt(2/600)
    let square = (0..200).map(|seed| (one(0.5, seed) - one(0.0, seed)).norm_squared()).sum::<f64>() / 600.0;
    close("variance over draws", square / 0.25, 1.0, 3.0 * (2.0f64 / 600.0).sqrt());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn neighbour_list_holds_exactly_the_near_pairs(
        size in [1.05f64..12.0, 1.05f64..12.0, 1.05f64..12.0],
        periodic in [any::<bool>(), any::<bool>(), any::<bool>()],
        places in prop::collection::vec([0.0f64..1.0, 0.0f64..1.0, 0.0f64..1.0, 0.05f64..1.0], 0..120),
        speed in 0.0f64..2.0,
    ) {
        let mut scene = empty(size, periodic, unit(), surface(1.0, 0.0));
        scene.domain = Domain::new(size.into(), periodic);
        let mut particles = Particles::default();
        for (k, place) in places.iter().enumerate() {
            let x = Vector3::from_fn(|axis, _| place[axis] * size[axis]);
            let v = Vector3::new(speed, 0.0, 0.0) * if k % 2 == 0 { 1.0 } else { -1.0 };
            particles.push(x, v, 0.5 * place[3], 1.0, 0);
        }
        let mut list = NeighbourList::default();
        list.build(&mut particles, &scene, 0.1);
        let skin = list.skin();
        prop_assert!(list.allows(0.1 * particles.largest_speed(list.frame())), "does not last for one use");
        // positions are wrapped when the list is built: nearest images are found if no particle moves by half a period
        // relative to another
        let period = (0..3).filter(|k| periodic[*k]).map(|k| size[k]).fold(f64::INFINITY, f64::min);
        let needed = 0.2 * particles.largest_speed(list.frame());
        prop_assert!(skin <= (0.5 * period).max(needed).max(2e-3) * 1.000001, "{skin} in a period of {period}");
        let mut got: Vec<(u32, u32)> = list.pairs.iter().map(|p| (p.i.min(p.j), p.i.max(p.j))).collect();
        got.sort_unstable();
        let before = got.len();
        got.dedup();
        prop_assert_eq!(before, got.len(), "a pair is listed twice");
        let mut want = Vec::new();
        for i in 0..particles.len() {
            for j in i + 1..particles.len() {
                let gap = scene.domain.separation(&particles.position[i], &particles.position[j]).norm()
                    - particles.radius[i] - particles.radius[j];
                if gap < skin {
                    want.push((i as u32, j as u32));
                }
            }
        }
        prop_assert_eq!(got, want);
        for (k, pair) in list.pairs.iter().enumerate() {
            prop_assert_eq!(list.slot(&diptych::encounter::Couple::pair(pair.j, pair.i)), Some(k));
        }
    }
}

#[test]
fn a_start_of_many_beside_walls() {
    // one in two thousand positions is within the placement margin of a wall, so that some of 50,000 particles are
    let mut scene = empty([0.1, 0.03, 0.06], [true, false, true], small(), surface(1.0, 0.0));
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(1.0, 0.0)),
        plane([0.0, 0.03, 0.0], [0.0, -1.0, 0.0], surface(1.0, 0.0)),
    ];
    let particles = random(&scene, 50_000, 0.5, 3);
    let radius = 0.5 * scene.species[0].diameter;
    assert!(particles.position.iter().all(|x| x.y >= radius && x.y <= 0.03 - radius));
}
