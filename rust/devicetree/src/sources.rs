// SPDX-License-Identifier: Apache-2.0
//! Writes the C file and the macro.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use crate::Devicetree;
use crate::names::{self, Device, Kind, Meaning};

impl Devicetree {
    /// Returns the C file: the specification of each device for Zephyr's drivers, as a constant of its own, which the
    /// linker drops if the program does not use it. A device whose driver is not in the image has a null pointer there.
    /// `is_set` returns whether the image has an option, by its name without `CONFIG_`.
    pub fn c_source(&self, is_set: impl Fn(&str) -> bool) -> String {
        let mut source = "/* SPDX-License-Identifier: Apache-2.0 */\n\
                          /* The devices that the devicetree has names for. */\n\n\
                          #include <zephyr/device.h>\n"
            .to_owned();
        for (option, header) in [("GPIO", "gpio"), ("PWM", "pwm"), ("ADC", "adc"), ("I2C", "i2c"), ("SPI", "spi")] {
            if is_set(option) {
                // Writing to a String cannot fail.
                let _ = writeln!(source, "#include <zephyr/drivers/{header}.h>");
            }
        }
        let names = names::of(self, &is_set);
        let mut constants = BTreeMap::new();
        for meaning in names.values() {
            let Meaning::Usable(Device { node, kind }) = meaning else { continue };
            constants.extend(constants_of(node, kind).into_iter().map(|Constant { symbol, c, .. }| (symbol, c)));
        }
        for c in constants.values() {
            let _ = write!(source, "\n{c}");
        }
        if is_set("LF_OSCILLOSCOPE") {
            source += &self.named_pins(&names);
        }
        source
    }

    /// Returns the table of pins by their names, aliases first, because applications use them.
    fn named_pins(&self, names: &BTreeMap<String, Meaning>) -> String {
        let is_alias = |name: &str| self.aliases.contains_key(name.split(['.', '[']).next().unwrap_or(name));
        let mut names: Vec<_> = names.iter().collect();
        names.sort_by_key(|(name, _)| !is_alias(name));
        let (mut table, mut count) = (String::new(), 0);
        for (name, meaning) in names {
            let Meaning::Usable(Device { node, kind: kind @ Kind::Gpio { .. } }) = meaning else { continue };
            for Constant { symbol, .. } in constants_of(node, kind) {
                let _ = writeln!(table, "\t{{{name:?}, &{symbol}}},");
                count += 1;
            }
        }
        format!(
            "\n#include <lf/oscilloscope.h>\n\nconst struct lf_named_pin lf_named_pins[] = {{\n{table}\t{{NULL, \
             NULL}},\n}};\nconst size_t lf_named_pin_count = {count};\n"
        )
    }

    /// Returns the Rust of the crate with the macro: a module `found` with a function for each device that calls, for
    /// example, `Gpio::new` with a name and with constants of C, each a `Spec` of its type, and the macro `__device!`.
    pub fn rust_source(&self, is_set: impl Fn(&str) -> bool) -> String {
        let names = names::of(self, &is_set);
        let (mut statics, mut functions, mut arms) = (BTreeSet::new(), String::new(), String::new());
        let mut known = Vec::new();
        for (name, meaning) in &names {
            let message = match meaning {
                Meaning::Usable(Device { node, kind }) => {
                    let function = identifier(name);
                    let handle = kind.handle();
                    let mut arguments = format!("{name:?}");
                    for constant in constants_of(node, kind) {
                        let _ = write!(arguments, ", &{}", constant.symbol);
                        statics.insert(format!(
                            "        safe static {}: Spec<{}>;\n",
                            constant.symbol, constant.rust_type
                        ));
                    }
                    let _ = writeln!(
                        functions,
                        "    pub fn {function}() -> {handle} {{\n        {handle}::new({arguments})\n    }}"
                    );
                    let _ = writeln!(arms, "    ({name}) => {{ $crate::devices::found::{function}() }};");
                    // Nearly every node may be a sensor, as far as the devicetree shows.
                    if *kind != Kind::Sensor {
                        known.push(name.as_str());
                    }
                    continue;
                }
                Meaning::WithoutDriver(kind) => format!(
                    "the image has no driver for `{name}`: set CONFIG_{}=y in the application's prj.conf",
                    kind.option()
                ),
                Meaning::Disabled(node) => format!(
                    "`{name}` is disabled in this board's devicetree: {node} needs `status = \"okay\";`, which the \
                     application's boards/BOARD.overlay can say"
                ),
            };
            let _ = writeln!(arms, "    ({name}) => {{ compile_error!({message:?}) }};");
        }
        let known = if known.is_empty() { "none at all".to_owned() } else { known.join(", ") };
        let statics = String::from_iter(statics);
        format!(
            "/// Devices by their names.\n#[doc(hidden)]\npub mod found {{\n    \
             #[allow(clippy::wildcard_imports)]\n    use super::*;\n    \
             unsafe extern \"C\" {{\n{statics}    }}\n{functions}}}\n\n\
             /// Expands `device!`.\n#[doc(hidden)]\n#[macro_export]\nmacro_rules! __device {{\n{arms}    \
             ($($name:tt)*) => {{ compile_error!(concat!(\"this board's devicetree has no device `\", \
             stringify!($($name)*), \"` that programs can use; it has {known}. An alias of your own is a line of the \
             application's boards/BOARD.overlay\")) }};\n}}\n"
        )
    }
}

impl Kind {
    /// Returns the type of the handle for `device!`.
    fn handle(&self) -> &'static str {
        match self {
            Self::Gpio { .. } => "Gpio",
            Self::Pwm { .. } => "PwmNode",
            Self::Adc { .. } => "AdcNode",
            Self::I2c | Self::I2cBus => "I2cNode",
            Self::Spi => "SpiNode",
            Self::Uart => "UartNode",
            Self::Sensor => "SensorNode",
        }
    }
}

/// C's specification of a device.
struct Constant {
    symbol: String,
    /// Its type in bindings of Zephyr.
    rust_type: &'static str,
    /// Its declaration and definition.
    c: String,
}

impl Constant {
    /// Returns one of this type, in C and in Rust, and of this value, which refers to this device, or to none if that
    /// has no driver.
    fn new(symbol: String, (c_type, rust_type): (&str, &'static str), device: &str, value: &str) -> Self {
        let c = format!(
            "extern const struct device DEVICE_DT_NAME_GET({device}) __weak;\n\
             extern const {c_type} {symbol};\n\
             const {c_type} {symbol} = {value};\n"
        );
        Self { symbol, rust_type, c }
    }
}

/// Returns C's specifications of a device, in the order of the parameters of its type's `new`.
fn constants_of(node: &str, kind: &Kind) -> Vec<Constant> {
    let short = node.trim_start_matches("DT_N_");
    let own = || {
        let types = ("struct device *const", "*const crate::raw::device");
        Constant::new(format!("lf_device_{short}"), types, node, &format!("DEVICE_DT_GET({node})"))
    };
    match kind {
        Kind::Gpio { property, index } => vec![Constant::new(
            format!("lf_pin_{short}_{property}_{index}"),
            ("struct gpio_dt_spec", "crate::raw::gpio_dt_spec"),
            &format!("DT_GPIO_CTLR_BY_IDX({node}, {property}, {index})"),
            &format!("GPIO_DT_SPEC_GET_BY_IDX({node}, {property}, {index})"),
        )],
        Kind::Pwm { index } => vec![Constant::new(
            format!("lf_pwm_{short}_{index}"),
            ("struct pwm_dt_spec", "crate::raw::pwm_dt_spec"),
            &format!("DT_PWMS_CTLR_BY_IDX({node}, {index})"),
            &format!("PWM_DT_SPEC_GET_BY_IDX({node}, {index})"),
        )],
        Kind::Adc { index } => vec![
            Constant::new(
                format!("lf_adc_{short}_{index}"),
                ("struct adc_dt_spec", "crate::raw::adc_dt_spec"),
                &format!("DT_IO_CHANNELS_CTLR_BY_IDX({node}, {index})"),
                &format!("ADC_DT_SPEC_GET_BY_IDX({node}, {index})"),
            ),
            own(),
        ],
        Kind::I2c => vec![
            Constant::new(
                format!("lf_i2c_{short}"),
                ("struct i2c_dt_spec", "crate::raw::i2c_dt_spec"),
                &format!("DT_BUS({node})"),
                &format!("I2C_DT_SPEC_GET({node})"),
            ),
            own(),
        ],
        Kind::I2cBus => vec![
            Constant::new(
                format!("lf_i2c_{short}"),
                ("struct i2c_dt_spec", "crate::raw::i2c_dt_spec"),
                node,
                &format!("{{.bus = DEVICE_DT_GET({node}), .addr = UINT16_MAX}}"),
            ),
            own(),
        ],
        // The second one keeps the device selected after a part of a transaction.
        Kind::Spi => vec![
            Constant::new(
                format!("lf_spi_{short}"),
                ("struct spi_dt_spec", "crate::raw::spi_dt_spec"),
                &format!("DT_BUS({node})"),
                &format!("SPI_DT_SPEC_GET({node}, SPI_OP_MODE_MASTER | SPI_WORD_SET(8))"),
            ),
            Constant::new(
                format!("lf_spi_held_{short}"),
                ("struct spi_dt_spec", "crate::raw::spi_dt_spec"),
                &format!("DT_BUS({node})"),
                &format!(
                    "SPI_DT_SPEC_GET({node}, SPI_OP_MODE_MASTER | SPI_WORD_SET(8) | SPI_HOLD_ON_CS | SPI_LOCK_ON)"
                ),
            ),
            own(),
        ],
        Kind::Uart | Kind::Sensor => vec![own()],
    }
}

/// Returns the name of the function for a device's name.
fn identifier(name: &str) -> String {
    format!("device_{}", name.replace(['.', '['], "_").replace(']', ""))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A header in Zephyr's form, of a tree with a device of each kind.
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
#define DT_N_S_keys_PATH \"/keys\"
#define DT_N_S_keys_STATUS_okay 1
#define DT_N_NODELABEL_keys DT_N_S_keys
#define DT_N_S_keys_P_gpios_IDX_0_PH DT_N_S_gpio_40004000
#define DT_N_S_keys_P_gpios_IDX_1_PH DT_N_S_gpio_40004000
#define DT_N_S_display_PATH \"/display\"
#define DT_N_S_display_STATUS_okay 1
#define DT_N_ALIAS_screen DT_N_S_display
#define DT_N_S_display_P_reset_gpios_IDX_0_PH DT_N_S_gpio_40004000
#define DT_N_S_display_P_reset_gpios_NAME_x_PH DT_N_S_gpio_40004000
#define DT_N_ALIAS_far DT_N_S_far
#define DT_N_S_far_PATH \"/far\"
#define DT_N_S_far_STATUS_okay 1
#define DT_N_S_far_P_gpios_IDX_0_PH DT_N_S_gpio_40005000
#define DT_CHOSEN_zephyr_console DT_N_S_uart_4000c000
#define DT_N_NODELABEL_console DT_N_S_uart_4000c000
#define DT_N_S_uart_4000c000_PATH \"/uart@4000c000\"
#define DT_N_S_uart_4000c000_STATUS_okay 1
#define DT_N_S_uart_4000c000_P_hw_flow_control_EXISTS 1
#define DT_N_S_i2c_100_PATH \"/i2c@100\"
#define DT_N_S_i2c_100_STATUS_okay 1
#define DT_N_NODELABEL_i2c0 DT_N_S_i2c_100
#define DT_N_S_i2c_100_S_lm75_48_PATH \"/i2c@100/lm75@48\"
#define DT_N_S_i2c_100_S_lm75_48_STATUS_okay 1
#define DT_N_S_i2c_100_S_lm75_48_BUS_i2c 1
#define DT_N_ALIAS_thermometer DT_N_S_i2c_100_S_lm75_48
#define DT_N_S_spi_200_PATH \"/spi@200\"
#define DT_N_S_spi_200_STATUS_okay 1
#define DT_N_S_spi_200_S_accel_3_PATH \"/spi@200/accel@3\"
#define DT_N_S_spi_200_S_accel_3_STATUS_okay 1
#define DT_N_S_spi_200_S_accel_3_BUS_spi 1
#define DT_N_ALIAS_accel DT_N_S_spi_200_S_accel_3
#define DT_N_S_fans_S_fan_PATH \"/fans/fan\"
#define DT_N_S_fans_S_fan_STATUS_okay 1
#define DT_N_NODELABEL_fan DT_N_S_fans_S_fan
#define DT_N_S_fans_S_fan_P_pwms_IDX_0_PH DT_N_S_gpio_40004000
#define DT_N_S_fans_S_fan_P_enable_gpios_IDX_0_PH DT_N_S_gpio_40004000
#define DT_N_S_knob_PATH \"/knob\"
#define DT_N_S_knob_STATUS_okay 1
#define DT_N_NODELABEL_knob DT_N_S_knob
#define DT_N_S_knob_P_io_channels_IDX_0_PH DT_N_S_gpio_40004000
#define DT_N_S_knob_P_io_channels_IDX_1_PH DT_N_S_gpio_40004000
#define DT_N_S_knob_P_gpios_IDX_0_PH DT_N_S_gpio_40004000
";

    fn all(_: &str) -> bool {
        true
    }

    #[test]
    fn devices_are_found_by_alias_and_label() {
        insta::assert_snapshot!(Devicetree::read(HEADER).rust_source(all));
    }

    #[test]
    fn c_has_each_device_once() {
        insta::assert_snapshot!(Devicetree::read(HEADER).c_source(all));
    }

    #[test]
    fn without_drivers_the_option_is_named() {
        let tree = Devicetree::read(HEADER);
        insta::assert_snapshot!(tree.rust_source(|option| option == "GPIO" || option == "SERIAL"));
        assert!(!tree.c_source(|option| option == "GPIO").contains("lf_i2c_"));
    }

    #[test]
    fn an_alias_counts_before_a_label_of_its_name() {
        let with_label = format!("{HEADER}#define DT_N_NODELABEL_led0 DT_N_S_keys\n");
        assert_eq!(Devicetree::read(&with_label).rust_source(all), Devicetree::read(HEADER).rust_source(all));
    }

    #[test]
    fn a_tree_without_devices_says_so() {
        assert!(Devicetree::read("").rust_source(all).contains("; it has none at all."));
    }
}
