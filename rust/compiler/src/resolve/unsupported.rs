// SPDX-License-Identifier: Apache-2.0
//! Features of the language that are parsed and then refused by name, so that nothing is ignored silently.

use crate::diagnostics::{Code, Diagnostic, Span};
use crate::syntax::ast::{ReactionKeyword, Reactor, ReactorKind};

/// Declares the features, each with the alternative; the README has a table of them.
macro_rules! features {
    ($($feature:ident: $name:literal $verb:ident, $instead:literal;)*) => {
        /// A feature that is refused.
        #[derive(Clone, Copy)]
        pub(super) enum Feature {
            $($feature,)*
        }

        impl Feature {
            pub(super) const ALL: &[Self] = &[$(Self::$feature,)*];

            pub(super) const fn name(self) -> &'static str {
                match self {
                    $(Self::$feature => $name,)*
                }
            }

            const fn verb(self) -> &'static str {
                match self {
                    $(Self::$feature => stringify!($verb),)*
                }
            }

            pub(super) const fn instead(self) -> &'static str {
                match self {
                    $(Self::$feature => $instead,)*
                }
            }
        }
    };
}

features! {
    Mutation: "mutations" are, "use a reaction";
}

impl Feature {
    /// Returns the refusal at the place of the feature.
    pub(super) fn refused(self, span: Span) -> Diagnostic {
        let message = format!("{} {} not supported yet", self.name(), self.verb());
        Diagnostic::new(Code::Unsupported, span, message).hint(self.instead())
    }
}

/// Reports every unsupported feature in a reactor.
pub(super) fn check(reactor: &Reactor, found: &mut Vec<Diagnostic>) {
    if let Some(span) = reactor.realtime {
        let message = "`realtime` has no effect: every reactor runs in real time, unless `fast` says otherwise";
        found.push(Diagnostic::new(Code::NoEffect, span, message).hint("remove it, or leave it"));
    }
    let mutations = reactor.body.reactions.iter().filter(|reaction| reaction.kind == ReactionKeyword::Mutation);
    found.extend(mutations.map(|reaction| Feature::Mutation.refused(reaction.keyword)));
    check_hosts(reactor, found);
}

/// Reports hosts in other places: only a federated reactor names the RTI's host, and only its instances have hosts.
fn check_hosts(reactor: &Reactor, found: &mut Vec<Diagnostic>) {
    if reactor.kind == ReactorKind::Federated {
        return;
    }
    for host in reactor.body.instances.iter().filter_map(|instance| instance.host.as_ref()) {
        let message = "only the instances in a federated reactor can be placed";
        let hint = "remove `at …`, or make the containing reactor `federated`";
        found.push(Diagnostic::new(Code::MisplacedHost, host.span, message).hint(hint));
    }
    if let Some(host) = &reactor.host {
        let message = "only a federated reactor can say where its RTI is";
        let hint = "remove `at …`, or make the reactor `federated`";
        found.push(Diagnostic::new(Code::MisplacedHost, host.span, message).hint(hint));
    }
}
