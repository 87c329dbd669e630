// SPDX-License-Identifier: Apache-2.0
//! Encrypted connections on the target: both ends of one in memory, with the buffers that images have. The tests print
//! what a handshake and a record take of the processor; nothing depends on it.
#![no_std]

use core::ffi::{CStr, c_char};

use lf::println;
use lf_secure::{
    Channel, ChannelError, ChannelStage, FederationSecret, Keyring, Member, Participant, RECORD_OVERHEAD, Role,
    StaticSecret,
};

/// The length of a buffer: that of `CONFIG_LF_SECURITY_RECORD_SIZE`.
const BYTES: usize = 128 + RECORD_OVERHEAD;
/// The number of records that are measured together.
const RECORDS: u8 = 200;
const RTI: u8 = 1;
const FEDERATE: u8 = 2;

/// The result of a test, with what is wrong.
type Outcome = Result<(), &'static CStr>;

unsafe extern "C" {
    /// Returns the time in nanoseconds.
    #[link_name = "test_now_ns"]
    safe fn now_ns() -> i64;
}

/// Exports the cases to C.
macro_rules! cases {
    ($($exported:ident = $case:ident),* $(,)?) => {
        $(
            #[unsafe(no_mangle)]
            extern "C" fn $exported() -> *const c_char {
                match $case() {
                    Ok(()) => core::ptr::null(),
                    Err(wrong) => wrong.as_ptr(),
                }
            }
        )*
    };
}

cases! {
    both_ends_prove_who_they_are_and_carry_records = carry,
    a_changed_record_and_a_changed_datagram_are_noticed = change,
}

/// One end.
struct End<'k> {
    channel: Channel<[u8; BYTES]>,
    keyring: &'k Keyring<'k>,
}

impl<'k> End<'k> {
    fn new(keyring: &'k Keyring<'k>) -> Self {
        Self { channel: Channel::new([0; BYTES], [0; BYTES]), keyring }
    }

    fn begin(&mut self, role: Role, ephemeral: u8) {
        self.channel.begin(role, self.keyring, [ephemeral; 32], u32::from(ephemeral), 0);
    }
}

/// Passes on all that one end has to send, with the first bit of the byte at a place changed.
fn pass(from: &mut End<'_>, to: &mut End<'_>, change: Option<usize>) -> Result<(), ChannelError> {
    let mut sent = 0;
    while !from.channel.pending().is_empty() {
        let (pending, space) = (from.channel.pending(), to.channel.space());
        let count = pending.len().min(space.len());
        space[..count].copy_from_slice(&pending[..count]);
        if let Some(place) = change.and_then(|place| place.checked_sub(sent)).filter(|place| *place < count) {
            space[place] ^= 1;
        }
        sent += count;
        from.channel.sent(count);
        to.channel.filled(count, to.keyring)?;
    }
    from.channel.take_sent();
    Ok(())
}

/// Calls `with` with a federate's end and the RTI's end of a connection, after their handshake.
fn connected(with: impl FnOnce(&mut End<'_>, &mut End<'_>) -> Outcome) -> Outcome {
    let secret = |seed| StaticSecret::new([seed; 32]);
    let federation = || FederationSecret::new([0x5A; 32]);
    let members = [Member { federate: 3, key: secret(FEDERATE).public() }];
    let rti_key = secret(RTI).public();
    let federate = Keyring::new(secret(FEDERATE), federation(), rti_key, &[]);
    let rti = Keyring::new(secret(RTI), federation(), rti_key, &members);
    let (mut federate, mut rti) = (End::new(&federate), End::new(&rti));
    let begin = now_ns();
    federate.begin(Role::Initiator, 0x11);
    federate.channel.expect(Participant::Rti);
    rti.begin(Role::Responder, 0x22);
    let made = pass(&mut federate, &mut rti, None)
        .and_then(|()| pass(&mut rti, &mut federate, None))
        .and_then(|()| pass(&mut federate, &mut rti, None));
    println!("both ends of a handshake: {} ns", now_ns() - begin);
    if made.is_err() || rti.channel.stage() != ChannelStage::Open {
        return Err(c"the handshake is not complete");
    }
    if (federate.channel.peer(), rti.channel.peer()) != (Some(Participant::Rti), Some(Participant::Federate(3))) {
        return Err(c"an end takes the other one for another participant");
    }
    with(&mut federate, &mut rti)
}

fn carry() -> Outcome {
    connected(|federate, rti| {
        for length in [8, 32, 128] {
            let begin = now_ns();
            for number in 0..RECORDS {
                let (content, mut taken) = ([number; 128], [0; 128]);
                if !federate.channel.seal(&content[..length]) || pass(federate, rti, None).is_err() {
                    return Err(c"a record cannot be sent");
                }
                if rti.channel.take(&mut taken) != Ok(length) || taken[..length] != content[..length] {
                    return Err(c"another record has come");
                }
            }
            let each = (now_ns() - begin) / i64::from(RECORDS);
            println!("both ends of a record of {length} bytes: {each} ns");
        }
        Ok(())
    })
}

fn change() -> Outcome {
    connected(|federate, rti| {
        let mut datagram = [0; 64];
        let keys = federate.channel.datagrams().ok_or(c"there are no keys for datagrams")?;
        let count = keys.seal(b"T3", &mut datagram).ok_or(c"a datagram does not fit")?;
        let keys = rti.channel.datagrams().ok_or(c"there are no keys for datagrams")?;
        for place in 0..count {
            let mut changed = datagram;
            changed[place] ^= 1;
            if keys.open(&mut changed[..count]).is_some() {
                return Err(c"a changed datagram counts");
            }
        }
        let begin = now_ns();
        if keys.open(&mut datagram[..count]).is_none_or(|content| content != b"T3") {
            return Err(c"a datagram does not count");
        }
        println!("a datagram that has come: {} ns", now_ns() - begin);
        if !federate.channel.seal(b"a value") || pass(federate, rti, Some(4)).is_err() {
            return Err(c"a record cannot be sent");
        }
        match rti.channel.take(&mut [0; 16]) {
            Err(ChannelError::Forged) => Ok(()),
            _ => Err(c"a changed record is not noticed"),
        }
    })
}
