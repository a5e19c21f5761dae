//! Visits of the statements and expressions of a WGSL function.

use wesl::syntax::{CompoundStatement, Expression, Statement};

/// Calls `f` on every statement, inner ones first.
pub fn each_statement(block: &mut CompoundStatement, f: &mut impl FnMut(&mut Statement)) {
    for statement in &mut block.statements {
        let statement = statement.node_mut();
        for inner in blocks(statement) {
            each_statement(inner, f);
        }
        f(statement);
    }
}

/// Calls `f` on every expression, operands first.
pub fn each_expression(block: &mut CompoundStatement, f: &mut impl FnMut(&mut Expression)) {
    each_statement(block, &mut |statement| {
        for expression in expressions(statement) {
            visit(expression, f);
        }
    });
}

/// The blocks within a statement.
fn blocks(statement: &mut Statement) -> Vec<&mut CompoundStatement> {
    match statement {
        Statement::Compound(s) => vec![s],
        Statement::If(s) => {
            let mut all = vec![&mut s.if_clause.body];
            all.extend(s.else_if_clauses.iter_mut().map(|c| &mut c.body));
            all.extend(s.else_clause.as_mut().map(|c| &mut c.body));
            all
        }
        Statement::Switch(s) => s.clauses.iter_mut().map(|c| &mut c.body).collect(),
        Statement::Loop(s) => {
            let mut all = vec![&mut s.body];
            all.extend(s.continuing.as_mut().map(|c| &mut c.body));
            all
        }
        Statement::For(s) => vec![&mut s.body],
        Statement::While(s) => vec![&mut s.body],
        _ => Vec::new(),
    }
}

/// The expressions of a statement itself.
fn expressions(statement: &mut Statement) -> Vec<&mut Expression> {
    match statement {
        Statement::Assignment(s) => vec![s.lhs.node_mut(), s.rhs.node_mut()],
        Statement::Increment(s) => vec![s.expression.node_mut()],
        Statement::Decrement(s) => vec![s.expression.node_mut()],
        Statement::If(s) => {
            let mut all = vec![s.if_clause.expression.node_mut()];
            all.extend(s.else_if_clauses.iter_mut().map(|c| c.expression.node_mut()));
            all
        }
        Statement::Switch(s) => vec![s.expression.node_mut()],
        Statement::Loop(s) => {
            let end = s.continuing.as_mut().and_then(|c| c.break_if.as_mut());
            end.map(|b| b.expression.node_mut()).into_iter().collect()
        }
        Statement::For(s) => {
            let mut all: Vec<_> = s.condition.as_mut().map(|c| c.node_mut()).into_iter().collect();
            for part in [&mut s.initializer, &mut s.update].into_iter().flatten() {
                all.extend(expressions(part.node_mut()));
            }
            all
        }
        Statement::While(s) => vec![s.condition.node_mut()],
        Statement::Return(s) => s.expression.as_mut().map(|e| e.node_mut()).into_iter().collect(),
        Statement::FunctionCall(s) => s.call.arguments.iter_mut().map(|a| a.node_mut()).collect(),
        Statement::Declaration(s) => s.initializer.as_mut().map(|e| e.node_mut()).into_iter().collect(),
        _ => Vec::new(),
    }
}

fn visit(expression: &mut Expression, f: &mut impl FnMut(&mut Expression)) {
    match expression {
        Expression::Parenthesized(e) => visit(e.expression.node_mut(), f),
        Expression::NamedComponent(e) => visit(e.base.node_mut(), f),
        Expression::Indexing(e) => {
            visit(e.base.node_mut(), f);
            visit(e.index.node_mut(), f);
        }
        Expression::Unary(e) => visit(e.operand.node_mut(), f),
        Expression::Binary(e) => {
            visit(e.left.node_mut(), f);
            visit(e.right.node_mut(), f);
        }
        Expression::FunctionCall(e) => {
            for argument in &mut e.arguments {
                visit(argument.node_mut(), f);
            }
        }
        Expression::Literal(_) | Expression::TypeOrIdentifier(_) => {}
    }
    f(expression);
}
