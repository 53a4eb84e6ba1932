//! Names of requests.

use hexsense_core::wire::Request;

/// What a request is called in messages.
pub fn name(request: &Request) -> &'static str {
    match request {
        Request::Identity => "identity",
        Request::Status => "status",
        Request::Stream(_) => "stream",
        Request::Rate(_) => "scan rate",
        Request::Block(_) => "block",
        Request::Drive { .. } => "drive frequency",
        Request::Sums { .. } => "harmonic sums",
        Request::ActiveSet => "active set",
        Request::ReadSet { .. } => "bytes of the set",
        Request::History { .. } => "history of sets",
        Request::Log { .. } => "log of changes",
        Request::Challenge => "challenge",
        Request::Change { .. } => "change",
        Request::UploadChunk { .. } => "piece of an upload",
        Request::UploadCommit => "commit of an upload",
        Request::UploadAbort => "end of an upload",
        Request::Harmonics { .. } => "harmonics",
        Request::Motion { .. } => "motion",
        Request::Prove { .. } => "proof of the key",
        Request::LogProof { .. } => "proof of the log",
    }
}
