//! Integration tests: one program with one module per topic. "Oracle A" to "oracle H" in comments are sections of a
//! catalogue of reference values that were computed independently of this library.

#![allow(clippy::type_complexity, reason = "tables of an oracle's columns are read once, where they stand")]

mod made_up;
mod support;

mod added_mass; // inertia of the gas that spheres accelerate
mod analytic; // closed-form solutions: two bodies, walls, oblique impacts (oracle A, B)
mod batches; // averages over blocks of time, and comparisons with a known answer
mod bodies; // walls other than planes along an axis
mod bouncing; // spheres dropped on a floor, and squeezed between walls (oracle C)
mod buoyancy; // buoyancy: falling spheres of MFIX and in water, mixtures of densities, ledger, threads and processes
mod calendar; // one event queue for all particles: windows, ties, long runs, streams, threads
mod cases; // every case of the project, a few windows with each engine
mod chart; // work-precision chart: one impact, orders, Pareto fronts, failures, floors
mod cli; // the program: exit codes, messages, files, output with --quiet
mod clusters; // clusters: states by hand, ideal gas, percolation of balls, messages
mod coupling; // a gas that feels the particles: alone, uniform force, momentum, pressure drop, bits, messages
mod crowd; // dense crowds: contact time, impacts during a change of stepping, a mixture in a gas
mod dense; // dense soft scenes: against all pairs, and the same bits on any number of threads
mod diameters; // species with a distribution of diameters: moments, laws of conservation, drag, messages
mod discharge; // beads that flow out of a vessel, compared with Beverloo's law
mod dissipation; // restitution below one: cooling, collapse, coming to rest, cradles, the ledger (oracle E)
mod docs; // imports between modules; documents name existing things; public numbers have units
mod domains; // one run divided into domains; no result depends on the order of the store
mod drag; // drag laws against independent integrations; order of the splitting
mod dsmc; // collisions by chance: rates, cooling, walls, conserved quantities, bits, messages
mod endless; // surfaces of triangles through periodic sides
mod everyday; // long names, folders in use or emptied, damaged files, large scenes, bad cases read by programs
mod examples; // the programs of examples/ run and are short
mod files; // files of other programs: each oddity, and each pair of oddities
mod first_answer; // README, picture, pages and stored runs agree
mod floors; // floors in predictions: slopes, chutes, buoyancy, drag, inlets
mod fluid; // gas profiles against independent solvers, tables, pipes
mod folder; // the folder of results: which command owns it, and which files are replaced in it
mod free_surface; // surface of a layer: waves by hand, columns, smoothing, up, messages
mod fuzz; // damaged and made-up inputs to every reader
mod gas; // equilibrium: equation of state, collision rates, walls, overlaps, conservation, same bits (oracle D)
mod gates; // openings in closed form: sums of what passes, ids, a gate that opens
mod groups; // variants that are compared or share a panel, and impacts that are counted
mod hand; // commands without any file: built-in cases, a first case, completions, manual pages
mod held; // spheres at rest between several walls, and by friction; spheres that pass through walls
mod hertz; // Hertzian contacts: single impacts, a gas, the case and its messages
mod hybrid; // instantaneous collisions and lasting contacts: agreement with both engines, beds, cradle, ledgers, threads
mod inputs; // case files, good and bad: refusals with their place and message
mod instants; // windows end at the requested instants
mod invariants; // results in other frames of reference, and rules for all scenes
mod islands; // islands against the classical algorithms
mod judge; // files of any program: series, output of LAMMPS, tables with errors, messages
mod keys; // the list of keys: complete, ranges as messages name them, the page up to date, numbers without units
mod kick; // the tabulated drag kick against its drag law
#[cfg(feature = "lab")]
mod lab; // the lab: token, other hosts, limits, protocol, every scene in both panels, commands that reproduce, threads
mod library; // programs that use the library: defaults, random starts, run_until, files of triangles
mod lift; // forces across the slip and torque of the gas
mod limits; // kinds of failures, the TC model, and maps of failures against theory
#[cfg(feature = "lab")]
mod live; // a run on a page: bits, frames, access, resumption; pages with recorded runs
mod maps; // the maps of `limits`, which show where each method fails, against theory
mod measurements; // measurements that a case asks for, against theories and brute force
mod meshes; // walls of triangles: seams, corners, vessels, damaged meshes
mod mixtures; // pairs of kinds, spheres of very different sizes
mod moving_bodies; // bodies and meshes that move: times of touch, vessels, rotation, no missed touch, images, ledger
mod moving_walls; // walls whose shape moves: exact map, period doubling, no missed touch, frames, ledger, bits, messages
mod needs; // models that a scene needs, against closed forms
mod numbers; // every number of the paper, and every claim with its words, in docs/paper.md
mod observed_verdicts; // verdicts on numbers measured under [observe]: the rule, its rates of wrong answers, real rows
mod observers; // measurements while a simulation runs, and their times
mod openings; // inlets and outlets: books, ids, contacts that stay, resumed runs, threads, blocked inlets, messages
mod orbit; // sheared boxes on an orbit: epicycles, work of tides, bits, refusals
mod order; // sums over particles: identical bits in any order of the store
mod output;
mod over_time; // series and paths: against theories, in tables and pictures
mod own_law; // contact laws of the calling program
mod paper; // Table 1 of the paper and its audit, recomputed (oracle H)
mod parts; // starts and runs in which each process has a part from the beginning
mod pieces; // trajectories in pieces, written by threads in place of processes
mod plan; // predictions against short runs, recommendations, the command `plan`
mod plan_contacts; // kinds of contact in a plan: walls of unequal elasticity, elastic bounces
mod player; // recordings of particles: same bits, bounded, complete in the page
mod random_scenes; // random small scenes: hard spheres are the limit of stiff soft spheres
mod restitution; // restitution by speed: every model, every soft law, gases, bits, messages
mod resume; // killed or stopped runs continue with the same bits; damaged checkpoints; full disks
mod rotation;
mod roughness; // rough walls: density of facets, energy, bits, messages
mod schedule; // windows of the schedule against shorter windows
mod schema; // the schema for editors: values that it refuses or accepts
mod seams; // drag laws and wall shapes of the calling program, with the required methods alone
mod seen_gas; // the gas that particles see: plain means of one state, the variance of the gas, its share with particles
mod sensitivity; // factors with a large effect, without effect, missing in a scene, or refused
mod servo; // walls that particles press on with a given pressure: closed forms, a pressed crowd, bits, messages
mod shapes; // walls of all kinds: closed forms, corners, the pressure of a gas on them (oracle D2)
mod shear; // sheared boxes: across a side, translation, work of shear, engines, bits, kinetic theory
mod size_and_power; // how often the verdict is wrong, on scenes of every kind and on known differences
mod sizes; // the time for large inputs is proportional to their size
mod snapshots; // state between windows, stored and restored with identical bits
mod soak; // random dense gases in every way of stepping: energy and momentum
mod starts; // starts of a case from saved states and tables
mod stress; // stress, contacts per particle, volume fraction, and the densest starts
mod structure; // structure factor, contact network and coarse-grained fields
mod suspensions; // drag in suspensions: published values, packed beds, hindered settling, local fractions, bits
mod sweep; // sweeps: killed and continued, grids and replicas, refusals, points that stop
mod terminal; // messages may be lost, results may not
mod thermostat; // heated gases: without losses, ledger, kinetic theory, drag, bits, messages
mod trajectory; // frames for other programs: bits, surfaces, failures
mod trust; // the trust sheet of a run, and the halved step
mod turbulence; // turbulence along the paths of particles: well mixed, Tchen, Hinze and Csanady, frozen limit, ledger, bits, messages
mod tutorial; // the commands of docs/tutorial.md, and its decision
mod untrusted; // texts, files and links of others: legible, within their folder, within memory limits
mod validate; // the validation suite: rows, tables, changed references, unknown names
mod verdict; // equivalent, different or unresolved: rates of wrong answers, and answers for scenes
mod verdict_scenes; // verdicts on scenes at rest, relaxing, stopped, or sampled at different times
mod vessels; // vessels smaller than the box: random starts, regions, slabs, and the cost of islands in them
mod viscosity; // shear viscosity: free flight, Enskog, Garzó and Dufty, messages
mod words; // sentences of reports and summaries must be true of the runs
