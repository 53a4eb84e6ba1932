//! A template, line by line.

use std::collections::BTreeSet;

/// A template and its keys.
pub struct Template {
    /// Its text.
    pub as_it_is: String,
    lines: Vec<Line>,
}

/// A line with the key that it gives; a list over several lines is one line.
struct Line {
    key: Option<String>,
    text: String,
}

impl Template {
    /// Takes a template apart; keys behind "# " are there too.
    pub fn of(text: &str) -> Self {
        let (mut lines, mut table) = (Vec::<Line>::new(), String::new());
        let mut open = false;
        for line in text.lines() {
            if open && let Some(last) = lines.last_mut() {
                last.text += &format!("{line}\n");
                open = line != "]";
                continue;
            }
            if line.starts_with('[') {
                table = line.trim_matches(['[', ']']).to_owned() + ".";
            }
            let used = line.strip_prefix("# ").filter(|line| is_assignment(line));
            let used = used.unwrap_or(line);
            let key = is_assignment(used).then(|| used.split(' ').next().unwrap_or_default());
            open = used.ends_with("= [");
            lines.push(Line {
                key: key.map(|key| format!("{table}{key}")),
                text: format!("{used}\n"),
            });
        }
        let as_it_is = text.to_owned();
        Self { as_it_is, lines }
    }

    /// The keys that it gives or shows.
    pub fn keys(&self) -> BTreeSet<String> {
        self.lines
            .iter()
            .filter_map(|line| line.key.clone())
            .collect()
    }

    /// The text with all optional keys.
    pub fn with_all(&self) -> String {
        self.lines.iter().map(|line| line.text.as_str()).collect()
    }

    fn place(&self, key: &str) -> Option<usize> {
        self.lines
            .iter()
            .position(|line| line.key.as_deref() == Some(key))
    }

    /// The text without the first line of a key; `None` for a table.
    pub fn without(&self, key: &str) -> Option<String> {
        let place = self.place(key)?;
        let kept = self
            .lines
            .iter()
            .enumerate()
            .filter(|(line, _)| *line != place);
        Some(kept.map(|(_, line)| line.text.as_str()).collect())
    }

    /// The text with another number at the first line of a key, or as the first element of its list.
    pub fn with(&self, key: &str, number: f64) -> String {
        let place = self.place(key).unwrap_or_else(|| panic!("no {key}"));
        let (name, value) = self.lines[place].text.split_once('=').unwrap();
        let changed = match value.trim().strip_prefix('[') {
            Some(list) => {
                let end = list.find([',', ']']).unwrap();
                format!("{name}= [{number:?}{}\n", &list[end..])
            }
            None => format!("{name}= {number:?}\n"),
        };
        let lines = self.lines.iter().enumerate();
        lines
            .map(|(line, at)| if line == place { &changed } else { &at.text })
            .cloned()
            .collect()
    }

    /// The number of a key.
    pub fn number(&self, key: &str) -> Option<f64> {
        let text = &self.lines[self.place(key)?].text;
        let value = text.split_once('=')?.1.split('#').next()?;
        value.trim().parse().ok()
    }
}

fn is_assignment(line: &str) -> bool {
    let Some((key, _)) = line.split_once(" = ") else {
        return false;
    };
    !key.is_empty()
        && key
            .chars()
            .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}
