// SPDX-License-Identifier: Apache-2.0
//! The end of a participant's socket in the program that has the virtual network.

use std::io;
use std::os::unix::net::UnixStream;

use lf_coordination::Deadline;
use lf_runtime::platform::{NetError, Platform};

use super::frame::{Call, Frame};

/// Returns the number of the participant at the other end, with which it begins.
///
/// # Errors
/// When that is no participant, or gone.
pub fn participant(stream: &UnixStream) -> io::Result<u16> {
    let frame = Frame::read(stream)?;
    if Call::of(&frame) == Some(Call::Begin) { Ok(frame.port()) } else { Err(io::ErrorKind::InvalidData.into()) }
}

/// Answers the calls of a participant, whose first turn begins now, until it has ended.
pub fn serve(stream: &UnixStream, platform: &mut impl Platform) {
    let mut answer = Some(Frame::done().with_time(platform.now()));
    loop {
        if let Some(answer) = answer
            && answer.write(stream).is_err()
        {
            return;
        }
        let Ok(call) = Frame::read(stream) else { return };
        answer = answer_to(&call, platform);
    }
}

/// Makes the call; returns the answer if there is one.
fn answer_to(call: &Frame, platform: &mut impl Platform) -> Option<Frame> {
    let answer = match Call::of(call)? {
        Call::Begin => return None,
        Call::ShutDownWriting => {
            platform.shut_down_writing(call.socket());
            return None;
        }
        Call::Close => {
            platform.close(call.socket());
            return None;
        }
        Call::SetInterest => {
            platform.set_interest(call.socket(), call.interest());
            return None;
        }
        Call::WaitUntil => Ok(wait(call.deadline(), platform)),
        Call::Wait => Ok(wait(Deadline::Never, platform)),
        call_of_network => of_network(call_of_network, call, platform),
    };
    Some(answer.unwrap_or_else(Frame::failed))
}

fn of_network(kind: Call, call: &Frame, platform: &mut impl Platform) -> Result<Frame, NetError> {
    let socket = call.socket();
    let mut buffer = Vec::new();
    if matches!(kind, Call::Random | Call::ReceiveFrom | Call::Read) {
        buffer = vec![0; call.length()];
    }
    Ok(match kind {
        Call::Random => {
            platform.random(&mut buffer).map_err(|error| NetError::Os(error.0))?;
            Frame::done().with_bytes(&buffer)
        }
        Call::Connect => {
            let (address, _) = call.address().ok_or(NetError::Unreachable)?;
            Frame::done().about(platform.connect(address)?)
        }
        Call::Connected => platform.connected(socket).map(|()| Frame::done())?,
        Call::Listen => Frame::done().about(platform.listen(call.port())?),
        Call::Bind => Frame::done().about(platform.bind(call.port())?),
        Call::ReceiveFrom => match platform.receive_from(socket, &mut buffer)? {
            Some((count, from)) => Frame::done().with_bytes(&buffer[..count.min(buffer.len())]).with_address(from),
            None => Frame::nothing(),
        },
        Call::SendTo => {
            let (to, bytes) = call.address().ok_or(NetError::Unreachable)?;
            platform.send_to(socket, to, bytes).map(|()| Frame::done())?
        }
        Call::LocalPort => Frame::done().with_number(platform.local_port(socket)?.into()),
        Call::Accept => match platform.accept(socket)? {
            Some((socket, ip)) => {
                Frame::done().about(socket).with_address(lf_runtime::platform::Endpoint { ip, port: 0 })
            }
            None => Frame::nothing(),
        },
        Call::Read => {
            let transfer = platform.read(socket, &mut buffer)?;
            let answer = Frame::moved(transfer);
            let count = answer.length();
            answer.with_bytes(&buffer[..count])
        }
        Call::Write => Frame::moved(platform.write(socket, &call.bytes)?),
        _ => return Err(NetError::Stale),
    })
}

/// Waits until the participant's next turn.
fn wait(until: Deadline, platform: &mut impl Platform) -> Frame {
    let mut answer = Frame::done();
    platform.wait(until, &mut |socket, interest| answer.add_ready(socket, interest));
    answer.with_time(platform.now()).interrupted_if(platform.interrupted())
}
