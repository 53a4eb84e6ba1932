//! The difference of two strings, with the interface of the crate `dissimilar`.
//!
//! That crate is Apache-2.0 only, which the GPL-2.0 of the emulator does not allow. `defmt-decoder`, which reads the
//! firmware's log, depends on it to mark differences in the output of its own printer. The virtual board prints by
//! itself, so a plain answer is enough: the common beginning, the differences, the common end.

/// A piece of the difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Chunk<'a> {
    /// In both strings.
    Equal(&'a str),
    /// In the first string only.
    Delete(&'a str),
    /// In the second string only.
    Insert(&'a str),
}

/// The deletions from `first` and the insertions that make it `second`.
#[must_use]
pub fn diff<'a>(first: &'a str, second: &'a str) -> Vec<Chunk<'a>> {
    let same = |pair: &(char, char)| pair.0 == pair.1;
    let length = |pairs: &mut dyn Iterator<Item = (char, char)>| {
        pairs.map(|(c, _)| c.len_utf8()).sum::<usize>()
    };
    let head = length(&mut first.chars().zip(second.chars()).take_while(same));
    let (common, first) = first.split_at(head);
    let second = &second[head..];
    let tail = length(
        &mut first
            .chars()
            .rev()
            .zip(second.chars().rev())
            .take_while(same),
    );
    let (deleted, ending) = first.split_at(first.len() - tail);
    let inserted = &second[..second.len() - tail];
    [
        Chunk::Equal(common),
        Chunk::Delete(deleted),
        Chunk::Insert(inserted),
        Chunk::Equal(ending),
    ]
    .into_iter()
    .filter(|(Chunk::Equal(text) | Chunk::Delete(text) | Chunk::Insert(text))| !text.is_empty())
    .collect()
}

#[cfg(test)]
mod tests {
    use super::{Chunk, diff};

    #[test]
    fn the_middle_differs() {
        let expected = [
            Chunk::Equal("x = "),
            Chunk::Delete("1"),
            Chunk::Insert("23"),
            Chunk::Equal(";"),
        ];
        assert_eq!(diff("x = 1;", "x = 23;"), expected);
    }

    #[test]
    fn common_ends_do_not_overlap_and_characters_stay_whole() {
        assert_eq!(diff("aa", "aaa"), [Chunk::Equal("aa"), Chunk::Insert("a")]);
        assert_eq!(diff("é", "è"), [Chunk::Delete("é"), Chunk::Insert("è")]);
        assert!(diff("", "").is_empty());
    }
}
