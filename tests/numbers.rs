//! The page docs/paper.md answers the whole paper: it must contain every number of the paper's text, and every claim
//! in its words.

use std::path::Path;

/// Numbers of the paper's text by section, without those in Table 1, as docs/paper.md writes them.
const NUMBERS: [(&str, &[&str]); 8] = [
    (
        "2.1",
        &["42000", "1.205", "1.515e-5", "1.5 mm", "1032", "406 µm", "1038", "1e-3", "1e-2", "200", "2500", "18 μ_f"],
    ),
    ("2.2", &["40 slices", "15 for"]),
    ("3.1", &["4/3"]),
    ("3.2", &["2 γ_n"]),
    ("3.4", &["0.3", "1/2", "8/(3π)", "100", "T_c/50", "T_c/15", "N_c > 5", "10 %", "1 %"]),
    ("4", &["e_c = 1", "μ_c = 0", "e_w = 1", "μ_w = 0", "e_w = 0.94", "μ_w = 0.325", "<α_p> = 1e-2"]),
    ("4", &["0 < λ ≤ 0.01", "k ≤ 2", "0 < λ* < 0.05"]),
    ("4", &["k_n = 300 N/m", "3000"]),
];

/// Rows of Table 1 as printed, for cases B to G: the beginning of the row in docs/paper.md, and the printed values.
const TABLE_1: [(&str, [&str; 6]); 10] = [
    ("d_p", ["406 µm", "406 µm", "406 µm", "1.5 µm", "1.5 mm", "1.5 mm"]),
    ("volume fraction", ["1.2e-3", "4e-3", "1e-2", "4.1e-3", "1.4e-2", "4.1e-2"]),
    ("N_p, from it and the box", ["10520", "35067", "87668", "712", "2433", "7127"]),
    ("k_n, N/m", ["3000", "3000", "3000", "5000", "5000", "5000"]),
    ("Δt_p, s", ["1e-6", "1e-6", "1e-6", "4e-5", "4e-5", "4e-5"]),
    ("Δt_f, s", ["1e-5", "1e-5", "1e-5", "2.5e-5", "2.5e-5", "2.5e-5"]),
    ("N_c of a pair at that step", ["10", "10", "10", "10", "10", "10"]),
    ("δ_max/d at u_r, pair", ["0.05", "0.05", "0.05", "0.03", "0.03", "0.03"]),
    ("CFL of collisions, Δt u_r/d", ["0.01", "0.3", "0.3", "0.01", "0.3", "0.3"]),
    ("u_r, m/s", ["1.05", "0.87", "0.79", "0.61", "0.56", "0.53"]),
];

/// [-] CFL number of particles, which is equal in all rows of Table 1.
const CFL_OF_PARTICLES: &str = "1.5";

/// Quotations from the paper that docs/paper.md judges, each after its section.
const WORDS: [(&str, &str); 27] = [
    ("4, Fig. 5 left", "the mean particle velocity profile is flatter than that of the fluid"),
    ("4, Fig. 5 left", "this is due to the strong influence of transverse particle dispersion"),
    ("4, Fig. 5 left", "mostly dependent on the particle diameter"),
    ("4, Fig. 5 left", "more transported by the fluid than larger particles"),
    ("4, Fig. 5 middle", "lead to an overcrowding of the particles"),
    ("4, Fig. 5 middle", "Larger particles are instead more concentrated at the near wall region"),
    ("4, Fig. 5 middle", "creating a mean force towards the wall"),
    ("4, Fig. 5", "in excellent agreement with hard-sphere model simulations"),
    ("4, Fig. 5 right", "the strong sensitivity of the system to the boundary conditions for particles"),
    ("4, Fig. 5 right", "induces dissipation at the wall"),
    ("4, Fig. 5 right", "characterized by a non-zero value of the shear stress"),
    ("4, Fig. 5 right", "by collisional redistribution, an increase in"),
    ("4, Fig. 5 right", "our results also fully agree with the simulations based on the hard-sphere model"),
    ("4, Fig. 6 left", "the maximum value of the overlap is strongly dependent on"),
    ("4, Fig. 6 middle", "the percentage of the collisions which have the high overlapping is very small"),
    ("4, Fig. 6 right", "does not depend on the stiffness coefficient value for different particle diameters"),
    ("4", "the first impact relative velocity"),
    ("4, Fig. 7", "do not affect the whole dynamics of the gas-particles flow"),
    ("4, Eq. 12", "for k ≤ 2"),
    ("4, Eq. 13", "the estimation of the mean overlapping"),
    ("4, Eq. 13", "takes values between (0, 0.05) less constraining"),
    ("2.1", "the particles are not affected by the turbulence of the fluid"),
    ("2.1", "the influence of the particles on the mean fluid flow"),
    ("3.2", "starts to collide and a collision force"),
    ("3.4", "N_c should be greater than"),
    ("1", "the hard-sphere model is better suited to dilute regimes"),
    ("5", "compared and validated quantitatively and qualitatively"),
];

/// The four possible verdicts on a claim of the paper.
const VERDICTS: [&str; 4] = ["holds", "holds in part", "does not hold", "cannot be checked"];

fn page() -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/paper.md")).unwrap()
}

/// Rows of the tables in a section of the page, as cells without bars.
fn rows(page: &str, heading: &str) -> Vec<Vec<String>> {
    let (_, part) = page.split_once(&format!("\n## {heading}\n")).unwrap_or_else(|| panic!("no section {heading}"));
    let part = part.split("\n## ").next().unwrap_or_default();
    let cells = |line: &str| line.split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<String>>();
    let row = |line: &&str| line.starts_with("| ");
    part.lines().filter(row).map(|line| cells(line.trim_matches('|'))).collect()
}

/// True if a number occurs in a text as a whole, and not as a part of a longer number.
fn stands(text: &str, number: &str) -> bool {
    let part = |c: char| c.is_ascii_digit() || c == '.' || c == '/';
    text.match_indices(number).any(|(at, _)| {
        let (before, after) = (text[..at].chars().next_back(), text[at + number.len()..].chars().next());
        let starts = number.starts_with(|c: char| c.is_ascii_digit());
        let ends = number.ends_with(|c: char| c.is_ascii_digit());
        !(starts && before.is_some_and(part) || ends && after.is_some_and(|c| c.is_ascii_digit() || c == 'e'))
    })
}

#[test]
fn numbers_stand_by_themselves() {
    assert!(stands("N_c > 5.", "N_c > 5") && !stands("N_c > 50", "N_c > 5"));
    assert!(stands("(**0.3**)", "0.3") && !stands("0.325", "0.3") && !stands("10.3", "0.3"));
}

#[test]
fn every_number_of_the_paper_is_answered() {
    let page = page();
    let rows_of = rows(&page, "Every number of the paper");
    for (section, numbers) in NUMBERS {
        let text: String = rows_of.iter().filter(|row| row[0] == section).map(|row| row[1].clone() + " ; ").collect();
        for number in numbers {
            assert!(stands(&text, number), "section {section}: {number} is not in the table of numbers");
        }
    }
    let table = rows(&page, "Table 1, recomputed");
    let row = |name: &str| table.iter().find(|row| row[0] == name).unwrap_or_else(|| panic!("no row {name}"));
    for (name, printed) in TABLE_1 {
        let row = row(name);
        for (place, printed) in printed.into_iter().enumerate() {
            assert!(stands(&row[1 + place], printed), "{name}: {printed} is not in \"{}\"", row[1 + place]);
        }
    }
    assert!(row("CFL of particles")[1..7].iter().all(|cell| stands(cell, CFL_OF_PARTICLES)));
}

#[test]
fn every_claim_quotes_the_paper_and_is_judged() {
    let page = page();
    let table = rows(&page, "The claims");
    let claims: Vec<&Vec<String>> =
        table.iter().filter(|row| row[0] != "section" && !row[0].starts_with('-')).collect();
    let mut counts = [0; VERDICTS.len()];
    for claim in &claims {
        let quote = claim[1].split('"').nth(1).unwrap_or_else(|| panic!("no quotation in {}", claim[1]));
        assert!(
            WORDS.contains(&(claim[0].as_str(), quote)),
            "section {}: \"{quote}\" is not among the words",
            claim[0]
        );
        let verdict = claim[3].split("**").nth(1).unwrap_or_else(|| panic!("no verdict on \"{quote}\""));
        let known = VERDICTS.iter().position(|known| *known == verdict);
        counts[known.unwrap_or_else(|| panic!("no such verdict: {verdict}"))] += 1;
    }
    assert_eq!(claims.len(), WORDS.len(), "every quotation once");
    let [holds, in_part, not, unknown] = counts;
    let told = format!(
        "Of {} claims {holds} hold, {in_part} hold in part, {not} do not hold, and {unknown} cannot be checked.",
        claims.len()
    );
    assert!(page.contains(&told), "the front page should say: {told}");
    let audit = rows(&page, "The audit");
    let numbered = audit.iter().filter(|row| row[0].parse::<usize>().is_ok()).count();
    assert!(page.contains(&format!("lists {numbered} statements")), "{numbered} statements are in the audit");
}
