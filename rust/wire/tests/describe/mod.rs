// SPDX-License-Identifier: Apache-2.0
//! Messages in the words of the recordings.

use lf_wire::{DELAY_NONE, KIND_TRANSIENT, Message, NeighborStructure, RejectCode, Tag};

/// Returns the recorder's description of such a message, in a run with this start time in nanoseconds.
pub(crate) fn describe(message: &Message<'_>, start: i64) -> String {
    let name = message.name();
    let tag = |tag: &Tag| describe_tag(*tag, start);
    match message {
        Message::Reject(code) => format!("{name} {}", describe_code(*code)),
        Message::FedIds { federate, federation_id } | Message::P2pSendingFedId { federate, federation_id, .. } => {
            format!("{name} federate {federate}, federation \"{}\"", String::from_utf8_lossy(federation_id))
        }
        Message::TransientFedIds { federate, kind, federation_id } => {
            let kind = describe_kind(*kind == KIND_TRANSIENT);
            format!("{name} federate {federate}, {kind}, federation \"{}\"", String::from_utf8_lossy(federation_id))
        }
        Message::EffectiveStart { start: time, tag: t } => format!("{name} {time}, effective start {}", tag(t)),
        Message::Timestamp(time) => format!("{name} {time}"),
        Message::TaggedMessage { port, federate, tag: t, payload }
        | Message::P2pTaggedMessage { port, federate, tag: t, payload } => {
            format!("{name} {} to federate {federate}, port {port}, {} bytes", tag(t), payload.len())
        }
        Message::P2pMessage { port, federate, payload } => {
            format!("{name} to federate {federate}, port {port}, {} bytes", payload.len())
        }
        Message::StopReply(t) => format!("STOP_REQUEST_REPLY {}", tag(t)),
        Message::NextEventTag(t)
        | Message::TagGrant(t)
        | Message::ProvisionalTagGrant(t)
        | Message::LatestTagComplete(t)
        | Message::StopRequest(t)
        | Message::StopGranted(t)
        | Message::DownstreamNextEventTag(t) => format!("{name} {}", tag(t)),
        Message::AddressQuery { federate, is_transient: Some(is_transient) } => {
            format!("{name} federate {federate}, {}", describe_kind(*is_transient))
        }
        Message::AddressQuery { federate, .. }
        | Message::T3 { federate }
        | Message::UpstreamConnected { federate }
        | Message::UpstreamDisconnected { federate }
        | Message::OutboundConnected { federate }
        | Message::OutboundDisconnected { federate }
        | Message::FedNonce { federate, .. } => {
            format!("{name} federate {federate}")
        }
        Message::AddressQueryReply { port, address: [a, b, c, d] } => {
            format!("{name} port {port}, address {a}.{b}.{c}.{d}")
        }
        Message::AddressQueryReplyIpv6 { port, address, scope } => {
            format!("{name} port {port}, address {}%{scope}", std::net::Ipv6Addr::from(*address))
        }
        Message::AddressAdvertisement { port } => format!("{name} port {port}"),
        Message::PortAbsent { port, federate, tag: t } => {
            format!("{name} {} to federate {federate}, port {port}", tag(t))
        }
        Message::NeighborStructure(neighbors) => format!("{name} {}", describe_neighbors(neighbors)),
        Message::UdpPort(port) => match port {
            0 => format!("{name} 0 (initial synchronization only)"),
            65535 => format!("{name} 65535 (clock synchronization off)"),
            port => format!("{name} {port}"),
        },
        Message::Resign
        | Message::Failed
        | Message::Stop
        | Message::Ack
        | Message::T1(_)
        | Message::T4(_)
        | Message::CodedProbe(_)
        | Message::RtiResponse { .. }
        | Message::FedResponse { .. } => name.to_owned(),
    }
}

fn describe_kind(is_transient: bool) -> &'static str {
    if is_transient { "transient" } else { "persistent" }
}

fn describe_tag(tag: Tag, start: i64) -> String {
    if tag.time == Tag::FOREVER.time {
        return format!("(FOREVER, {})", tag.microstep);
    }
    format!("(start+{}, {})", tag.time.wrapping_sub(start), tag.microstep)
}

fn describe_neighbors(neighbors: &NeighborStructure<'_>) -> String {
    let upstream = neighbors.upstream().map(|(federate, delay)| match delay {
        DELAY_NONE => format!("{federate} (no after)"),
        delay => format!("{federate} (after {delay} ns)"),
    });
    let downstream = neighbors.downstream().map(|federate| federate.to_string());
    let join = |list: Vec<String>| list.join(", ");
    format!("upstream [{}], downstream [{}]", join(upstream.collect()), join(downstream.collect()))
}

fn describe_code(code: RejectCode) -> &'static str {
    match code {
        RejectCode::FederationIdMismatch => "FEDERATION_ID_DOES_NOT_MATCH",
        RejectCode::IdInUse => "FEDERATE_ID_IN_USE",
        RejectCode::IdOutOfRange => "FEDERATE_ID_OUT_OF_RANGE",
        RejectCode::UnexpectedMessage => "UNEXPECTED_MESSAGE",
        RejectCode::WrongServer => "WRONG_SERVER",
        RejectCode::HmacMismatch => "HMAC_DOES_NOT_MATCH",
        RejectCode::NotInAuthenticationMode => "RTI_NOT_EXECUTED_WITH_AUTH",
        RejectCode::JoinsTooLate => "8 (joining too late)",
        RejectCode::Insecure => "229 (not encrypted)",
        RejectCode::Other(_) => "unknown",
    }
}
