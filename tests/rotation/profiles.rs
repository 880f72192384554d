//! Averages of spins in slices: in files if spheres rotate, and in verdicts.

use crate::support::{diptych, words};
use serde_json::Value;

/// Runs a command on the channel with rough walls, in a sixteenth of its box. Returns the summary and `profiles.csv`.
fn channel(command: &str, arguments: &[&str]) -> (Value, String) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let case = [command, "cases/rotation/rough-walls.toml", "--set=domain.size[0]=7.5 mm", "--set=statistics.slices=5"];
    let times = ["--set=run.duration=3 s", "--set=run.average_from=0.5 s", "--out", out.to_str().unwrap()];
    let output = diptych(&[&case, arguments, &times].concat()).output().unwrap();
    let read =
        |name: &str| std::fs::read_to_string(out.join(name)).unwrap_or_else(|_| panic!("{}", words(&output.stderr)));
    assert_eq!(read("report.html").contains("Mean spins"), !arguments.contains(&"--set=contact.rotation=false"));
    (serde_json::from_str(&read("summary.json")).unwrap(), read("profiles.csv"))
}

/// Values of a column of `profiles.csv`; `None` if this column does not exist.
fn column(table: &str, name: &str) -> Option<Vec<f64>> {
    let mut lines = table.lines();
    let place = lines.next()?.split(',').position(|head| head == name)?;
    Some(lines.map(|line| line.split(',').nth(place).unwrap().parse().unwrap()).collect())
}

#[test]
fn profiles_have_spins_only_where_spheres_rotate() {
    let rule = "--set=hard.friction.walton.tangential_restitution=0.44";
    let (_, rough) = channel("run", &[rule, "--model=hard"]);
    let spin = column(&rough, "mean_spin_x").unwrap();
    // the two walls turn spheres about opposite axes
    assert!(spin[0] * spin[4] < 0.0 && spin[0].abs() > 3.0 * spin[2].abs(), "{spin:?}");
    let all = column(&rough, "rotational_temperature").unwrap();
    let parts = ["Rxx", "Ryy", "Rzz"].map(|name| column(&rough, name).unwrap());
    for (slice, whole) in all.iter().enumerate() {
        let mean = parts.iter().map(|part| part[slice]).sum::<f64>() / 3.0;
        assert!(*whole > 0.0 && (mean / whole - 1.0).abs() < 1e-9, "{mean} {whole}");
    }
    assert!(column(&rough, "rotational_temperature_se").unwrap().iter().all(|error| *error > 0.0));
    let (_, smooth) = channel("run", &[rule, "--model=hard", "--set=contact.rotation=false"]);
    assert!(column(&smooth, "www").is_some() && column(&smooth, "mean_spin_x").is_none(), "{smooth}");
}
