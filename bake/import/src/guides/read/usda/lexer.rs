//! Splits USD text into tokens, and reads the values that hair needs. Memory is proportional to the file.

use super::super::source::Source;
use crate::error::BakeError;
use std::str::FromStr;

/// Maximum number of numbers in one list.
pub(super) const MOST_NUMBERS: usize = 1 << 26;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Token<'a> {
    /// Name, keyword or number.
    Word(&'a str),
    /// Contents of a string, an asset path or a path, without quotes.
    Text(&'a str),
    /// Bracket, comma or other single character.
    Mark(char),
    /// End of a statement: a line feed or a semicolon.
    Break,
    End,
}

pub(super) struct Lexer<'a> {
    source: Source<'a>,
    text: &'a str,
    at: usize,
}

impl<'a> Lexer<'a> {
    pub(super) fn new(source: Source<'a>, text: &'a str) -> Self {
        Self { source, text, at: 0 }
    }

    /// Returns an error at the current line.
    pub(super) fn fault(&self, reason: impl Into<String>) -> BakeError {
        let line = 1 + self.text[..self.at].bytes().filter(|byte| *byte == b'\n').count();
        self.fault_in(&format!("line {line}"), reason)
    }

    pub(super) fn fault_in(&self, place: &str, reason: impl Into<String>) -> BakeError {
        self.source.fault(place.to_owned(), reason)
    }

    pub(super) fn next(&mut self) -> Result<Token<'a>, BakeError> {
        loop {
            let rest = &self.text[self.at..];
            let Some(c) = rest.chars().next() else { return Ok(Token::End) };
            if c == '#' || rest.starts_with("//") {
                self.at += rest.find('\n').unwrap_or(rest.len());
                continue;
            }
            if rest.starts_with("/*") {
                self.enclosed(2, "*/")?;
                continue;
            }
            return Ok(match c {
                '\n' | ';' => {
                    self.at += 1;
                    Token::Break
                }
                _ if c.is_whitespace() => {
                    self.at += c.len_utf8();
                    continue;
                }
                '"' | '\'' | '@' => {
                    let three = [c, c, c].iter().collect::<String>();
                    let quotes = if rest.starts_with(&three) { three } else { c.into() };
                    Token::Text(self.enclosed(quotes.len(), &quotes)?)
                }
                '<' => Token::Text(self.enclosed(1, ">")?),
                _ if is_word(c) => {
                    let length = rest.find(|c: char| !is_word(c)).unwrap_or(rest.len());
                    self.at += length;
                    Token::Word(&rest[..length])
                }
                _ => {
                    self.at += c.len_utf8();
                    Token::Mark(c)
                }
            });
        }
    }

    /// Returns the next token, which stays the next one.
    pub(super) fn peek(&mut self) -> Result<Token<'a>, BakeError> {
        let at = self.at;
        let token = self.next();
        self.at = at;
        token
    }

    /// Returns the text up to `end`, after an opening of `skip` bytes. A backslash escapes the next character.
    fn enclosed(&mut self, skip: usize, end: &str) -> Result<&'a str, BakeError> {
        let begin = self.at + skip;
        let bytes = self.text.as_bytes();
        let mut at = begin;
        while at < bytes.len() {
            if bytes[at..].starts_with(end.as_bytes()) {
                self.at = at + end.len();
                return Ok(&self.text[begin..at]);
            }
            at += if bytes[at] == b'\\' { 2 } else { 1 };
        }
        Err(self.fault(format!("found no end of what begins here, expected {end}")))
    }

    /// Skips to the bracket that closes one that was read already. Calls `each` with each `key = value` directly within
    /// the brackets, and the first token of the value.
    pub(super) fn skip_brackets(&mut self, mut each: impl FnMut(&'a str, Token<'a>)) -> Result<(), BakeError> {
        let (mut depth, mut key) = (1_usize, "");
        while depth > 0 {
            match self.next()? {
                Token::Mark('(' | '[' | '{') => depth += 1,
                Token::Mark(')' | ']' | '}') => depth -= 1,
                Token::Mark('=') if depth == 1 => each(key, self.peek()?),
                Token::Word(word) => key = word,
                Token::End => return Err(self.fault(format!("the file ends within {depth} open brackets"))),
                _ => {}
            }
        }
        Ok(())
    }

    pub(super) fn skip_value(&mut self) -> Result<(), BakeError> {
        match self.next()? {
            Token::Mark('(' | '[' | '{') => self.skip_brackets(|_, _| ()),
            _ => Ok(()),
        }
    }

    pub(super) fn string(&mut self) -> Result<&'a str, BakeError> {
        match self.next()? {
            Token::Text(text) => Ok(text),
            other => Err(self.unexpected(other, "a string")),
        }
    }

    pub(super) fn unexpected(&self, found: Token<'a>, expected: &str) -> BakeError {
        let found = match found {
            Token::Word(text) | Token::Text(text) => format!("{:?}", text.chars().take(40).collect::<String>()),
            Token::Mark(mark) => format!("{mark:?}"),
            Token::Break => "the end of a line".to_owned(),
            Token::End => "the end of the file".to_owned(),
        };
        self.fault(format!("found {found}, expected {expected}"))
    }

    pub(super) fn strings(&mut self) -> Result<Vec<&'a str>, BakeError> {
        let mut strings = Vec::new();
        if self.next()? != Token::Mark('[') {
            return Ok(strings);
        }
        loop {
            match self.next()? {
                Token::Text(text) => strings.push(text),
                Token::Mark(',') | Token::Break => {}
                Token::Mark(']') => return Ok(strings),
                other => return Err(self.unexpected(other, "strings")),
            }
        }
    }

    /// Reads a number, or numbers in brackets, to one list of at most `most`. The innermost brackets contain `width`
    /// numbers; 0 permits any count. `None` is an empty list.
    pub(super) fn numbers<T: FromStr>(&mut self, width: usize, most: usize) -> Result<Vec<T>, BakeError> {
        let (mut numbers, mut open, mut begins) = (Vec::new(), 0_usize, 0);
        loop {
            match self.next()? {
                Token::Mark('[' | '(') => {
                    open += 1;
                    begins = numbers.len();
                }
                Token::Mark(')') if width > 0 && numbers.len() - begins != width => {
                    let found = numbers.len() - begins;
                    return Err(self.fault(format!("found {found} numbers in brackets, expected {width}")));
                }
                Token::Mark(']' | ')') if open > 0 => {
                    open -= 1;
                    begins = numbers.len();
                }
                Token::Word("None") => {}
                Token::Word(word) if numbers.len() < most => match word.parse() {
                    Ok(number) => numbers.push(number),
                    Err(_) => return Err(self.unexpected(Token::Word(word), "a number")),
                },
                Token::Word(_) => {
                    return Err(self.fault(format!("found more numbers in a list, expected at most {most}")));
                }
                Token::Mark(',') | Token::Break if open > 0 => {}
                other => return Err(self.unexpected(other, "numbers")),
            }
            if open == 0 {
                return Ok(numbers);
            }
        }
    }
}

fn is_word(c: char) -> bool {
    !c.is_whitespace() && !"()[]{}<>=,;\"'@#&".contains(c)
}
