// SPDX-License-Identifier: Apache-2.0
//! Checked reactors: the syntax tree with its names resolved.

use std::collections::BTreeMap;

use super::expand::TypeArgument;
pub(crate) use super::load::ReactorId;
use crate::diagnostics::Span;
use crate::lexical::Language;
use crate::syntax::ast;

/// The position of a checked reactor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct ClassId(pub(crate) usize);

/// A checked reactor, with types instead of its type parameters.
#[derive(Debug)]
pub(crate) struct Class<'p> {
    pub(crate) id: ReactorId,
    /// The language of its bodies, types and values.
    pub(crate) language: Language,
    pub(crate) types: &'p [TypeArgument],
    /// Further files in which names of its code may be declared.
    pub(crate) files: &'p [usize],
    /// The reactors whose declarations `types` may name.
    pub(crate) users: Vec<ClassId>,
    pub(crate) ast: &'p ast::Reactor,
    pub(crate) name: String,
    pub(crate) parameters: Vec<CheckedParameter<'p>>,
    pub(crate) states: Vec<CheckedState<'p>>,
    pub(crate) ports: Vec<CheckedPort<'p>>,
    pub(crate) timers: Vec<&'p ast::Timer>,
    pub(crate) actions: Vec<CheckedAction<'p>>,
    pub(crate) methods: Vec<CheckedMethod<'p>>,
    pub(crate) children: Vec<CheckedChild<'p>>,
    pub(crate) connections: Vec<CheckedConnection<'p>>,
    pub(crate) reactions: Vec<CheckedReaction<'p>>,
}

impl Class<'_> {
    /// Returns the declaration of a port as this reactor sees it, as far as it is known.
    pub(crate) fn port<'c>(&'c self, port: PortRef, classes: &'c [Class<'_>]) -> Option<&'c CheckedPort<'c>> {
        match port {
            PortRef::Own(port) => self.ports.get(port),
            PortRef::Child(child, port) => classes[self.children.get(child)?.class?.0].ports.get(port),
        }
    }

    /// Returns the language of a port as this reactor sees it.
    pub(crate) fn language_at(&self, port: PortRef, classes: &[Class<'_>]) -> Language {
        let child = match port {
            PortRef::Own(_) => None,
            PortRef::Child(child, _) => self.children.get(child).and_then(|child| child.class),
        };
        child.map_or(self.language, |ClassId(class)| classes[class].language)
    }

    /// Returns whether a port as this reactor sees it has several channels: a multiport, or one of a bank.
    pub(crate) fn is_wide(&self, port: PortRef, classes: &[Class<'_>]) -> bool {
        self.is_of_bank(port) || self.port(port, classes).is_some_and(|port| port.width.is_some())
    }

    /// Returns whether a port belongs to each member of a bank.
    pub(crate) fn is_of_bank(&self, port: PortRef) -> bool {
        match port {
            PortRef::Own(_) => false,
            PortRef::Child(child, _) => self.children[child].ast.width.is_some(),
        }
    }
}

/// A parameter with its type.
#[derive(Debug)]
pub(crate) struct CheckedParameter<'p> {
    pub(crate) name: &'p ast::Name,
    /// The type in the target language's spelling.
    pub(crate) ty: String,
    pub(crate) ty_span: Span,
    pub(crate) is_time: bool,
    pub(crate) default: Option<&'p ast::Expression>,
}

/// A state variable with its type.
#[derive(Debug)]
pub(crate) struct CheckedState<'p> {
    pub(crate) name: &'p ast::Name,
    pub(crate) ty: String,
    pub(crate) ty_span: Span,
    pub(crate) is_time: bool,
    pub(crate) init: Option<&'p ast::Expression>,
    /// The serialization settings, if a transient federate hands it over.
    pub(crate) handed_over: Option<Sending<'p>>,
    /// Whether entering its mode by reset restores its initial value.
    pub(crate) resets: bool,
    /// The mode that contains it.
    pub(crate) mode: Option<usize>,
}

/// An input or output.
#[derive(Debug)]
pub(crate) struct CheckedPort<'p> {
    pub(crate) name: &'p ast::Name,
    pub(crate) direction: ast::Direction,
    /// Whether bodies may change its value.
    pub(crate) mutable: bool,
    pub(crate) ty: String,
    pub(crate) ty_span: Span,
    /// The width, if it is a multiport.
    pub(crate) width: Option<&'p ast::Width>,
    pub(crate) capacity: Option<usize>,
    pub(crate) sending: Sending<'p>,
}

/// A value with its place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Given<T> {
    pub(crate) value: T,
    pub(crate) span: Span,
}

/// The serialization settings of a port or of a connection.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sending<'p> {
    /// The name of the serializer.
    pub(crate) serializer: Option<Given<&'p str>>,
    /// The maximum number of bytes of a serialized value or of a text, or of elements of a list.
    pub(crate) max_length: Option<Given<usize>>,
}

/// An action.
#[derive(Debug)]
pub(crate) struct CheckedAction<'p> {
    pub(crate) ast: &'p ast::ActionSyntax,
    pub(crate) ty: String,
    pub(crate) ty_span: Span,
    pub(crate) capacity: Option<usize>,
}

/// A method, with the types of its arguments and of its result, each with its place.
#[derive(Debug)]
pub(crate) struct CheckedMethod<'p> {
    pub(crate) ast: &'p ast::MethodSyntax,
    pub(crate) arguments: Vec<(String, String, Span)>,
    pub(crate) ty: Option<(String, Span)>,
}

/// A contained reactor.
#[derive(Debug)]
pub(crate) struct CheckedChild<'p> {
    pub(crate) ast: &'p ast::Instantiation,
    /// The class; `None` if there is no such reactor.
    pub(crate) class: Option<ClassId>,
    /// The arguments, one per parameter of its class.
    pub(crate) arguments: Vec<Option<&'p ast::Expression>>,
    /// `@maxwait`, in a main or federated reactor.
    pub(crate) max_wait: Option<Wait<'p>>,
    /// The place of `@transient`, in a federated reactor.
    pub(crate) transient: Option<Span>,
}

/// The time of `@maxwait` or `@absent_after`, in the scope of the containing reactor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wait<'p> {
    pub(crate) value: &'p ast::Expression,
    /// The whole attribute.
    pub(crate) span: Span,
}

/// A port as a reactor sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum PortRef {
    /// A port of its own.
    Own(usize),
    /// A port of a contained reactor: the child, and the port of its class.
    Child(usize, usize),
}

/// One or several ports at one end of a connection.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConnectionEnd<'p> {
    pub(crate) port: PortRef,
    /// The reference as it is written.
    pub(crate) ast: &'p ast::Reference,
}

/// Sources connected to destinations, channel by channel.
#[derive(Debug)]
pub(crate) struct CheckedConnection<'p> {
    pub(crate) left: Vec<ConnectionEnd<'p>>,
    pub(crate) right: Vec<ConnectionEnd<'p>>,
    /// Whether the left side is repeated as often as the right one needs.
    pub(crate) iterated: bool,
    pub(crate) after: Option<&'p ast::Expression>,
    pub(crate) physical: bool,
    pub(crate) capacity: Option<usize>,
    pub(crate) max_wait: Option<Wait<'p>>,
    pub(crate) absent_after: Option<Wait<'p>>,
    pub(crate) sending: Sending<'p>,
    /// The mode that contains it.
    pub(crate) mode: Option<usize>,
    /// The whole connection statement.
    pub(crate) span: Span,
}

/// The meaning of a reaction's dependency.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Variable {
    Startup,
    Shutdown,
    /// `reset`
    Reset,
    /// A mode as an effect, with its transition.
    Mode(usize, ast::Transition),
    Port(PortRef),
    Action(usize),
    Timer(usize),
}

/// A variable of a reaction.
#[derive(Debug)]
pub(crate) struct ReactionVariable {
    /// The name in the body: `port` or `child__port`.
    pub(crate) name: String,
    pub(crate) variable: Variable,
    pub(crate) triggers: bool,
    pub(crate) uses: bool,
    pub(crate) effect: bool,
    pub(crate) span: Span,
}

/// A reaction.
#[derive(Debug)]
pub(crate) struct CheckedReaction<'p> {
    pub(crate) ast: &'p ast::ReactionSyntax,
    /// The variables, including `startup` and `shutdown`, each once.
    pub(crate) parameters: Vec<ReactionVariable>,
}

impl CheckedReaction<'_> {
    /// Returns the contained reactors whose ports it names, in their order, each with the first place.
    pub(crate) fn children(&self) -> BTreeMap<usize, Span> {
        let mut children = BTreeMap::new();
        for parameter in &self.parameters {
            if let Variable::Port(PortRef::Child(child, _)) = parameter.variable {
                children.entry(child).or_insert(parameter.span);
            }
        }
        children
    }
}
