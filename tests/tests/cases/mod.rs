//! Inputs of other programs that once gave wrong pictures or were refused, each with the right result.

mod hair;
