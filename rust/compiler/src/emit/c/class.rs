// SPDX-License-Identifier: Apache-2.0
//! The file of a reactor class: its types, the storage of its instances, their constructors, and its bodies.

use std::collections::{BTreeMap, BTreeSet};

use super::class_file::ClassFile;
use super::cpp::extension;
use super::header;
use super::structs::{ACTION, PORT, declares_bank_index, files, self_struct, value_struct};
use super::symbols::Symbols;
use super::text::{Text, name_of};
use super::types::CType;
use crate::emit::host::{GivenValue, ReactionPart};
use crate::emit::view::View;
use crate::emit::{EmitError, File};
use crate::plan::{Child, ClassIndex, FileIndex, Location, Method, Parameter, StateVariable, Value};

/// Emits the file of a class.
pub(super) fn emit(symbols: &Symbols<'_>, index: ClassIndex, folder: &str) -> Result<File, EmitError> {
    let (view, name) = (symbols.view, symbols.class(index));
    let class = view.class(index);
    let text = Text::new(view, format!("{folder}/c/{name}.{}", extension(view)), &format!("Reactor `{}`.", class.name));
    let mut file = ClassFile { symbols, index, class, name, types: symbols.types(index), text };
    file.preambles();
    file.names();
    file.types();
    file.storage();
    file.construct();
    if index == view.plan.main {
        file.give();
    }
    file.children()?;
    file.reset();
    file.handover();
    file.methods();
    for reaction in &class.reactions {
        if symbols.reacts(index, reaction.number) {
            for part in ReactionPart::ALL {
                match part.code(reaction) {
                    Some(_) if reaction.external && part == ReactionPart::Body => file.external(reaction),
                    Some(code) => file.reaction(reaction, part, code),
                    None => {}
                }
            }
        }
    }
    Ok(file.text.file())
}

/// Returns the line of a declaration, as a comment.
fn place(text: &str, at: Location) -> String {
    format!("/* {text}, line {}. */", at.line)
}

impl ClassFile<'_, '_> {
    fn preambles(&mut self) {
        self.text.line("#include <string.h>\n#include <lf.h>");
        for file in files(self.symbols.view, self.class) {
            self.text.line(format_args!("#include \"{}.h\"", self.symbols.file(file)));
        }
        for (name, ty) in &self.class.types {
            self.text.line(format_args!("#define {name} {}", ty.text));
        }
        for preamble in &self.class.preambles {
            self.text.code(preamble);
        }
        if self.class.reactions.iter().any(|reaction| reaction.external) {
            self.text.line(format_args!("#include \"../{}\"", header::path(self.symbols.view, self.class)));
        }
    }

    /// Lets the compiler check that no header replaces the program's names in this file: macros differ between systems
    /// and versions, so no table could list them.
    fn names(&mut self) {
        let class = self.class;
        let mut names: BTreeMap<&str, Location> = BTreeMap::new();
        names.extend(class.parameters.iter().map(|it| (it.name.as_str(), it.at)));
        names.extend(class.state.iter().map(|it| (it.name.as_str(), it.at)));
        names.extend(class.ports.iter().map(|it| (it.name.as_str(), it.at)));
        names.extend(class.actions.iter().map(|it| (it.name.as_str(), it.at)));
        names.extend(class.children.iter().map(|it| (it.name.as_str(), it.at)));
        for child in &class.children {
            let ports = &self.symbols.plan.classes[child.class.0].ports;
            names.extend(ports.iter().map(|it| (it.name.as_str(), it.at)));
        }
        for (name, at) in names {
            self.text.place(at).line(format_args!("LF_NAME_({name:?}, {name});"));
        }
        self.text.continues();
    }

    /// Emits the struct of the state, and those of ports and actions.
    fn types(&mut self) {
        let (class, types) = (self.class, self.types);
        self.text.line("\n/* The type of `self` in bodies. */");
        self_struct(&mut self.text, class, &format!("{types}_self_t"));
        self.text.line("");
        for port in &class.ports {
            value_struct(&mut self.text, PORT, class, &port.ty, &format!("{types}_{}_t", port.name));
        }
        for action in &class.actions {
            value_struct(&mut self.text, ACTION, class, &action.ty, &format!("{types}_{}_t", action.name));
        }
        let mut seen = BTreeSet::from([self.index]);
        for child in class.children.iter().filter(|child| seen.insert(child.class)) {
            let (target, prefix) = (self.symbols.view.class(child.class), self.symbols.types(child.class));
            for port in target.ports.iter().filter(|_| !prefix.is_empty()) {
                value_struct(&mut self.text, PORT, target, &port.ty, &format!("{prefix}_{}_t", port.name));
            }
        }
    }

    /// Emits the function that initialises the parameters and the state of an instance.
    fn construct(&mut self) {
        let (class, name, types) = (self.class, self.name, self.types);
        self.text.line(format_args!("\n{}", place("A new instance: what is not given has its default", class.at)));
        let linkage = self.linkage();
        self.text.line(format_args!(
            "{linkage}void {name}_construct(void *lf_self, const void *const *lf_given, int lf_member) {{\n    \
             {types}_self_t *self = ({types}_self_t *)lf_self;\n    (void)lf_given;\n    \
             self->base.bank_index = lf_member;"
        ));
        if !declares_bank_index(class) {
            self.text.line("    self->bank_index = lf_member;");
        }
        for (index, parameter) in class.parameters.iter().enumerate() {
            let (own, ty) = (&parameter.name, self.ty(&parameter.ty));
            let target = if class.has_state(own) {
                // State of the same name hides it from bodies; initial values still name it.
                self.text.line(format_args!("    {};", ty.declare(&format!("lf_parameter_{own}"))));
                format!("lf_parameter_{own}")
            } else {
                format!("self->{own}")
            };
            self.text.line(format_args!("    if (lf_given[{index}] != NULL) {{"));
            self.text.line(format_args!("        LF_ASSIGN_({target}, lf_given[{index}]);\n    }} else {{"));
            match &parameter.default {
                Some(default) => self.assign(&target, &ty, default),
                None => {
                    self.text.line(format_args!("        LF_CLEAR_({target});"));
                }
            }
            self.text.line("    }");
            let defaults = class.parameters.iter().filter_map(|parameter| parameter.default.as_ref());
            let inits = class.state.iter().filter_map(|state| state.init.as_ref());
            self.local(parameter, &target, defaults.chain(inits));
        }
        for state in &class.state {
            self.state(state);
        }
        self.text.line("}");
    }

    /// Emits a variable with the value of a parameter, where expressions name it.
    fn local<'v>(&mut self, parameter: &Parameter, place: &str, values: impl IntoIterator<Item = &'v Value>) {
        let (name, array) = (&parameter.name, self.ty(&parameter.ty).is_array());
        if !values.into_iter().any(|value| self.symbols.view.mentions(value, name)) {
            return;
        }
        let ty = if array { format!("__typeof__(&{place}[0])") } else { format!("__typeof__({place})") };
        self.text.line(format_args!("    {ty} {name} = {place};\n    (void){name};"));
    }

    /// Emits the parameters that values name, as variables.
    fn locals(&mut self, values: &[&Value]) {
        for parameter in &self.class.parameters {
            if !self.class.has_state(&parameter.name) {
                self.local(parameter, &format!("self->{}", parameter.name), values.iter().copied());
            }
        }
    }

    fn state(&mut self, state: &StateVariable) {
        if let Some(init) = &state.init {
            self.text.line("    {");
            let ty = self.ty(&state.ty);
            self.assign(&format!("self->{}", state.name), &ty, init);
            self.text.line("    }");
        }
    }

    /// Emits lines that assign a value.
    fn assign(&mut self, target: &str, ty: &CType, value: &Value) {
        self.variable("lf_value", ty, value);
        let value = address("lf_value", ty, value);
        self.text.line(format_args!("        LF_ASSIGN_({target}, {value});"));
    }

    /// Emits a variable with a value.
    fn variable(&mut self, name: &str, ty: &CType, value: &Value) {
        let code = match value {
            Value::Time { ns } => {
                self.text.line(format_args!("        {} = INT64_C({ns});", ty.declare(name)));
                return;
            }
            Value::Code(code) => code,
        };
        let is_word = |c: char| c.is_alphanumeric() || c == '_' || c == '.' || c == '-';
        if code.text.chars().all(is_word) && !is_elsewhere(ty, value) {
            self.text.line(format_args!("        {} = {};", ty.declare(name), code.text));
        } else if is_list(value) && ty.is_token() {
            self.text.line(format_args!("        static {} {name}_elements[] =", ty.element()));
            self.text.code(code).line("        ;");
            self.text.line(format_args!("        {} = {name}_elements;", ty.declare(name)));
        } else if is_elsewhere(ty, value) {
            self.text.line(format_args!("        const void *{name} = "));
            self.text.code(code).line("        ;");
        } else {
            self.text.line(format_args!("        {} =", ty.declare(name)));
            self.text.code(code).line("        ;");
        }
    }

    /// Emits the functions that construct contained reactors.
    fn children(&mut self) -> Result<(), EmitError> {
        let class = self.class;
        for (index, child) in class.children.iter().enumerate() {
            if self.symbols.makes(self.index, index) {
                self.child(index, child)?;
            }
        }
        Ok(())
    }

    fn child(&mut self, index: usize, child: &Child) -> Result<(), EmitError> {
        let (view, name, types, linkage) = (self.symbols.view, self.name, self.types, self.linkage());
        let (target, made) = (view.class(child.class), self.symbols.class(child.class));
        self.text.line(format_args!("\n{}", place(&format!("`{} = new {}(…)`", child.name, target.name), child.at)));
        self.text.line(format_args!("{linkage}void {made}_construct(void *, const void *const *, int);"));
        self.text
            .line(format_args!("{linkage}void {name}_make_{index}(void *lf_self, void *lf_child, int lf_member) {{"));
        self.text.line(format_args!("    {types}_self_t *self = ({types}_self_t *)lf_self;\n    (void)self;"));
        let values: Vec<&Value> = child.arguments.iter().flatten().collect();
        self.locals(&values);
        if view.counts_members(self.class, child) {
            self.text.line("    int bank_index = lf_member;");
        }
        let mut given = Vec::new();
        for (number, (parameter, value)) in view.given(child)?.into_iter().enumerate() {
            let (ty, variable) = (CType::new(target, &parameter.ty), format!("lf_argument_{number}"));
            given.push(match value {
                GivenValue::Value(value) => {
                    self.variable(&variable, &ty, value);
                    address(&variable, &ty, value)
                }
                GivenValue::Member => {
                    self.text.line(format_args!("        {} = lf_member;", ty.declare(&variable)));
                    format!("&{variable}")
                }
                GivenValue::Default => "NULL".to_owned(),
            });
        }
        given.push("NULL".to_owned());
        let given = given.join(", ");
        self.text.line(format_args!("    const void *const lf_given[] = {{ {given} }};"));
        self.text.line(format_args!("    {made}_construct(lf_child, lf_given, lf_member);\n}}"));
        Ok(())
    }

    /// Emits the function that resets the state in a mode, or the state outside of modes.
    fn reset(&mut self) {
        let (class, name, types) = (self.class, self.name, self.types);
        let modes: BTreeSet<Option<usize>> =
            class.state.iter().filter(|state| state.resets).map(|state| state.mode).collect();
        for mode in modes.into_iter().filter(|mode| class.has_resets(*mode)) {
            let function = reset_function(name, mode);
            self.text.line(format_args!("\n{}", place("Resets the state", class.at)));
            let linkage = self.linkage();
            self.text.line(format_args!(
                "{linkage}void {function}(void *lf_self) {{\n    {types}_self_t *self = ({types}_self_t *)lf_self;"
            ));
            let values: Vec<&Value> = class.state.iter().filter_map(|state| state.init.as_ref()).collect();
            self.locals(&values);
            for state in class.state.iter().filter(|state| state.resets && state.mode == mode) {
                self.state(state);
            }
            self.text.line("}");
        }
    }

    /// Emits the function that returns the place of a state that is handed over, by its number in the class.
    fn handover(&mut self) {
        let (class, types, linkage) = (self.class, self.types, self.linkage());
        let states: Vec<_> = class.state.iter().filter(|state| state.handed_over.is_some()).collect();
        if states.is_empty() {
            return;
        }
        self.text.line(format_args!("\n{}", place("The states for the next instance", class.at)));
        let function = handover_function(self.name);
        self.text.line(format_args!(
            "{linkage}void *{function}(void *lf_self, int lf_state, size_t *lf_size) {{\n    \
             {types}_self_t *self = ({types}_self_t *)lf_self;\n    switch (lf_state) {{"
        ));
        for (number, state) in states.into_iter().enumerate() {
            let name = &state.name;
            self.text.line(format_args!("    case {number}:"));
            self.text.line(format_args!("        *lf_size = sizeof(self->{name});\n        return &self->{name};"));
        }
        self.text.line("    default:\n        return NULL;\n    }\n}");
    }

    fn methods(&mut self) {
        let (class, name, types) = (self.class, self.name, self.types);
        let head = |method: &Method| {
            let arguments = method.arguments.iter().map(|(name, ty)| format!(", {}", self.ty(ty).declare(name)));
            let arguments: String = arguments.collect();
            let own = format!("{name}_method_{}({types}_self_t *self{arguments})", method.name);
            let returned = method.ty.as_ref().map_or_else(|| format!("void {own}"), |ty| self.ty(ty).declare(&own));
            format!("__attribute__((unused)) static {returned}")
        };
        let heads: Vec<String> = class.methods.iter().map(head).collect();
        self.text.line("");
        for (method, head) in class.methods.iter().zip(&heads) {
            self.text.line(format_args!("{head};"));
            self.text.line(format_args!("#define {}(...) {name}_method_{0}(self, ##__VA_ARGS__)", method.name));
        }
        for (method, head) in class.methods.iter().zip(&heads) {
            self.text.line(format_args!("\n{}\n{head} {{", place(&format!("Method `{}`", method.name), method.at)));
            self.text.code(&method.body).line("}");
        }
    }
}

/// Returns the name of the function that resets the state in a mode of a class, or the state outside of modes.
pub(super) fn reset_function(class: &str, mode: Option<usize>) -> String {
    mode.map_or_else(|| format!("{class}_reset"), |mode| format!("{class}_reset_in_{mode}"))
}

/// Returns the name of the function that returns the place of a state that a class hands over.
pub(super) fn handover_function(class: &str) -> String {
    format!("{class}_handed_over")
}

fn is_list(value: &Value) -> bool {
    matches!(value, Value::Code(code) if code.text.trim_start().starts_with('{'))
}

/// Returns whether an expression points to the value of an array, which needs no variable of its own.
fn is_elsewhere(ty: &CType, value: &Value) -> bool {
    let is_text = matches!(value, Value::Code(code) if code.text.trim_start().starts_with('"'));
    ty.is_array() && !is_list(value) && !is_text
}

/// Returns the address of a value in a variable, or behind it.
fn address(variable: &str, ty: &CType, value: &Value) -> String {
    if is_elsewhere(ty, value) { variable.to_owned() } else { format!("&{variable}") }
}

/// Emits the header with the preambles of an LF file.
pub(super) fn preamble_header(view: &View<'_>, file: FileIndex, header: &str, folder: &str) -> File {
    let about = format!("The declarations of {}.", name_of(&view.plan.files[file.0].path));
    let mut text = Text::new(view, format!("{folder}/c/{header}.h"), &about);
    text.line("#pragma once\n#include <lf.h>");
    for header in view.native.protobufs.iter().filter_map(|file| generated_header(&file.path)) {
        text.line(format_args!("#include {header:?}"));
    }
    for preamble in view.preambles(file) {
        text.code(preamble);
    }
    text.file()
}

/// Returns the name of the header that protobuf-c generates from a file.
fn generated_header(path: &str) -> Option<String> {
    Some(format!("{}.pb-c.h", name_of(path).strip_suffix(".proto")?))
}
