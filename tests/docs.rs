//! Rules for documents, comments and the structure of the source.

use clap::CommandFactory;
use diptych::case::Case;
use diptych::cli::Cli;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Exceptions from the order of modules. `scene` imports fluid and walls, which use its types `Species` and `Surface`.
/// These data belong together.
const EXCEPTIONS: [(&str, &str); 2] = [("scene", "fluid"), ("scene", "walls")];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn text(path: &str) -> String {
    let path = root().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Path, relative to the crate, and text of every source file.
fn sources() -> Vec<(String, String)> {
    fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                collect(&path, found);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }
    let mut found = Vec::new();
    collect(&root().join("src"), &mut found);
    found.sort();
    let name = |path: &Path| path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/");
    found.iter().map(|path| (name(path), std::fs::read_to_string(path).unwrap())).collect()
}

/// Path of a source file within its crate: the physics, the input, or the program.
fn in_crate(path: &str) -> &str {
    let path = path.trim_start_matches("src/");
    ["physics/", "input/"].iter().find_map(|folder| path.strip_prefix(folder)).unwrap_or(path)
}

/// Lines of code of a file: without comments, and without the tests at the end.
fn code(text: &str) -> String {
    let body = text.split("#[cfg(test)]").next().unwrap_or_default();
    body.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Modules of the crate that a piece of code names after `crate::`, also within braces.
fn imports(code: &str) -> Vec<String> {
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut found = Vec::new();
    for (place, _) in code.match_indices("crate::") {
        let rest = &code[place + "crate::".len()..];
        match rest.strip_prefix('{') {
            Some(group) => {
                let group = group.split(';').next().unwrap_or_default();
                found.extend(group.split(',').map(|part| word(part.trim())));
            }
            None => found.push(word(rest)),
        }
    }
    found
}

#[test]
fn imports_point_up_the_list_of_modules() {
    let libraries = ["src/physics/lib.rs", "src/input/lib.rs", "src/lib.rs"].map(text);
    let modules = libraries.iter().flat_map(|library| library.lines());
    let order: Vec<&str> = modules.filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';')).collect();
    assert!(order.len() > 35);
    let rank = |module: &str| order.iter().position(|known| *known == module);
    let mut wrong = Vec::new();
    for (path, text) in sources() {
        let module = in_crate(&path).trim_end_matches(".rs").split('/').next().unwrap().to_owned();
        let Some(place) = rank(&module) else { continue };
        for import in imports(&code(&text)) {
            let allowed = EXCEPTIONS.contains(&(module.as_str(), import.as_str()));
            if rank(&import).is_some_and(|other| other > place) && !allowed {
                wrong.push(format!("{path} names {import}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Blocks of the doc comments of a file: number of the first line, and the text without comment marks.
fn doc_comments(text: &str) -> Vec<(usize, String)> {
    let mut blocks: Vec<(usize, String)> = Vec::new();
    let mut is_open = false;
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim();
        let words = line.strip_prefix("///").or(line.strip_prefix("//!"));
        match (words, is_open) {
            (Some(words), true) => {
                let block = &mut blocks.last_mut().unwrap().1;
                // an empty line ends a sentence
                block.push_str(if words.trim().is_empty() { " . " } else { " " });
                block.push_str(words.trim());
            }
            (Some(words), false) => blocks.push((number, words.trim().to_owned())),
            (None, _) => {}
        }
        is_open = words.is_some();
    }
    blocks
}

/// First lines name the item or say what it does. Words for persons are not used for things. Sentences are short.
#[test]
fn doc_comments_are_plain() {
    const OPENINGS: [&str; 12] = [
        "What ",
        "Whether ",
        "Who ",
        "Whose ",
        "The same",
        "Of ",
        "How ",
        "As ",
        "Where ",
        "Which ",
        "When ",
        "By which ",
    ];
    const PERSONS: [&str; 8] = ["who", "whoever", "whom", "nobody", "somebody", "everybody", "anybody", "everyone"];
    let mut wrong = Vec::new();
    for (path, text) in sources() {
        for (line, block) in doc_comments(&text) {
            // a unit may precede the first word
            let start = block.strip_prefix('[').and_then(|rest| Some(rest.split_once(']')?.1.trim_start()));
            let start = start.unwrap_or(&block);
            if OPENINGS.iter().any(|opening| start.starts_with(opening)) {
                wrong.push(format!("{path}:{line}: begins with {start:.40}"));
            }
            let lower = block.to_lowercase();
            let mut words = lower.split(|c: char| !c.is_alphanumeric());
            if let Some(person) = words.find(|word| PERSONS.contains(word)) {
                wrong.push(format!("{path}:{line}: {person}"));
            }
            // code and links count as one word each
            let pieces = block.split('`').enumerate().map(|(k, piece)| if k % 2 == 1 { "x" } else { piece });
            let prose: String = pieces.collect();
            for sentence in prose.split_inclusive(['.', ':', ';', '!', '?']).collect::<Vec<_>>().join("\n").split('\n')
            {
                let count = sentence.split_whitespace().count();
                if count > 35 {
                    wrong.push(format!("{path}:{line}: {count} words: {sentence:.60}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn one_name_stands_for_one_type() {
    let mut known = std::collections::BTreeMap::<String, Vec<String>>::new();
    for (path, text) in sources() {
        for line in code(&text).lines().filter(|line| !line.starts_with(' ')) {
            let rest = line.strip_prefix("pub ").unwrap_or(line);
            let rest = rest.strip_prefix("pub(").and_then(|rest| Some(rest.split_once(") ")?.1)).unwrap_or(rest);
            let kinds = ["struct ", "enum ", "trait ", "type ", "union "];
            let Some(name) = kinds.iter().find_map(|kind| rest.strip_prefix(kind)) else { continue };
            let name = name.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default();
            known.entry(name.to_owned()).or_default().push(path.clone());
        }
    }
    let several: Vec<_> = known.iter().filter(|(_, paths)| paths.len() > 1).collect();
    assert!(known.len() > 500 && several.is_empty(), "{several:#?}");
}

/// `println!` and similar macros end the program if a pipe has been closed or a disk is full. A build script prints to
/// cargo.
#[test]
fn one_file_writes_to_the_terminal() {
    let may_print = ["src/runs/terminal.rs", "src/input/build.rs"];
    for (path, text) in sources().into_iter().filter(|(path, _)| !may_print.contains(&path.as_str())) {
        for word in ["println!", "print!", "stdout()", "dbg!"] {
            let code = code(&text);
            assert!(!code.contains(word), "{path} has {word}: runs/terminal.rs prints");
        }
    }
}

#[test]
fn engines_do_not_know_each_other_and_one_file_knows_each_foreign_library() {
    for (path, text) in sources() {
        let code = code(&text);
        for (own, other) in [("src/physics/engine/soft/", "hard"), ("src/physics/engine/hard/", "soft")] {
            let named = [format!("engine::{other}"), format!("super::{other}"), format!("super::super::{other}")];
            assert!(!path.starts_with(own) || !named.iter().any(|name| code.contains(name)), "{path} names {other}");
        }
        for (library, only) in [
            ("parry3d", "src/physics/walls/shape.rs"),
            ("kuva", "src/output/figures/chart.rs"),
            ("priority_queue", "calendar.rs"),
        ] {
            let elsewhere = code.contains(&format!("{library}::")) || code.contains(&format!("{library}_f64::"));
            let drawn = ["output/figures/cells.rs", "output/figures/map.rs", "output/figures/rows.rs"];
            let figure = library == "kuva" && drawn.iter().any(|file| path.ends_with(file));
            let figure = figure || library == "parry3d" && path.ends_with("src/physics/walls/mesh/tree.rs");
            assert!(path.ends_with(only) || figure || !elsewhere, "{path} names {library}");
        }
    }
}

/// Only the folder `distributed` of the engines has code for several processes. Elsewhere, the code of engines,
/// islands and uniform steps is that for one process.
#[test]
fn one_folder_of_the_engines_knows_other_processes() {
    let is_elsewhere =
        |path: &str| path.starts_with("src/physics/engine/") && !path.starts_with("src/physics/engine/distributed/");
    for (path, text) in sources().into_iter().filter(|(path, _)| is_elsewhere(path)) {
        assert!(!code(&text).to_lowercase().contains("communicator"), "{path} names the communicator");
    }
}

/// Results cannot depend on the time, because physics does not read a clock. Engines measure times for reports, with a
/// clock that the caller passes.
#[test]
fn only_studies_and_the_clock_read_the_time() {
    let reads = |path: &str| ["src/runs/", "src/study/"].iter().any(|floor| path.starts_with(floor));
    for (path, text) in sources().into_iter().filter(|(path, _)| !reads(path)) {
        assert!(path == "src/physics/clock.rs" || !code(&text).contains("Instant::now"), "{path} reads the time");
    }
}

/// Code blocks of one language in a Markdown text.
fn blocks<'a>(markdown: &'a str, language: &str) -> Vec<&'a str> {
    let fence = format!("```{language}\n");
    markdown.split(fence.as_str()).skip(1).filter_map(|rest| rest.split("\n```").next()).collect()
}

/// Path, relative to the crate, and text of every page for readers, including the folders in `docs/`.
fn documents() -> Vec<(String, String)> {
    fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                collect(&path, found);
            } else if path.extension().is_some_and(|extension| extension == "md") {
                found.push(path);
            }
        }
    }
    let names = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "models/README.md", "python/README.md"];
    let mut found: Vec<PathBuf> = names.iter().map(|name| root().join(name)).collect();
    collect(&root().join("docs"), &mut found);
    found.sort();
    let name = |path: &Path| path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/");
    found.iter().map(|path| (name(path), std::fs::read_to_string(path).unwrap())).collect()
}

/// Anchors of the headings of a page, as made by GitHub and similar sites.
fn anchors(markdown: &str) -> Vec<String> {
    let headings =
        markdown.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    let kept = |c: &char| c.is_alphanumeric() || ['-', '_', ' '].contains(c);
    headings.map(|heading| heading.to_lowercase().chars().filter(kept).collect::<String>().replace(' ', "-")).collect()
}

#[test]
fn links_between_pages_lead_somewhere() {
    let mut wrong = Vec::new();
    for (name, markdown) in documents() {
        let folder = root().join(&name).parent().unwrap().to_owned();
        for link in markdown.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if link.contains("://") || link.contains(char::is_whitespace) {
                continue;
            }
            let (path, anchor) = link.split_once('#').map_or((link, None), |(path, anchor)| (path, Some(anchor)));
            let target = if path.is_empty() { root().join(&name) } else { folder.join(path) };
            let is_known = |anchor: &str| {
                std::fs::read_to_string(&target).is_ok_and(|page| anchors(&page).iter().any(|known| known == anchor))
            };
            if !target.exists() || anchor.is_some_and(|anchor| !is_known(anchor)) {
                wrong.push(format!("{name}: {link}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn toml_in_documents_is_a_case_or_part_of_one() {
    let base: toml::Table = text("tests/inputs/good/base.toml").parse().unwrap();
    let mut seen = 0;
    for (name, markdown) in documents() {
        for block in blocks(&markdown, "toml") {
            let part: toml::Table = block.parse().unwrap_or_else(|error| panic!("{name}: {error}\n{block}"));
            let whole = part.contains_key("domain");
            let mut case = if whole { toml::Table::new() } else { base.clone() };
            case.extend(part);
            let path = root().join("cases/of-a-document.toml");
            let read = Case::from_text(&path, Arc::from(case.to_string()), &[]).and_then(|case| case.variants(None));
            assert!(read.is_ok(), "{name}: {}\n{block}", read.unwrap_err());
            seen += 1;
        }
    }
    assert!(seen > 0);
}

#[test]
fn documents_name_commands_and_files_that_exist() {
    Cli::command().debug_assert();
    let commands: Vec<String> = Cli::command().get_subcommands().map(|command| command.get_name().to_owned()).collect();
    let table = text("docs/commands.md");
    for command in &commands {
        let line = format!("| `diptych {command}");
        let has_line = [" ", "`"].iter().any(|end| table.contains(&format!("{line}{end}")));
        assert!(has_line, "docs/commands.md has no line for {command}");
    }
    for (name, markdown) in documents() {
        for (place, _) in markdown.match_indices("`diptych ") {
            let rest = &markdown[place + "`diptych ".len()..];
            let word: String = rest.chars().take_while(|c| c.is_ascii_alphabetic()).collect();
            assert!(commands.contains(&word), "{name} names the command {word}");
        }
        // paths in backticks or links
        for word in markdown.split(|c: char| c.is_whitespace() || "`()[],;\"".contains(c)) {
            let word = word.trim_end_matches(['.', ':']);
            let ours = ["cases/", "src/", "tests/", "models/", "docs/"].iter().any(|start| word.starts_with(start));
            if ours && !word.contains(['<', '*']) {
                assert!(root().join(word).exists(), "{name} names {word}");
            }
        }
    }
}

/// The version of the workspace is that of the changelog, of the citation, and of the line to cite in the README.
#[test]
fn the_version_is_told_alike() {
    let manifest = text("Cargo.toml");
    let version = manifest.lines().find_map(|line| line.strip_prefix("version = \"")?.strip_suffix('"')).unwrap();
    assert_eq!(version, env!("CARGO_PKG_VERSION"));
    let newest = text("CHANGELOG.md").lines().find_map(|line| line.strip_prefix("## ").map(str::to_owned));
    assert_eq!(newest.as_deref(), Some(version));
    assert!(text("CITATION.cff").lines().any(|line| line == format!("version: {version}")));
    assert!(text("README.md").contains(&format!("Diptych, version {version} ")));
}

/// True if the text in brackets is a unit: "-", or symbols with powers, joined by spaces and slashes, as in `kg m/s` or
/// `1/s²`.
fn is_unit(text: &str) -> bool {
    let known = ["1", "m", "s", "ns", "kg", "N", "J", "W", "Pa", "K", "rad", "°", "px", "byte"];
    let without_power = |symbol: &str| {
        let symbol = symbol.split_once('^').map_or(symbol, |(symbol, _)| symbol);
        symbol.trim_matches(['(', ')']).trim_end_matches(['²', '³', '⁴', '⁵', '⁶']).to_owned()
    };
    text == "-" || text.split([' ', '/']).all(|symbol| known.contains(&without_power(symbol).as_str()))
}

/// True if a comment names a unit, in brackets or in words, for one field or for all fields of a type.
fn says_a_unit(comment: &str) -> bool {
    let mut bracketed = comment.split('[').skip(1).filter_map(|rest| rest.split_once(']'));
    let words = [
        "in SI",
        "All times in s.",
        "in the unit of",
        "in units of",
        "in the units of",
        "[units of the axis]",
        "in the quantity's unit",
    ];
    bracketed.any(|(text, _)| is_unit(text)) || words.iter().any(|words| comment.contains(words))
}

#[test]
fn what_is_a_unit() {
    for unit in ["-", "m", "m/s", "kg m/s", "m²/s³", "1/s²", "N/m^1.5", "N s/m^1.25", "(m/s)^p"] {
        assert!(is_unit(unit), "{unit}");
    }
    for other in ["", "0, 1", "`Scene::species`", "unit", "mm of it", "-1", "k"] {
        assert!(!is_unit(other), "{other}");
    }
    assert!(says_a_unit(" [m] length.") && says_a_unit(" Mean [-] of what [`Scene`] holds."));
    assert!(!says_a_unit(" Unites islands of [`Scene`], at index [0].") && !says_a_unit(" A unit normal."));
}

/// Number of lines of all files of a module together.
fn lines_of(module: &str) -> usize {
    let own = |path: &str| path == format!("{module}.rs") || path.starts_with(&format!("{module}/"));
    sources().iter().filter(|(path, _)| own(in_crate(path))).map(|(_, text)| text.lines().count()).sum()
}

#[test]
fn the_map_of_modules_is_of_these_modules() {
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/architecture.md")).unwrap();
    let table = page.split_once("| module | holds | lines |").unwrap().1;
    let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    for row in rows {
        let cells: Vec<&str> = row.trim_matches('|').split(" | ").map(str::trim).collect();
        let (module, told) = (cells[0].trim_matches('`'), cells[2].parse::<usize>().unwrap());
        let lines = lines_of(module);
        // largest change of the number of lines before the page must be updated
        assert!(
            told.abs_diff(lines) <= 20 + lines / 10,
            "docs/architecture.md says {told} lines of {module}, it has {lines}"
        );
    }
}

#[test]
fn public_numbers_say_their_unit() {
    let mut wrong = Vec::new();
    for (path, text) in sources() {
        // written tables have the unit in the names of their columns, and the report draws given values
        if path.starts_with("src/input/case/file.rs") {
            continue;
        }
        let (mut comment, mut whole) = (String::new(), String::new());
        for line in text.split("#[cfg(test)]").next().unwrap_or_default().lines().map(str::trim) {
            if let Some(words) = line.strip_prefix("///") {
                comment += words;
                continue;
            }
            let field = line.strip_prefix("pub ").and_then(|rest| rest.strip_suffix(','));
            let number = field.and_then(|field| field.split_once(": ")).filter(|(_, kind)| {
                ["f64", "Option<f64>", "Vec<f64>", "Vector3<f64>", "Vec<Vector3<f64>>"].contains(kind)
            });
            if line.contains("struct ") || line.contains("enum ") {
                whole = comment.clone();
            }
            if let Some((name, _)) = number
                && name != "normal" // a unit vector everywhere: docs/notation.md
                && !says_a_unit(&comment)
                && !says_a_unit(&whole)
            {
                wrong.push(format!("{path}: {name}"));
            }
            if !line.starts_with("#[") {
                comment.clear();
            }
        }
    }
    assert!(wrong.is_empty(), "no [unit] in the comment of {wrong:#?}");
}
