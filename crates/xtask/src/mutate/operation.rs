//! Operations on the syntax tree of a shader module.

use surelight_prepare::syntax::{each_expression, each_statement};
use wesl::syntax::{
    AssignmentOperator, CompoundStatement, Expression, ExpressionNode, GlobalDeclaration, Statement, TranslationUnit,
};

/// A change of one declaration: a function, or a constant of the module.
///
/// Expressions are compared as syntax, so that formatting does not matter. An operation that applies nowhere, or
/// at more than one place, is an error.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Operation {
    /// An expression becomes another.
    Replace(&'static str, &'static str),
    /// The variable, constant or field gets another value where it is declared or assigned with `=`.
    Set(&'static str, &'static str),
    /// The function returns another value.
    Return(&'static str),
    /// The assignment to the variable or field is removed.
    Remove(&'static str),
}

impl Operation {
    /// The module with the operation applied to its declaration of this name; of several under different
    /// conditions, to one. The rest of the text stays.
    pub(crate) fn apply(self, module: &str, declaration: &str) -> Result<String, String> {
        let mut unit: TranslationUnit = module.parse().map_err(|e| format!("it does not parse: {e}"))?;
        let (mut places, mut found, mut text) = (0, false, module.to_owned());
        for node in &mut unit.global_declarations {
            let span = node.span().range();
            let changed = match node.node_mut() {
                GlobalDeclaration::Function(f) if *f.ident.name() == declaration => self.in_function(&mut f.body)?,
                GlobalDeclaration::Declaration(d) if *d.ident.name() == declaration => match (self, &mut d.initializer)
                {
                    (Self::Set(name, to), Some(value)) if name == declaration => {
                        *value = expression(to)?.into();
                        1
                    }
                    _ => 0,
                },
                _ => continue,
            };
            found = true;
            places += changed;
            if changed == 1 {
                text.replace_range(span, &node.to_string());
            }
        }
        match (found, places) {
            (false, _) => Err(format!("it has no {declaration}")),
            (true, 1) => Ok(text),
            (true, n) => Err(format!("{self:?} applies {n} times in {declaration}, not once")),
        }
    }

    fn in_function(self, body: &mut CompoundStatement) -> Result<u32, String> {
        let mut places = 0;
        match self {
            Self::Replace(of, by) => {
                let (of, by) = (expression(of)?.to_string(), expression(&format!("({by})"))?);
                each_expression(body, &mut |e| {
                    if e.to_string() == of {
                        places += 1;
                        *e = by.clone();
                    }
                });
            }
            Self::Set(name, to) => {
                let to = expression(to)?;
                let mut set = |value: &mut ExpressionNode| {
                    places += 1;
                    *value = to.clone().into();
                };
                each_statement(body, &mut |statement| match statement {
                    Statement::Declaration(d) if *d.ident.name() == name => d.initializer.iter_mut().for_each(&mut set),
                    Statement::Assignment(a) if is_set(a.operator, &a.lhs, name) => set(&mut a.rhs),
                    _ => {}
                });
            }
            Self::Return(to) => {
                let to = expression(to)?;
                each_statement(body, &mut |statement| {
                    if let Statement::Return(returned) = statement {
                        places += 1;
                        returned.expression = Some(to.clone().into());
                    }
                });
            }
            Self::Remove(name) => each_statement(body, &mut |statement| {
                if matches!(statement, Statement::Assignment(a) if is_set(a.operator, &a.lhs, name)) {
                    places += 1;
                    *statement = Statement::Compound(CompoundStatement::default());
                }
            }),
        }
        Ok(places)
    }
}

/// Whether an assignment with `=` is to the variable or field that is written so.
fn is_set(operator: AssignmentOperator, lhs: &ExpressionNode, name: &str) -> bool {
    operator == AssignmentOperator::Equal
        && lhs.to_string() == expression(name).map_or_else(|_| name.into(), |e| e.to_string())
}

fn expression(text: &str) -> Result<Expression, String> {
    text.parse().map_err(|e| format!("{text}: {e}"))
}

#[cfg(test)]
mod tests {
    use super::Operation::{self, Remove, Replace, Return, Set};

    const MODULE: &str = "const N: u32 = 4u;
        fn f(a: f32) -> f32 { var b = a; b = a * 2.0; if (b > 1.0) { (*p).x = b; } return b; }";

    fn applied(operation: Operation, declaration: &str) -> Result<String, String> {
        operation.apply(MODULE, declaration).map(|text| text.split_whitespace().collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn operations_change_one_place() {
        for (operation, declaration, part) in [
            (Replace("a*2.0", "a + 1.0"), "f", "b = (a + 1.0);"),
            (Set("(*p).x", "0.0"), "f", "(*p).x = 0.0;"),
            (Return("a"), "f", "return a;"),
            (Set("N", "8u"), "N", "const N: u32 = 8u;"),
        ] {
            let text = applied(operation, declaration).unwrap();
            assert!(text.contains(part), "{operation:?}: {text}");
        }
        assert!(!applied(Remove("(*p).x"), "f").unwrap().contains("(*p).x"));
    }

    #[test]
    fn an_operation_that_applies_nowhere_or_twice_is_an_error() {
        for (operation, declaration) in [
            (Replace("a", "b"), "f"),
            (Set("b", "1.0"), "f"),
            (Remove("c"), "f"),
            (Return("a"), "g"),
            (Return("1u"), "N"),
        ] {
            assert!(applied(operation, declaration).is_err(), "{operation:?}");
        }
    }
}
