//! Two-way coupling: the gas alone stays as it is, momentum of gas and particles closes, the pressure drop carries the
//! weight of the particles, same bits, messages.
mod first_step;
mod half_kick;
use crate::support::{case, close, diptych, shared, words};
use diptych::ContactLaw;
use diptych::engine::distributed::Distributed;
use diptych::engine::soft::Soft;
use diptych::experiment::{Experiment, Integrator, Model, SoftStepping};
use diptych::fluid::{
    ChannelFlow, Coupling, HeldFlow, Langevin, LoadedFlow, Modulation, SliceSums, TurbulenceModel, TurbulenceStatistics,
};
use diptych::placement::initial_state;
use diptych::schedule::Schedule;
use diptych::simulation::Simulation;

/// A vertical channel, 40 mm wide, with a thousand beads; `@` stands for further keys of the gas.
const CHANNEL: &str = r#"
[domain]
size = ["10 mm", "40 mm", "20 mm"]
periodic = ["x", "z"]
[gravity]
acceleration = ["0 m/s^2", "0 m/s^2", "-9.81 m/s^2"]
[fluid]
density = "1.2 kg/m^3"
kinematic_viscosity = "1.5e-5 m^2/s"
[fluid.profile.k_epsilon_channel]
reynolds_number = 42000
[fluid.coupling]
slices = 10
[drag.schiller_naumann]
[[particles]]
name = "bead"
diameter = "0.4 mm"
density = "1000 kg/m^3"
count = 1000
velocity_mean = ["0 m/s", "0 m/s", "13 m/s"]
velocity_fluctuation = "0.5 m/s"
[[walls]]
restitution = 1
plane = { point = ["0 m", "0 m", "0 m"], normal = [0, 1, 0] }
[[walls]]
restitution = 1
plane = { point = ["0 m", "40 mm", "0 m"], normal = [0, -1, 0] }
[contact]
restitution = 1
[soft.linear_spring_dashpot]
stiffness = "1000 N/m"
[run]
model = "hard"
duration = "0.5 s"
seed = 3
"#;

fn begin(experiment: &Experiment) -> Simulation {
    Simulation::new(experiment, initial_state(experiment).unwrap())
}

/// Runs the first windows (times between two exchanges with the gas) of an experiment.
fn run(experiment: &Experiment, windows: u64) -> Simulation {
    let mut simulation = begin(experiment);
    simulation.run(windows, Schedule::new(experiment).window).unwrap();
    simulation
}

fn flow(model: TurbulenceModel) -> ChannelFlow {
    ChannelFlow::solve(15.75, 0.04, 1.5e-5, model).unwrap()
}

/// Without particles the steady solution of the gas stays steady. It was iterated until k and ε changed by less than
/// 1e-11 in one sweep over the cells (weight 0.7); a time step of any length repeats such a sweep.
#[test]
fn a_gas_without_particles_stays_as_it_is() {
    for model in [TurbulenceModel::WallFunctions, TurbulenceModel::LaunderSharma] {
        let alone = flow(model);
        let gradient = alone.pressure_gradient(1.2);
        for held in [HeldFlow::FlowRate, HeldFlow::PressureGradient(gradient)] {
            let coupling = Coupling { slices: 7, held, modulation: Modulation::Simonin };
            let mut loaded = LoadedFlow::new(coupling, &alone, 1.2, 1.0);
            for duration in [1e-4, 1e-3, 0.1] {
                (0..50).for_each(|_| loaded.advance(duration, &[SliceSums::default(); 7]));
            }
            let present = loaded.flow().unwrap();
            for (now, before) in present.nodes.iter().zip(&alone.nodes) {
                close("velocity", now.u, before.u, 1e-8 * alone.bulk_velocity);
                close("k", now.k, before.k, 1e-8 * before.k);
                close("ε", now.epsilon, before.epsilon, 1e-8 * before.epsilon);
            }
            close("pressure gradient", loaded.pressure_gradient(), gradient, 1e-8 * gradient);
            let momentum = loaded.balance;
            close("momentum", momentum.unexplained(), 0.0, 1e-12 * momentum.by_pressure);
        }
    }
}

/// Crowe's modulation leaves a gas without particles as it is. If slip s produces most of the turbulence, its kinetic
/// energy k follows r s² = k^(3/2)/l (exchange rate r). Here 1/l = 1/λ + 1/l_0, with the spacing λ of the particles
/// and the length l_0 of the gas alone. Shear and diffusion change k by less than 2 %.
#[test]
fn slip_produces_the_turbulence_of_crowe() {
    for model in [TurbulenceModel::WallFunctions, TurbulenceModel::LaunderSharma] {
        let alone = flow(model);
        let coupling = Coupling { slices: 7, held: HeldFlow::FlowRate, modulation: Modulation::Crowe };
        let mut loaded = LoadedFlow::new(coupling, &alone, 1.2, 1.0);
        (0..100).for_each(|_| loaded.advance(1e-3, &[SliceSums::default(); 7]));
        for (now, before) in loaded.flow().unwrap().nodes.iter().zip(&alone.nodes) {
            close("k", now.k, before.k, 1e-8 * before.k);
            close("ε", now.epsilon, before.epsilon, 1e-8 * before.epsilon);
        }
    }
    let alone = flow(TurbulenceModel::WallFunctions);
    let coupling = Coupling { slices: 7, held: HeldFlow::FlowRate, modulation: Modulation::Crowe };
    let mut loaded = LoadedFlow::new(coupling, &alone, 1.2, 1.0);
    let (duration, slip, rate, share, diameter) = (1e-4, 8.0, 40.0, 0.02, 1e-4_f64);
    let volume = loaded.box_volume() / 7.0;
    let exchange = rate * 1.2 * volume;
    let one = std::f64::consts::PI / 6.0 * diameter.powi(3);
    let sums = SliceSums {
        impulse: slip * exchange * duration,
        volume: share * volume,
        mass: 1.0,
        exchange,
        count: share * volume / one,
    };
    let spacing = (one / share).cbrt() - diameter;
    close("spacing", sums.spacing(volume), spacing, 1e-12);
    (0..20_000).for_each(|_| loaded.advance(duration, &[sums; 7]));
    let produced = rate / (1.0 - share) * slip * slip;
    let present = loaded.flow().unwrap();
    let middle = alone.nodes.len() - 1;
    let length = alone.nodes[middle].k.powf(1.5) / alone.nodes[middle].epsilon;
    let wanted = (produced / (1.0 / spacing + 1.0 / length)).powf(2.0 / 3.0);
    let (k, epsilon) = (present.nodes[middle].k, present.nodes[middle].epsilon);
    println!("k {k} wanted {wanted}; gas alone {}", alone.nodes[middle].k);
    // diffusion from places with other lengths, and production by shear
    close("k in the middle", k, wanted, 0.02 * wanted);
    close("ε in the middle", epsilon, k.powf(1.5) * (1.0 / spacing + 1.0 / length), 1e-9 * epsilon);
}

/// If particles take momentum uniformly from the gas in a channel or a pipe, the pressure drop rises by this force per
/// volume, and nothing else changes. The gas answers within 0.05 s (height over friction velocity); 2 s are simulated.
#[test]
fn a_uniform_force_is_carried_by_the_pressure_drop() {
    let pipe = ChannelFlow::solve_pipe(15.75, 0.04, 1.5e-5, None).unwrap();
    for alone in [flow(TurbulenceModel::WallFunctions), flow(TurbulenceModel::LaunderSharma), pipe] {
        let coupling = Coupling { slices: 9, held: HeldFlow::FlowRate, modulation: Modulation::None };
        let mut loaded = LoadedFlow::new(coupling, &alone, 1.2, 1.0);
        let volume = loaded.box_volume();
        let (force, duration) = (100.0, 1e-3);
        // slices of a pipe have the volumes of rings
        let part = |slice: usize| match alone.section {
            diptych::fluid::Section::Channel => 1.0 / 9.0,
            diptych::fluid::Section::Pipe => (17.0 - 2.0 * slice as f64) / 81.0,
        };
        let sums = |slice| SliceSums { impulse: force * duration * volume * part(slice), ..SliceSums::default() };
        let slices: Vec<SliceSums> = (0..9).map(sums).collect();
        (0..2000).for_each(|_| loaded.advance(duration, &slices));
        let wanted = alone.pressure_gradient(1.2) + force;
        close("pressure drop", loaded.pressure_gradient(), wanted, 1e-8 * wanted);
        for (now, before) in loaded.flow().unwrap().nodes.iter().zip(&alone.nodes) {
            close("velocity", now.u, before.u, 1e-7 * alone.bulk_velocity);
        }
    }
}

/// The momentum of the particles and of the gas changes only by weight, by the pressure drop and by friction of the
/// gas at the walls. Smooth walls take no momentum of particles along z. Sums are exact to 1e-10 of the largest part.
#[test]
fn momentum_of_gas_and_particles_closes() {
    for (model, keys) in [
        (Model::Hard, &["fluid.coupling.pressure_gradient=\"120 Pa/m\""][..]),
        (Model::Soft, &["fluid.lift.shear=true"]),
        (Model::Dsmc, &["fluid.profile.k_epsilon_channel.model=\"launder_sharma\"", "fluid.turbulence.langevin={}"]),
    ] {
        let experiment = case(CHANNEL, model, keys).unwrap();
        let before = begin(&experiment);
        let after = run(&experiment, 300);
        let gas = after.loaded_flow().unwrap().balance;
        let ledger = &after.record.ledger;
        let weight = ledger.gravity_impulse.z;
        let gained = after.particles.momentum().z - before.particles.momentum().z;
        let largest = gas.by_pressure.abs().max(weight.abs()).max(gas.to_particles.abs());
        close("particles", gained, weight + ledger.drag_impulse.z, 1e-10 * largest);
        close("exchange", gas.to_particles, ledger.drag_impulse.z, 1e-10 * largest);
        close("gas", gas.unexplained(), 0.0, 1e-10 * largest);
        let both = gained + gas.now - gas.start;
        close("both", both, weight + gas.by_pressure - gas.to_walls, 1e-10 * largest);
        assert!(gas.to_particles > 0.1 * largest, "the gas has hardly acted: {gas:?}");
    }
}

/// In a steady state the pressure drop carries the friction of the gas at the walls and the weight of the particles.
/// In the second half of this run, particles and gas still gain some momentum. With this gain, the balance holds to
/// rounding. The gain is less than a fifth of the weight.
#[test]
fn the_pressure_drop_rises_by_the_weight_of_the_particles() {
    let experiment = case(CHANNEL, Model::Hard, &[]).unwrap();
    let schedule = Schedule::new(&experiment);
    let mut simulation = begin(&experiment);
    simulation.run(schedule.windows() / 2, schedule.window).unwrap();
    let (early, start) = (simulation.loaded_flow().unwrap().balance, simulation.time);
    let moving = simulation.particles.momentum().z;
    simulation.run(schedule.windows() / 2, schedule.window).unwrap();
    let late = simulation.loaded_flow().unwrap();
    let (volume, time) = (late.box_volume(), simulation.time - start);
    let per_volume = |impulse: f64| impulse / (volume * time);
    let drop = per_volume(late.balance.by_pressure - early.by_pressure);
    let friction = per_volume(late.balance.to_walls - early.to_walls);
    let gained = per_volume(simulation.particles.momentum().z - moving + late.balance.now - early.now);
    let fluid = experiment.scene.fluid.as_ref().unwrap();
    let weight = 9.81 * (1000.0 - fluid.density) * 1000.0 * std::f64::consts::PI / 6.0 * 0.4e-3_f64.powi(3) / volume;
    close("balance", drop, friction + weight + gained, 1e-9 * drop);
    // one response time is 0.3 s: the particles still gain some of their weight
    assert!(gained.abs() < 0.2 * weight && drop > 1.5 * friction, "{drop} {friction} {weight} {gained}");
}

/// Damping by particles cannot be tested alone in a channel, where shear produces turbulence. So the flows with and
/// without Simonin's damping are compared: it lowers the turbulent kinetic energy k everywhere.
#[test]
fn particles_damp_turbulence() {
    let of = |modulation: &str| {
        let experiment = case(CHANNEL, Model::Hard, &[&format!("fluid.coupling.modulation=\"{modulation}\"")]).unwrap();
        run(&experiment, Schedule::new(&experiment).windows()).loaded_flow().unwrap().flow().unwrap().nodes
    };
    let (without, with) = (of("none"), of("simonin"));
    for (without, with) in without.iter().zip(&with) {
        assert!(with.k < 0.95 * without.k, "{with:?} {without:?}");
    }
}

#[test]
fn the_gas_is_the_same_on_processes_and_after_a_snapshot() {
    let experiment = case(CHANNEL, Model::Soft, &["fluid.lift.shear=true", "fluid.turbulence.langevin={}"]).unwrap();
    let window = Schedule::new(&experiment).window;
    let start = initial_state(&experiment).unwrap();
    let mut whole = run(&experiment, 40);
    let state = |simulation: &mut Simulation| (simulation.fingerprint(), simulation.loaded_flow().cloned());
    // resumed in the middle, after observers have looked at half-kicked states
    let mut first = Simulation::new(&experiment, start.clone());
    let mut done = 0;
    first
        .run_while(40, window, &mut |simulation, windows| {
            done = windows;
            simulation.with_synchronised_velocities(0.5 * window, |_| ());
            windows < 17
        })
        .unwrap();
    let mut second = Simulation::restore(&experiment, first.snapshot().unwrap()).unwrap();
    second.run(40 - done, window).unwrap();
    assert_eq!(state(&mut whole), state(&mut second));
    let of = (experiment.scene.clone(), start);
    for stepping in [SoftStepping::Local, SoftStepping::Uniform] {
        let engine = || {
            Box::new(Soft::new(ContactLaw::linear(1000.0), Integrator::VelocityVerlet, 1e-6, stepping))
                as Box<dyn Distributed>
        };
        let on = |size| shared(size, &of, &engine, (4e-3, 12), state);
        let alone = on(1);
        for size in [2, 3] {
            assert_eq!(on(size), alone, "{size} processes");
        }
    }
}

/// Three beads in a narrow channel weigh more than the pressure gradient carries. The gas stops; the report says so.
#[test]
fn a_report_says_that_the_gas_has_left_the_range_of_its_model() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("case.toml");
    let heavy = CHANNEL
        .replace("size = [\"10 mm\", \"40 mm\"", "size = [\"10 mm\", \"20 mm\"")
        .replace("point = [\"0 m\", \"40 mm\"", "point = [\"0 m\", \"20 mm\"")
        .replace("reynolds_number = 42000", "reynolds_number = 8000\nmodel = \"launder_sharma\"")
        .replace("slices = 10", "slices = 5\npressure_gradient = \"20 Pa/m\"")
        .replace("count = 1000", "count = 400")
        .replace("\"13 m/s\"", "\"4 m/s\"")
        .replace("duration = \"0.5 s\"", "duration = \"2 s\"");
    let sentence = "the gas has left the range of its turbulence model";
    for (text, wanted) in [(heavy.clone(), true), (heavy.replace("count = 400", "count = 1"), false)] {
        std::fs::write(&file, text).unwrap();
        let out = folder.path().join(if wanted { "heavy" } else { "light" });
        let output = diptych(&["run", file.to_str().unwrap(), "--out", out.to_str().unwrap()]).output().unwrap();
        assert!(output.status.success(), "{}", words(&output.stderr));
        let report = std::fs::read_to_string(out.join("report.html")).unwrap();
        assert_eq!(report.contains(sentence), wanted, "{sentence}");
    }
}

/// In a channel and a pipe, particles take unequal momentum in different slices; the gas loses exactly this momentum.
#[test]
fn uneven_slices_of_a_pipe_lose_no_momentum() {
    let pipe = ChannelFlow::solve_pipe(15.75, 0.04, 1.5e-5, None).unwrap();
    for alone in [flow(TurbulenceModel::WallFunctions), pipe] {
        let coupling = Coupling { slices: 7, held: HeldFlow::FlowRate, modulation: Modulation::Simonin };
        let mut loaded = LoadedFlow::new(coupling, &alone, 1.2, 1.0);
        let volume = loaded.box_volume() / 7.0;
        let slices = |step: usize| -> Vec<SliceSums> {
            let sums = |slice: usize| SliceSums {
                impulse: 1e-3 * volume * ((slice + step) % 7) as f64,
                volume: 0.01 * volume * ((3 * slice + step) % 5) as f64,
                ..SliceSums::default()
            };
            (0..7).map(sums).collect()
        };
        (0..300).for_each(|step| loaded.advance(1e-4, &slices(step)));
        let balance = loaded.balance;
        let wanted: f64 = (0..300).flat_map(slices).map(|sums| sums.impulse).sum();
        close("to particles", balance.to_particles, wanted, 1e-12 * wanted);
        close("gas", balance.unexplained_share(), 0.0, 1e-10);
    }
}

/// Gas enters a slice that particles leave with the velocity of the neighbouring slice. In a step too short for
/// friction, the new velocity in a cell thus stays within the range of the cell and its neighbours before.
#[test]
fn gas_that_makes_room_keeps_its_velocity() {
    let alone = flow(TurbulenceModel::WallFunctions);
    let coupling = Coupling { slices: 6, held: HeldFlow::PressureGradient(0.0), modulation: Modulation::None };
    let mut loaded = LoadedFlow::new(coupling, &alone, 1.2, 1.0);
    let volume = loaded.box_volume() / 6.0;
    let full = |odd: usize| -> Vec<SliceSums> {
        let share = |slice: usize| if slice % 2 == odd { 0.3 * volume } else { 0.0 };
        (0..6).map(|slice| SliceSums { volume: share(slice), ..SliceSums::default() }).collect()
    };
    loaded.advance(1e-12, &full(0));
    for odd in [1, 0] {
        let before: Vec<f64> = loaded.flow().unwrap().nodes.iter().map(|node| node.u).collect();
        loaded.advance(1e-12, &full(odd));
        let after = loaded.flow().unwrap();
        for (cell, node) in after.nodes.iter().enumerate() {
            let near = &before[cell.saturating_sub(1)..(cell + 2).min(before.len())];
            let [low, high] = [f64::min, f64::max].map(|of| near.iter().copied().reduce(of).unwrap());
            assert!(node.u > low - 1e-6 && node.u < high + 1e-6, "{cell}: {} in {low} .. {high}", node.u);
        }
    }
}

/// Particles with the response time τ damp k at the rate 2 r k St/(1 + St) (exchange rate r). St is τ over the
/// integral time (k/ε)/(1/2 + 3/4 C_0) with the constant C_0 of the case, so St/(1 + St) changes with C_0.
#[test]
fn turbulence_is_damped_by_the_constants_of_the_case() {
    let alone = flow(TurbulenceModel::WallFunctions);
    let middle = *alone.nodes.last().unwrap();
    let response = 0.5 * middle.k / middle.epsilon;
    let logarithm = |modulation: Modulation, kolmogorov_constant: f64| {
        let coupling = Coupling { slices: 7, held: HeldFlow::FlowRate, modulation };
        let constants = Langevin { kolmogorov_constant, ..Langevin::default() };
        let mut loaded = LoadedFlow::new(coupling, &alone, 1.2, 1.0).with_langevin(constants);
        let exchange = 20.0 * 1.2 * loaded.box_volume() / 7.0;
        loaded.advance(1e-5, &[SliceSums { mass: response * exchange, exchange, ..SliceSums::default() }; 7]);
        loaded.flow().unwrap().nodes.last().unwrap().k.ln()
    };
    let damped = |constant: f64| logarithm(Modulation::None, constant) - logarithm(Modulation::Simonin, constant);
    let share = |constant: f64| {
        let stokes = 0.5 * (0.5 + 0.75 * constant);
        stokes / (1.0 + stokes)
    };
    for constant in [1.0, 2.1, 7.0] {
        let wanted = share(constant) / share(2.1);
        // the logarithms change by 2e-4, so that the ratio errs by about as much
        close("damping over that of 2.1", damped(constant) / damped(2.1), wanted, 1e-3 * wanted);
    }
    let seen = "[fluid.turbulence.langevin]\nkolmogorov_constant = 7\n[fluid.coupling]";
    let [own, default] = [seen, "[fluid.turbulence.langevin]\n[fluid.coupling]"].map(|table| {
        let experiment = case(&CHANNEL.replace("[fluid.coupling]", table), Model::Hard, &[]).unwrap();
        begin(&experiment).loaded_flow().cloned().unwrap()
    });
    assert_ne!(own, default);
    let constants = Langevin { kolmogorov_constant: 7.0, ..Langevin::default() };
    assert_eq!(own, default.with_langevin(constants));
}

/// Compared with a gas that is not damped, particles lower the logarithm of ε in a short step 1.2 times as much as
/// that of k (turbulent kinetic energy k, dissipation rate ε). Slip increases the damping.
#[test]
fn dissipation_is_damped_faster_than_turbulence() {
    let alone = flow(TurbulenceModel::WallFunctions);
    let middle = |modulation: Modulation, slip: f64| {
        let coupling = Coupling { slices: 7, held: HeldFlow::FlowRate, modulation };
        let mut loaded = LoadedFlow::new(coupling, &alone, 1.2, 1.0);
        let volume = loaded.box_volume() / 7.0;
        let (exchange, duration) = (20.0 * 1.2 * volume, 1e-5);
        let (impulse, mass) = (slip * exchange * duration, 0.05 * exchange);
        let sums = SliceSums { impulse, mass, exchange, ..SliceSums::default() };
        loaded.advance(duration, &[sums; 7]);
        let node = *loaded.flow().unwrap().nodes.last().unwrap();
        [node.k.ln(), node.epsilon.ln()]
    };
    let [k, epsilon] = middle(Modulation::None, 0.0);
    let [damped_k, damped_epsilon] = middle(Modulation::Simonin, 0.0);
    assert!(damped_k < k);
    // the step changes k by 2e-4, so that the ratio of the logarithms errs by about as much
    close("ratio", (epsilon - damped_epsilon) / (k - damped_k), 1.2, 1e-3);
    // a slip shortens the eddies that particles see, and so the Stokes number and the damping grow
    let [crossing_k, _] = middle(Modulation::Simonin, 5.0);
    assert!(crossing_k < damped_k - 0.01 * (k - damped_k), "{crossing_k} {damped_k} {k}");
    // in full: 2 r St/(1 + St), St = τ/T, T = k/ε/(1/2 + 3/4 C_0)/sqrt(1 + β² s²/(2k/3)), C_0 = 2.1 and β² = 0.45
    let node = alone.nodes.last().unwrap();
    let crossing = (1.0 + 0.45 * 25.0 / (2.0 / 3.0 * node.k)).sqrt();
    let stokes = 0.05 / (node.k / node.epsilon / (0.5 + 0.75 * 2.1) / crossing);
    let wanted = 2.0 * 20.0 * stokes / (1.0 + stokes);
    close("rate of damping", (k - crossing_k) / 1e-5, wanted, 2e-3 * wanted);
}

/// The turbulence that particles see is that of the present gas, not that of the gas before the particles changed it.
#[test]
fn particles_see_the_turbulence_of_the_present_gas() {
    let experiment = case(CHANNEL, Model::Hard, &["fluid.turbulence.langevin={}"]).unwrap();
    let seen = |simulation: &Simulation| {
        let fluid = simulation.scene().fluid.as_ref().unwrap();
        format!("{:?}", fluid.turbulence.as_ref().unwrap().statistics)
    };
    let (start, later) = (begin(&experiment), run(&experiment, 50));
    assert_ne!(seen(&start), seen(&later));
    let present = TurbulenceStatistics::of(&later.loaded_flow().unwrap().flow().unwrap()).unwrap();
    assert_eq!(seen(&later), format!("{present:?}"));
}

#[test]
fn the_gas_fills_the_channel_and_the_pipe() {
    let volume = |text: &str| {
        let experiment = case(text, Model::Hard, &["particles[0].count=20"]).unwrap();
        begin(&experiment).loaded_flow().unwrap().box_volume()
    };
    close("channel", volume(CHANNEL) / 8e-6, 1.0, 1e-9);
    let walls = CHANNEL.find("[[walls]]").unwrap()..CHANNEL.find("[contact]").unwrap();
    let cylinder = "[[walls]]\nrestitution = 1\ncylinder = { center = [\"20 mm\", \"20 mm\", \"0 m\"], axis = \"z\", radius = \"20 mm\", inside = true }\n";
    let mut pipe = CHANNEL.to_owned();
    pipe.replace_range(walls, cylinder);
    let pipe = pipe
        .replace("[\"10 mm\", \"40 mm\", \"20 mm\"]", "[\"40 mm\", \"40 mm\", \"20 mm\"]")
        .replace("periodic = [\"x\", \"z\"]", "periodic = [\"z\"]")
        .replace("k_epsilon_channel]", "k_epsilon_pipe]\ndiameter = \"40 mm\"");
    close("pipe", volume(&pipe) / (std::f64::consts::PI * 0.02_f64.powi(2) * 0.02), 1.0, 1e-9);
}

/// `fluid --after` draws the gas of a finished run beside the gas alone. It refuses the run of another gas, and a
/// folder without a table of the gas.
#[test]
fn the_gas_is_drawn_before_and_after() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (file, done) = (path("case.toml"), path("run"));
    std::fs::write(&file, CHANNEL.replace("duration = \"0.5 s\"", "duration = \"0.05 s\"")).unwrap();
    let output = diptych(&["run", &file, "--out", &done]).output().unwrap();
    assert!(output.status.success(), "{}", words(&output.stderr));
    let fluid = |name: &str, more: &[&str]| {
        let out = path(name);
        let output = diptych(&[&["fluid", &file, "--out", &out][..], more].concat()).output().unwrap();
        (output.status.code(), words(&output.stdout) + &words(&output.stderr), std::path::PathBuf::from(out))
    };
    let (code, said, out) = fluid("after", &["--after", &done]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("among the particles the gas in the middle has"), "{said}");
    let figure = std::fs::read_to_string(out.join("figures/gas.svg")).unwrap();
    assert!(figure.contains("gas alone"), "the figure shows the gas alone");
    let (code, _, out) = fluid("before", &[]);
    assert!(code == Some(0) && !out.join("figures/gas.svg").exists());
    let other = "fluid.profile.k_epsilon_channel.reynolds_number=40000";
    for (more, wanted) in [
        (&["--after", &done, "--set", other][..], "is not the gas of this case"),
        (&["--after", folder.path().to_str().unwrap()], "a frozen gas is the same before and after"),
    ] {
        let (code, said, _) = fluid("refused", more);
        assert!(code == Some(2) && said.contains(wanted), "{code:?} {said}");
    }
    std::fs::write(folder.path().join("gas.csv"), "variant,y_m\nhard,zero\n").unwrap();
    let (code, said, _) = fluid("refused", &["--after", folder.path().to_str().unwrap()]);
    assert!(code == Some(2) && said.contains("is no table of the gas"), "{code:?} {said}");
}

#[test]
fn a_gas_that_cannot_feel_particles_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("case.toml");
    let say = |text: &str| {
        std::fs::write(&file, text).unwrap();
        let output = diptych(&["check", file.to_str().unwrap()]).output().unwrap();
        (output.status.code(), words(&output.stdout) + &words(&output.stderr))
    };
    let uniform = CHANNEL
        .replace("[fluid.profile.k_epsilon_channel]\nreynolds_number = 42000", "[fluid.profile.uniform]\nvelocity = 3");
    let across = CHANNEL.replace("\"-9.81 m/s^2\"]", "\"0 m/s^2\"]").replacen(
        "\"0 m/s^2\", \"0 m/s^2\"",
        "\"0 m/s^2\", \"-9.81 m/s^2\"",
        1,
    );
    for (text, wanted) in [
        (uniform, "needs a gas flow that is computed"),
        (CHANNEL.replace("[drag.schiller_naumann]\n", ""), "needs drag"),
        (across, "needs gravity along z or none"),
        (CHANNEL.replace("slices = 10", "slices = 0"), "1 ..= 1000"),
    ] {
        let (code, message) = say(&text);
        assert!(code == Some(2) && message.contains(wanted) && message.contains("case.toml"), "{code:?} {message}");
    }
    let long = CHANNEL.replace("seed = 3", "window = \"10 ms\"");
    let (code, message) = say(&long);
    assert!(code == Some(0) && message.contains("a tenth of the slip"), "{code:?} {message}");
}
