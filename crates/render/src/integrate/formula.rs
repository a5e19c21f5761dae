//! A user's formula: checked to be one expression, so that nothing else enters the shader.

use naga::valid::{Capabilities, ValidationFlags, Validator};

/// Maximum number of dimensions of an integral.
pub const MAX_DIMENSIONS: usize = surelight_prepare::shared::MAX_DIMENSIONS as usize;

/// Maximum length of a formula, in bytes.
const LONGEST: usize = 1024;

/// Maximum nesting depth of brackets.
const DEEPEST: usize = 64;

/// Numbers that formulas may use by name.
const CONSTANTS: &str =
    "const pi: f32 = 3.14159265358979;\nconst tau: f32 = 6.28318530717959;\nconst e: f32 = 2.71828182845905;\n";

/// Letters for the first dimensions, beside `x0`, `x1`, ….
const LETTERS: [&str; 4] = ["x", "y", "z", "w"];

/// A scalar expression in WGSL over a number of variables.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Formula {
    text: String,
    dimensions: usize,
}

/// A mistake in a formula.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FormulaError {
    /// No expression.
    #[error("the formula is empty")]
    Empty,
    /// Too long or too deeply nested to compile.
    #[error("the formula is {0}")]
    Size(&'static str),
    /// Text that no expression contains.
    #[error(
        "the formula has '{found}' at column {column}: only one expression is allowed, without declarations, loops or comments"
    )]
    Forbidden {
        /// Counted from 1, in characters.
        column: usize,
        /// The text there.
        found: String,
    },
    /// Brackets that do not match.
    #[error("the formula's bracket '{bracket}' at column {column} has no partner")]
    Bracket {
        /// Counted from 1, in characters.
        column: usize,
        /// The bracket.
        bracket: char,
    },
    /// The message of the WGSL compiler.
    #[error("the formula is not valid WGSL at column {column}{near}: {message}")]
    Wgsl {
        /// Counted from 1, in characters.
        column: usize,
        /// The text there, as " ('…')".
        near: String,
        /// The compiler's message.
        message: String,
    },
    /// More or fewer dimensions than there are variables for.
    #[error("an integral has 1 to 10 dimensions, not {0}")]
    Dimensions(usize),
}

impl Formula {
    /// Parses and validates an expression over `dimensions` variables: `x0` … `x9`, the first four
    /// also `x`, `y`, `z`, `w`.
    ///
    /// # Errors
    /// With the column in `text`, where the error has one.
    pub fn new(text: &str, dimensions: usize) -> Result<Self, FormulaError> {
        if !(1..=MAX_DIMENSIONS).contains(&dimensions) {
            return Err(FormulaError::Dimensions(dimensions));
        }
        if text.trim().is_empty() {
            return Err(FormulaError::Empty);
        }
        if text.len() > LONGEST {
            return Err(FormulaError::Size("longer than 1024 bytes"));
        }
        only_expression(text)?;
        let formula = Self { text: text.to_owned(), dimensions };
        formula.validate()?;
        Ok(formula)
    }

    /// The expression as it was given.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Variables.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// The source of the module `package::integrand`, and the offset of the expression in it.
    pub(super) fn module(&self) -> (String, usize) {
        let mut source = format!("{CONSTANTS}fn integrand(point_of_the_box: array<f32, 10>) -> f32 {{\n");
        for i in 0..self.dimensions {
            source += &format!("    let x{i} = point_of_the_box[{i}];\n");
            if let Some(letter) = LETTERS.get(i) {
                source += &format!("    let {letter} = point_of_the_box[{i}];\n");
            }
        }
        source += "    return ";
        let start = source.len();
        source += &self.text;
        source += ";\n}\n";
        (source, start)
    }

    fn validate(&self) -> Result<(), FormulaError> {
        let (source, start) = self.module();
        let module = naga::front::wgsl::parse_str(&source).map_err(|error| {
            let span = error.labels().next().and_then(|(span, _)| span.to_range());
            let labels: Vec<_> = error.labels().map(|(_, label)| label).filter(|label| !label.is_empty()).collect();
            let mut message = error.message().to_owned();
            if !labels.is_empty() && !message.contains(labels[0]) {
                message += &format!(" ({})", labels[0]);
            }
            self.wgsl_error(span, start, message)
        })?;
        // The expression must not have added a declaration.
        if module.functions.len() != 1 || !module.global_variables.is_empty() || !module.entry_points.is_empty() {
            return Err(FormulaError::Forbidden { column: 1, found: self.text.clone() });
        }
        let validated = Validator::new(ValidationFlags::all(), Capabilities::default()).validate(&module);
        validated.map(drop).map_err(|error| {
            let span = error.spans().next().and_then(|(span, _)| span.to_range());
            let mut message = error.as_inner().to_string();
            let mut cause = std::error::Error::source(error.as_inner());
            while let Some(inner) = cause {
                message = inner.to_string();
                cause = inner.source();
            }
            if message.contains("declared return type") {
                message = "the value is not a number: f32(…) makes one of a condition, .x of a vector".into();
            }
            self.wgsl_error(span, start, message)
        })
    }

    fn wgsl_error(&self, span: Option<std::ops::Range<usize>>, start: usize, mut message: String) -> FormulaError {
        let range = span.unwrap_or(start..start);
        let begin = range.start.saturating_sub(start).min(self.text.len());
        let end = range.end.saturating_sub(start).clamp(begin, self.text.len());
        let before = self.text.get(..begin).unwrap_or("");
        let found = self.text.get(begin..end).unwrap_or("");
        // The compiler reports on the statement around the expression.
        message = message.replace("expected `;`", "expected an operator or the end").replace(" (see msg)", "");
        let near = match found {
            "" if begin == self.text.len() => {
                message = message.replace("found \";\"", "found nothing");
                " (its end)".to_owned()
            }
            "" => String::new(),
            found => format!(" ('{found}')"),
        };
        if let Some(i) = LETTERS.iter().position(|&l| l == found).or_else(|| found.strip_prefix('x')?.parse().ok())
            && i >= self.dimensions
        {
            message += &format!("; it is variable number {}, and the box has {} dimension(s)", i + 1, self.dimensions);
        }
        FormulaError::Wgsl { column: before.chars().count() + 1, near, message }
    }
}

/// Refuses all that could end the expression or begin another construct: statements, blocks,
/// attributes, comments, unmatched brackets.
fn only_expression(text: &str) -> Result<(), FormulaError> {
    let characters: Vec<char> = text.chars().collect();
    let mut open: Vec<(char, usize)> = Vec::new();
    let mut operators = 0;
    for (i, &c) in characters.iter().enumerate() {
        let column = i + 1;
        let forbidden = |found: String| Err(FormulaError::Forbidden { column, found });
        match (c, characters.get(i + 1)) {
            (';' | '{' | '}' | '@' | '#' | '"' | '`' | '\\' | '\'' | '$', _) => return forbidden(c.to_string()),
            ('/', Some(&next @ ('/' | '*'))) => return forbidden(format!("/{next}")),
            // WESL's paths into the renderer's own modules.
            (':', Some(':')) => return forbidden("::".into()),
            _ if c != ' ' && (c.is_control() || c.is_whitespace()) => return forbidden(c.escape_unicode().to_string()),
            ('(' | '[', _) => open.push((c, column)),
            (')' | ']', _) => {
                let partner = if c == ')' { '(' } else { '[' };
                if open.pop().is_none_or(|(found, _)| found != partner) {
                    return Err(FormulaError::Bracket { column, bracket: c });
                }
            }
            _ => {}
        }
        operators = if matches!(c, '-' | '!' | '~' | '&' | '*') {
            operators + 1
        } else if c == ' ' {
            operators
        } else {
            0
        };
        if operators > DEEPEST {
            return Err(FormulaError::Size("a chain of more than 64 operators"));
        }
        if open.len() > DEEPEST {
            return Err(FormulaError::Size("nested more than 64 brackets deep"));
        }
    }
    match open.pop() {
        Some((bracket, column)) => Err(FormulaError::Bracket { column, bracket }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_of_every_dimension_are_taken() {
        for (text, dimensions) in [
            ("5*pow(x,4)", 1),
            ("5*pow(x,4.0)", 1),
            ("1", 1),
            ("f32(x*x + y*y < 1)", 2),
            ("select(0.0, 1.0, x + y < 1)", 2),
            ("exp(-dot(vec4f(x,y,z,w), vec4f(x0,x1,x2,x3))) * x5", 6),
            ("sin(pi * x9) + e - tau", 10),
            ("array<f32, 2>(1.0, 2.0)[u32(x)]", 1),
            ("-x", 1),
        ] {
            assert!(Formula::new(text, dimensions).is_ok(), "{text}: {:?}", Formula::new(text, dimensions));
        }
    }

    #[test]
    fn mistakes_are_reported_with_their_column() {
        for (text, column, words) in [
            ("5*pow(x,4", 6, "partner"),
            ("x)+(x", 2, "partner"),
            ("x + foo", 5, "foo"),
            ("x + y", 5, "variable number 2"),
            ("1 + x7*2", 5, "variable number 8"),
            ("x; loop", 2, "only one expression"),
            ("x // y", 3, "only one expression"),
            ("x /* y", 3, "only one expression"),
            ("x + package::core", 12, "only one expression"),
            ("é + 1 }", 7, "only one expression"),
            ("x > 0.5", 1, "f32("),
            ("vec2f(x, x)", 1, "not a number"),
            ("1/0", 1, "ivision by zero"),
            ("pow(x)", 1, ""),
            ("x +", 4, "found nothing"),
            ("x = 2", 3, "operator"),
            ("1, 2", 2, "operator"),
            ("integrand(point_of_the_box)", 1, ""),
        ] {
            let error = Formula::new(text, 1).expect_err(text);
            let message = error.to_string();
            assert!(message.contains(words), "{text}: {message}");
            match error {
                FormulaError::Forbidden { column: found, .. }
                | FormulaError::Bracket { column: found, .. }
                | FormulaError::Wgsl { column: found, .. } => assert_eq!(found, column, "{text}: {message}"),
                other => panic!("{text}: {other:?}"),
            }
        }
    }

    #[test]
    fn sizes_are_bounded() {
        assert_eq!(Formula::new("  ", 1), Err(FormulaError::Empty));
        assert_eq!(Formula::new("x", 11), Err(FormulaError::Dimensions(11)));
        assert!(matches!(Formula::new(&"x+".repeat(3000), 1), Err(FormulaError::Size(_))));
        let deep = format!("{}x{}", "(".repeat(65), ")".repeat(65));
        assert!(matches!(Formula::new(&deep, 1), Err(FormulaError::Size(_))));
        let fine = format!("{}x{}", "(".repeat(64), ")".repeat(64));
        assert!(Formula::new(&fine, 1).is_ok());
        // Compilers recurse into operators: a long chain must not exhaust the stack.
        assert!(matches!(Formula::new(&format!("{}x", "- ".repeat(65)), 1), Err(FormulaError::Size(_))));
        assert!(Formula::new(&format!("x{}", "+x".repeat(500)), 1).is_ok());
    }
}
