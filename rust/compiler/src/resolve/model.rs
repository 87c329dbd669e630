// SPDX-License-Identifier: Apache-2.0
//! Checked reactors: the syntax tree with its names resolved.

pub(crate) use super::load::ReactorId;
use crate::diagnostics::Span;
use crate::syntax::ast;

/// The position of a checked reactor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct ClassId(pub(crate) usize);

/// A checked reactor.
#[derive(Debug)]
pub(crate) struct Class<'p> {
    pub(crate) id: ReactorId,
    pub(crate) ast: &'p ast::Reactor,
    pub(crate) name: String,
    /// Whether it uses a feature that is not supported and that declares names which are not known here.
    pub(crate) opaque: bool,
    pub(crate) parameters: Vec<Parameter<'p>>,
    pub(crate) states: Vec<State<'p>>,
    pub(crate) ports: Vec<Port<'p>>,
    pub(crate) timers: Vec<&'p ast::Timer>,
    pub(crate) actions: Vec<Action<'p>>,
    pub(crate) children: Vec<Child<'p>>,
    pub(crate) connections: Vec<Connection<'p>>,
    pub(crate) reactions: Vec<Reaction<'p>>,
}

impl Class<'_> {
    /// The declaration of a port as this reactor sees it, as far as it is known.
    pub(crate) fn port<'c>(&'c self, port: PortRef, classes: &'c [Class<'_>]) -> Option<&'c Port<'c>> {
        match port {
            PortRef::Own(port) => self.ports.get(port),
            PortRef::Child(child, port) => classes[self.children.get(child)?.class?.0].ports.get(port),
        }
    }
}

/// A parameter with its type.
#[derive(Debug)]
pub(crate) struct Parameter<'p> {
    pub(crate) name: &'p ast::Name,
    /// In the target language's spelling.
    pub(crate) ty: String,
    pub(crate) ty_span: Span,
    pub(crate) is_time: bool,
    pub(crate) default: Option<&'p ast::Expression>,
}

/// A state variable with its type.
#[derive(Debug)]
pub(crate) struct State<'p> {
    pub(crate) name: &'p ast::Name,
    pub(crate) ty: String,
    pub(crate) ty_span: Span,
    pub(crate) is_time: bool,
    pub(crate) init: Option<&'p ast::Expression>,
}

/// An input or output.
#[derive(Debug)]
pub(crate) struct Port<'p> {
    pub(crate) name: &'p ast::Name,
    pub(crate) direction: ast::Direction,
    pub(crate) ty: String,
    pub(crate) ty_span: Span,
    /// Whether it is a multiport, which is not supported.
    pub(crate) wide: bool,
    pub(crate) capacity: Option<usize>,
    pub(crate) sending: Sending<'p>,
}

/// A value with its place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Given<T> {
    pub(crate) value: T,
    pub(crate) span: Span,
}

/// How the values of a port or of a connection become bytes, as far as it is said there.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sending<'p> {
    /// The name of the serializer.
    pub(crate) serializer: Option<Given<&'p str>>,
    /// The most bytes of a serialized value or of a text, or elements of a list.
    pub(crate) max_length: Option<Given<usize>>,
}

/// An action.
#[derive(Debug)]
pub(crate) struct Action<'p> {
    pub(crate) ast: &'p ast::Action,
    pub(crate) ty: String,
    pub(crate) ty_span: Span,
    pub(crate) capacity: Option<usize>,
}

/// A contained reactor.
#[derive(Debug)]
pub(crate) struct Child<'p> {
    pub(crate) ast: &'p ast::Instantiation,
    /// Nothing if there is no such reactor.
    pub(crate) class: Option<ClassId>,
    /// One per parameter of its class.
    pub(crate) arguments: Vec<Option<&'p ast::Expression>>,
    /// `@maxwait`, in a main or federated reactor.
    pub(crate) max_wait: Option<Wait<'p>>,
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
    /// One of its own.
    Own(usize),
    /// One of a contained reactor: the child, and the port of its class.
    Child(usize, usize),
}

/// One source connected to one destination.
#[derive(Debug)]
pub(crate) struct Connection<'p> {
    pub(crate) from: PortRef,
    pub(crate) to: PortRef,
    pub(crate) after: Option<&'p ast::Expression>,
    pub(crate) physical: bool,
    pub(crate) capacity: Option<usize>,
    pub(crate) max_wait: Option<Wait<'p>>,
    pub(crate) absent_after: Option<Wait<'p>>,
    pub(crate) sending: Sending<'p>,
    /// The whole connection statement.
    pub(crate) span: Span,
}

/// What a reaction's dependency stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Variable {
    Startup,
    Shutdown,
    Port(PortRef),
    Action(usize),
    Timer(usize),
}

/// A variable of a reaction.
#[derive(Debug)]
pub(crate) struct ReactionParameter {
    /// As the body names it: `port` or `child__port`.
    pub(crate) name: String,
    pub(crate) variable: Variable,
    pub(crate) triggers: bool,
    pub(crate) uses: bool,
    pub(crate) effect: bool,
    pub(crate) span: Span,
}

/// A reaction.
#[derive(Debug)]
pub(crate) struct Reaction<'p> {
    pub(crate) ast: &'p ast::Reaction,
    /// `startup` and `shutdown` included, each variable once.
    pub(crate) parameters: Vec<ReactionParameter>,
}
