//! Which file a path leads into.

use std::collections::BTreeMap;

use crate::source::{Scope, Segments, Source};

/// All modules of one crate.
pub struct Modules<'a> {
    /// The name under which the crate's binary imports its library.
    library: &'a str,
    modules: BTreeMap<Segments, (usize, &'a Scope)>,
}

/// A file that needs another one, both by their place among the sources.
pub struct Arrow {
    pub from: usize,
    pub to: usize,
    pub line: usize,
    pub path: String,
}

/// Re-exports of re-exports are followed this far.
const MAX_STEPS: usize = 8;

impl<'a> Modules<'a> {
    pub fn new(sources: &'a [Source], library: &'a str) -> Self {
        let has_library = sources.iter().any(|source| source.path == "lib.rs");
        let mut modules = BTreeMap::new();
        for (file, source) in sources.iter().enumerate() {
            let outer = module_of(&source.path, has_library);
            for (inner, scope) in &source.modules {
                modules.insert([outer.as_slice(), inner].concat(), (file, scope));
            }
        }
        Self { library, modules }
    }

    /// The first path in each file that leads into each other one.
    pub fn arrows(&self) -> Vec<Arrow> {
        let mut arrows = Vec::new();
        for (module, &(from, scope)) in &self.modules {
            for mention in &scope.mentions {
                let target = self.resolve(module, &mention.path, MAX_STEPS);
                let Some(&(to, _)) = target.and_then(|target| self.modules.get(&target)) else {
                    continue;
                };
                if to != from {
                    let path = mention.path.join("::");
                    let line = mention.line;
                    arrows.push(Arrow {
                        from,
                        to,
                        line,
                        path,
                    });
                }
            }
        }
        arrows.sort_by_key(|arrow| (arrow.from, arrow.to, arrow.line));
        arrows.dedup_by_key(|arrow| (arrow.from, arrow.to));
        arrows
    }

    /// The module in which the last segment of `path`, as `module` writes it, is a module or an item; nothing for other
    /// crates and for variables.
    fn resolve(&self, module: &[String], path: &[String], steps: usize) -> Option<Segments> {
        let steps = steps.checked_sub(1)?;
        let mut rest = path;
        let mut start = module.to_vec();
        match path.first()?.as_str() {
            "crate" => start.clear(),
            library if library == self.library => start.clear(),
            "self" if path.len() > 1 => {}
            "super" => {
                while rest.first().is_some_and(|head| head == "super") {
                    start.pop()?;
                    rest = &rest[1..];
                }
                return self.descend(start, rest, steps);
            }
            head if path.len() > 1 && self.modules.contains_key(&child(module, head)) => {
                return self.descend(start, path, steps);
            }
            head => {
                let (_, scope) = self.modules.get(module)?;
                let behind = scope.names.get(head).filter(|behind| behind[0] != head)?;
                return self.resolve(module, &[behind, &path[1..]].concat(), steps);
            }
        }
        self.descend(start, &rest[1..], steps)
    }

    fn descend(&self, mut at: Segments, path: &[String], steps: usize) -> Option<Segments> {
        for (place, segment) in path.iter().enumerate() {
            let inner = child(&at, segment);
            if self.modules.contains_key(&inner) {
                at = inner;
                continue;
            }
            let rest = &path[place..];
            let (_, scope) = self.modules.get(&at)?;
            if scope.items.contains(segment) {
                return Some(at);
            }
            if let Some(behind) = scope.names.get(segment) {
                let behind = [behind, &rest[1..]].concat();
                return self.resolve(&at, &behind, steps).or(Some(at));
            }
            for glob in &scope.globs {
                if let Some(target) = self.resolve(&at, glob, steps)
                    && target != at
                    && self.offers(&target, segment)
                {
                    return self.descend(target, rest, steps);
                }
            }
            return Some(at);
        }
        Some(at)
    }

    fn offers(&self, module: &[String], name: &str) -> bool {
        self.modules.contains_key(&child(module, name))
            || self.modules.get(module).is_some_and(|(_, scope)| {
                scope.items.contains(name) || scope.names.contains_key(name)
            })
    }
}

fn child(module: &[String], name: &str) -> Segments {
    [module, &[name.to_owned()]].concat()
}

/// `a/mod.rs` and `a.rs` are `a`; `lib.rs`, or `main.rs` where there is no library, is the root.
fn module_of(path: &str, has_library: bool) -> Segments {
    let mut segments: Segments = path
        .trim_end_matches(".rs")
        .split('/')
        .map(str::to_owned)
        .collect();
    let root = if has_library { "lib" } else { "main" };
    if segments == [root] || segments.last().is_some_and(|last| last == "mod") {
        segments.pop();
    }
    segments
}
