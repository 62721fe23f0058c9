//! What the tests and the developers' chores share.

pub mod assets;
