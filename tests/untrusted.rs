//! Texts, files and links that others have written must not affect the terminal, the page, a spreadsheet, or files of
//! the user.

use crate::support::{diptych, words};
use diptych::legible;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::path::Path;

const BASE: &str = include_str!("inputs/good/base.toml");

/// Characters that may affect a terminal or a browser, or deceive readers of names.
const ACTING: [char; 12] = [
    '\u{1b}',
    '\u{7}',
    '\u{8}',
    '\r',
    '\u{7f}',
    '\u{9b}',
    '\u{202e}',
    '\u{2066}',
    '\u{200b}',
    '\u{feff}',
    '\u{2028}',
    '\u{e0041}',
];

/// True if the only control characters of a text are line ends and tabs.
fn is_legible(text: &str) -> bool {
    !text.contains(|c: char| legible::acts(c) && !matches!(c, '\n' | '\t'))
}

/// Exit code of the program, and its output on both streams.
fn said(arguments: &[&str], place: &Path) -> (i32, String, String) {
    let output = diptych(arguments).current_dir(place).output().unwrap();
    let (out, err) = (words(&output.stdout), words(&output.stderr));
    assert!(!err.contains("panicked"), "{arguments:?}: {err}");
    (output.status.code().unwrap_or(-1), out, err)
}

fn write(place: &Path, name: &str, text: impl AsRef<[u8]>) {
    std::fs::write(place.join(name), text).unwrap();
}

#[test]
fn escapes_reach_neither_the_terminal_nor_the_page() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    write(place, "key.toml", format!("{BASE}\n\"k\\u001b[31mRED\\nerror: forged\" = 1\n"));
    write(place, "use.toml", format!("{BASE}\nuse = \"a\\u001b[31m\\u202e\"\n"));
    write(place, "head.csv", "x,y,z,\u{1b}[31mRED\n");
    write(place, "head.toml", BASE.replace("count = 100", "file = \"head.csv\""));
    for arguments in [
        &["check", "key.toml"][..],
        &["check", "use.toml"],
        &["check", "head.toml"],
        &["check", "quick", "--set", "\u{1b}[31m=1"],
        &["check", "quick", "--set", "run.\u{1b}[31m\u{9b}x=1"],
        &["check", "quick", "--set", "run.model=\"\u{202e}tfos\""],
        &["check", "\u{1b}[31m.toml"],
        &["run", "quick", "--model", "\u{1b}[31m"],
        &["check", "key.toml", "--json"],
    ] {
        let (code, out, err) = said(arguments, place);
        assert_eq!(code, 2, "{arguments:?}: {err}");
        assert!(is_legible(&out) && is_legible(&err), "{arguments:?}: {out:?} {err:?}");
        assert!(!err.contains("\nerror: forged"), "{err}");
        assert!(err.contains("\\u{") || arguments[0] == "run", "{arguments:?}: {err:?}");
    }
    let name = "name = \"\\u001b[31mRED\\u202e<b>\"\nmodel = \"hard\"\n";
    write(place, "name.toml", format!("{BASE}\n[[compare]]\n{name}[[compare]]\nmodel = \"hard\"\n"));
    let (code, out, err) = said(&["compare", "name.toml", "--out", "o", "--set", "run.duration=1 ms"], place);
    assert_eq!(code, 0, "{err}");
    let page = std::fs::read_to_string(place.join("o/report.html")).unwrap();
    assert!(is_legible(&out) && is_legible(&err) && is_legible(&page));
    assert!(page.contains("\\u{1b}[31mRED\\u{202e}&lt;b&gt;"));
    for figure in std::fs::read_dir(place.join("o/figures")).unwrap() {
        assert!(is_legible(&std::fs::read_to_string(figure.unwrap().path()).unwrap()));
    }
}

#[test]
fn random_names_and_paths_are_legible_and_do_not_panic() {
    let place = tempfile::tempdir().unwrap();
    let mut draw = Xoshiro256PlusPlus::seed_from_u64(20);
    let letters: Vec<char> = "ab./\\'\"[]=#-+@ ~*é".chars().chain(ACTING).collect();
    let mut text = |most: usize| -> String {
        let length = draw.random_range(1..=most);
        (0..length).map(|_| letters[draw.random_range(0..letters.len())]).collect()
    };
    for number in 0..1000 {
        let (key, name, file) = (text(12), text(12), text(12));
        let typed = |text: &str| toml::Value::String(text.into()).to_string();
        let case = BASE.replace("count = 100", &format!("file = {}", typed(&file)));
        let case = case.replace("name = \"glass\"", &format!("name = {}", typed(&name)));
        // half of the cases are refused because of the key, the others because of the file
        let case = if number % 2 == 0 { case + &format!("\n{} = 1\n", typed(&key)) } else { case };
        let sets = [format!("{key}={name}"), format!("run.seed={key}")];
        for sets in [&sets[..0], &sets[..1], &sets[1..]] {
            let read = diptych::case::Case::from_text(&place.path().join("case.toml"), case.as_str().into(), sets);
            let told = read.and_then(|case| diptych::study::check_text(&case)).map_err(|error| error.to_string());
            let told = told.unwrap_or_else(|error| error);
            assert!(is_legible(&told), "{number}: {told:?}");
        }
    }
}

#[test]
fn a_spreadsheet_computes_no_name_and_states_read_back() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    let named = |name: &str| BASE.replace("name = \"glass\"", &format!("name = {name:?}"));
    for name in ["=1+1", "@sum", "-coarse", "'=x", "+1", "-5"] {
        write(place, "case.toml", named(name));
        let (code, _, err) = said(
            &["run", "case.toml", "--save-state", "--overwrite", "--out", "o", "--set", "run.duration=0 s"],
            place,
        );
        assert_eq!(code, 0, "{err}");
        let state = std::fs::read_to_string(place.join("o/state.csv")).unwrap();
        let number = name.parse::<f64>().is_ok();
        let cell = format!(",{}{name}\n", if number { "" } else { "'" });
        assert!(state.contains(&cell), "{name}: {}", state.lines().last().unwrap());
        std::fs::copy(place.join("o/state.csv"), place.join("state.csv")).unwrap();
        write(place, "again.toml", named(name).replace("count = 100", "file = \"state.csv\""));
        let (code, _, err) = said(&["check", "again.toml"], place);
        assert_eq!(code, 0, "{name}: {err}");
    }
    let variant = "[[compare]]\nname = \"=cmd|' /C calc'!A0\"\nmodel = \"hard\"\n";
    write(place, "case.toml", format!("{BASE}\n{variant}[[compare]]\nmodel = \"hard\"\n"));
    let (code, _, err) =
        said(&["compare", "case.toml", "--overwrite", "--out", "o", "--set", "run.duration=1 ms"], place);
    assert_eq!(code, 0, "{err}");
    let profiles = std::fs::read_to_string(place.join("o/profiles.csv")).unwrap();
    assert!(profiles.lines().any(|line| line.starts_with("'=cmd")) && !profiles.contains("\n=cmd"));
}

#[test]
fn long_cells_and_keys_are_quoted_in_part() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    let long = "x".repeat(100_000);
    write(place, "cell.csv", format!("x,y,z\n1e-3,{long},1e-3\n"));
    write(place, "head.csv", format!("x,y,{long}\n"));
    write(place, "cell.xyz", format!("1\nProperties=pos:R:3 units=\"m s\"\n1e-3 {long} 1e-3\n"));
    for file in ["cell.csv", "head.csv", "cell.xyz"] {
        write(place, "case.toml", BASE.replace("count = 100", &format!("file = {file:?}")));
        let (code, _, err) = said(&["check", "case.toml"], place);
        assert!(code == 2 && err.len() < 2000 && !err.contains(&long[..201]), "{file}: {} characters", err.len());
    }
    write(place, "case.toml", format!("{BASE}\n{long} = 1\n"));
    for arguments in [&["check", "case.toml"][..], &["check", "quick", "--set", &format!("run.{long}=1")]] {
        let (code, _, err) = said(arguments, place);
        assert!(code == 2 && err.len() < 5000, "{} characters", err.len());
    }
}

#[cfg(unix)]
#[test]
fn links_do_not_lead_out_of_the_folder_and_pipes_do_not_hang() {
    use std::os::unix::fs::symlink;
    let place = tempfile::tempdir().unwrap();
    let (outer, inner) = (place.path(), place.path().join("case"));
    std::fs::create_dir_all(inner.join("models/walls")).unwrap();
    write(outer, "secret.csv", "top secret\n");
    write(outer, "secret.toml", "top secret\n");
    write(outer, "secret.stl", "solid top secret\n");
    let table = "x,y,z\n1e-3,1e-3,1e-3\n";
    write(&inner, "own.csv", table);
    symlink("../secret.csv", inner.join("link.csv")).unwrap();
    symlink("own.csv", inner.join("inner.csv")).unwrap();
    symlink("../secret.stl", inner.join("link.stl")).unwrap();
    symlink("..", inner.join("folder")).unwrap();
    symlink("../../../secret.toml", inner.join("models/walls/link.toml")).unwrap();
    let case = |file: &str| BASE.replace("count = 100", &format!("file = {file:?}"));
    let mesh = "[[walls]]\nrestitution = 0.9\nmesh = { file = \"link.stl\", unit = \"1 mm\" }\n";
    for (text, part) in [
        (case("link.csv"), "is a link to what is not in the folder of the case or below"),
        (case("folder/secret.csv"), "is a link to what is not in the folder of the case or below"),
        (case("../secret.csv"), "is not in the folder of the case or below"),
        (format!("{BASE}\n{mesh}"), "is a link to what is not in the folder of the case or below"),
        (format!("{BASE}\n[[walls]]\nuse = \"walls/link\"\n"), "is a link that leads out of the folder of `models/`"),
    ] {
        write(&inner, "case.toml", text);
        for folder in [&inner, outer] {
            let path = inner.join("case.toml");
            let (code, out, err) = said(&["check", path.to_str().unwrap()], folder);
            assert_eq!(code, 2, "{err}");
            assert!(err.contains(part) && !(out + &err).contains("top secret"), "{err}");
        }
    }
    write(&inner, "case.toml", case("inner.csv"));
    assert_eq!(said(&["check", "case.toml"], &inner).0, 0);
    // a path that the user typed is accepted
    write(outer, "table.csv", table);
    let own = said(&["check", "case/case.toml", "--set", "particles[0].file=table.csv"], outer);
    assert_eq!(own.0, 0, "{}", own.2);
    assert!(std::process::Command::new("mkfifo").arg(inner.join("pipe.csv")).status().unwrap().success());
    write(&inner, "case.toml", case("pipe.csv"));
    for arguments in [["check", "case.toml"], ["check", "pipe.csv"]] {
        let (code, _, err) = said(&arguments, &inner);
        assert!(code == 2 && err.contains("a pipe or a device"), "{err}");
    }
}

#[test]
fn keys_without_end_are_refused() {
    let place = tempfile::tempdir().unwrap();
    let deep = vec!["a"; 20_000].join(".");
    for key in [deep.clone(), format!("a{}", "[0]".repeat(20_000)), format!("run.{deep}")] {
        let (code, _, err) = said(&["check", "quick", "--set", &format!("{key}=1")], place.path());
        assert!(code == 2 && err.contains("more than 64 parts"), "{code}: {err:.300}");
    }
    let variant = format!("{BASE}\n[[compare]]\nmodel = \"hard\"\nset = {{ \"{deep}\" = 1 }}\n");
    for text in [variant, format!("{deep} = 1\n{BASE}"), format!("{BASE}\nx = {}1\n", "[".repeat(20_000))] {
        write(place.path(), "case.toml", text);
        let (code, _, err) = said(&["check", "case.toml"], place.path());
        assert!(code == 2, "{code}: {err:.300}");
    }
}

/// The memory of the process is limited, as by `ulimit -v`. 600 MB are sufficient for the program, but not for the
/// requested run.
#[cfg(target_os = "linux")]
#[test]
fn memory_that_is_not_there_is_refused_before() {
    let place = tempfile::tempdir().unwrap();
    let program = env!("CARGO_BIN_EXE_diptych");
    let mut many = String::new();
    for kind in 0..10_000 {
        many +=
            &format!("[[particles]]\nname = \"{kind}\"\ndiameter = \"1 um\"\ndensity = \"1000 kg/m^3\"\ncount = 1\n");
    }
    write(place.path(), "kinds.toml", format!("{BASE}\n{many}"));
    let few = "--set particles[0].count=2000000 --set particles[0].diameter='\"20 um\"'";
    for (arguments, part) in [
        (format!("run quick --model hard {few} --out o --threads 1"), "2000000 particles"),
        (format!("compare quick {few} --out o --threads 1"), "2000000 particles"),
        ("run quick --model hard --set statistics.slices=100000 --out o --threads 1".to_owned(), "100000 slices"),
        ("run kinds.toml --out o --threads 1".to_owned(), "allowed: up to 1000 kinds"),
        ("check kinds.toml".to_owned(), "allowed: up to 1000 kinds"),
    ] {
        let script = format!("ulimit -v 600000; exec {program} {arguments}");
        let output = std::process::Command::new("sh").args(["-c", &script]).current_dir(place.path()).output().unwrap();
        let told = words(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {told}");
        assert!(told.contains(part) && !place.path().join("o").exists(), "{arguments}: {told}");
    }
    let script = format!("ulimit -v 600000; exec {program} check quick {few}");
    let output = std::process::Command::new("sh").args(["-c", &script]).current_dir(place.path()).output().unwrap();
    let told = words(&output.stdout);
    assert!(output.status.success() && told.contains("2000000 particles"), "{told} {}", words(&output.stderr));
}
