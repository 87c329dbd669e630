// SPDX-License-Identifier: Apache-2.0
//! Programs that compile; the files beside each have its plan and its warnings.
//!
//! `cargo xtask bless -p lf-compiler plans::` rewrites the expected output.

use std::fs;
use std::path::{Path, PathBuf};

use lf_compiler::{SourceProvider, Style, compile};

struct Folder(PathBuf);

impl SourceProvider for Folder {
    fn read(&self, path: &str) -> Result<String, String> {
        fs::read_to_string(self.0.join(path)).map_err(|error| error.to_string())
    }
}

fn check(name: &str) {
    let provider = Folder(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/plans"));
    let compilation = compile(&format!("{name}.lf"), &provider);
    let said = compilation.diagnostics.render(Style::Plain);
    let plan = compilation.plan.map_or_else(|| "no plan".to_owned(), |plan| plan.to_string());
    insta::with_settings!({
        snapshot_path => "plans",
        prepend_module_to_snapshot => false,
        omit_expression => true,
    }, {
        insta::assert_snapshot!(name, format!("{said}{plan}"));
    });
}

#[test]
fn a_main_reactor_with_everything_it_can_have() {
    check("hello");
}

#[test]
fn undelayed_connections_are_one_port_and_delayed_ones_hold_what_is_on_its_way() {
    check("hierarchy");
}

#[test]
fn each_instance_in_a_federated_reactor_is_a_federate() {
    check("federation");
}

#[test]
fn federates_that_come_and_go_are_known_as_such() {
    check("transients");
}

#[test]
fn instances_behind_a_bank_without_members_keep_their_arguments() {
    check("empty_bank");
}

#[test]
fn federates_of_other_languages_have_what_their_files_say_and_know_what_comes() {
    check("languages");
}

#[test]
fn reactions_of_the_federated_reactor_are_in_the_federate_that_they_name_or_in_all() {
    check("federated_reactions");
    check("idle_federated_reactor");
}

#[test]
fn a_queue_whose_source_has_no_rate_has_some_room_and_a_warning() {
    check("unknown_capacity");
}

#[test]
fn a_queue_between_the_times_of_modes_has_some_room_and_a_warning() {
    check("unknown_mode_capacities");
}

#[test]
fn handlers_of_watchdogs_come_first_and_the_time_out_is_how_often_they_run() {
    check("watchdogs");
}

#[test]
fn physical_connections_have_queues_that_count_from_physical_time() {
    check("physical_connections");
}

#[test]
fn physical_connections_between_federates_go_past_the_rti() {
    check("direct");
}

#[test]
fn federates_in_cycles_without_delay_know_what_to_wait_for_and_what_to_tell() {
    check("zero_delay");
}

#[test]
fn queues_of_network_inputs_hold_what_can_be_under_way_and_a_guess_in_a_cycle_is_a_warning() {
    check("cycle");
}

#[test]
fn older_forms_compile_with_warnings() {
    check("older_forms");
}

#[test]
fn decentralized_federates_know_their_waits_and_peers() {
    check("decentralized");
}

#[test]
fn older_waits_and_handlers_count_and_the_new_forms_are_named() {
    check("older_waits");
}

#[test]
fn waits_and_handlers_have_no_effect_where_the_rti_decides_or_nobody_does() {
    check("idle_waits");
    check("idle_waits_alone");
}

#[test]
fn queues_follow_waits_up_to_a_limit_and_what_is_beyond_is_said() {
    check("long_waits");
}

#[test]
fn federates_that_wait_for_each_other_for_ever_are_named() {
    check("endless_waits");
}

#[test]
fn multiports_and_banks_are_as_wide_as_their_parameters_say() {
    check("banks");
}

#[test]
fn each_member_of_a_bank_in_a_federated_reactor_is_a_federate() {
    check("banks_of_federates");
}

#[test]
fn reactors_have_what_they_inherit_and_types_in_place_of_type_parameters() {
    check("inherited");
}

#[test]
fn elements_of_a_mode_name_it_and_connections_out_of_it_copy() {
    check("modes");
}

#[test]
fn the_time_of_a_mode_that_is_never_reset_is_never_ahead() {
    check("mode_capacities");
}

#[test]
fn bodies_in_c_know_the_ports_of_contained_reactors_by_their_own_names() {
    check("c_bodies");
}

#[test]
fn ports_are_numbered_as_other_compilers_number_them() {
    check("port_numbers");
    check("own_ports");
}
