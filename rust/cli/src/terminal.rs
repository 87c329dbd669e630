// SPDX-License-Identifier: Apache-2.0
//! Whether to use colours.

use std::io::{self, IsTerminal};

use lf_compiler::Style;

/// Whether standard error is a terminal whose user wants colours (<https://no-color.org>).
pub(crate) fn coloured() -> bool {
    io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

/// The compiler's name for that.
pub(crate) fn style() -> Style {
    if coloured() { Style::Coloured } else { Style::Plain }
}
