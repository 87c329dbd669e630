; SPDX-License-Identifier: Apache-2.0
; The symbols that editors list without a language server.

(reactor name: (identifier) @name) @definition.class
(mode name: (identifier) @name) @definition.module
(method name: (identifier) @name) @definition.function
(reaction name: (identifier) @name) @definition.function
(state name: (identifier) @name) @definition.field
(port name: (identifier) @name) @definition.field
(timer name: (identifier) @name) @definition.field
(action name: (identifier) @name) @definition.field
(watchdog name: (identifier) @name) @definition.field
(instantiation name: (identifier) @name) @definition.field
(instantiation reactor: (identifier) @name) @reference.class
(superclasses name: (identifier) @name) @reference.class
