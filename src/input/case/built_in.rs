//! Cases, and sets of values (parts of cases, which a case includes by `use`), compiled into the program. So the
//! program finds them without a folder on the disk.

use include_dir::{Dir, include_dir};
use std::path::{Path, PathBuf};

/// Files of the folder `cases`, compiled into the program.
static CASES: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../cases");

/// Files of the folder `models`, compiled into the program: the sets of values.
static MODELS: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../models");

/// Case, or set of values (part of a case, which cases include by `use`), that is built into the program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BuiltIn {
    /// Name of the case or set: path within the folder `cases` or `models`, without `.toml`.
    pub name: String,
    /// Path by which messages name the file.
    pub path: PathBuf,
    /// Whole text of the file.
    pub text: &'static str,
}

/// Finds the file `name` in a folder of built-in files; `None` if there is none. `kind` is the name of the folder in
/// messages.
fn find(folder: &'static Dir, kind: &str, name: &str) -> Option<BuiltIn> {
    let text = folder.get_file(format!("{name}.toml"))?.contents_utf8()?;
    let path = PathBuf::from(format!("{kind}/{name}.toml (built in)"));
    Some(BuiltIn { name: name.to_owned(), path, text })
}

/// All TOML files of a folder of built-in files and of its subfolders, sorted by the depth of the subfolder, then by
/// name. `kind` is the name of the folder in messages.
fn all(folder: &'static Dir, kind: &str) -> Vec<BuiltIn> {
    fn names(folder: &Dir, found: &mut Vec<String>) {
        let name = |path: &Path| path.with_extension("").to_string_lossy().replace('\\', "/");
        let texts = folder.files().filter(|file| file.path().extension().is_some_and(|e| e == "toml"));
        found.extend(texts.map(|file| name(file.path())));
        folder.dirs().for_each(|inner| names(inner, found));
    }
    let mut found = Vec::new();
    names(folder, &mut found);
    found.sort_by_key(|name| (name.matches('/').count(), name.clone()));
    found.iter().filter_map(|name| find(folder, kind, name)).collect()
}

/// Built-in case with the given name, such as `quick` or `paper/figure-5`; `None` if there is none.
pub fn case(name: &str) -> Option<BuiltIn> {
    find(&CASES, "cases", name)
}

/// Bytes of a data file of a built-in case; `None` if there is no such file. `path` begins at the folder that contains
/// `cases`, such as `cases/paper/gas-dns.csv`.
pub fn file(path: &Path) -> Option<&'static [u8]> {
    CASES.get_file(path.strip_prefix("cases").ok()?).map(include_dir::File::contents)
}

/// Names and contents of the data files of a built-in case. A copy of the case requires these files too.
pub fn files_of(case: &BuiltIn) -> Vec<(String, &'static [u8])> {
    let folder = Path::new(&case.name).parent().and_then(|folder| match folder.as_os_str().is_empty() {
        true => Some(&CASES),
        false => CASES.get_dir(folder),
    });
    let files = folder.into_iter().flat_map(Dir::files);
    let named = files.filter_map(|file| {
        let name = file.path().file_name()?.to_str()?;
        case.text.contains(&format!("\"{name}\"")).then(|| (name.to_owned(), file.contents()))
    });
    named.collect()
}

/// All built-in cases.
pub fn cases() -> Vec<BuiltIn> {
    all(&CASES, "cases")
}

/// Built-in set of values with the given name, such as `fluids/air`; `None` if there is none.
pub fn set(name: &str) -> Option<BuiltIn> {
    find(&MODELS, "models", name)
}

/// All built-in sets of values.
pub fn sets() -> Vec<BuiltIn> {
    all(&MODELS, "models")
}
