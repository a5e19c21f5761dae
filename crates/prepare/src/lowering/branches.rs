//! Branches that are worth a jump.
//!
//! Shaders mark an `if` with `@branch` where its body is long and most lanes skip it. A GPU jumps
//! over it as it is. A CPU driver runs the body for no lane at all, masked, and jumps only at the
//! end of a loop: for it the statement becomes a loop that runs once.
//!
//! ```wgsl
//! @branch if (condition) { body }
//! // becomes
//! { var taken = condition; loop { if (!taken) { break; } taken = false; body } }
//! ```

use wesl::syntax::{Attribute, CompoundStatement, GlobalDeclaration, IfStatement, Statement, TranslationUnit};

use crate::syntax::each_statement;

/// Marks the statements: `@branch`.
const MARK: &str = "branch";

/// Replaces every marked `if` by a loop that runs once (`loops`), or removes the marks.
///
/// The error names a marked statement that no loop can replace: one with an `else`, or whose body
/// leaves an outer loop.
pub(crate) fn lower_branches(kernel: &mut TranslationUnit, loops: bool) -> Result<(), String> {
    let mut error = None;
    for declaration in &mut kernel.global_declarations {
        let GlobalDeclaration::Function(function) = declaration.node_mut() else { continue };
        let name = function.ident.to_string();
        each_statement(&mut function.body, &mut |statement| {
            let Statement::If(branch) = statement else { return };
            let Some(mark) = branch.attributes.iter().position(|a| is_mark(a.node())) else { return };
            branch.attributes.remove(mark);
            if !loops {
                return;
            }
            match looped(branch) {
                Ok(lowered) => *statement = lowered,
                Err(reason) => error = error.take().or(Some(format!("@branch in {name}: {reason}"))),
            }
        });
    }
    error.map_or(Ok(()), Err)
}

fn is_mark(attribute: &Attribute) -> bool {
    matches!(attribute, Attribute::Custom(custom) if custom.name == MARK)
}

fn looped(branch: &IfStatement) -> Result<Statement, &'static str> {
    if branch.else_clause.is_some() || !branch.else_if_clauses.is_empty() {
        return Err("it has an else");
    }
    if leaves_loop(&branch.if_clause.body) {
        return Err("its body leaves an outer loop");
    }
    let text = format!(
        "{{ var taken = {}; loop {{ if (!taken) {{ break; }} taken = false; }} }}",
        branch.if_clause.expression
    );
    let mut lowered: Statement = text.parse().map_err(|_| "its condition cannot be moved")?;
    let Statement::Compound(block) = &mut lowered else { return Err("it is no block") };
    let Some(Statement::Loop(once)) = block.statements.last_mut().map(|s| s.node_mut()) else {
        return Err("it is no loop");
    };
    once.body.statements.extend(branch.if_clause.body.statements.iter().cloned());
    Ok(lowered)
}

/// Whether a `break` or `continue` of the body belongs to a loop around it.
fn leaves_loop(body: &CompoundStatement) -> bool {
    body.statements.iter().any(|statement| match statement.node() {
        Statement::Break(_) | Statement::Continue(_) => true,
        Statement::Compound(inner) => leaves_loop(inner),
        Statement::If(inner) => {
            leaves_loop(&inner.if_clause.body)
                || inner.else_if_clauses.iter().any(|c| leaves_loop(&c.body))
                || inner.else_clause.as_ref().is_some_and(|c| leaves_loop(&c.body))
        }
        _ => false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lowered(body: &str, loops: bool) -> Result<String, String> {
        let mut kernel: TranslationUnit = format!("fn f(a: bool) {{ {body} }}").parse().unwrap();
        lower_branches(&mut kernel, loops)?;
        Ok(kernel.to_string().split_whitespace().collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn a_marked_if_becomes_a_loop_that_runs_once() {
        let text = lowered("@branch if (a) { g(); @branch if (b) { h(); } }", true).unwrap();
        assert_eq!(text.matches("loop").count(), 2, "{text}");
        assert!(!text.contains("@branch"), "{text}");
        assert!(text.contains("taken = false; g();"), "{text}");
        naga::front::wgsl::parse_str(&format!("{text} fn g() {{}} fn h() {{}} const b = true;")).unwrap();
    }

    #[test]
    fn elsewhere_the_mark_goes() {
        let text = lowered("@branch if (a) { g(); } if (a) { h(); }", false).unwrap();
        assert_eq!(
            (text.matches("if").count(), text.contains("loop"), text.contains('@')),
            (2, false, false),
            "{text}"
        );
        assert!(lowered("if (a) { h(); }", true).unwrap().contains("if (a)"));
    }

    #[test]
    fn a_body_that_leaves_an_outer_loop_is_refused() {
        for body in ["@branch if (a) { g(); } else { h(); }", "loop { @branch if (a) { if (a) { break; } } }"] {
            assert!(lowered(body, true).unwrap_err().contains("@branch in f"), "{body}");
        }
        assert!(lowered("loop { @branch if (a) { loop { break; } return; } }", true).is_ok());
    }
}
