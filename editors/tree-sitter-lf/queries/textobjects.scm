; SPDX-License-Identifier: Apache-2.0
; Helix's: a class is a reactor, and a function is what has code.

(reactor body: (_) @class.inside) @class.around

(reaction body: (_) @function.inside) @function.around
(method body: (_) @function.inside) @function.around
(watchdog body: (_) @function.inside) @function.around
(preamble (code_block) @function.inside) @function.around

(parameters (parameter) @parameter.inside) @parameter.around
(arguments (_) @parameter.inside) @parameter.around
(triggers (_) @parameter.inside) @parameter.around

[(line_comment) (block_comment)] @comment.inside
(line_comment)+ @comment.around
(block_comment) @comment.around

(property) @entry.around
(property value: (_) @entry.inside)
