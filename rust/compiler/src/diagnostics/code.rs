// SPDX-License-Identifier: Apache-2.0
//! The stable names of all diagnostics, and their severities.

/// The severity of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// The program is compiled nevertheless.
    Warning,
    /// There is no plan for this program.
    Error,
}

macro_rules! codes {
    ($($(#[$doc:meta])* $variant:ident = $text:literal,)*) => {
        /// The stable name of a kind of diagnostic: a letter (`E` error, `W` warning), a number, and words.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Code { $($(#[$doc])* $variant,)* }

        impl Code {
            /// All codes.
            pub const ALL: &'static [Code] = &[$(Code::$variant,)*];

            /// Returns the name as it is printed.
            pub fn text(self) -> &'static str {
                match self { $(Code::$variant => $text,)* }
            }
        }
    };
}

codes! {
    /// Text that is not part of the language in this position.
    Syntax = "E001-syntax",
    /// A `{=` without `=}`.
    UnterminatedCode = "E002-unterminated-code",
    /// A `/*` without `*/`.
    UnterminatedComment = "E003-unterminated-comment",
    /// A string without its closing quote.
    UnterminatedString = "E004-unterminated-string",
    /// A word of the language used as a name.
    ReservedWord = "E005-reserved-word",
    /// Expressions or types nested too deeply.
    NestingTooDeep = "E006-nesting-too-deep",
    /// A number that does not fit.
    NumberTooLarge = "E007-number-too-large",
    /// A name that generated Rust cannot use.
    RustName = "E008-rust-name",
    /// A name that bodies in another language cannot use.
    LanguageName = "E064-language-name",
    /// A host name or address that is invalid.
    BadHost = "E009-bad-host",

    /// No `target`, or one whose language is not compiled here.
    WrongTarget = "E010-wrong-target",
    /// A target property that does not exist.
    UnknownProperty = "E011-unknown-property",
    /// A target property with a value that it cannot have.
    BadPropertyValue = "E012-bad-property-value",
    /// A target property given twice.
    DuplicateProperty = "E013-duplicate-property",
    /// An attribute that does not exist.
    UnknownAttribute = "E014-unknown-attribute",
    /// An attribute with arguments that it cannot have.
    BadAttribute = "E015-bad-attribute",

    /// A file that cannot be read.
    MissingFile = "E020-missing-file",
    /// A reactor that the imported file does not have.
    MissingImport = "E022-missing-import",

    /// A file whose name is impossible for generated files and programs.
    FileName = "E023-file-name",

    /// A feature of the language that is not supported yet.
    Unsupported = "E030-unsupported",
    /// A target property that is not supported yet.
    UnsupportedProperty = "E031-unsupported-property",

    /// No main or federated reactor.
    NoMain = "E040-no-main",
    /// More than one main or federated reactor.
    SeveralMains = "E041-several-mains",
    /// A main reactor with inputs or outputs.
    MainWithPorts = "E042-main-with-ports",
    /// Two things of one name.
    DuplicateName = "E043-duplicate-name",
    /// An instance of a reactor that does not exist.
    UnknownReactor = "E044-unknown-reactor",
    /// A value for a parameter that does not exist.
    UnknownParameter = "E045-unknown-parameter",
    /// A port of an instance that does not exist.
    UnknownInstance = "E046-unknown-instance",
    /// A port that does not exist.
    UnknownPort = "E047-unknown-port",
    /// A name without a declaration.
    UnknownName = "E048-unknown-name",
    /// A parameter without a value.
    MissingValue = "E049-missing-value",
    /// A declaration without a type.
    MissingType = "E050-missing-type",
    /// Reactors that contain each other.
    CyclicInstantiation = "E051-cyclic-instantiation",
    /// A parameter given twice.
    DuplicateValue = "E052-duplicate-value",
    /// Types for the type parameters of a reactor that has another number of them.
    TypeArguments = "E053-type-arguments",
    /// A width that is unknown at compile time.
    BadWidth = "E054-bad-width",

    /// Modes of which none or several are initial, or modes in a place where there can be none.
    BadMode = "E055-bad-mode",
    /// Something of another mode.
    OtherMode = "E056-other-mode",
    /// State in a mode that is entered by reset, without a rule for what happens to it.
    NotReset = "E057-not-reset",

    /// Something that cannot trigger a reaction or be used by it.
    NotReadable = "E061-not-readable",
    /// Something that a reaction cannot write.
    NotWritable = "E062-not-writable",
    /// The same dependency twice in one list.
    DuplicateDependency = "E063-duplicate-dependency",
    /// A code block that is not written in the target language.
    CodeSyntax = "E065-code-syntax",

    /// A type that the target language does not have.
    BadType = "E066-bad-type",
    /// Connected ports of different types.
    TypeMismatch = "E070-type-mismatch",
    /// Two writers of one port.
    TwoWriters = "E071-two-writers",
    /// A port on the wrong side of a connection.
    WrongDirection = "E072-wrong-direction",
    /// Different numbers of ports on both sides of a connection.
    WidthMismatch = "E073-width-mismatch",
    /// A type whose values cannot go to another federate.
    Unsendable = "E074-unsendable",
    /// A type whose values a connection would have to copy, and that cannot be copied.
    Uncopyable = "E075-uncopyable",

    /// A value that is no time.
    NotATime = "E080-not-a-time",
    /// A time without a unit.
    MissingUnit = "E081-missing-unit",
    /// A unit that does not exist.
    BadUnit = "E082-bad-unit",
    /// A time below zero.
    NegativeTime = "E083-negative-time",
    /// A value that does not belong to the type.
    WrongValue = "E084-wrong-value",
    /// A policy that does not exist.
    BadPolicy = "E085-bad-policy",

    /// Reactions that wait for each other.
    CausalityLoop = "E090-causality-loop",
    /// A reaction in the federated reactor itself.
    FederatedReaction = "E092-federated-reaction",
    /// A federated reactor without instances.
    NoFederates = "E093-no-federates",
    /// Two federates with one name in the generated files.
    FederateNameClash = "E094-federate-name-clash",
    /// A capacity that cannot be computed.
    UnboundedCapacity = "E095-unbounded-capacity",
    /// A program that is too large for the ids of the protocol or of the tables.
    TooLarge = "E096-too-large",
    /// A host (`at`) for something that has no host.
    MisplacedHost = "E097-misplaced-host",

    /// An initial value in parentheses.
    OldInitialiser = "W001-old-initialiser",
    /// A target property without an effect beyond the default.
    IdleProperty = "W002-idle-property",
    /// A C type where a Rust type belongs.
    CType = "W003-c-type",
    /// Something that has no effect.
    NoEffect = "W004-no-effect",
    /// A capacity below what the program needs at most.
    SmallCapacity = "W005-small-capacity",
    /// A capacity in a cycle of federates that the compiler can only guess.
    UnknownCapacity = "W006-unknown-capacity",
    /// An older notation, which newer programs do not use.
    OlderForm = "W007-older-form",
    /// Federates that wait for each other without end.
    EndlessWait = "W008-endless-wait",
    /// A connection that leaves channels of one side unconnected.
    UnequalWidths = "W009-unequal-widths",
    /// A reaction without a body.
    MissingBody = "W010-missing-body",
    /// A macro that inherited code uses, and that its own file defines differently or not at all.
    InheritedMacro = "W011-inherited-macro",
    /// Clock synchronization that is not encrypted in a program whose connections are.
    OpenClocks = "W012-open-clocks",
}

impl Code {
    /// Returns whether this kind of diagnostic prevents a plan.
    pub fn severity(self) -> Severity {
        if self.text().starts_with('W') { Severity::Warning } else { Severity::Error }
    }
}

#[cfg(test)]
mod tests {
    use super::Code;
    use std::collections::HashSet;

    #[test]
    fn numbers_are_unique() {
        let numbers: HashSet<_> = Code::ALL.iter().map(|code| &code.text()[..4]).collect();
        assert_eq!(numbers.len(), Code::ALL.len());
    }
}
