; SPDX-License-Identifier: Apache-2.0
; The target declaration has chosen the kind of the node.

((rust_code) @injection.content
  (#set! injection.language "rust"))

((c_code) @injection.content
  (#set! injection.language "c"))

((cpp_code) @injection.content
  (#set! injection.language "cpp"))

([(line_comment) (block_comment)] @injection.content
  (#set! injection.language "comment"))
