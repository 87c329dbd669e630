// SPDX-License-Identifier: Apache-2.0
//! The variables of a reactor's instances: their state, ports, what bodies see of triggers, and where values wait.

use super::class_file::ClassFile;
use super::symbols::Symbols;
use super::types::CType;
use crate::plan::TriggerKind;

impl ClassFile<'_, '_> {
    /// The variables of all instances.
    pub(super) fn storage(&mut self) {
        let (symbols, types) = (self.symbols, self.types);
        let (plan, federate) = (symbols.plan, symbols.federate);
        self.text.line("");
        if plan.is_federated() && self.index == plan.main && federate.instances.iter().all(|one| one.path != plan.name)
        {
            self.instance(None, &plan.name, &plan.name);
        }
        let own = self.index;
        for (index, instance) in federate.instances.iter().enumerate().filter(|(_, one)| one.class == own) {
            let full = if instance.parent.is_none() && instance.child.is_none() {
                instance.path.clone()
            } else {
                format!("{}.{}", plan.name, instance.path)
            };
            let own = instance.path.rsplit('.').next().unwrap_or(&instance.path);
            self.instance(Some(index), own, &full);
        }
        for (index, port) in federate.ports.iter().enumerate() {
            let Some((class, declared)) = symbols.declared(&port.path).filter(|(class, _)| *class == self.index) else {
                continue;
            };
            let ty = CType::new(&plan.classes[class.0], &port.ty);
            let info = info(&format!("{types}_{declared}_t"), index, &ty, symbols.readers(index), None);
            self.text.line(format_args!("/* {} */\n{types}_{declared}_t lf_port_{index} = {{ {info} }};", port.path));
        }
        for (index, trigger) in federate.triggers.iter().enumerate() {
            let Some((_, declared)) = symbols.declared(&trigger.path).filter(|(class, _)| *class == self.index) else {
                continue;
            };
            match &trigger.kind {
                TriggerKind::Action { ty, .. } => {
                    let ty = self.ty(ty);
                    let pool = self.pool(index, &ty, trigger.capacity);
                    let info = info(&format!("{types}_{declared}_t"), index, &ty, 1, pool);
                    let text = format!("{types}_{declared}_t lf_trigger_{index} = {{ {info} }};");
                    self.text.line(format_args!("/* {} */\n{text}", trigger.path));
                }
                TriggerKind::Timer { .. } | TriggerKind::Watchdog { .. } => {
                    let info = format!("&(const lf_cell_info_t){{ .id = {index} }}");
                    let text = format!("lf_action_base_t lf_trigger_{index} = {{ .info = {info} }};");
                    self.text.line(format_args!("/* {} */\n{text}", trigger.path));
                }
                TriggerKind::Delay { fills, .. } | TriggerKind::NetworkInput { fills, .. } => {
                    let port = &federate.ports[fills.0];
                    if let Some((class, _)) = symbols.declared(&port.path) {
                        let ty = CType::new(&plan.classes[class.0], &port.ty);
                        self.pool(index, &ty, trigger.capacity);
                    }
                }
                TriggerKind::Startup | TriggerKind::Shutdown | TriggerKind::Reset => {}
            }
        }
    }

    /// Where values wait that are not pointers; how large they are, the compiler knows.
    fn pool(&mut self, trigger: usize, ty: &CType, capacity: usize) -> Option<usize> {
        let by_value = !ty.is_nothing() && !ty.is_token() && !ty.is_text();
        if by_value {
            let declared = ty.declare(&format!("lf_value_{trigger}"));
            // Beside those that wait there is the one that happens, and one that is about to wait.
            self.text.line(format_args!(
                "typedef {declared};\nLF_POOL({}, sizeof(lf_value_{trigger}), {});",
                pool_name(trigger),
                capacity + 2
            ));
        }
        by_value.then_some(trigger)
    }

    fn instance(&mut self, index: Option<usize>, own: &str, full: &str) {
        let (variable, types) = (Symbols::instance(index), self.types);
        self.text.line(format_args!(
            "/* {full} */\n{types}_self_t {variable} = {{ .base = {{ .name = {own:?}, .full_name = {full:?} }} }};"
        ));
    }
}

/// The name of the store for the values of a trigger.
pub(super) fn pool_name(trigger: usize) -> String {
    format!("lf_pool_{trigger}")
}

/// How a port or an action begins: what kind of values it has, and where they are.
fn info(name: &str, id: usize, ty: &CType, readers: usize, pool: Option<usize>) -> String {
    let mut of_cell = format!(".id = {id}, .readers = {readers}");
    let mut of_type = String::new();
    if !ty.is_nothing() {
        of_cell =
            format!("{of_cell}, .value_offset = offsetof({name}, value), .value_size = sizeof((({name} *)0)->value)");
        of_type = if ty.is_token() {
            format!(".type = {{ .element_size = sizeof({}) }}, ", ty.element())
        } else {
            format!(".type = {{ .element_size = sizeof((({name} *)0)->value) }}, ")
        };
    }
    of_cell += if ty.is_token() { ", .is_token = true" } else { "" };
    of_cell += if ty.is_text() { ", .is_string = true" } else { "" };
    let pool = pool.map(|trigger| format!(", .pool = &{}", pool_name(trigger))).unwrap_or_default();
    format!("{of_type}.info = &(const lf_cell_info_t){{ {of_cell}{pool} }}")
}
