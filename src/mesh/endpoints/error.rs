//! What can be wrong with a list of endpoints.

/// Why a list of endpoints is not read; each in one sentence that says how to mend it.
#[derive(Debug, thiserror::Error)]
pub enum EndpointError {
    /// The file is longer than is read.
    #[error("the endpoints have {0} bytes, more than are read: split the file")]
    TooLong(usize),
    /// More endpoints than are read.
    #[error("line {line} begins endpoint {number}, more than the {most} that are read: split the file", most = super::ENDPOINTS_MOST)]
    TooMany {
        /// Where the first too many begins.
        line: u64,
        /// Its number.
        number: usize,
    },
    /// A CSV file without a column that is needed.
    #[error(
        "line 1 of the endpoints has no column {0}: write a first line with the names of the columns, such as name,kind,x,y,z"
    )]
    NoColumn(&'static str),
    /// A place that cannot be understood.
    #[error("line {line} of the endpoints {problem}")]
    Damaged {
        /// Where.
        line: u64,
        /// What is wrong and how to mend it, as the rest of the sentence.
        problem: String,
    },
    /// JSON of another format.
    #[error("the JSON is {0}, and not ramus-endpoints/1: save the endpoints again")]
    Format(String),
    /// JSON in which an endpoint cannot be what it says.
    #[error("endpoint {number} in the JSON {problem}")]
    Wrong {
        /// Which, from 1.
        number: usize,
        /// What is wrong and how to mend it, as the rest of the sentence.
        problem: String,
    },
}
