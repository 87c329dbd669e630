// SPDX-License-Identifier: Apache-2.0
//! The one main or federated reactor.

use super::checker::Checker;
use super::load::Program;
use super::model::{Class, ClassId};
use crate::characters::shown;
use crate::diagnostics::{Code, Diagnostic, FileId, Span};
use crate::syntax::ast::ReactorKind;

/// Returns the last part of a path without its extension.
pub(super) fn file_stem(path: &str) -> &str {
    let name = path.rsplit('/').next().unwrap_or(path);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

/// Returns the name of a program: that of its main file.
pub(crate) fn program_name(program: &Program) -> &str {
    program.units.first().map_or("", |unit| file_stem(&unit.path))
}

/// The maximum length of a main file's name without its extension: systems accept up to 255 bytes for a file name.
const NAME_MAX: usize = 120;

/// Reports a name of the main file that folders, packages and build files cannot have.
fn check_name(checker: &mut Checker<'_>) {
    let name = program_name(checker.program);
    let is_usual = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.');
    let what = if let Some(strange) = name.chars().find(|c| !is_usual(*c)) {
        let shown = if strange == ' ' { "a space".to_owned() } else { shown(strange) };
        format!("has {shown} in it")
    } else if !name.starts_with(|first: char| first.is_alphanumeric() || first == '_') {
        "does not begin with a letter, a digit or `_`".to_owned()
    } else if name.len() > NAME_MAX {
        format!("is longer than {NAME_MAX} bytes")
    } else {
        return;
    };
    let message = format!("the name of this file {what}, and folders and programs are called like it");
    let hint = "rename it: letters, digits, `_`, `-` and `.` can be in it";
    checker.report(Diagnostic::new(Code::FileName, Span::default(), message).hint(hint));
}

/// Returns the position of the main or federated reactor of the main file.
pub(super) fn find(checker: &mut Checker<'_>, classes: &[Class<'_>]) -> Option<ClassId> {
    check_name(checker);
    let is_main = |class: &Class<'_>| class.id.unit == 0 && class.ast.kind != ReactorKind::Plain;
    let mut mains = classes.iter().enumerate().filter(|(_, class)| is_main(class));
    let Some((first, main)) = mains.next() else {
        // A reactor without a name is probably the main one, and has been reported.
        if classes.iter().any(|class| class.id.unit == 0 && class.ast.name.is_none()) {
            return None;
        }
        let span = Span::new(FileId::default(), 0, 0);
        let diagnostic = Diagnostic::new(Code::NoMain, span, "there is no main reactor in this file")
            .hint("write `main reactor { … }`, or `federated reactor { … }` for a federation");
        checker.report(diagnostic);
        return None;
    };
    let others: Vec<_> = mains.map(|(_, class)| class.ast.keyword).collect();
    for other in &others {
        let diagnostic = Diagnostic::new(Code::SeveralMains, *other, "a program has one main or federated reactor")
            .also(main.ast.keyword, "the first one")
            .hint("make the other one a plain reactor, or put it into a file of its own");
        checker.report(diagnostic);
    }
    let word = if main.ast.kind == ReactorKind::Main { "main" } else { "federated" };
    for port in &main.ports {
        let message = format!("a {word} reactor has no inputs or outputs, because nothing contains it");
        let hint = "put the port into a contained reactor";
        checker.report(Diagnostic::new(Code::MainWithPorts, port.name.span, message).hint(hint));
    }
    for parameter in main.parameters.iter().filter(|parameter| parameter.default.is_none()) {
        let message = format!("parameter `{}` of the {word} reactor has no value", parameter.name.text);
        let hint = format!("give it a default: `{}: T = …`", parameter.name.text);
        checker.report(Diagnostic::new(Code::MissingValue, parameter.name.span, message).hint(hint));
    }
    for class in classes.iter().filter(|class| class.ast.kind != ReactorKind::Plain) {
        let users = classes.iter().flat_map(|class| &class.children);
        for user in users.filter(|user| user.class.is_some_and(|used| classes[used.0].id == class.id)) {
            let message = format!("`{}` is a {word} reactor, which nothing can contain", class.name);
            let diagnostic = Diagnostic::new(Code::UnknownReactor, user.ast.class.span, message)
                .hint("make it a plain reactor and contain it in a new main reactor");
            checker.report(diagnostic);
        }
    }
    others.is_empty().then_some(ClassId(first))
}
