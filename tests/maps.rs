//! The maps of `diptych limits` compared with theory: boundaries within one cell, numbers within their errors.

use diptych::output::limits::{Map, MapPoint};
use diptych::study::limits::{Grid, map, names};
use std::collections::HashMap;
use std::path::Path;
use std::process::Command;
use std::sync::{Mutex, OnceLock, PoisonError};

const QUICK: Grid = Grid { quick: true, quiet: true };

/// Runs the map with a given name.
fn run(name: &str) -> Map {
    map(name, &QUICK).expect("a map of that name").expect("scenes that can be made")
}

/// Map with a given name. The first test that needs a map runs it; later tests use the same result.
fn of(name: &'static str) -> &'static Map {
    static KEPT: Mutex<Option<HashMap<&str, &'static OnceLock<Map>>>> = Mutex::new(None);
    // the lock of the table is held only while the place of the map is found, so that different maps run at the same
    // time
    let place = {
        let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
        *kept.get_or_insert_default().entry(name).or_insert_with(|| Box::leak(Box::default()))
    };
    place.get_or_init(|| run(name))
}

/// Index of the column with a given name.
fn column(map: &Map, name: &str) -> usize {
    map.columns.iter().position(|column| *column == name).expect("a column of that name")
}

/// Method `at`: the number of a row in a column. The number must be known.
trait At {
    fn at(&self, column: usize) -> f64;
}

impl At for MapPoint {
    fn at(&self, column: usize) -> f64 {
        self.values[column].expect("a number that is known")
    }
}

fn row<'m>(map: &'m Map, column: &str, value: f64) -> &'m MapPoint {
    let k = self::column(map, column);
    map.rows.iter().find(|row| row.at(k) == value).expect("a row of that value")
}

/// Damping ratio ζ of a linear contact with the restitution `e`.
fn damping(e: f64) -> f64 {
    -e.ln() / (std::f64::consts::PI.powi(2) + e.ln().powi(2)).sqrt()
}

/// Stability limit of Heun's method for a contact with the restitution `e`: the time step times the undamped angular
/// frequency, x, at which |1 + λx + (λx)²/2| exceeds 1. Here λ = -ζ + i sqrt(1-ζ²) with the damping ratio ζ. The limit
/// is 0 without damping.
fn limit_of_heun(e: f64) -> f64 {
    let (a, b) = (-damping(e), (1.0 - damping(e).powi(2)).sqrt());
    let radius = |x: f64| {
        let (re, im) = (1.0 + a * x + 0.5 * (a * a - b * b) * x * x, b * x + a * b * x * x);
        re * re + im * im
    };
    (1..3000).map(|k| f64::from(k) * 1e-3).take_while(|x| radius(*x) <= 1.0).last().unwrap_or(0.0)
}

#[test]
fn stability_ends_where_the_amplification_factors_say() {
    let verlet = |e: f64| 2.0 * ((1.0 + damping(e).powi(2)).sqrt() - damping(e));
    // limits from the amplification factors, computed independently to three digits
    for (e, of_verlet, of_heun) in [(1.0, 2.0, 0.0), (0.94, 1.961, 0.566), (0.5, 1.615, 1.437), (0.1, 1.141, 2.104)] {
        assert!((verlet(e) - of_verlet).abs() < 1e-3 && (limit_of_heun(e) - of_heun).abs() < 2e-3, "e = {e}");
    }
    for (name, limit) in [("stability-verlet", verlet as fn(f64) -> f64), ("stability-heun", limit_of_heun)] {
        let map = of(name);
        // the tolerance is one cell of the quick grid
        let cell = map.rows[1].at(0) - map.rows[0].at(0);
        assert!((cell - 0.2).abs() < 1e-12);
        for row in &map.rows {
            let (x, e) = (row.at(0), row.at(1));
            let grows = row.failure.is_some() || row.at(2) > 2.0;
            assert!(!grows || x > limit(e) - cell, "{name}: e = {e} grows at {x}, limit {}", limit(e));
            assert!(grows || x < limit(e) + cell, "{name}: e = {e} is stable at {x}, limit {}", limit(e));
        }
    }
}

#[test]
fn restitution_is_that_of_the_linear_map() {
    // mean, smallest and largest over 200 phases, computed independently; the tolerance is 0.002 for N_c >= 10, else
    // 0.01
    for (name, e, steps, mean, tolerance) in [
        ("restitution-heun", 1.0, 7.735, 1.0229, 0.002),
        ("restitution-heun", 1.0, 10.0, 1.01089, 0.002),
        ("restitution-heun", 0.94, 10.0, 0.94857, 0.002),
        ("restitution-heun", 1.0, 5.0, 1.0776, 0.01),
        ("restitution-verlet", 1.0, 10.0, 1.0, 0.002),
        ("restitution-verlet", 0.5, 10.0, 0.4909, 0.002),
        ("restitution-verlet", 0.1, 10.0, 0.0596, 0.01),
    ] {
        let map = of(name);
        let row = map.rows.iter().find(|row| row.at(0) == steps && row.at(1) == e).expect("a row");
        assert!((row.at(2) - mean).abs() < tolerance, "{name}, e = {e}, N_c = {steps}: {:?}", row.values);
        assert!((row.at(2) - row.at(5)).abs() < tolerance, "{name}: {:?}", row.values);
    }
}

#[test]
fn an_elastic_gas_heats_by_as_much_as_the_linear_map_says() {
    let map = of("heating");
    let at = row(map, "steps_per_contact", 7.735);
    println!("{:?}", at.values);
    assert!((at.at(1) / 0.015 - 1.0).abs() < 0.1, "+1.5 % of T per collision suffered: {:?}", at.values);
    for row in &map.rows {
        // three standard errors over three seeds, plus an allowance for oblique impacts, in which the gain is 1 % lower
        let tolerance = 3.0 * row.at(2) + 0.03 * row.at(3);
        assert!((row.at(1) - row.at(3)).abs() < tolerance, "{:?}", row.values);
    }
}

#[test]
fn overlaps_are_those_of_the_closed_form() {
    let map = of("tunnelling-pair");
    for row in &map.rows {
        let (overlap, predicted) = (row.at(2), row.at(3));
        assert_eq!(row.failure.is_some(), predicted > 0.5, "{row:?}");
        // at 20 steps, the overlap at the ends of steps is smaller than the maximum by up to (π/40)²/2
        assert!(row.failure.is_some() || (overlap / predicted - 1.0).abs() < 0.01, "{row:?}");
    }
    // a sphere passes the plate undetected only if its centre moves in one step from outside to beyond the middle
    let map = of("tunnelling-plate");
    for row in &map.rows {
        let per_step = row.at(0) * std::f64::consts::PI / row.at(1);
        let seen = per_step < 0.55;
        assert!(!seen || row.at(3) == 0.0, "{row:?}");
        assert!(row.at(0) < 0.5 || row.at(2) + row.at(3) > 0.0 || row.at(1) < 3.0, "{row:?}");
    }
}

#[test]
fn soft_spheres_touch_less_often_as_they_crowd_less() {
    let map = of("softness");
    for row in &map.rows {
        // three standard errors, plus an allowance for collisions with other particles while contacts last a tenth of
        // the time
        let tolerance = 3.0 * row.at(2) + 0.005;
        assert!((row.at(1) - row.at(3)).abs() < tolerance, "{:?}", row.values);
    }
    let softest = &map.rows[map.rows.len() - 1];
    assert!(softest.at(1) < 1.0 - 10.0 * softest.at(2) / 3.0, "the effect is seen: {softest:?}");
}

/// Map of the decay of anisotropy (unequal velocity variances), which soft spheres reduce more slowly than hard ones.
/// The quick grid has one stiffness, κ_n = 0.05, for which the collision integral gives 13.6 %.
#[test]
fn soft_spheres_even_out_more_slowly_as_their_collision_integral_says() {
    let map = of("anisotropy");
    for row in &map.rows {
        // three standard errors, plus an allowance for the neighbours of a lasting contact, a fraction φ of the
        // particles
        assert!((row.at(2) - row.at(4)).abs() < 3.0 * row.at(3) + 0.01, "{row:?}");
    }
    let softest = &map.rows[map.rows.len() - 1];
    assert!(softest.at(2) < 1.0 - 10.0 * softest.at(3) / 3.0, "the effect is seen: {softest:?}");
}

#[test]
fn lines_collapse_below_the_thresholds() {
    // thresholds: 7 - 4 sqrt 3 for three spheres on a line, 3 - 2 sqrt 2 for two spheres at a wall
    for (name, count, threshold) in [("collapse-line", 3.0, 0.0717967697), ("collapse-wall", 2.0, 0.1715729)] {
        let map = of(name);
        let of_count: Vec<&MapPoint> = map.rows.iter().filter(|row| row.at(0) == count).collect();
        let cell = of_count[1].at(1) - of_count[0].at(1);
        assert!((cell - 0.04).abs() < 1e-12);
        for row in &of_count {
            let (e, share) = (row.at(1), row.at(2));
            assert!(share == 1.0 || e > threshold - cell, "{name}: e = {e}, {share}");
            assert!(share == 0.0 || e < threshold + cell, "{name}: e = {e}, {share}");
        }
        // more spheres collapse at least as easily, and every collapse is reported as a failure
        for row in &map.rows {
            assert!(row.at(2) == 0.0 || row.failure.is_some());
            assert!(row.at(2) == 0.0 || row.at(1) < row.at(3) + 0.05, "{row:?}");
        }
    }
}

#[test]
fn a_bed_at_rest_diverges_without_a_contact_time() {
    let map = of("rest");
    let time = column(map, "contact_time_s");
    let failed: Vec<&MapPoint> = map.rows.iter().filter(|row| row.failure.is_some()).collect();
    assert_eq!(failed.len(), 1);
    assert_eq!(failed[0].values[time], None);
    let last = |t: Option<f64>| map.rows.iter().rfind(|row| row.values[time] == t).expect("a row").at(2);
    // about one collision per sphere and contact time
    for t in [1e-3, 1e-4] {
        assert!((0.1..5.0).contains(&(last(Some(t)) * t)), "{t}: {}", last(Some(t)));
    }
    assert!(last(None) > last(Some(1e-3)));
}

#[test]
fn stepped_spheres_miss_more_the_longer_the_step() {
    let map = of("stepped-missed");
    let missed: Vec<f64> = map.rows.iter().map(|row| row.at(1)).collect();
    assert!(missed.windows(2).all(|pair| pair[1] > pair[0]), "{missed:?}");
    assert!(missed[0] < 0.05 && missed[missed.len() - 1] > 0.1, "{missed:?}");
    let map = of("stepped-overlap");
    for row in &map.rows {
        // the estimate for head-on impacts at the full rate is an upper limit; it is approached for short steps
        assert!(row.at(1) < row.at(4), "{row:?}");
    }
    let first = &map.rows[0];
    assert!(first.at(1) > 0.7 * first.at(4), "{first:?}");
}

#[test]
fn cradles_differ_as_they_should() {
    // exact solutions for springs; for hard spheres ((1+e)/2)^(n-1)
    let map = of("cradle");
    for (n, e, soft) in
        [(3.0, 1.0, 0.98003213), (3.0, 0.94, 0.93606343), (5.0, 1.0, 0.94240173), (5.0, 0.94, 0.8805742)]
    {
        let row = map.rows.iter().find(|row| row.at(0) == n && row.at(1) == e).expect("a row");
        assert!((row.at(2) - soft).abs() < 1e-3, "{row:?}");
        let first_blow = (0.5 + 0.5 * e).powi(n as i32 - 1);
        assert!(
            (row.at(3) - first_blow).abs() < 1e-9 || (n == 5.0 && (row.at(3) - 0.88529281).abs() < 1e-8),
            "{row:?}"
        );
    }
    let map = of("simultaneous");
    for row in &map.rows {
        assert!((row.at(2).abs() - 0.002375).abs() < 1e-9, "{row:?}");
        let (late, soft) = (row.at(0), row.at(1));
        assert!(late.abs() < 1.3 || (soft - row.at(2)).abs() < 1e-3, "apart, both agree: {row:?}");
    }
    let together = row(map, "late", 0.0);
    assert!(together.at(1).abs() < 1e-6, "from both sides at once: {together:?}");
}

#[test]
fn the_splitting_is_of_second_order() {
    let map = of("splitting");
    let (a, b) = (&map.rows[1], &map.rows[3]);
    for column in [1, 2] {
        let order = (a.at(column) / b.at(column)).ln() / (a.at(0) / b.at(0)).ln();
        assert!((order - 2.0).abs() < 0.05, "{order}");
    }
}

#[test]
fn maps_do_not_depend_on_the_threads() {
    for name in ["collapse-line", "tunnelling-pair", "collapse-gas"] {
        let once = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            format!("{:?}", pool.install(|| run(name)).rows)
        };
        let one = once(1);
        for threads in [2, 3] {
            assert_eq!(one, once(threads), "{name}, {threads} threads");
        }
    }
}

#[test]
fn the_command_writes_a_table_and_a_picture_per_map() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("results");
    let go = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_diptych"));
        command.current_dir(env!("CARGO_MANIFEST_DIR")).arg("limits").args(arguments).arg("--out").arg(&folder);
        command.output().unwrap()
    };
    let refused = go(&["--quick", "--only", "cradel"]);
    assert_eq!(refused.status.code(), Some(2));
    let message = String::from_utf8(refused.stderr).unwrap();
    assert!(message.contains("cradel") && names().all(|name| message.contains(name)), "{message}");
    assert!(!folder.exists());
    let done = go(&["--quick", "--quiet", "--only", "cradle", "--only", "splitting"]);
    assert_eq!(done.status.code(), Some(0), "{done:?}");
    assert!(done.stdout.is_empty() && done.stderr.is_empty(), "{done:?}");
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap_or_else(|why| panic!("{name}: {why}"));
    for map in ["cradle", "splitting"] {
        assert!(read(&format!("maps/{map}.csv")).lines().count() > 4);
        assert!(read(&format!("figures/{map}.svg")).contains("<svg"));
        let again = format!("diptych limits --only {map} --quick");
        assert!(read("report.html").contains(&again));
    }
    assert!(read("maps/cradle.csv").starts_with("spheres,restitution,last_soft_m_s,"));
    let summary: serde_json::Value = serde_json::from_str(&read("summary.json")).unwrap();
    assert_eq!(summary["maps"].as_array().unwrap().len(), 2);
    // a folder with results is overwritten only on request; then only the user's own files remain of the old ones
    let own = folder.join("maps/my-own.csv");
    std::fs::write(&own, "steps,outcome of my own\n1,2\n").unwrap();
    assert_eq!(go(&["--quick", "--quiet", "--only", "cradle"]).status.code(), Some(2));
    assert_eq!(go(&["--quick", "--quiet", "--only", "cradle", "--overwrite"]).status.code(), Some(0));
    assert!(own.exists());
    assert!(!folder.join("maps/splitting.csv").exists() && !folder.join("figures/splitting.svg").exists());
}

#[test]
fn two_maps_of_the_same_runs_run_them_once() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("results");
    let mut command = Command::new(env!("CARGO_BIN_EXE_diptych"));
    command.args(["limits", "--quick", "--only", "stepped-missed", "--only", "stepped-overlap", "--out"]).arg(&folder);
    let done = command.output().unwrap();
    let told = String::from_utf8(done.stderr).unwrap();
    assert_eq!((done.status.code(), told.matches(" points in ").count()), (Some(0), 1), "{told}");
    for map in ["stepped-missed", "stepped-overlap"] {
        assert!(folder.join(format!("maps/{map}.csv")).exists(), "{map}");
    }
}

#[test]
fn every_map_has_a_case_that_runs() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/limits");
    for name in names() {
        let case = diptych::case::Case::read(&folder.join(format!("{name}.toml")), &[]);
        let checked = case.and_then(|case| case.experiment(None, None));
        assert!(checked.is_ok(), "{name}: {}", checked.err().map(|e| e.to_string()).unwrap_or_default());
    }
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), names().count());
    assert_eq!(of("cradle").case, std::fs::read_to_string(folder.join("cradle.toml")).unwrap());
}

/// The restitution in runs of an engine with Hertz's law is that of the integrator for a single contact, for any
/// number of steps.
#[test]
fn hertzian_restitution_is_that_of_the_method() {
    let map = of("restitution-hertz");
    let (mean, predicted) = (column(map, "mean"), column(map, "predicted"));
    for row in &map.rows {
        // the runs have 20 phases, the prediction 200: the tolerance is a quarter of the spread over phases
        let spread = row.at(column(map, "largest")) - row.at(column(map, "least"));
        let apart = (row.at(mean) - row.at(predicted)).abs();
        assert!(apart < 0.25 * spread + 1e-6, "{:?}", row.values);
    }
}

/// Largest error of Walton's rule over all slips, in per cent of the largest friction impulse, at the normal
/// restitution 0.9. The values were computed independently with 40,000 steps of the linear oscillator.
#[test]
fn walton_is_a_spring_with_equal_half_periods_and_none_without_dashpot() {
    let reference = [
        ("walton-spring", [(0.2, 3.797), (0.44, 2.456), (0.7, 0.972), (0.9, 0.107)]),
        ("walton-undamped", [(0.2, 26.874), (0.44, 24.304), (0.7, 20.221), (0.9, 14.465)]),
    ];
    for (name, largest) in reference {
        let map = of(name);
        let [slip, beta, error] = ["reduced_slip", "tangential_restitution", "error"].map(|name| column(map, name));
        for (restitution, wanted) in largest {
            let rows = || map.rows.iter().filter(|row| row.at(beta) == restitution);
            let errors = || rows().map(|row| (row.at(slip), 100.0 * row.at(error).abs()));
            let (worst, found) = errors().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            println!("{name}: beta_0 {restitution}: {found:.4} % at {worst}, {wanted} %");
            assert!((found - wanted).abs() < 0.003, "{name}, {restitution}: {found} {wanted}");
            // the slip with the largest error is that at which Walton's rule changes from sticking to sliding, unless
            // rule and spring agree
            assert!(wanted < 0.2 || worst == 1.0, "{name}, {restitution}: {worst}");
        }
    }
}
