; SPDX-License-Identifier: Apache-2.0
; Helix's: a parameter has its colour wherever the reactor uses it.

(reactor) @local.scope

(parameter name: (identifier) @local.definition.variable.parameter)

(width (identifier) @local.reference)
(list (identifier) @local.reference)
(timer (arguments (identifier) @local.reference))
(action (arguments (identifier) @local.reference))
(_ value: (identifier) @local.reference)
(watchdog timeout: (identifier) @local.reference)
