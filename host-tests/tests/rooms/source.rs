//! What one file imports, mentions and defines, read from its tokens.
//!
//! A lexer is enough: Rust's `use` lines have a grammar of three rules, and a path is identifiers with `::` between
//! them, in the body of a macro as elsewhere.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{Delimiter, Ident, TokenStream, TokenTree};

/// Segments of a path: `crate`, `wire`, `Request`.
pub type Segments = Vec<String>;

/// One file of a crate.
pub struct Source {
    /// From the crate's `src`, with `/`.
    pub path: String,
    /// The file's own module first, then the modules with a body inside it, each by its path from the file's module.
    pub modules: BTreeMap<Segments, Scope>,
}

/// What stands in one module.
#[derive(Default)]
pub struct Scope {
    /// Names that a `use` brings, and the paths behind them.
    pub names: BTreeMap<String, Segments>,
    /// Paths that a `use` takes everything from.
    pub globs: Vec<Segments>,
    /// Items defined here.
    pub items: BTreeSet<String>,
    /// Paths of private imports and of code, with the line.
    pub mentions: Vec<Mention>,
}

/// A path that this module depends on, if it leads into another file of the crate.
pub struct Mention {
    pub line: usize,
    pub path: Segments,
}

impl Source {
    /// Reads a file; one that is no Rust fails the test that reads it.
    pub fn new(path: &str, text: &str) -> Self {
        let tokens: TokenStream = text
            .parse()
            .unwrap_or_else(|error| panic!("{path} cannot be read: {error}"));
        let mut modules = BTreeMap::new();
        scan(tokens, &[], true, &mut modules);
        modules.entry(Vec::new()).or_default();
        Self {
            path: path.to_owned(),
            modules,
        }
    }
}

const ITEMS: [&str; 10] = [
    "struct", "enum", "fn", "const", "static", "type", "trait", "union", "macro", "mod",
];

/// Reads tokens that stand in `module`; `top` says that items among them are the module's own.
fn scan(
    tokens: TokenStream,
    module: &[String],
    top: bool,
    modules: &mut BTreeMap<Segments, Scope>,
) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut public = false;
    let mut at = 0;
    while at < tokens.len() {
        let word = ident(&tokens, at);
        if is_punct(&tokens, at, '#') {
            at = attribute(&tokens, at);
            continue;
        }
        if word == "pub" {
            public = true;
            at += 1 + usize::from(group(&tokens, at + 1, Delimiter::Parenthesis).is_some());
            continue;
        }
        if word == "mod"
            && let Some(body) = group(&tokens, at + 2, Delimiter::Brace)
        {
            let inner: Segments = [module, &[ident(&tokens, at + 1)]].concat();
            scan(body, &inner, true, modules);
            at += 3;
        } else if word == "use" && !is_punct(&tokens, at + 1, '<') {
            let end = end_of(&tokens, at, true);
            let scope = modules.entry(module.to_vec()).or_default();
            import(&tokens[at + 1..end], &[], public, scope);
            at = end + 1;
        } else if ITEMS.contains(&word.as_str()) && !ident(&tokens, at + 1).is_empty() {
            if top {
                let scope = modules.entry(module.to_vec()).or_default();
                scope.items.insert(ident(&tokens, at + 1));
            }
            // `const fn` and the like name the item after the second word.
            at += if ITEMS.contains(&ident(&tokens, at + 1).as_str()) {
                1
            } else {
                2
            };
        } else if let TokenTree::Group(inner) = &tokens[at] {
            scan(inner.stream(), module, false, modules);
            at += 1;
        } else if let TokenTree::Ident(head) = &tokens[at] {
            at = mention(
                &tokens,
                at,
                head,
                modules.entry(module.to_vec()).or_default(),
            );
        } else {
            at += 1;
        }
        public = false;
    }
}

/// Where to go on after the attribute at `at`: behind the item, too, if the attribute keeps it to tests.
fn attribute(tokens: &[TokenTree], at: usize) -> usize {
    let inner = usize::from(is_punct(tokens, at + 1, '!'));
    let Some(body) = group(tokens, at + 1 + inner, Delimiter::Bracket) else {
        return at + 1;
    };
    let mut next = at + 2 + inner;
    if body.to_string().replace(' ', "") != "cfg(test)" {
        return next;
    }
    while is_punct(tokens, next, '#') {
        next = attribute(tokens, next);
    }
    end_of(tokens, next, ident(tokens, next) == "use") + 1
}

/// The place of the token that ends the item at `at`: its `;` or its braces.
fn end_of(tokens: &[TokenTree], at: usize, import: bool) -> usize {
    (at..tokens.len())
        .find(|&end| {
            is_punct(tokens, end, ';') || !import && group(tokens, end, Delimiter::Brace).is_some()
        })
        .unwrap_or(tokens.len())
}

/// `a::b`, `a::b as c`, `a::*`, `a::{…, …}`, in this module with `before` in front.
fn import(tokens: &[TokenTree], before: &[String], public: bool, scope: &mut Scope) {
    for branch in
        tokens.split(|token| matches!(token, TokenTree::Punct(comma) if comma.as_char() == ','))
    {
        let mut path = before.to_vec();
        let mut line = 0;
        let mut name = None;
        for (at, token) in branch.iter().enumerate() {
            match token {
                TokenTree::Ident(word) if word == "as" => {
                    name = Some(ident(branch, at + 1));
                    break;
                }
                TokenTree::Ident(word) => {
                    line = word.span().start().line;
                    // `{self}` names what stands before the braces.
                    if word != "self" || path.is_empty() {
                        path.push(word.to_string());
                    }
                }
                TokenTree::Punct(star) if star.as_char() == '*' => {
                    scope.globs.push(path.clone());
                    line = star.span().start().line;
                    name = Some(String::from("*"));
                }
                TokenTree::Group(inner) => {
                    let inner: Vec<TokenTree> = inner.stream().into_iter().collect();
                    import(&inner, &path, public, scope);
                    path.clear();
                }
                _ => {}
            }
        }
        let Some(last) = path.last().cloned() else {
            continue;
        };
        if !public {
            let path = path.clone();
            scope.mentions.push(Mention { line, path });
        }
        let name = name.unwrap_or(last);
        if name != "*" && name != "_" {
            scope.names.insert(name, path);
        }
    }
}

/// Notes the path that begins with `head`; returns the place behind it.
fn mention(tokens: &[TokenTree], at: usize, head: &Ident, scope: &mut Scope) -> usize {
    let mut path = vec![head.to_string()];
    let mut next = at + 1;
    while is_punct(tokens, next, ':')
        && is_punct(tokens, next + 1, ':')
        && !ident(tokens, next + 2).is_empty()
    {
        path.push(ident(tokens, next + 2));
        next += 3;
    }
    let after_dot = at > 0 && is_punct(tokens, at - 1, '.');
    let after_colons = at > 1 && is_punct(tokens, at - 1, ':') && is_punct(tokens, at - 2, ':');
    let lifetime = at > 0 && is_punct(tokens, at - 1, '\'');
    // A small word alone is a variable, unless it is called.
    let variable = path.len() == 1
        && path[0].starts_with(|letter: char| letter.is_lowercase())
        && group(tokens, next, Delimiter::Parenthesis).is_none()
        && !is_punct(tokens, next, '!');
    if !(after_dot || after_colons || lifetime || variable) {
        let line = head.span().start().line;
        scope.mentions.push(Mention { line, path });
    }
    next
}

fn ident(tokens: &[TokenTree], at: usize) -> String {
    match tokens.get(at) {
        Some(TokenTree::Ident(word)) => word.to_string(),
        _ => String::new(),
    }
}

fn is_punct(tokens: &[TokenTree], at: usize, sign: char) -> bool {
    matches!(tokens.get(at), Some(TokenTree::Punct(punct)) if punct.as_char() == sign)
}

fn group(tokens: &[TokenTree], at: usize, delimiter: Delimiter) -> Option<TokenStream> {
    match tokens.get(at) {
        Some(TokenTree::Group(group)) if group.delimiter() == delimiter => Some(group.stream()),
        _ => None,
    }
}
