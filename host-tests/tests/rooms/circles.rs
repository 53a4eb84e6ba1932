//! Circles between the files and folders of one folder.
//!
//! Inside each folder, its files and subfolders are the rooms; an arrow between two files joins the two rooms in which
//! they lie. A circle of files always shows in the innermost folder that holds them all, so that folders one by one are
//! all there is to look at.

use std::collections::{BTreeMap, BTreeSet};

use crate::modules::{Arrow, Modules};
use crate::source::Source;

/// Two files of one folder that are two halves of one type, by their paths from `src`, and why.
#[derive(Debug, Clone, Copy)]
pub struct Halves {
    pub files: [&'static str; 2],
    #[expect(dead_code, reason = "for whoever reads the list")]
    pub reason: &'static str,
}

/// One text for each circle, with files and lines, and one for each pair of halves that need not be listed.
pub fn find(sources: &[Source], library: &str, halves: &[Halves]) -> Vec<String> {
    let arrows = Modules::new(sources, library).arrows();
    let path = |file: usize| sources[file].path.as_str();
    let mut found = Vec::new();
    for pair in halves {
        let [first, second] = pair.files;
        let joins = |from, to| {
            arrows
                .iter()
                .any(|arrow| path(arrow.from) == from && path(arrow.to) == to)
        };
        if folder_of(first) != folder_of(second) || !joins(first, second) || !joins(second, first) {
            found.push(format!(
                "  {first} and {second} do not import each other in one folder: take them off the list of halves"
            ));
        }
    }
    let folders: BTreeSet<&str> = sources
        .iter()
        .flat_map(|source| ancestors(&source.path))
        .collect();
    for folder in folders {
        let room = |file: usize| room_in(folder, path(file), halves);
        let mut joined: BTreeMap<(&str, &str), Vec<&Arrow>> = BTreeMap::new();
        for arrow in &arrows {
            if let (Some(from), Some(to)) = (room(arrow.from), room(arrow.to))
                && from != to
            {
                joined.entry((from, to)).or_default().push(arrow);
            }
        }
        for circle in circles(joined.keys().copied().collect()) {
            found.push(describe(folder, &circle, &joined, sources));
        }
    }
    found
}

/// `a/b/c.rs` lies in the folders ``, `a` and `a/b`.
fn ancestors(path: &str) -> impl Iterator<Item = &str> {
    std::iter::once("").chain(path.match_indices('/').map(|(at, _)| &path[..at]))
}

fn folder_of(path: &str) -> &str {
    path.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// The file or subfolder of `folder` that `path` lies in; the second half of a type lies in the first.
fn room_in<'a>(folder: &str, path: &'a str, halves: &[Halves]) -> Option<&'a str> {
    let path = halves
        .iter()
        .find(|pair| pair.files[1] == path)
        .map_or(path, |pair| pair.files[0]);
    let inside = match folder {
        "" => path,
        _ => path.strip_prefix(folder)?.strip_prefix('/')?,
    };
    Some(inside.split_once('/').map_or(inside, |(room, _)| room))
}

/// Sets of rooms in which each reaches every other.
fn circles<'a>(joined: BTreeSet<(&'a str, &'a str)>) -> Vec<BTreeSet<&'a str>> {
    let reached = |from: &'a str| {
        let mut reached = BTreeSet::new();
        let mut next = vec![from];
        while let Some(at) = next.pop() {
            for &(_, to) in joined.iter().filter(|(start, _)| *start == at) {
                if reached.insert(to) {
                    next.push(to);
                }
            }
        }
        reached
    };
    let rooms: BTreeSet<&str> = joined.iter().flat_map(|(from, to)| [*from, *to]).collect();
    let reach: BTreeMap<&str, BTreeSet<&str>> =
        rooms.iter().map(|room| (*room, reached(room))).collect();
    let mut found: Vec<BTreeSet<&str>> = Vec::new();
    for (room, reached) in &reach {
        let circle: BTreeSet<&str> = reached
            .iter()
            .copied()
            .filter(|other| reach[other].contains(room))
            .collect();
        if !circle.is_empty() && !found.contains(&circle) {
            found.push(circle);
        }
    }
    found
}

fn describe(
    folder: &str,
    circle: &BTreeSet<&str>,
    joined: &BTreeMap<(&str, &str), Vec<&Arrow>>,
    sources: &[Source],
) -> String {
    let rooms: Vec<&str> = circle.iter().copied().collect();
    let place = if folder.is_empty() { "src" } else { folder };
    let mut text = format!("  circle in {place}: {}", rooms.join(", "));
    for ((from, to), arrows) in joined {
        if circle.contains(from) && circle.contains(to) {
            text += &format!("\n    {from} → {to}");
            for arrow in arrows {
                let (file, target) = (&sources[arrow.from].path, &sources[arrow.to].path);
                text += &format!("\n      {file}:{} {} ({target})", arrow.line, arrow.path);
            }
        }
    }
    text
}
