use hexsense_core::wire::MAX_FRAME;
use hexsense_core::wire::message::encode_response;

use super::*;
use crate::transport::TransportError;

/// Answers everything with a flood: other numbers, then the right one, then that again.
struct Flood {
    now: Duration,
    asked: u16,
}

impl Transport for Flood {
    fn write(&mut self, _: &[u8]) -> Result<(), TransportError> {
        self.asked += 1;
        Ok(())
    }

    fn read(&mut self, into: &mut Vec<u8>, _: Duration) -> Result<(), TransportError> {
        self.now += Duration::from_millis(1);
        let others = (1_000..2_000).map(|number| (number, Response::Done));
        let right = (self.asked, Response::Erased { sets: 3 });
        let flood = others.chain([right, (self.asked, Response::Erased { sets: 4 })]);
        for (sequence, response) in flood {
            let mut frame = [0; MAX_FRAME];
            let length = encode_response(&response, sequence, &mut frame).unwrap();
            into.extend(&frame[..length]);
        }
        Ok(())
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn port(&self) -> &str {
        "flood"
    }
}

#[test]
fn answers_that_nobody_asked_for_are_dropped() {
    let now = Duration::ZERO;
    let mut conversation = Conversation::new(Box::new(Flood { now, asked: 0 }));
    for _ in 0..3 {
        let answer = conversation.ask(&Request::Status).unwrap();
        assert_eq!(answer, Response::Erased { sets: 3 });
        let blocks = conversation.block(Duration::from_millis(5));
        assert!(blocks.is_err());
        assert_eq!((conversation.awaited, &conversation.answer), (None, &None));
    }
}
