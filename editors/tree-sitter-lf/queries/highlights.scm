; SPDX-License-Identifier: Apache-2.0
; The names of captures are Helix's. Neovim takes the same colours, because it shortens a name that it does not know.

; Comments

(line_comment) @comment.line
(block_comment) @comment.block
((block_comment) @comment.block.documentation
  (#match? @comment.block.documentation "^/[*][*][^/]"))

; Values

(string) @string
(character) @constant.character
(integer) @constant.numeric.integer
(float) @constant.numeric.float
(boolean) @constant.builtin.boolean
(unit) @keyword
["forever" "never"] @constant.builtin
(path) @constant
(package) @string.special.path
(host) @string.special.url

; Names

(target_name) @type
(property name: (_) @variable.other.member)
(imported_reactor name: (identifier) @type)
(imported_reactor alias: (identifier) @type)
(attribute "@" @attribute name: (identifier) @attribute)
(attribute_argument name: (identifier) @variable.parameter)

(reactor name: (identifier) @type)
(superclasses name: (identifier) @type)
(instantiation reactor: (identifier) @type)
(type_parameter (identifier) @type.parameter)
(named_type (identifier) @type)
(time_type) @type.builtin

(parameter name: (identifier) @variable.parameter)
(method_parameter name: (identifier) @variable.parameter)
(argument name: (identifier) @variable.parameter)

(state name: (identifier) @variable.other.member)
(port name: (identifier) @variable.other.member)
(timer name: (identifier) @variable.other.member)
(action name: (identifier) @variable.other.member)
(watchdog name: (identifier) @variable.other.member)
(instantiation name: (identifier) @variable)
(reference container: (identifier) @variable)
(reference name: (identifier) @variable.other.member)
(reference alias: (identifier) @variable)

(mode name: (identifier) @type.enum.variant)
(transition mode: (identifier) @type.enum.variant)
(reaction name: (identifier) @function)
(method name: (identifier) @function.method)
(builtin_trigger) @variable.builtin

; Keywords

["target" "at" "as" "from" "after" "serializer"] @keyword.control
["deadline" "tardy" "STP" "STAA"] @keyword.control
"import" @keyword.control.import
["reaction" "mutation"] @keyword.control
["reactor" "preamble" "input" "output" "state" "timer" "action" "watchdog" "mode" "method"] @keyword.storage.type
[
  "main"
  "federated"
  "realtime"
  "extends"
  "private"
  "public"
  "mutable"
  "const"
  "logical"
  "physical"
  "initial"
  "interleaved"
] @keyword.storage.modifier
(state "reset" @keyword.storage.modifier)
(transition ["reset" "history"] @keyword.storage.modifier)
["new" "widthof"] @keyword.operator

; Signs

["->" "~>" "=" "+" "-" "*"] @operator
["{=" "=}"] @punctuation.special
["{" "}" "(" ")" "[" "]" "<" ">"] @punctuation.bracket
["," ";" ":" "." "::"] @punctuation.delimiter
