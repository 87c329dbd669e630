// SPDX-License-Identifier: Apache-2.0
//! The variables of a reactor's instances: state, ports, triggers as bodies see them, and stores of queued values.

use super::class_file::ClassFile;
use super::cpp::as_bytes;
use super::symbols::Symbols;
use super::types::CType;
use crate::emit::host::sent_ports;
use crate::languages::c::PROTO;
use crate::plan::TriggerKind;

impl ClassFile<'_, '_> {
    /// Emits the variables of all instances.
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
            let Some((class, declared)) = federate.declared(&port.path).filter(|(class, _)| *class == self.index)
            else {
                continue;
            };
            let ty = CType::new(symbols.view.class(class), &port.ty);
            let (name, variable) = (format!("{types}_{declared}_t"), format!("lf_port_{index}"));
            self.text.line(format_args!("/* {} */", port.path));
            if symbols.is_copied(index) {
                self.as_bytes(&ty, &variable, &port.path);
            }
            let message = self.serializer(index, &ty, &variable);
            let readers = symbols.readers(index);
            let cell = ValueCell { ty: &ty, name: &name, id: index, readers, pool: None, message };
            self.text.line(cell.declare(&variable));
        }
        for (index, trigger) in federate.triggers.iter().enumerate() {
            let Some((_, declared)) = federate.declared(&trigger.path).filter(|(class, _)| *class == self.index) else {
                continue;
            };
            match &trigger.kind {
                TriggerKind::Action { ty, .. } => {
                    let ty = self.ty(ty);
                    let (name, variable) = (format!("{types}_{declared}_t"), format!("lf_trigger_{index}"));
                    self.text.line(format_args!("/* {} */", trigger.path));
                    let pool = self.pool(index, &ty, trigger.capacity, &trigger.path);
                    let cell = ValueCell { ty: &ty, name: &name, id: index, readers: 1, pool, message: None };
                    self.text.line(cell.declare(&variable));
                }
                TriggerKind::Timer { .. } | TriggerKind::Watchdog { .. } => {
                    let info = format!("static const lf_cell_info_t lf_trigger_{index}_info = {{ .id = {index} }};");
                    let text = format!("lf_action_base_t lf_trigger_{index} = {{ .info = &lf_trigger_{index}_info }};");
                    self.text.line(format_args!("/* {} */\n{info}\n{text}", trigger.path));
                }
                TriggerKind::Delay { fills, .. } | TriggerKind::NetworkInput { fills, .. } => {
                    let port = &federate.ports[fills.0];
                    if let Some((class, _)) = federate.declared(&port.path) {
                        let ty = CType::new(symbols.view.class(class), &port.ty);
                        self.pool(index, &ty, trigger.capacity, &trigger.path);
                    }
                }
                TriggerKind::Startup | TriggerKind::Shutdown | TriggerKind::Reset => {}
            }
        }
    }

    /// Emits the serializer of a port whose values are messages of Protocol Buffers.
    fn serializer(&mut self, port: usize, ty: &CType, variable: &str) -> Option<Message> {
        let mut sent = sent_ports(self.symbols.federate).filter(|(sent, _)| sent.0 == port);
        let is_proto = sent.any(|(_, sent)| sent.serializer.and_then(|by| by.name.as_deref()) == Some(PROTO));
        if !is_proto {
            return None;
        }
        let (name, ty) = (format!("{variable}_serializer"), ty.element());
        self.text.line(format_args!("LF_SERIALIZER_({name}, {ty}, {});", functions_of(ty)));
        let federate = self.symbols.federate;
        let is_filled =
            federate.inputs.iter().any(|input| federate.filled(input).is_some_and(|filled| filled.0 == port));
        Some(Message { name, is_filled })
    }

    /// Emits the store of queued values that are not pointers; the compiler knows their size.
    fn pool(&mut self, trigger: usize, ty: &CType, capacity: usize, path: &str) -> Option<usize> {
        let by_value = !ty.is_nothing() && !ty.is_token() && !ty.is_text();
        if by_value {
            let declared = ty.declare(&format!("lf_value_{trigger}"));
            // Beside the queued values there are the present one and one that is about to be queued.
            self.text.line(format_args!(
                "typedef {declared};\nLF_POOL({}, sizeof(lf_value_{trigger}), {});",
                pool_name(trigger),
                capacity + 2
            ));
            self.as_bytes(ty, &format!("trigger_{trigger}"), path);
        }
        by_value.then_some(trigger)
    }

    /// Asserts that values can be copied as bytes, which is not true for all of C++.
    fn as_bytes(&mut self, ty: &CType, variable: &str, path: &str) {
        if self.symbols.view.native.is_cpp && !ty.is_nothing() {
            let name = format!("lf_bytes_of_{variable}");
            let declared = ty.declare(&name);
            self.text.line(format_args!("typedef {declared};"));
            self.text.line(as_bytes(&name, &format!("values of {path}")));
        }
    }

    fn instance(&mut self, index: Option<usize>, own: &str, full: &str) {
        let (variable, types) = (Symbols::instance(index), self.types);
        self.text.line(format_args!(
            "/* {full} */\n{types}_self_t {variable} = {{ .base = {{ .name = {own:?}, .full_name = {full:?} }} }};"
        ));
    }
}

/// Returns the name of the store for the values of a trigger.
pub(super) fn pool_name(trigger: usize) -> String {
    format!("lf_pool_{trigger}")
}

/// A port or an action.
struct ValueCell<'a> {
    ty: &'a CType,
    /// The name of its struct.
    name: &'a str,
    id: usize,
    readers: usize,
    pool: Option<usize>,
    message: Option<Message>,
}

/// The serializer of a port.
struct Message {
    /// Its variable.
    name: String,
    /// Whether the values come from another federate, by the serializer, which alone can free them.
    is_filled: bool,
}

/// Returns the beginning of the names of the functions that protobuf-c generates for a message: `Motor__LeftWheel` has
/// `motor__left_wheel__pack`.
fn functions_of(message: &str) -> String {
    let mut name = String::new();
    // There is no separator at the beginning.
    let mut was_upper = true;
    for one in message.chars() {
        if one.is_ascii_uppercase() && !was_upper && !name.ends_with("__") {
            name.push('_');
        }
        was_upper = one.is_ascii_uppercase();
        name.push(one.to_ascii_lowercase());
    }
    name
}

impl ValueCell<'_> {
    /// Returns its variable, whose first members are the kind and the addresses of its values. C++ demands members in
    /// the order of their declarations.
    fn declare(&self, variable: &str) -> String {
        let Self { ty, name, id, readers, pool, message } = self;
        let (mut of_cell, mut of_type) = (format!(".id = {id}"), String::new());
        of_cell += if ty.is_token() { ", .is_token = true" } else { "" };
        of_cell += if ty.is_text() { ", .is_string = true" } else { "" };
        of_cell = format!("{of_cell}, .readers = {readers}");
        if !ty.is_nothing() {
            let value = format!("((({name} *)0)->value)");
            of_cell = format!("{of_cell}, .value_offset = offsetof({name}, value), .value_size = sizeof{value}");
            let element = if ty.is_token() { format!("({})", ty.element()) } else { value };
            let owned = match message {
                Some(Message { name, is_filled: true }) => {
                    format!(", .destructor = {name}_free, .copy_constructor = {name}_copy")
                }
                _ => String::new(),
            };
            of_type = format!(".type = {{ .element_size = sizeof{element}{owned} }}, ");
        }
        let pool = pool.map(|trigger| format!(", .pool = &{}", pool_name(trigger))).unwrap_or_default();
        let message =
            message.as_ref().map(|Message { name, .. }| format!(", .serializer = &{name}")).unwrap_or_default();
        format!(
            "static const lf_cell_info_t {variable}_info = {{ {of_cell}{pool}{message} }};\n\
             {name} {variable} = {{ {of_type}.info = &{variable}_info }};"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::functions_of;

    #[test]
    fn functions_of_messages_have_the_names_that_protobuf_c_gives_them() {
        let names = [
            ("Person", "person"),
            ("ProtoHelloWorld", "proto_hello_world"),
            ("Motor__LeftWheel", "motor__left_wheel"),
            ("GPSFix", "gpsfix"),
            ("My_Type", "my__type"),
        ];
        for (message, functions) in names {
            assert_eq!(functions_of(message), functions);
        }
    }
}
