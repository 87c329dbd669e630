; SPDX-License-Identifier: Apache-2.0
; Neovim's; Helix folds nothing, and Zed folds by indentation.

[
  (properties)
  (reactor_body)
  (mode_body)
  (code_block)
  (block_comment)
] @fold
