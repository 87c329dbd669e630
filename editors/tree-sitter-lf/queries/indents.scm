; SPDX-License-Identifier: Apache-2.0
; Helix's.

[
  (properties)
  (list)
  (attribute_arguments)
  (type_parameters)
  (parameters)
  (method_parameters)
  (triggers)
  (arguments)
  (port_group)
  (reactor_body)
  (mode_body)
  (code_block)
] @indent

["}" ")" "]" ">" "=}"] @outdent

(block_comment) @opaque
