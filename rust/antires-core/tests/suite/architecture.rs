//! The arrows between the modules: those of the table below and no others, and no circle between files.
//!
//! Read from the sources: every path that begins with `crate`, `super`, `self` or the name of a child module, but
//! for test modules. A name that a module passes on (`pub use`) counts as an import from where it is defined.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// What each module may use.
const ARROWS: [(&str, &[&str]); 10] = [
    ("error", &[]),
    ("rng", &[]),
    ("linalg", &["error"]),
    ("rational", &["linalg"]),
    ("fem", &["error", "linalg"]),
    ("modal", &["error", "linalg", "fem"]),
    ("antiresonances", &["error", "linalg", "fem", "modal"]),
    ("optimize", &["error", "rng"]),
    ("update", &["error", "fem", "modal", "antiresonances", "optimize"]),
    ("prepared", &["linalg", "update"]),
];

type Module = Vec<String>;

/// Text of each module, without comments and tests.
type Sources = BTreeMap<Module, String>;

fn module(path: &str) -> Module {
    path.split("::").map(str::to_owned).collect()
}

fn read(folder: &Path, at: &Module, sources: &mut Sources) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let inside = [at.clone(), vec![stem.clone()]].concat();
        if path.is_dir() {
            read(&path, &inside, sources);
        } else if stem != "tests" {
            let name = match stem.as_str() {
                "lib" | "mod" => at.clone(),
                _ => inside,
            };
            sources.insert(name, without_tests(&fs::read_to_string(&path).unwrap()));
        }
    }
}

fn crate_sources() -> Sources {
    let mut sources = Sources::new();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    read(&folder, &Module::new(), &mut sources);
    sources
}

fn without_tests(text: &str) -> String {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    code.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// A `use` statement, or a path in the code.
struct Import {
    path: Vec<String>,
    passed_on: bool,
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// All paths of a `use` tree such as `a::{b, c::d}`.
fn expand(tree: &str, before: &[String], out: &mut Vec<Vec<String>>) {
    let tree = tree.trim();
    if let Some((head, rest)) = tree.split_once('{') {
        let inner = rest.strip_suffix('}').unwrap_or(rest);
        let head = head.split("::").map(str::trim).filter(|s| !s.is_empty());
        let before: Vec<String> = before.iter().cloned().chain(head.map(str::to_owned)).collect();
        let (mut depth, mut start) = (0, 0);
        for (i, c) in inner.char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    expand(&inner[start..i], &before, out);
                    start = i + 1;
                }
                _ => {}
            }
        }
        expand(&inner[start..], &before, out);
    } else if !tree.is_empty() {
        let name = tree.split(" as ").next().unwrap_or(tree);
        let own = name.split("::").map(|s| s.trim().to_owned());
        let mut path: Vec<String> = before.iter().cloned().chain(own).collect();
        if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
            path.pop();
        }
        out.push(path);
    }
}

/// The `use` statements of a text, and the text without them.
fn statements(text: &str) -> (Vec<Import>, String) {
    let (mut imports, mut code, mut pending) = (Vec::new(), String::new(), String::new());
    for line in text.lines() {
        let trimmed = line.trim();
        let begins = ["use ", "pub use ", "pub(super) use ", "pub(crate) use "]
            .iter()
            .any(|start| trimmed.starts_with(start));
        if begins || !pending.is_empty() {
            pending.push_str(trimmed);
            pending.push(' ');
            if let Some((statement, _)) = pending.split_once(';') {
                let (visibility, tree) = statement.split_once("use ").unwrap();
                let mut paths = Vec::new();
                expand(tree, &[], &mut paths);
                let passed_on = !visibility.trim().is_empty();
                imports.extend(paths.into_iter().map(|path| Import { path, passed_on }));
                pending.clear();
            }
        } else {
            code.push_str(line);
            code.push('\n');
        }
    }
    (imports, code)
}

/// Paths of at least two names in the code.
fn inline_paths(code: &str) -> Vec<Import> {
    let mut imports = Vec::new();
    let words = code.split(|c: char| !is_word(c) && c != ':');
    for word in words.filter(|word| word.contains("::") && !word.starts_with(':')) {
        let names = word.split("::").filter(|name| !name.is_empty());
        imports.push(Import { path: names.map(str::to_owned).collect(), passed_on: false });
    }
    imports
}

/// The module and the name in it that a path leads to; none where it leads out of the crate.
fn absolute(from: &Module, path: &[String], sources: &Sources) -> Option<Module> {
    let mut names = path.iter();
    let mut at = match names.next()?.as_str() {
        "crate" => Module::new(),
        "self" => from.clone(),
        "super" => from[..from.len() - 1].to_vec(),
        child => {
            let inside = [from.clone(), vec![child.to_owned()]].concat();
            sources.get(&inside).map(|_| inside)?
        }
    };
    for name in names {
        if name == "super" {
            at.pop();
        } else {
            at.push(name.clone());
        }
    }
    Some(at)
}

/// The file that defines what an absolute path names.
fn file_of(path: &Module, passed_on: &BTreeMap<Module, Module>, sources: &Sources) -> Module {
    for length in (0..=path.len()).rev() {
        let prefix = path[..length].to_vec();
        if let Some(origin) = passed_on.get(&prefix) {
            return file_of(origin, passed_on, sources);
        }
        if sources.contains_key(&prefix) {
            return prefix;
        }
    }
    Module::new()
}

/// Which files each file uses.
fn edges(sources: &Sources) -> BTreeMap<Module, BTreeSet<Module>> {
    let (mut passed_on, mut used) = (BTreeMap::new(), Vec::new());
    for (from, text) in sources {
        let (imports, code) = statements(text);
        for import in imports.into_iter().chain(inline_paths(&code)) {
            let Some(to) = absolute(from, &import.path, sources) else {
                continue;
            };
            match to.last() {
                Some(name) if import.passed_on => {
                    passed_on.insert([from.clone(), vec![name.clone()]].concat(), to);
                }
                _ => used.push((from.clone(), to)),
            }
        }
    }
    let mut edges: BTreeMap<Module, BTreeSet<Module>> = BTreeMap::new();
    for (from, to) in used {
        let to = file_of(&to, &passed_on, sources);
        if to != from {
            edges.entry(from).or_default().insert(to);
        }
    }
    edges
}

/// Arrows that the table does not have.
fn wrong_arrows(edges: &BTreeMap<Module, BTreeSet<Module>>) -> Vec<String> {
    let mut wrong = Vec::new();
    for (from, targets) in edges {
        let Some(top) = from.first() else { continue };
        let row = ARROWS.iter().find(|(name, _)| name == top);
        for to in targets {
            let allowed = match (row, to.first()) {
                (Some((_, allowed)), Some(to)) => to == top || allowed.contains(&to.as_str()),
                _ => false,
            };
            if !allowed {
                wrong.push(format!("{} -> {}", from.join("::"), to.join("::")));
            }
        }
    }
    wrong
}

/// One circle between files, if there is one.
fn circle(edges: &BTreeMap<Module, BTreeSet<Module>>) -> Option<String> {
    fn visit(
        at: &Module,
        edges: &BTreeMap<Module, BTreeSet<Module>>,
        path: &mut Vec<Module>,
        done: &mut BTreeSet<Module>,
    ) -> Option<String> {
        if let Some(start) = path.iter().position(|m| m == at) {
            let names = path[start..].iter().chain([at]).map(|m| m.join("::"));
            return Some(names.collect::<Vec<_>>().join(" -> "));
        }
        if !done.contains(at) {
            path.push(at.clone());
            for to in edges.get(at).into_iter().flatten() {
                if let Some(found) = visit(to, edges, path, done) {
                    return Some(found);
                }
            }
            path.pop();
            done.insert(at.clone());
        }
        None
    }
    let mut done = BTreeSet::new();
    edges.keys().find_map(|at| visit(at, edges, &mut Vec::new(), &mut done))
}

#[test]
fn every_arrow_is_in_the_table() {
    let sources = crate_sources();
    let tops: BTreeSet<&str> = sources.keys().filter_map(|m| m.first()).map(String::as_str).collect();
    assert_eq!(tops, ARROWS.iter().map(|(name, _)| *name).collect());
    let edges = edges(&sources);
    assert!(edges.values().map(BTreeSet::len).sum::<usize>() > 200);
    assert_eq!(wrong_arrows(&edges), Vec::<String>::new());
}

#[test]
fn no_two_files_use_each_other() {
    assert_eq!(circle(&edges(&crate_sources())), None);
}

/// The sources with a line more in one module.
fn with(line: &str, at: &str) -> Sources {
    let mut sources = crate_sources();
    sources.get_mut(&module(at)).unwrap().push_str(line);
    sources
}

#[test]
fn a_wrong_arrow_is_seen_in_every_form() {
    for (line, at) in [
        ("\nuse crate::antiresonances::secular::Scratch;", "modal::receptance"),
        ("\nuse crate::antiresonances::Query;", "modal::receptance"),
        (
            "\nuse super::super::{\n    linalg::wide,\n    fem::model::{Model, joins},\n};",
            "linalg::symmetric",
        ),
        ("\nfn f() { crate::modal::modes::hertz(1.0); }", "optimize::island"),
        ("\nuse crate::optimize::Bounds;", "fem::model"),
        ("\npub(super) fn f(h: super::super::modal::receptance::Receptance) {}", "fem::term"),
    ] {
        assert_eq!(wrong_arrows(&edges(&with(line, at))).len(), 1, "{line}");
    }
}

#[test]
fn a_circle_is_seen_in_every_form() {
    for (line, at) in [
        ("\nuse super::solver::Prepared;", "antiresonances::search"),
        ("\nuse super::AntiresonanceSolver;", "antiresonances::search"),
        ("\nuse super::polish::Polish;", "optimize::descent"),
        ("\nfn f(p: crate::fem::Model) { super::model::joins(); }", "fem::term"),
        ("\nuse parameters::turn;", "fem::frame"),
    ] {
        assert!(circle(&edges(&with(line, at))).is_some(), "{line}");
    }
}
