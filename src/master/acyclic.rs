//! Records of a slave of DP-V1, read and written over a connection of a master of class 2.

use core::time::Duration;

use thiserror::Error;

use super::owner::heard;
use super::{Session, SessionError};
use crate::client::{AcyclicAnswer, AcyclicClient, AcyclicError, NoResponse, NotAsked, ParameterRequest};
use crate::host::{Clock, Link};
use crate::profibus::dpv1::identification::LEN;
use crate::profibus::dpv1::{CALL_INDEX, ErrorCode, MAX_DATA, PARAMETER_INDEX};
use crate::profibus::fdl::Address;
use crate::time::Instant;

/// Send_Timeout, times 10 ms: 10 s. A slave ends a connection that is silent for some times as long.
const SEND_TIMEOUT: u16 = 1000;

/// The header of a call of identification, and the number of I&M0.
const CALL: [u8; 2] = [0x08, 0x00];
const FIRST_BLOCK: u16 = 65000;

/// Why a record was not read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The line.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// It was not begun.
    #[error(transparent)]
    NotAsked(#[from] NotAsked),
    /// The slave.
    #[error(transparent)]
    Acyclic(#[from] AcyclicError),
    /// The response to a request of parameters is none.
    #[error("record 47: {0}")]
    Parameters(#[from] NoResponse),
    /// The slave answers with another block of identification.
    #[error("the slave answered with other octets than I&M{block}: {got} of them, expected 68")]
    Identification {
        /// Which was asked for.
        block: u16,
        /// Octets.
        got: usize,
    },
    /// This session exchanges data with the slave: profirust has no acyclic services beside it.
    #[error("master and slave {address} exchange data in this session; use another one for records")]
    Exchanging {
        /// The slave.
        address: Address,
    },
}

/// A connection of a master of class 2 to a slave, whoever owns that. Every call blocks until it is done or has failed, in
/// bounded time.
///
/// ```no_run
/// use core::time::Duration;
/// use profidrive::host::link::terminal::Terminal;
/// use profidrive::host::{Stop, SystemClock};
/// use profidrive::master::{Connection, Session, Settings};
/// use profidrive::profibus::fdl::Address;
/// use profidrive::time::BaudRate;
///
/// let link = Terminal::open("/tmp/bus".as_ref(), BaudRate::K500)?;
/// let settings = Settings::untimed(Address::station(2)?, BaudRate::K500);
/// let mut session = Session::new(link, SystemClock::new(), Stop::new()?, settings)?;
/// let mut connection = Connection::open(&mut session, Address::station(7)?, Duration::from_secs(10))?;
/// println!("{:02X?}", connection.read(1, 10)?);
/// connection.close()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Connection<'s, L, C> {
    session: &'s mut Session<L, C>,
    address: Address,
    client: AcyclicClient,
    patience: Duration,
}

impl<'s, L: Link, C: Clock> Connection<'s, L, C> {
    /// Opens one. A job is given up after `patience`.
    ///
    /// # Errors
    /// [`RecordError`]
    pub fn open(
        session: &'s mut Session<L, C>,
        address: Address,
        patience: Duration,
    ) -> Result<Self, RecordError> {
        if session.exchanges_with(address) {
            return Err(RecordError::Exchanging { address });
        }
        // From here on both ends count their telegrams: what is repeated runs once.
        session.diagnosis(address)?;
        let client = AcyclicClient::class_2(SEND_TIMEOUT, patience);
        let mut this = Self { session, address, client, patience };
        let now = this.session.now();
        this.client.open(now);
        this.run()?;
        Ok(this)
    }

    /// Reads a record.
    ///
    /// # Errors
    /// [`RecordError`]
    pub fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
        let now = self.session.now();
        self.client.read(now, slot, index, MAX_DATA)?;
        self.run()
    }

    /// Writes a record.
    ///
    /// # Errors
    /// [`RecordError`]
    pub fn write(&mut self, slot: u8, index: u8, data: &[u8]) -> Result<(), RecordError> {
        let now = self.session.now();
        self.client.write(now, slot, index, data)?;
        self.run().map(drop)
    }

    /// Asks for parameters by record 47, and waits for the response.
    ///
    /// # Errors
    /// [`RecordError`]
    pub fn parameters(&mut self, slot: u8, request: &ParameterRequest) -> Result<Vec<u8>, RecordError> {
        let begun = self.session.now();
        self.until_not_busy(begun, |this| this.write(slot, PARAMETER_INDEX, request.octets()))?;
        self.until_not_busy(begun, |this| this.read(slot, PARAMETER_INDEX))
    }

    /// Asks for a block of identification and maintenance, 0 for I&M0.
    ///
    /// # Errors
    /// [`RecordError`]
    pub fn identification(&mut self, slot: u8, block: u16) -> Result<[u8; LEN], RecordError> {
        let [high, low] = FIRST_BLOCK.saturating_add(block).to_be_bytes();
        let call = [CALL[0], CALL[1], high, low];
        self.write(slot, CALL_INDEX, &call)?;
        let octets = self.read(slot, CALL_INDEX)?;
        let wrong = RecordError::Identification { block, got: octets.len() };
        let (head, octets) = octets.split_first_chunk::<4>().ok_or(wrong)?;
        let wrong = RecordError::Identification { block, got: octets.len().saturating_add(4) };
        if *head != call {
            return Err(wrong);
        }
        octets.try_into().map_err(|_| wrong)
    }

    /// Ends the connection.
    ///
    /// # Errors
    /// [`RecordError::Session`]
    pub fn close(mut self) -> Result<(), RecordError> {
        self.client.close();
        self.run().map(drop)
    }

    /// A state conflict says that the drive has not done yet what was asked before.
    fn until_not_busy<R>(
        &mut self,
        begun: Instant,
        act: impl Fn(&mut Self) -> Result<R, RecordError>,
    ) -> Result<R, RecordError> {
        loop {
            let outcome = act(self);
            let is_busy = matches!(&outcome, Err(RecordError::Acyclic(AcyclicError::Refused { failure, .. }))
                if [ErrorCode::STATE_CONFLICT, ErrorCode::BUSY].contains(&failure.code));
            if !is_busy || self.session.now().saturating_since(begun) > self.patience {
                return outcome;
            }
        }
    }

    /// Does what is asked: the octets of a record that was read.
    fn run(&mut self) -> Result<Vec<u8>, RecordError> {
        loop {
            let now = self.session.now();
            let Some(sent) = self.client.poll_transmit(now) else { return Ok(Vec::new()) };
            let answer = self.session.ask(self.address, Some((sent.dsap, sent.ssap)), sent.data)?;
            if let Some(outcome) = self.client.handle(self.session.now(), heard(&answer)) {
                return Ok(match outcome? {
                    AcyclicAnswer::Read(data) => data.to_vec(),
                    AcyclicAnswer::Opened { .. }
                    | AcyclicAnswer::Written
                    | AcyclicAnswer::Acknowledged
                    | AcyclicAnswer::Closed => Vec::new(),
                });
            }
        }
    }
}
