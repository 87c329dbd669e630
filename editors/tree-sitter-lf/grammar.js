// SPDX-License-Identifier: Apache-2.0
/**
 * @file The grammar of Lingua Franca for editors, as the parser in `rust/compiler` reads it.
 * @license Apache-2.0
 */

/// <reference types="tree-sitter-cli/dsl" />
// @ts-check

/** Returns the rule of items between commas; a comma may follow the last one. */
const list = (item) => optional(seq(item, repeat(seq(",", item)), optional(",")));

/** Returns the rule of one or more items between commas. */
const list1 = (item) => seq(item, repeat(seq(",", item)));

module.exports = grammar({
  name: "lf",

  // The tokens of `src/scanner.c`, in the order of its enumeration.
  externals: ($) => [
    $._code_open,
    $.rust_code,
    $.c_code,
    $.cpp_code,
    $.other_code,
    $._code_close,
    $.target_name,
    $.unit,
    $.property_name,
    $.path,
    $.host,
    // It is never read. The parser expects it everywhere, so that code is found everywhere.
    $._nothing,
    // No rule has it: it is valid only where the parser recovers from an error.
    $._recovery,
  ],

  extras: ($) => [/[ \t\r\n\f]/, $.line_comment, $.block_comment, $._nothing],

  word: ($) => $.identifier,

  conflicts: ($) => [
    // Behind a reaction without a body, a name is a use, or begins an instance or a connection.
    [$.reaction],
  ],

  rules: {
    source_file: ($) => repeat($._declaration),

    _declaration: ($) => choice($.target, $.import, $.preamble, $.reactor, ";"),

    // The target and its properties.

    target: ($) => prec.right(seq("target", field("name", $.target_name), optional($.properties), optional(";"))),

    properties: ($) => seq("{", list($.property), "}"),

    property: ($) =>
      seq(field("name", choice($.property_name, $.string)), ":", field("value", $._property_value)),

    _property_value: ($) =>
      choice(
        $.properties,
        alias($._property_list, $.list),
        $.path,
        $.string,
        $.character,
        $.boolean,
        $._number,
        $.time,
      ),

    _property_list: ($) => seq("[", list($._property_value), "]"),

    // Imports and preambles.

    import: ($) =>
      prec.right(
        seq(
          "import",
          list1($.imported_reactor),
          "from",
          field("source", choice($.string, $.package)),
          optional(";"),
        ),
      ),

    imported_reactor: ($) =>
      seq(field("name", $.identifier), optional(seq("as", field("alias", $.identifier)))),

    package: (_) => token(prec(-1, /<[^>\r\n]*>/)),

    preamble: ($) => prec.right(seq(optional(choice("private", "public")), "preamble", $.code_block, optional(";"))),

    // Attributes.

    attribute: ($) =>
      prec.right(seq("@", field("name", $.identifier), optional($.attribute_arguments))),

    attribute_arguments: ($) => seq("(", list(choice($.attribute_argument, $._expression)), ")"),

    attribute_argument: ($) => seq(field("name", $.identifier), "=", field("value", $._expression)),

    // Reactors.

    reactor: ($) =>
      seq(
        repeat($.attribute),
        repeat(choice("main", "federated", "realtime")),
        "reactor",
        field("name", optional($.identifier)),
        optional($.type_parameters),
        optional($.parameters),
        optional($.placement),
        optional($.superclasses),
        field("body", $.reactor_body),
      ),

    type_parameters: ($) => seq("<", list($.type_parameter), ">"),

    type_parameter: ($) =>
      choice(
        $.code_block,
        seq(
          field("name", $.identifier),
          optional(seq("extends", field("bound", $.identifier))),
          repeat($.identifier),
        ),
      ),

    parameters: ($) => seq("(", list($.parameter), ")"),

    parameter: ($) =>
      seq(
        repeat($.attribute),
        field("name", $.identifier),
        optional($._type_annotation),
        optional($._initial_value),
      ),

    placement: ($) => seq("at", $.host),

    superclasses: ($) => seq("extends", list1(field("name", $.identifier))),

    reactor_body: ($) => seq("{", repeat(choice($._member, $.mode, $.preamble, $.port, $.method, ";")), "}"),

    mode: ($) => seq(optional("initial"), "mode", field("name", optional($.identifier)), field("body", $.mode_body)),

    mode_body: ($) => seq("{", repeat(choice($._member, ";")), "}"),

    // The members of reactors and modes.

    _member: ($) =>
      choice($.state, $.timer, $.action, $.watchdog, $.reaction, $.instantiation, $.connection),

    state: ($) =>
      prec.right(
        seq(
          repeat($.attribute),
          optional("reset"),
          "state",
          field("name", $.identifier),
          optional($._type_annotation),
          optional($._initial_value),
        ),
      ),

    method: ($) =>
      seq(
        repeat($.attribute),
        optional("const"),
        "method",
        field("name", $.identifier),
        $.method_parameters,
        optional($._type_annotation),
        field("body", $.code_block),
      ),

    method_parameters: ($) => seq("(", list($.method_parameter), ")"),

    method_parameter: ($) => seq(field("name", $.identifier), optional($._type_annotation)),

    port: ($) =>
      seq(
        repeat($.attribute),
        choice(seq(optional("mutable"), "input"), "output"),
        optional($.width),
        field("name", $.identifier),
        optional($._type_annotation),
      ),

    timer: ($) =>
      prec.right(
        seq(
          repeat($.attribute),
          "timer",
          field("name", $.identifier),
          optional(alias($._values, $.arguments)),
        ),
      ),

    action: ($) =>
      prec.right(
        seq(
          repeat($.attribute),
          optional(choice("logical", "physical")),
          "action",
          field("name", $.identifier),
          optional(alias($._values, $.arguments)),
          optional($._type_annotation),
        ),
      ),

    _values: ($) => seq("(", list($._expression), ")"),

    watchdog: ($) =>
      seq(
        repeat($.attribute),
        "watchdog",
        field("name", $.identifier),
        "(",
        field("timeout", $._expression),
        ")",
        optional($.effects),
        field("body", $.code_block),
      ),

    // Reactions.

    reaction: ($) =>
      seq(
        repeat($.attribute),
        choice("reaction", "mutation"),
        field("name", optional($.identifier)),
        $.triggers,
        optional($.uses),
        optional($.effects),
        field("body", optional($.code_block)),
        repeat(choice($.deadline, $.tardy)),
      ),

    triggers: ($) => seq("(", list(choice($.builtin_trigger, $.reference)), ")"),

    builtin_trigger: (_) => choice("startup", "shutdown", "reset"),

    uses: ($) => list1($.reference),

    effects: ($) => seq("->", list1(choice($.reference, $.transition))),

    transition: ($) => seq(choice("reset", "history"), "(", field("mode", $.identifier), ")"),

    deadline: ($) => seq("deadline", "(", field("value", $._expression), ")", field("body", $.code_block)),

    tardy: ($) =>
      choice(
        prec.right(seq("tardy", field("body", optional($.code_block)))),
        seq(choice("STP", "STAA"), "(", field("value", $._expression), ")", field("body", $.code_block)),
      ),

    // Instances and connections.

    instantiation: ($) =>
      seq(
        repeat($.attribute),
        field("name", $.identifier),
        "=",
        "new",
        optional($.width),
        field("reactor", $.identifier),
        optional($.type_arguments),
        $.arguments,
        optional($.placement),
      ),

    arguments: ($) => seq("(", list($.argument), ")"),

    argument: ($) => seq(field("name", $.identifier), $._initial_value),

    connection: ($) =>
      seq(
        repeat($.attribute),
        field("left", choice($.port_group, list1($.reference))),
        field("operator", choice("->", "~>")),
        field("right", list1($.reference)),
        optional($.delay),
        optional($.serializer),
      ),

    port_group: ($) => seq("(", list($.reference), ")", optional("+")),

    delay: ($) => seq("after", field("value", $._expression)),

    serializer: ($) => seq("serializer", field("name", $.string)),

    reference: ($) =>
      seq(
        choice($._place, seq("interleaved", "(", $._place, ")")),
        optional(seq("as", field("alias", $.identifier))),
      ),

    _place: ($) => seq(optional(seq(field("container", $.identifier), ".")), field("name", $.identifier)),

    width: ($) => seq("[", optional(seq($._width_term, repeat(seq("+", $._width_term)), optional("+"))), "]"),

    _width_term: ($) => choice($.integer, $.time, $.identifier, $.code_block, $.width_of),

    width_of: ($) => seq("widthof", "(", $.reference, ")"),

    // Types.

    _type_annotation: ($) => seq(":", field("type", $._type)),

    _type: ($) => choice($.time_type, $.named_type, $.code_block),

    time_type: (_) => "time",

    named_type: ($) =>
      prec.right(
        seq(
          $.identifier,
          repeat(seq(choice(".", "::"), $.identifier)),
          optional($.type_arguments),
          repeat("*"),
          optional(seq("[", optional($.integer), "]")),
        ),
      ),

    type_arguments: ($) => seq("<", list($._type), ">"),

    // Values.

    _initial_value: ($) =>
      choice(
        seq("=", field("value", $._expression)),
        field("value", alias(choice($._parenthesized_list, $._braced_list), $.list)),
      ),

    _expression: ($) =>
      choice(
        $.string,
        $.character,
        $.boolean,
        $._number,
        $.time,
        $.identifier,
        $.code_block,
        $.list,
      ),

    list: ($) => choice($._parenthesized_list, $._braced_list, $._bracketed_list),

    _parenthesized_list: ($) => seq("(", list($._expression), ")"),

    _braced_list: ($) => seq("{", list($._expression), "}"),

    _bracketed_list: ($) => seq("[", list($._expression), "]"),

    boolean: (_) => choice("true", "True", "false", "False"),

    _number: ($) => seq(optional("-"), choice($.integer, $.float)),

    integer: (_) => /[0-9]+/,

    float: (_) => token(choice(/[0-9]*\.[0-9]+([eE][+-]?[0-9]+)?/, /[0-9]+[eE][+-]?[0-9]+/)),

    time: ($) => choice(seq(optional("-"), $.integer, $.unit), "forever", "never"),

    string: (_) => token(choice(seq('"""', repeat(choice(/[^"]/, /"[^"]/, /""[^"]/)), '"""'), /"([^"\\\r\n]|\\[^\r\n])*"/)),

    character: (_) => /'(\\.|[^\\'\t\r\n])'/,

    // Code of the target language, whose name chooses the kind of its node.

    code_block: ($) =>
      seq(
        alias($._code_open, "{="),
        optional(choice($.rust_code, $.c_code, $.cpp_code, $.other_code)),
        alias($._code_close, "=}"),
      ),

    identifier: (_) => /[A-Za-z_][A-Za-z0-9_]*/,

    line_comment: (_) => token(choice(/\/\/[^\r\n]*/, /#[^\r\n]*/)),

    block_comment: (_) =>
      token(choice(/\/\*[^*]*\*+([^/*][^*]*\*+)*\//, seq("'''", repeat(choice(/[^']/, /'[^']/, /''[^']/)), "'''"))),
  },
});
