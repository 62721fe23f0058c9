//! Small inputs that once went wrong, each with the right result.

mod rest;
