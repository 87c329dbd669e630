// SPDX-License-Identifier: Apache-2.0
//! Writes the C file and the macro.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use crate::Devicetree;
use crate::names::{self, Meaning, Pin};

impl Devicetree {
    /// The C file: what Zephyr's drivers need of each pin, as a constant of its own, which the linker leaves out where
    /// no program uses it. A pin whose driver is not in the image has no port there.
    pub fn c_source(&self) -> String {
        let mut source =
            "/* SPDX-License-Identifier: Apache-2.0 */\n/* The pins that the devicetree has names for. */\n\n\
                          #include <zephyr/drivers/gpio.h>\n"
                .to_owned();
        for pin in pins(&names::of(self)) {
            let Pin { node, property, index } = pin;
            let symbol = pin.symbol();
            // Writing to a String cannot fail.
            let _ = write!(
                source,
                "\nextern const struct device DEVICE_DT_NAME_GET(DT_GPIO_CTLR_BY_IDX({node}, {property}, {index})) \
                 __weak;\n\
                 extern const struct gpio_dt_spec {symbol};\n\
                 const struct gpio_dt_spec {symbol} = GPIO_DT_SPEC_GET_BY_IDX({node}, {property}, {index});\n",
            );
        }
        source
    }

    /// Rust of the crate that has the macro: a module `pins` with a function for each pin that gives what `Gpio::new`
    /// makes of a name and a pin of C's type `Spec`, and the macro `__device!`.
    pub fn rust_source(&self) -> String {
        let names = names::of(self);
        let (mut symbols, mut functions, mut arms) = (String::new(), String::new(), String::new());
        for pin in pins(&names) {
            let _ = writeln!(symbols, "        safe static {}: Spec;", pin.symbol());
        }
        for (name, meaning) in &names {
            match meaning {
                Meaning::Usable(pin) => {
                    let (function, symbol) = (identifier(name), pin.symbol());
                    let _ = writeln!(
                        functions,
                        "    pub fn {function}() -> Gpio {{\n        Gpio::new(\"{name}\", &{symbol})\n    }}"
                    );
                    let _ = writeln!(arms, "    ({name}) => {{ $crate::devices::pins::{function}() }};");
                }
                Meaning::Disabled(node) => {
                    let message = format!(
                        "`{name}` is disabled in this board's devicetree: {node} needs `status = \"okay\";`, which the \
                         application's boards/BOARD.overlay can say"
                    );
                    let _ = writeln!(arms, "    ({name}) => {{ compile_error!({message:?}) }};");
                }
            }
        }
        let usable = names.iter().filter(|(_, meaning)| matches!(meaning, Meaning::Usable(_)));
        let usable: Vec<&str> = usable.map(|(name, _)| name.as_str()).collect();
        let known = if usable.is_empty() { "none at all".to_owned() } else { usable.join(", ") };
        format!(
            "/// Pins by their names.\n#[doc(hidden)]\npub mod pins {{\n    use super::{{Gpio, Spec}};\n    \
             unsafe extern \"C\" {{\n{symbols}    }}\n{functions}}}\n\n\
             /// What `device!` finds.\n#[doc(hidden)]\n#[macro_export]\nmacro_rules! __device {{\n{arms}    \
             ($($name:tt)*) => {{ compile_error!(concat!(\"this board's devicetree has no pin `\", \
             stringify!($($name)*), \"`; it has {known}. An alias of your own is a line of the application's \
             boards/BOARD.overlay\")) }};\n}}\n"
        )
    }
}

/// Every pin that can be used, once.
fn pins(names: &BTreeMap<String, Meaning>) -> BTreeSet<&Pin> {
    let mut pins = BTreeSet::new();
    for meaning in names.values() {
        if let Meaning::Usable(pin) = meaning {
            pins.insert(pin);
        }
    }
    pins
}

/// The name of the function for what is spelled so.
fn identifier(name: &str) -> String {
    format!("pin_{}", name.replace(['.', '['], "_").replace(']', ""))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As Zephyr writes it, of a tree with an LED, an array of keys, a display with a reset pin, and a disabled pin.
    const HEADER: &str = "\
#define DT_N_PATH \"/\"
#define DT_N_INST_0_gpio_leds DT_N_S_leds
#define DT_N_S_gpio_40004000_PATH \"/gpio@40004000\"
#define DT_N_NODELABEL_gpio0         DT_N_S_gpio_40004000
#define DT_N_S_gpio_40004000_STATUS_okay 1
#define DT_N_S_gpio_40005000_PATH \"/gpio@40005000\"
#define DT_N_S_gpio_40005000_STATUS_disabled 1
#define DT_N_S_leds_PATH \"/leds\"
#define DT_N_S_leds_STATUS_okay 1
#define DT_N_S_leds_S_led_0_PATH \"/leds/led_0\"
#define DT_N_S_leds_S_led_0_STATUS_okay 1
#define DT_N_ALIAS_led0     DT_N_S_leds_S_led_0
#define DT_N_NODELABEL_green_led DT_N_S_leds_S_led_0
#define DT_N_S_leds_S_led_0_P_gpios_IDX_0_EXISTS 1
#define DT_N_S_leds_S_led_0_P_gpios_IDX_0_PH DT_N_S_gpio_40004000
#define DT_N_S_leds_S_led_0_P_gpios_IDX_0_VAL_pin 3
#define DT_N_S_leds_S_led_0_P_gpios_LEN 1
#define DT_N_S_leds_S_led_0_P_label \"Green LED\"
#define DT_N_S_keys_STATUS_okay 1
#define DT_N_NODELABEL_keys DT_N_S_keys
#define DT_N_S_keys_P_gpios_IDX_0_PH DT_N_S_gpio_40004000
#define DT_N_S_keys_P_gpios_IDX_1_PH DT_N_S_gpio_40004000
#define DT_N_S_display_STATUS_okay 1
#define DT_N_ALIAS_screen DT_N_S_display
#define DT_N_S_display_P_reset_gpios_IDX_0_PH DT_N_S_gpio_40004000
#define DT_N_S_display_P_reset_gpios_NAME_x_PH DT_N_S_gpio_40004000
#define DT_N_ALIAS_far DT_N_S_far
#define DT_N_S_far_STATUS_okay 1
#define DT_N_S_far_P_gpios_IDX_0_PH DT_N_S_gpio_40005000
#define DT_CHOSEN_zephyr_console DT_N_S_uart_4000c000
";

    #[test]
    fn what_has_pins_is_found_by_alias_and_label() {
        insta::assert_snapshot!(Devicetree::read(HEADER).rust_source());
    }

    #[test]
    fn c_has_each_pin_once() {
        insta::assert_snapshot!(Devicetree::read(HEADER).c_source());
    }

    #[test]
    fn an_alias_counts_before_a_label_of_its_name() {
        let with_label = format!("{HEADER}#define DT_N_NODELABEL_led0 DT_N_S_keys\n");
        assert_eq!(Devicetree::read(&with_label).rust_source(), Devicetree::read(HEADER).rust_source());
    }

    #[test]
    fn a_tree_without_pins_says_so() {
        assert!(Devicetree::read("").rust_source().contains("; it has none at all."));
    }
}
