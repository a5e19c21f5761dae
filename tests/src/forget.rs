//! Shader sources without the code of a feature.
//!
//! Everything under the feature's condition is removed from the text, by an implementation that
//! shares nothing with the one that composes kernels: if a scene lacks the feature, both must give
//! the same kernel.

/// The source without the code that only kernels with `feature` have; conditions that name it among
/// others get `false` in its place.
pub fn forget(source: &str, feature: &str) -> String {
    let mut out = String::new();
    let mut rest = source;
    // The state of the current chain of @if, @elif and @else.
    let mut chain = Chain::Open;
    while let Some(at) = next_attribute(rest) {
        out += &rest[..at];
        let (word, condition, after) = attribute(&rest[at..]);
        let after_node = &after[node_length(after)..];
        let node = &after[..after.len() - after_node.len()];
        let first = word == "@if";
        if first {
            chain = Chain::Open;
        }
        let value = condition.map_or(Some(true), |c| evaluate(c, feature));
        let keep = |out: &mut String, attribute: String| {
            *out += &attribute;
            *out += &forget(node, feature);
        };
        match (chain, value) {
            (Chain::Decided, _) | (_, Some(false)) => {}
            (Chain::Open, Some(true)) => {
                keep(&mut out, String::new());
                chain = Chain::Decided;
            }
            (Chain::Kept, Some(true)) => {
                keep(&mut out, "@else ".into());
                chain = Chain::Decided;
            }
            (state, None) => {
                let word = if state == Chain::Open { "@if" } else { "@elif" };
                let condition = replaced(condition.unwrap_or_default(), feature);
                keep(&mut out, format!("{word}({condition}) "));
                chain = Chain::Kept;
            }
        }
        rest = after_node;
    }
    out + rest
}

/// A chain of conditions so far.
#[derive(Clone, Copy, PartialEq)]
enum Chain {
    /// Nothing of it is kept.
    Open,
    /// Something is kept that may or may not hold.
    Kept,
    /// A condition is certainly true: the following branches are dead.
    Decided,
}

/// The position of the next `@if`, `@elif` or `@else`, outside of comments.
fn next_attribute(text: &str) -> Option<usize> {
    let mut from = 0;
    loop {
        let found = ["@if", "@elif", "@else", "//"].iter().filter_map(|w| text[from..].find(w)).min()? + from;
        if !text[found..].starts_with("//") {
            return Some(found);
        }
        from = found + text[found..].find('\n')?;
    }
}

/// The attribute's word, its condition, and the rest.
fn attribute(text: &str) -> (&str, Option<&str>, &str) {
    let word = &text[..1 + text[1..].find(|c: char| !c.is_alphabetic()).unwrap_or(text.len() - 1)];
    let rest = text[word.len()..].trim_start();
    if word == "@else" {
        return (word, None, rest);
    }
    let end = closing(rest, '(', ')');
    (word, Some(&rest[1..end - 1]), rest[end..].trim_start())
}

/// Bytes up to the bracket that closes the one at the beginning.
fn closing(text: &str, open: char, close: char) -> usize {
    let mut depth = 0usize;
    for (at, c) in text.char_indices() {
        if c == open {
            depth += 1;
        } else if c == close {
            depth -= 1;
            if depth == 0 {
                return at + c.len_utf8();
            }
        }
    }
    text.len()
}

/// Bytes of the declaration, statement, field or parameter at the beginning.
fn node_length(text: &str) -> usize {
    let mut at = 0;
    let mut depth = 0usize;
    // An import lists names in braces and ends with its semicolon; a declaration with a value may
    // hold commas in its call.
    let is_import = text.starts_with("import");
    while let Some(c) = text[at..].chars().next() {
        match c {
            '/' if text[at..].starts_with("//") => {
                at += text[at..].find('\n').unwrap_or(text.len() - at);
                continue;
            }
            '{' if depth == 0 && !is_import => {
                at += closing(&text[at..], '{', '}');
                let next = text[at..].trim_start();
                // `if (…) {…} else {…}` is one statement.
                let goes_on = next.starts_with("else");
                if !goes_on {
                    return at;
                }
                continue;
            }
            '<' if opens_parameters(text, at) => {
                at += closing(&text[at..], '<', '>');
                continue;
            }
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' if depth == 0 => return at,
            ')' | ']' | '}' => depth -= 1,
            ';' | ',' if depth == 0 => return at + 1,
            _ => {}
        }
        at += c.len_utf8();
    }
    at
}

/// Whether the `<` there begins parameters of a type, as in `ptr<function, T>`: comparisons and
/// shifts have space around them.
fn opens_parameters(text: &str, at: usize) -> bool {
    text[..at].ends_with(char::is_alphanumeric) && text[at + 1..].starts_with(char::is_alphabetic)
}

/// A condition with the feature off; `None` where others decide.
fn evaluate(condition: &str, feature: &str) -> Option<bool> {
    let condition = condition.trim();
    if let Some(parts) = split(condition, "||") {
        let values: Vec<_> = parts.iter().map(|p| evaluate(p, feature)).collect();
        return if values.contains(&Some(true)) {
            Some(true)
        } else {
            values.iter().all(|v| *v == Some(false)).then_some(false)
        };
    }
    if let Some(parts) = split(condition, "&&") {
        let values: Vec<_> = parts.iter().map(|p| evaluate(p, feature)).collect();
        return if values.contains(&Some(false)) {
            Some(false)
        } else {
            values.iter().all(|v| *v == Some(true)).then_some(true)
        };
    }
    if let Some(rest) = condition.strip_prefix('!') {
        return evaluate(rest, feature).map(|v| !v);
    }
    if condition.starts_with('(') && closing(condition, '(', ')') == condition.len() {
        return evaluate(&condition[1..condition.len() - 1], feature);
    }
    (condition == feature).then_some(false)
}

/// Operands of an operator outside of parentheses; `None` where there is none.
fn split<'a>(text: &'a str, operator: &str) -> Option<Vec<&'a str>> {
    let (mut parts, mut depth, mut from) = (Vec::new(), 0, 0);
    for (at, c) in text.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            _ if depth == 0 && at >= from && text[at..].starts_with(operator) => {
                parts.push(&text[from..at]);
                from = at + operator.len();
            }
            _ => {}
        }
    }
    (!parts.is_empty()).then(|| {
        parts.push(&text[from..]);
        parts
    })
}

/// The condition with `false` for the feature's name.
fn replaced(condition: &str, feature: &str) -> String {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut out = String::new();
    let mut rest = condition;
    while let Some(start) = rest.find(is_name) {
        let length = rest[start..].find(|c| !is_name(c)).unwrap_or(rest.len() - start);
        let name = &rest[start..start + length];
        out += &rest[..start];
        out += if name == feature { "false" } else { name };
        rest = &rest[start + length..];
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_under_a_feature_is_removed() {
        for (source, forgotten) in [
            ("a; @if(f) { b; { c; } } d;", "a;  d;"),
            ("@if(f) let x = g(1, 2); e;", " e;"),
            ("struct S { a: u32, @if(f) b: u32, c: u32 }", "struct S { a: u32,  c: u32 }"),
            ("fn g(a: u32, @if(f) b: u32) {}", "fn g(a: u32, ) {}"),
            ("fn g(a: u32, @if(f) b: ptr<function, array<u32, 2>>) {}", "fn g(a: u32, ) {}"),
            ("@if(f) var<storage, read> a: u32; b;", " b;"),
            ("@if(f) x(a < b, c > d); y;", " y;"),
            ("@if(!f) x(); @else y();", "x(); "),
            ("@if(f) x(); @else y();", " y();"),
            ("@if(f) x(); @elif(g) y(); @else z();", " @if(g) y(); @else z();"),
            ("@if(g) x(); @elif(f) y(); @else z();", "@if(g) x();  @else z();"),
            ("@if(f || g) x();", "@if(false || g) x();"),
            ("@if(f && g) x();", ""),
            ("@if(g) { @if(f) a(); b(); }", "@if(g) {  b(); }"),
            ("@if(f) if (a) { b(); } else { c(); } d();", " d();"),
            ("// @if(f) stays\n@if(f) fn g() {}\nh", "// @if(f) stays\n\nh"),
            ("@if(f) import package::a::{b, c};\nd", "\nd"),
            ("@if(ff) a();", "@if(ff) a();"),
        ] {
            assert_eq!(forget(source, "f"), forgotten, "{source}");
        }
    }
}
